"""Cells of table 1: one method on one element, timed and compared with a reference."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeVar

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import StepError
from ancfsparse.integrators import Newmark
from ancfsparse.integrators.interface.time_grid import count_steps
from ancfsparse.nonlinear import Method
from ancfsparse.problems import Problem, pendulum
from ancfsparse.results import Trajectory
from ancfsparse.results.data.interpolation import interpolate
from ancfsparse.solve import simulate
from ancfsparse.system import System
from benchmarks.common import paper
from benchmarks.common.first_order import FirstOrder, OdeRun, OutOfTimeError, integrate
from benchmarks.common.methods import SOLVERS
from benchmarks.common.timing import in_turn

Run = TypeVar("Run")

REFERENCE = "DOP853"
# Stability bounds its steps, so the error is far below: 1e-11 m where compared.  Much tighter
# tolerances meet the rounding of the forces and cost many times the steps.
REFERENCE_RTOL = 1e-8
REFERENCE_ATOL = 1e-9  # [m]

OUTPUT_TIMES = 400  # approximate number of times at which tips are compared
MIN_TOTAL_TIME = 1.0  # of the repeated runs of a cell [s]

METHODS: dict[str, Method | str] = {
    **{name: SOLVERS[f"{update}, full"] for name, update in paper.QUASI_NEWTON.items()},
    "Newton": SOLVERS["Newton"],
    "Modified Newton": SOLVERS["modified Newton"],
}
"""Our methods by column."""

COLUMNS = (*paper.ODE_FUNCTIONS, *METHODS)
"""All columns of the table."""


@dataclass(frozen=True)
class Row:
    """Element and dimension of a row."""

    element: str
    dim: int

    def problem(self) -> Problem:
        """Return its scene and rod."""
        return pendulum(self.element, paper.ELEMENTS, self.dim)


ROWS = {
    "L2T2": Row("l2t2", 2),
    "Thin": Row("thin", 3),
    "Thick": Row("thick", 3),
    "Thick, in the plane": Row("thick", 2),
}
"""The rows; the paper has the first three."""


@dataclass(frozen=True)
class Cell:
    """One method on one element."""

    # keys of `ROWS` and of `COLUMNS`
    row: str
    column: str
    # median wall time, of SciPy's integration or of our compiled time loop [s]; NaN without result
    seconds: float = math.nan
    runs: int = 0  # number of runs of the median
    # wall time from the scene to the first step of the last of these runs [s]; NaN for SciPy
    set_up_seconds: float = math.nan
    # (k, dim), tip at the output times [m]
    tip: Vector | None = field(default=None, repr=False)
    # largest distance of the tip from the reference [m]; NaN without result
    tip_error: float = math.nan
    evaluations: int = 0  # evaluations of the right-hand side or of the residual
    iterations_per_step: float = math.nan  # corrections per time step; NaN where there are none
    note: str = ""  # reason without result

    @property
    def finished(self) -> bool:
        """True if there is a result."""
        return self.tip is not None

    @property
    def paper_seconds(self) -> float:
        """The paper's time [s]; NaN where it has none."""
        return paper.SECONDS.get(self.row, {}).get(self.column, math.nan)

    @property
    def speed_up(self) -> float:
        """The paper's time over ours; NaN where one is missing."""
        return self.paper_seconds / self.seconds

    def record(self) -> dict[str, str | float | None]:
        """Return the entries of the CSV table; None where there is no result."""
        record: dict[str, str | float | None] = {
            "element": self.row,
            "method": self.column,
            "stands_for": paper.ODE_FUNCTIONS.get(self.column, ""),
            "seconds": self.seconds,
            "paper_seconds": self.paper_seconds,
            "speed_up": self.speed_up,
            "iterations_per_step": self.iterations_per_step,
            "evaluations": self.evaluations,
            "tip_error_m": self.tip_error,
            "runs": self.runs,
            "set_up_seconds": self.set_up_seconds,
            "note": self.note,
        }
        return {key: None if value != value else value for key, value in record.items()}


