"""Random runs of beams that rigid bodies hang on, judged as motions are."""

import numpy as np

import ancfsparse as ancf
from tests.soak.scenes import SI, draw, draw_integrator, draw_solver
from tests.soak.trials import motions

# Supports of a beam with a free end.
FREE_ENDS = ("pin", "clamp", "free", "pin by multipliers")
JOINTS = ("revolute", "universal", "cylindrical", "prismatic", "weld", "distance", "connect")


def run(seed, index):
    """Run a random scene by a random integrator and solver."""
    rng = np.random.default_rng([seed, index])
    return motions.attempt(draw_hung(rng), draw_integrator(rng), draw_solver(rng))


def draw_hung(rng, units=SI):
    """Draw a beam, hang a box on its end and perhaps another one on that, by any joint.

    All bodies begin without rotation, at the velocity of the end, which every joint allows.
    """
    drawn = draw(rng, units)
    while drawn.words["hold"] not in FREE_ENDS:
        drawn = draw(rng, units)
    beam, scene = drawn.beams[0], drawn.scene
    dim, length = scene.dim, beam.length
    mass = beam.length * beam.material.density * beam.section.area
    end = beam.end
    velocity = beam.velocity(end.position[None])[0] if beam.velocity is not None else np.zeros(dim)
    joints = ["connect"]
    if rng.random() < 0.7:
        joints.append(str(rng.choice(JOINTS if dim == 3 else ("weld", "prismatic", "distance"))))
    for joint in joints:
        edges = length * 10 ** rng.uniform(-1.5, -0.3, 3)
        corner = 0.5 * edges[:dim] * rng.choice([-1, 1], dim)
        axes = rotation(rng, dim)
        place = end.position + (0.3 * length if joint == "distance" else 0.0) * axes[:, 0]
        body = scene.add_body(
            ancf.Box(length=edges[0], width=edges[2], height=edges[1]),
            mass=mass * 10 ** rng.uniform(-1, 1),
            position=place - axes @ corner, velocity=velocity,
            orientation=axes if dim == 3 else np.arctan2(axes[1, 0], axes[0, 0]),
        )  # fmt: skip
        join(scene, joint, end, body.at(corner), axes)
        drawn.bodies.append(body)
        end = body.origin
    drawn.words |= {"bodies": joints}
    return drawn


def rotation(rng, dim):
    """Return random axes in the columns of a matrix (dim, dim)."""
    axes, _ = np.linalg.qr(rng.normal(size=(dim, dim)))
    axes[:, -1] *= np.linalg.det(axes)
    return axes


def join(scene, kind, a, b, axes):
    """Join two points."""
    if kind == "universal":
        scene.universal(a, b, axis_a=axes[:, 0], axis_b=axes[:, 1])
    elif kind in ("revolute", "cylindrical", "prismatic"):
        getattr(scene, kind)(a, b, axis=axes[:, 0])
    else:
        getattr(scene, kind)(a, b)
