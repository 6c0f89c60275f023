"""One run of the stability map: how it ended, and what follows from its stored states."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import EnergyIncreaseError, StepError
from ancfsparse.results import Trajectory
from ancfsparse.solve import simulate
from benchmarks.common import methods
from benchmarks.common.methods import chosen
from benchmarks.common.paper import QUASI_NEWTON
from benchmarks.stability.scenes import SCENES, Case

Vector = NDArray[np.float64]

T_END, MOST_STEPS = 2.0, 2000
"""A run lasts so long [s], or so many steps if that is shorter."""

FINISHED, RECOVERED, GAINED, FAILED = "finished", "recovered", "gained energy", "failed"
OUTCOMES = (FINISHED, RECOVERED, GAINED, FAILED)
"""Without help; with steps that a rung of the ladder saved; stopped by the watch; stopped."""

INTEGRATORS = methods.IMPLICIT
"""By their names in tables."""

SOLVERS = chosen(
    methods.SOLVERS,
    *("Newton", "auto", "modified Newton"),
    *(f"{update}, full" for update in QUASI_NEWTON.values()),
    *(f"{update}, {methods.PAIRS} pairs" for update in QUASI_NEWTON.values()),
)
"""By their names in tables."""


# Relative change of Young's modulus between neighbouring runs, and their number on either side.
MOVED, MOVES = 1e-9, 10


class Place(NamedTuple):
    """A point of the map: keys of `SCENES`, `INTEGRATORS`, `SOLVERS`; Pa and s."""

    scene: str
    youngs_modulus: float
    dt: float
    integrator: str
    solver: str

    @property
    def steps(self) -> int:
        """Number of steps of a whole run."""
        return min(MOST_STEPS, round(T_END / self.dt))


@dataclass(frozen=True)
class Run:
    """What happened at a point of the map.

    Attributes
    ----------
    place : Place
        Where.
    outcome : str
        One of `OUTCOMES`.
    steps : int
        Steps that were accepted.
    reason : str
        Why it was stopped, empty if it was not.
    iterations : float
        Corrections per step.
    new_seed, newton : float
        Shares of the steps that a new seed, and damped Newton or a rung above it, saved.
    turn : float
        Largest turn of an element within a step [rad].
    stretch : float
        Largest change of the length of an element within a step, over its length.
    gain, loss : float
        Most energy above what was given, and energy lost at the end, over the largest kinetic
        energy: from the stored states.
    chaotic : bool
        Whether it ended otherwise than Newton's run by chance alone, see `ends_by_chance`.
    """

    place: Place
    outcome: str
    steps: int
    reason: str
    iterations: float
    new_seed: float
    newton: float
    turn: float
    stretch: float
    gain: float
    loss: float
    chaotic: bool = False

    @property
    def whole(self) -> bool:
        """Whether it came to its end."""
        return self.outcome in (FINISHED, RECOVERED)

    def record(self) -> dict[str, Any]:
        """Return a row of the table, short: three digits."""
        return {
            **self.place._asdict(),
            "outcome": self.outcome,
            "steps": self.steps,
            "reason": self.reason,
            "iterations": round(self.iterations, 2),
            **{
                name: float(f"{getattr(self, name):.2e}")
                for name in ("new_seed", "newton", "turn", "stretch", "gain", "loss")
            },
            "chaotic": int(self.chaotic),
        }

    @classmethod
    def of(cls, row: dict[str, str]) -> Run:
        """Make a run of a row of the table."""
        place = Place(
            row["scene"], float(row["youngs_modulus"]), float(row["dt"]), row["integrator"],
            row["solver"],
        )  # fmt: skip
        chaotic = row["chaotic"] == "1"
        numbers = ("iterations", "new_seed", "newton", "turn", "stretch", "gain", "loss")
        values = {name: float(row[name]) for name in numbers}
        return cls(
            place, row["outcome"], int(row["steps"]), row["reason"], **values, chaotic=chaotic
        )  # fmt: skip


def run_at(place: Place) -> Run:
    """March a point of the map; being stopped is a result."""
    case = SCENES[place.scene](place.youngs_modulus)
    reason = ""
    try:
        path = simulate(
            case.scene, place.steps * place.dt, place.dt, integrator=INTEGRATORS[place.integrator],
            solver=SOLVERS[place.solver],
        )  # fmt: skip
        outcome = RECOVERED if path.stats.recoveries else FINISHED
    except EnergyIncreaseError as stop:
        path, outcome, reason = stop.trajectory, GAINED, "energy"
    except StepError as stop:
        path, outcome = stop.trajectory, FAILED
        reason = path.stats.events[-1].cause if path.stats.events else stop.reason
    new_seed, newton = saved_shares(path)
    turn, stretch = largest_changes(path, case)
    gain, loss = energy_balance(path, case)
    return Run(
        place, outcome, path.stats.steps, reason, path.stats.iterations_per_step, new_seed, newton,
        turn, stretch, gain, loss,
    )  # fmt: skip


def ends_by_chance(place: Place) -> bool:
    """Return whether runs beside a place end either way: its solver's and Newton's too.

    They differ by billionths of Young's modulus: the solver finishes some of them, and Newton not
    all.  Near its limit a motion is chaotic, and whether one run of it completes is no property of
    the solver.
    """
    beside = [
        place._replace(youngs_modulus=place.youngs_modulus * (1.0 + k * MOVED))
        for k in range(-MOVES, MOVES + 1) if k
    ]  # fmt: skip
    return any(run_at(each).whole for each in beside) and not all(
        run_at(each._replace(solver="Newton")).whole for each in beside
    )


def saved_shares(path: Trajectory) -> tuple[float, float]:
    """Return the shares of the steps that a new seed, and a rung of Newton's, saved.

    Of the steps up to the last event that was kept, if some were not.
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
    energy, unsure = path.energy, unsure_work(path, case)
    above = energy.total - energy.total[0] - work_of(path, case)
    above -= np.clip(above, -unsure, unsure)
    largest = float(energy.kinetic.max())
    if largest == 0.0:
        return 0.0, 0.0
    return max(float(above.max()) / largest, 0.0), max(-float(above[-1]) / largest, 0.0)


