"""The paper's pendulum in Exudyn."""

from __future__ import annotations

from ancfsparse.problems import Problem
from benchmarks.other_codes.exudyn import Model, OtherRun, Setting

IMMOVABLE = 1e14  # mass that stands for a pin [kg]

SETTINGS = (
    Setting("Exudyn, modified 0.02, dense", 0.02, "EigenDense"),
    Setting("Exudyn, modified 0.02, sparse", 0.02, "EigenSparse"),
    Setting("Exudyn, modified 0.05, sparse", 0.05, "EigenSparse"),
    Setting("Exudyn, full Newton, dense", 0.0, "EigenDense"),
)
"""Its fastest settings for ten elements, of all that were tried."""


def run_exudyn(
    problem: Problem, setting: Setting, t_end: float, dt: float, interval: float
) -> OtherRun:
    """Simulate a planar cable pinned at its start; arguments and errors as of `Model.run`.

    With a pinned coordinate its explicit methods converge to another motion, so for them a mass
    that nothing moves takes the place of the pin.
    """
    model = Model(problem.scene)
    nodes = model.nodes[problem.rod.name]
    if setting.explicit:
        model.add_mass(nodes[0], IMMOVABLE)
    else:
        for k in (0, 1):
            model.tie(nodes[0], k)
    model.watch(nodes[-1])
    return model.run(setting, t_end, dt, interval)