@dataclass
class Bench:
    """The pendulum of one row, ready to be run by every method."""

    row: str  # key of `ROWS`
    t_end: float  # [s]
    dt: float  # [s]
    reference: Vector  # (k, dim), tip on the same mesh, converged in time [m]
    cap: float  # time limit of an integrator of SciPy [s]
    runs: int  # of a fast cell
    on_time: Callable[[float], None] | None = None  # called with the simulated time now and then

    def __post_init__(self) -> None:
        """Set up the equations and the output times."""
        self.problem = ROWS[self.row].problem()
        self._system = System(self.problem.scene)
        self._equations = FirstOrder(self._system)
        self._every, self.t = output_times(self.t_end, self.dt)

    def run(self, column: str, divide: int = 1) -> Cell:
        """Fill a cell; the time step of one of our methods is divided by a whole number."""
        empty = Cell(self.row, column)
        fill = partial(self._march, divide=divide) if column in METHODS else self._integrate
        try:
            entries = repeated(lambda: fill(column), self.runs)
        except StepError as failure:
            return replace(empty, note=f"failed at {failure.time:.3g} s")
        except OutOfTimeError:
            return replace(empty, note=f"> {self.cap:g} s")
        except RuntimeError as failure:
            return replace(empty, note=str(failure))
        seconds = statistics.median(each.seconds for each in entries)
        return replace(entries[-1], seconds=seconds, runs=len(entries))

    def _march(self, column: str, divide: int) -> Cell:
        every = self._every * divide
        run = simulate_paper(self.problem, column, self.t_end, self.dt / divide, every)
        tip = run.position(self.problem.rod.end)
        return Cell(
            self.row,
            column,
            run.stats.march_seconds,
            set_up_seconds=run.stats.seconds["set-up"],
            tip=tip,
            tip_error=self._error(tip),
            evaluations=run.stats.residual_evaluations,
            iterations_per_step=run.stats.iterations_per_step,
        )

    def _integrate(self, column: str) -> Cell:
        tolerances = paper.RTOL, paper.ATOL
        run = integrate(
            self._equations, column, self.t, *tolerances, cap=self.cap, on_time=self.on_time
        )
        tip = tip_of(self.problem, self._system, run)
        return Cell(
            self.row,
            column,
            run.seconds,
            tip=tip,
            tip_error=self._error(tip),
            evaluations=run.evaluations,
        )

    def _error(self, tip: Vector) -> float:
        return float(np.linalg.norm(tip - self.reference, axis=1).max())


def reference(row: str, t_end: float, dt: float) -> Vector:
    """Return the tip at the output times, on the mesh of a row, converged in time.

    By an explicit method of order 8, which shares nothing with the methods compared with it but
    the forces: (k, dim) [m].
    """
    problem = ROWS[row].problem()
    system = System(problem.scene)
    _, t = output_times(t_end, dt)
    run = integrate(FirstOrder(system), REFERENCE, t, REFERENCE_RTOL, REFERENCE_ATOL)
    return tip_of(problem, system, run)


def tip_of(problem: Problem, system: System, run: OdeRun) -> Vector:
    """Return the tip at the output times of a run, (k, dim) [m]."""
    return interpolate(system.point(problem.rod.end), run.q)


def simulate_paper(
    problem: Problem, column: str, t_end: float, dt: float, save_every: int = 1
) -> Trajectory:
    """Simulate as the paper does: the trapezoidal rule, and its bounds on the residual."""
    return simulate(
        problem.scene,
        t_end,
        dt,
        integrator=Newmark(0.0),
        solver=METHODS[column],
        tolerance="paper",
        save_every=save_every,
    )


def output_times(t_end: float, dt: float) -> tuple[int, Vector]:
    """Return the number of steps between output times, and these times, (k,) [s]."""
    steps = count_steps(t_end, dt)
    every = next(
        each for each in range(max(1, steps // OUTPUT_TIMES), steps + 1) if steps % each == 0
    )
    return every, np.arange(steps // every + 1, dtype=np.float64) * (dt * every)


def repeated(once: Callable[[], Run], runs: int) -> list[Run]:
    """Run up to `runs` times, until they have taken `MIN_TOTAL_TIME`."""
    begin = time.perf_counter()
    (entries,) = in_turn(
        [once],
        lambda each: each(),
        runs,
        goes_on=lambda *_: time.perf_counter() - begin < MIN_TOTAL_TIME,
    )
    return entries
