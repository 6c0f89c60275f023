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
from numpy.typing import NDArray

from ancfsparse.errors import StepError
from ancfsparse.integrators import Newmark
from ancfsparse.integrators.interface.time_grid import count_steps
from ancfsparse.nonlinear import Method
from ancfsparse.problems import Problem, pendulum
from ancfsparse.results import Trajectory
from ancfsparse.results.data.interpolation import combine
from ancfsparse.solve import simulate
from ancfsparse.system import System
from benchmarks.common import paper
from benchmarks.common.first_order import FirstOrder, OdeRun, OutOfTimeError, integrate
from benchmarks.common.methods import SOLVERS
from benchmarks.common.timing import in_turn

Vector = NDArray[np.float64]
Kept = TypeVar("Kept")

REFERENCE = "DOP853"
# Stability bounds its steps, so the error is far below: 1e-11 m where compared.  Much tighter
# tolerances meet the rounding of the forces and cost many times the steps.
REFERENCE_RTOL, REFERENCE_ATOL = 1e-8, 1e-9

# Tips are compared, and drawn, at about this many times after the start.
INSTANTS = 400

# A cell is not run again once its runs have taken so long [s].
LONG_ENOUGH = 1.0

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
    """How the pendulum of a row is set up."""

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
    """One method on one element.

    Attributes
    ----------
    row, column : str
        Keys of `ROWS` and of `COLUMNS`.
    seconds : float
        Median wall time, of SciPy's integration or of our compiled march [s]; NaN without result.
    runs : int
        How many times the median is of.
    set_up_seconds : float
        Wall time from the scene to the first step of the last of these runs [s]; NaN for SciPy.
    tip : (k, dim) float or None
        Tip at the instants of the table [m].
    tip_error : float
        Largest distance of the tip from the reference [m]; NaN without result.
    evaluations : int
        Evaluations of the right-hand side or of the residual.
    iterations_per_step : float
        Corrections per time step; NaN where there are none.
    note : str
        What stands in the place of a result.
    """

    row: str
    column: str
    seconds: float = math.nan
    runs: int = 0
    set_up_seconds: float = math.nan
    tip: Vector | None = field(default=None, repr=False)
    tip_error: float = math.nan
    evaluations: int = 0
    iterations_per_step: float = math.nan
    note: str = ""

    @property
    def finished(self) -> bool:
        """Whether there is a result."""
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
        """Return everything but the tip, by the names that files use; None for what is missing."""
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


class Bench:
    """The pendulum of one row, ready to be run by every method.

    Parameters
    ----------
    row : str
        Key of `ROWS`.
    t_end, dt : float
        Simulated time and time step [s].
    reference : (k, dim) float
        Tip on the same mesh, converged in time [m], see `reference`.
    cap : float
        Wall time an integrator of SciPy may take [s].
    runs : int
        How often a fast cell is run.
    on_time : callable, optional
        Called with the simulated time now and then.

    Attributes
    ----------
    t : (k,) float
        Instants at which tips are compared [s].
    """

    def __init__(
        self,
        row: str,
        t_end: float,
        dt: float,
        reference: Vector,
        cap: float,
        runs: int,
        on_time: Callable[[float], None] | None = None,
    ) -> None:
        self.row, self.dt, self._t_end = row, dt, t_end
        self._reference = reference
        self._cap, self._runs, self._on_time = cap, runs, on_time
        self.problem = ROWS[row].problem()
        self._system = System(self.problem.scene)
        self._equations = FirstOrder(self._system)
        self._every, self.t = instants(t_end, dt)

    def run(self, column: str, divide: int = 1) -> Cell:
        """Fill a cell; the time step of one of our methods is divided by a whole number."""
        empty = Cell(self.row, column)
        fill = partial(self._march, divide=divide) if column in METHODS else self._integrate
        try:
            found = repeated(lambda: fill(column), self._runs)
        except StepError as failure:
            return replace(empty, note=f"failed at {failure.time:.3g} s")
        except OutOfTimeError:
            return replace(empty, note=f"> {self._cap:g} s")
        except RuntimeError as failure:
            return replace(empty, note=str(failure))
        seconds = statistics.median(each.seconds for each in found)
        return replace(found[-1], seconds=seconds, runs=len(found))

    def _march(self, column: str, divide: int) -> Cell:
        every = self._every * divide
        run = march(self.problem, column, self._t_end, self.dt / divide, every)
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
            self._equations, column, self.t, *tolerances, cap=self._cap, on_time=self._on_time
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
        return float(np.linalg.norm(tip - self._reference, axis=1).max())


def reference(row: str, t_end: float, dt: float) -> Vector:
    """Return the tip at the instants of the table, on the mesh of a row, converged in time.

    By an explicit method of order 8, which shares nothing with the methods compared with it but
    the forces: (k, dim) [m].
    """
    problem = ROWS[row].problem()
    system = System(problem.scene)
    _, t = instants(t_end, dt)
    run = integrate(FirstOrder(system), REFERENCE, t, REFERENCE_RTOL, REFERENCE_ATOL)
    return tip_of(problem, system, run)


def tip_of(problem: Problem, system: System, run: OdeRun) -> Vector:
    """Return where the tip is at the instants of a run: (k, dim) [m]."""
    return combine(system.point(problem.rod.end), run.q)


def march(
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


def instants(t_end: float, dt: float) -> tuple[int, Vector]:
    """Return every how many steps the tip is compared, and when: (k,) [s]."""
    steps = count_steps(t_end, dt)
    every = next(each for each in range(max(1, steps // INSTANTS), steps + 1) if steps % each == 0)
    return every, np.arange(steps // every + 1, dtype=np.float64) * (dt * every)


def repeated(once: Callable[[], Kept], runs: int) -> list[Kept]:
    """Run so many times, but not again once that has taken `LONG_ENOUGH`."""
    begin = time.perf_counter()
    (found,) = in_turn(
        [once],
        lambda each: each(),
        runs,
        goes_on=lambda *_: time.perf_counter() - begin < LONG_ENOUGH,
    )
    return found
