"""A scene of cables in Exudyn, cable by cable, with the same start."""

from __future__ import annotations

import time

from ancfsparse.errors import InputError
from ancfsparse.scene import Beam, Connect, Pin, Point, Scene
from benchmarks.other_codes.exudyn import Model, Setting

# The absolute tolerance that is small enough: 1e-6 lies below the rounding of 1e4 elements.
SETTINGS = (
    Setting("Exudyn, modified Newton", 0.5, "EigenSparse", reuse_pattern=True, absolute=1e-4),
    Setting("Exudyn, full Newton", 0.0, "EigenSparse", reuse_pattern=True, absolute=1e-4),
)
"""Its fastest settings for large meshes, of all that were tried."""


def time_exudyn(scene: Scene, setting: Setting, dt: float, steps: int) -> dict[str, float]:
    """Simulate cables, pins and connections under gravity with Exudyn's trapezoidal rule.

    Returns
    -------
    dict
        ``seconds`` of its solver alone and ``set_up_seconds`` before it [s],
        ``iterations_per_step`` and ``factorizations``.

    Raises
    ------
    InputError
        If the scene has anything else.
    ExudynError
        If its solver gives up.
    """
    begin = time.perf_counter()
    run = _model(scene).run(setting, steps * dt, dt, steps * dt)
    return {
        "seconds": run.seconds,
        "set_up_seconds": time.perf_counter() - begin - run.seconds,
        "iterations_per_step": run.iterations_per_step,
        "factorizations": run.counts["factorizations"],
    }


def _model(scene: Scene) -> Model:
    for body in scene.bodies:
        if not isinstance(body, Beam):
            raise InputError(f"{body!r} is not handed to Exudyn: make it of beams")
    model = Model(scene)

    def number(node: Point) -> int:
        return model.nodes[node.beam.name][node.index]

    for joint in scene.joints:
        for k in range(scene.dim):
            if isinstance(joint, Pin):
                model.tie(number(joint.node), k)
            elif isinstance(joint, Connect):
                model.tie(number(joint.b), k, number(joint.a))
            else:
                raise InputError(f"a {type(joint).__name__} is not handed to Exudyn")
    return model
