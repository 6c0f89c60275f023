"""Shapes at rest: the reactions balance the weight and the load."""

import numpy as np

import ancfsparse as ancf
from tests.soak.report import Report
from tests.soak.scenes import draw

MAX_RESIDUAL = 1e-6  # unbalanced force, over the sum of all


def run(seed, index):
    rng = np.random.default_rng([seed, index])
    drawn = draw(rng, held=True)
    tried = str(drawn.words)
    try:
        rest = ancf.solve_static(drawn.scene)
    except ancf.AncfError as refused:
        return Report(type(refused).__name__, [], tried)
    weight = sum(b.length * b.material.density * b.section.area for b in drawn.beams)
    forces = [weight * np.asarray(drawn.scene.gravity)]
    if drawn.force is not None:
        forces.append(np.asarray(drawn.force(0.0)))
    held = dict.fromkeys(joint.node for joint in drawn.scene.joints)
    forces += [rest.reaction(node) for node in held]
    left = float(np.linalg.norm(sum(forces)))
    size = sum(float(np.linalg.norm(force)) for force in forces)
    finds = []
    if not left <= MAX_RESIDUAL * size:
        finds.append(f"{left:.3g} N of {size:.3g} N of forces are not balanced")
    return Report("found", finds, tried)
