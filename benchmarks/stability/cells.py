"""One run of the stability map: its outcome, and measures of its stored states."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import EnergyIncreaseError, StepError
from ancfsparse.results import Trajectory
from ancfsparse.solve import simulate
from benchmarks.common import methods
from benchmarks.common.methods import chosen
from benchmarks.common.paper import QUASI_NEWTON
from benchmarks.stability.scenes import SCENES, Case

T_END = 2.0  # of a run [s], or
MAX_STEPS = 2000  # if these are shorter

FINISHED, RECOVERED, GAINED, FAILED = "finished", "recovered", "gained energy", "failed"
OUTCOMES = (FINISHED, RECOVERED, GAINED, FAILED)
"""Complete; complete with recovered steps; stopped for its energy; stopped."""

INTEGRATORS = methods.IMPLICIT
"""By their names in tables."""

SOLVERS = chosen(
    methods.SOLVERS,
    *("Newton", "auto", "modified Newton"),
    *(f"{update}, full" for update in QUASI_NEWTON.values()),
    *(f"{update}, {methods.PAIRS} pairs" for update in QUASI_NEWTON.values()),
)
"""By their names in tables."""


PERTURBATION = 1e-9  # relative change of Young's modulus between neighbouring runs
PERTURBATIONS = 10  # neighbouring runs on either side
MIN_COMPLETION_RATIO = 0.5  # complete neighbours over Newton's; 0.67 to 0.93 of the map's four runs


class MapPoint(NamedTuple):
    """A point of the map: keys of `SCENES`, `INTEGRATORS`, `SOLVERS`; Pa and s."""

    scene: str
    youngs_modulus: float
    dt: float
    integrator: str
    solver: str

    @property
    def steps(self) -> int:
        """Number of steps of a whole run."""
        return min(MAX_STEPS, round(T_END / self.dt))


@dataclass(frozen=True)
class Run:
    """The outcome at a point of the map."""

    map_point: MapPoint
    outcome: str  # one of `OUTCOMES`
    steps: int  # steps that were accepted
    reason: str  # why it was stopped, empty if it was not
    iterations: float  # corrections per step
    # fractions of the steps recovered by a new seed, and by damped Newton or beyond
    new_seed: float
    newton: float
    turn: float  # largest turn of an element within a step [rad]
    stretch: float  # largest change of the length of an element within a step, over its length
    # largest energy above the supplied work, and loss at the end, over the largest kinetic energy:
    # from the stored states
    gain: float
    loss: float
    # whether it ended otherwise than Newton's run by chance alone, see `ends_by_chance`
    chaotic: bool = False

    @property
    def is_complete(self) -> bool:
        """True if it came to its end."""
        return self.outcome in (FINISHED, RECOVERED)

    def record(self) -> dict[str, Any]:
        """Return a row of the table, short: three digits."""
        row: dict[str, Any] = self.map_point._asdict()
        for each in fields(self)[1:]:
            value = getattr(self, each.name)
            row[each.name] = float(f"{value:.2e}") if isinstance(value, float) else value
        return row | {"iterations": round(self.iterations, 2), "chaotic": int(self.chaotic)}

    @classmethod
    def of(cls, row: dict[str, str]) -> Run:
        """Make a run of a row of the table."""
        map_point = MapPoint(
            row["scene"], float(row["youngs_modulus"]), float(row["dt"]), row["integrator"],
            row["solver"],
        )  # fmt: skip
        numbers: dict[str, Any] = {
            each.name: float(row[each.name]) for each in fields(cls) if each.type == "float"
        }
        ending = row["outcome"], int(row["steps"]), row["reason"]
        return cls(map_point, *ending, **numbers, chaotic=row["chaotic"] == "1")


def run_at(map_point: MapPoint) -> Run:
    """Run a point of the map; an early end is a result."""
    case = SCENES[map_point.scene](map_point.youngs_modulus)
    reason = ""
    try:
        path = simulate(
            case.scene, map_point.steps * map_point.dt, map_point.dt,
            integrator=INTEGRATORS[map_point.integrator], solver=SOLVERS[map_point.solver],
        )  # fmt: skip
        outcome = RECOVERED if path.stats.recoveries else FINISHED
    except EnergyIncreaseError as stop:
        path, outcome, reason = stop.trajectory, GAINED, "energy"
    except StepError as stop:
        path, outcome = stop.trajectory, FAILED
        reason = path.stats.events[-1].cause if path.stats.events else str(stop.reason)
    new_seed, newton = recovered_fractions(path)
    turn, stretch = largest_changes(path, case)
    gain, loss = energy_balance(path, case)
    return Run(
        map_point, outcome, path.stats.steps, reason, path.stats.iterations_per_step, new_seed,
        newton, turn, stretch, gain, loss,
    )  # fmt: skip


def ends_by_chance(map_point: MapPoint) -> bool:
    """Return True if the solver finishes at least half as many neighbours as Newton, who not all.

    Neighbouring runs differ by billionths of Young's modulus.  Near its limit a motion is chaotic,
    and the outcome of one run is no property of the solver; the fraction of its neighbours is.
    """
    neighbours = [
        map_point._replace(youngs_modulus=map_point.youngs_modulus * (1.0 + k * PERTURBATION))
        for k in range(-PERTURBATIONS, PERTURBATIONS + 1) if k
    ]  # fmt: skip
    newton = sum(run_at(each._replace(solver="Newton")).is_complete for each in neighbours)
    if newton == len(neighbours):
        return False
    return sum(run_at(each).is_complete for each in neighbours) >= MIN_COMPLETION_RATIO * newton


def recovered_fractions(path: Trajectory) -> tuple[float, float]:
    """Return the fractions of steps recovered by a new seed, and by damped Newton or beyond.

    Of the steps up to the last stored event, if some were not stored.
    """
    stats = path.stats
    if not stats.recoveries:
        return 0.0, 0.0
    newton = {e.step for e in stats.events if e.rung != "new seed" and e.step <= stats.steps}
    seed = {e.step for e in stats.events if e.step <= stats.steps} - newton
    listed = stats.steps if len(newton | seed) == stats.recoveries else stats.events[-1].step
    return len(seed) / listed, len(newton) / listed


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
    """Return gain and loss of energy over the largest kinetic energy; see `Run`."""
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


def in_words(run: Run) -> str:
    """Name the outcome with its recovery or its reason."""
    if run.outcome == RECOVERED:
        by = "damped Newton" if run.newton > 0.0 else "a new seed"
        return f"recovered by {by} in {100 * (run.newton + run.new_seed):.2g} % of the steps"
    if run.is_complete:
        return run.outcome
    text = f"{run.outcome} at {run.steps * run.map_point.dt:.3g} s"
    return f"{text} ({run.reason})" if run.outcome == FAILED else text
