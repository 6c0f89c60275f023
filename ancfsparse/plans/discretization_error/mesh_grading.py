"""Whether a pilot shows that graded meshes need fewer elements, and which."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ancfsparse.plans.models.graded_mesh import (
    POWER,
    UNIFORM,
    Grade,
    density,
    equidistributed,
    missed,
)
from ancfsparse.plans.models.model import inner_nodes, undecided
from ancfsparse.plans.trial_runs.trial_runs import Pilot
from ancfsparse.scene import Beam, Scene
from ancfsparse.system import System

# States of a motion that are looked at, at most.
LOOKS = 64
# Nodes this close to a place with a force, a share of the length, stand there.
CLOSE = 1e-9
# Cubics that leave this share of the length of a beam show rounding.
NOISE = 1e-9


def grades(scene: Scene, pilot: Pilot) -> tuple[dict[str, Grade], float]:
    """Grade the meshes of all open beams by a pilot.

    Parameters
    ----------
    scene : Scene
        With what is open.
    pilot : Pilot
        A run of it.

    Returns
    -------
    dict of str to Grade
        By the name of the beam; empty where elements are no cables, or nothing is seen.
    float
        How many times as many elements the mesh of the pilot needs for the same error.
    """
    open_ = {beam.name: beam for beam in undecided(scene) if beam.name in pilot.model.counts}
    forces = inner_nodes(scene, open_)
    out: dict[str, Grade] = {}
    now = then = 0.0
    for name in open_:
        body = pilot.run.system.scene.body(name)
        if not (isinstance(body, Beam) and body.kind.is_cable):
            return {}, 1.0
        nodes = np.linspace(0.0, 1.0, body.n_elements + 1)
        if body.nodes is not None:
            nodes = np.array(body.nodes)
        f = _density(pilot, body, nodes, forces[name])
        own = pilot.model.grades.get(name, UNIFORM)
        out[name] = equidistributed(f, nodes) if f.any() else own
        stiffness = float(np.mean(body.stiffnesses()["bending_stiffness_z"])) * body.length
        now += stiffness * missed(f, nodes, own)
        then += stiffness * missed(f, nodes, out[name])
    return (out, float((now / then) ** (1.0 / POWER))) if then > 0.0 else ({}, 1.0)


def _density(pilot: Pilot, body: Beam, nodes: np.ndarray, forces: set[float]) -> np.ndarray:
    """Return the density of what the elements of a beam miss; zero where that is rounding."""
    system = pilot.run.system
    assert isinstance(system, System)
    i = system.bodies.index(body)
    every = max(1, len(pilot.run.t) // LOOKS)
    q = np.asarray(pilot.run.q)[::every]
    r, slopes = (q[:, system.vectors(each)[i]] for each in ("r", "r_x"))
    loaded = np.abs(nodes[:, None] - np.array(sorted(forces))).min(axis=1, initial=1.0) < CLOSE
    f = density(r, slopes, body.lengths, loaded)
    return np.where(body.lengths**4 * np.sqrt(f) > NOISE * body.length, f, 0.0)


def described(grades: Mapping[str, Grade]) -> str:
    """Explain graded meshes in a sentence."""
    name, most = max(grades.items(), key=lambda item: item[1].ratio)
    return (
        f"what bends {name} is concentrated, so its elements are up to {most.ratio:.2g} times as "
        "short there as elsewhere"
    )