def work_of(path: Trajectory, case: Case) -> Vector:
    """Return the work of the force on the end, summed over the way it went, (k,) [J]."""
    work = np.zeros(len(path.t))
    if case.force is not None:
        force = np.array([case.force(t) for t in path.t])
        way = np.diff(path.position(case.rod.end), axis=0)
        work[1:] = np.cumsum(np.sum(0.5 * (force[1:] + force[:-1]) * way, axis=1))
    return work


def unsure_work(path: Trajectory, case: Case) -> Vector:
    """Return what the work may be off by since the force jumped inside a step, (k,) [J]."""
    unsure = np.zeros(len(path.t))
    for jump in case.jumps:
        after = int(np.searchsorted(path.t, jump))
        if case.force is not None and after < len(path.t):
            change = np.subtract(case.force(path.t[after]), case.force(path.t[after - 1]))
            way = np.diff(path.position(case.rod.end)[after - 1 : after + 1], axis=0)[0]
            unsure[after:] += 0.5 * abs(float(change @ way))
    return unsure


def kinds(run: Run) -> str:
    """Name the outcome with its rung or its reason, for text."""
    if run.outcome == RECOVERED:
        rung = "damped Newton" if run.newton > 0.0 else "a new seed"
        return f"recovered by {rung} in {100 * (run.newton + run.new_seed):.2g} % of the steps"
    if run.whole:
        return run.outcome
    text = f"{run.outcome} at {run.steps * run.place.dt:.3g} s"
    return f"{text} ({run.reason})" if run.outcome == FAILED else text
