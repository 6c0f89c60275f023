"""The map of beams and cables without contact, and its findings."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.results import Trajectory
from benchmarks.common import methods
from benchmarks.common.methods import chosen
from benchmarks.common.paper import QUASI_NEWTON
from benchmarks.common.target import verdict
from benchmarks.stability.cells import Run
from benchmarks.stability.findings import comparison, gains
from benchmarks.stability.map_spec import MapSpec
from benchmarks.stability.scenes import SCENES, Case
from benchmarks.stability.stability_map import Stability

CALM_TURN = 0.3  # largest turn of an element in a calm step [rad]
CALM_STRETCH = 1e-3  # largest relative change of its length in a calm step
MAX_NEWTON_FRACTION = 0.05  # calm steps that damped Newton may recover


def measure(path: Trajectory, case: Case) -> tuple[float, float, float, float]:
    """Return turn [rad], stretch, gain and loss [-]; see `BEAMS`."""
    return *largest_changes(path, case), *energy_balance(path, case)


def largest_changes(path: Trajectory, case: Case) -> tuple[float, float]:
    """Return the largest turn [rad] and relative stretch of a chord of an element in a step."""
    if path.stats.steps == 0:
        return 0.0, 0.0
    nodes = range(case.rod.n_elements + 1)
    chords = np.diff([path.position(case.rod.node(i)) for i in nodes], axis=0)
    lengths = np.linalg.norm(chords, axis=2)
    old, new = chords[:, :-1], chords[:, 1:]
    across = old[..., 0] * new[..., 1] - old[..., 1] * new[..., 0]
    turns = np.abs(np.arctan2(across, np.sum(old * new, axis=2)))
    return float(turns.max()), float(np.abs(np.diff(lengths, axis=1) / lengths[:, :-1]).max())


def energy_balance(path: Trajectory, case: Case) -> tuple[float, float]:
    """Return gain and loss of energy over the largest kinetic energy; see `BEAMS`."""
    energy, uncertainty = path.energy, work_uncertainty(path, case)
    above = energy.total - energy.total[0] - work_of(path, case)
    above -= np.clip(above, -uncertainty, uncertainty)
    largest = float(energy.kinetic.max())
    if largest == 0.0:
        return 0.0, 0.0
    return max(float(above.max()) / largest, 0.0), max(-float(above[-1]) / largest, 0.0)


def work_of(path: Trajectory, case: Case) -> Vector:
    """Return the work of the force on the end, summed along its path, (k,) [J]."""
    work = np.zeros(len(path.t))
    if case.force is not None:
        force = np.array([case.force(t) for t in path.t])
        displacement = np.diff(path.position(case.rod.end), axis=0)
        work[1:] = np.cumsum(np.sum(0.5 * (force[1:] + force[:-1]) * displacement, axis=1))
    return work


def work_uncertainty(path: Trajectory, case: Case) -> Vector:
    """Return the uncertainty of the work of a force that jumps inside a step, (k,) [J]."""
    uncertainty = np.zeros(len(path.t))
    for jump in case.jumps:
        after = int(np.searchsorted(path.t, jump))
        if case.force is not None and after < len(path.t):
            change = np.subtract(case.force(path.t[after]), case.force(path.t[after - 1]))
            displacement = np.diff(path.position(case.rod.end)[after - 1 : after + 1], axis=0)[0]
            uncertainty[after:] += 0.5 * abs(float(change @ displacement))
    return uncertainty


BEAMS = MapSpec(
    command="stability map",
    varied="Young's modulus",
    unit="Pa",
    scenes=SCENES,
    stiffnesses=(1e6, 1e7, 1e8, 1e9, 1e10, 2e11),
    steps=(1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2),
    integrators=methods.IMPLICIT,
    solvers=chosen(
        methods.SOLVERS,
        *("Newton", "auto", "modified Newton"),
        *(f"{update}, full" for update in QUASI_NEWTON.values()),
        *(f"{update}, {methods.PAIRS} pairs" for update in QUASI_NEWTON.values()),
    ),
    for_all_integrators=("Newton", "auto"),
    for_all_solvers=("Newmark(0)", "GeneralizedAlpha(0.8)"),
    t_end=2.0,
    max_steps=2000,
    # Largest turn [rad] and relative stretch of an element within a step; largest energy above the
    # supplied work, and loss at the end, over the largest kinetic energy.
    measures=("turn", "stretch", "gain", "loss"),
    measure=measure,
)


def select_calm(result: Stability) -> list[Run]:
    """Return the runs that took steps, all of them calm, and came to their end."""
    return [
        run for run in result.runs
        if run.is_complete
        and run.measures["turn"] < CALM_TURN
        and run.measures["stretch"] < CALM_STRETCH
    ]  # fmt: skip


def select_calm_of_others(result: Stability) -> list[Run]:
    """Return the calm runs of all solvers but Newton, which recovers their failed steps."""
    return [run for run in select_calm(result) if run.map_point.solver != "Newton"]


def findings(result: Stability) -> list[str]:
    """State the failures relative to Newton, recoveries of calm runs, and hidden gains."""
    others = select_calm_of_others(result)
    often = [run for run in others if run.newton > MAX_NEWTON_FRACTION]
    largest = max((run.newton for run in others), default=0.0)
    by_newton = [run for run in select_calm(result) if run.map_point.solver == "Newton"]
    own = max((run.newton for run in by_newton), default=0.0)
    return [
        *comparison(result),
        f"Where no element turns by {CALM_TURN:g} rad or stretches by {CALM_STRETCH:g} within a "
        f"step, in {len(others)} runs of other solvers, damped Newton saved at most "
        f"{100 * largest:.2g} % of the steps of a run (target: {100 * MAX_NEWTON_FRACTION:g} %, "
        f"{verdict(not often)}); of Newton's own calm runs, at most {100 * own:.2g} %.",
        *gains(
            result,
            "of the largest kinetic energy above the supplied work",
            lambda run: (
                f", with stretches of {100 * run.measures['stretch']:.2g} % and turns of "
                f"{run.measures['turn']:.2g} rad in a step"
            ),
        ),
    ]
