"""Methods for a motion without time integration: paths of equilibria, and sums of modes."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.plans.model_error.modal_truncation_error import (
    factor_equations,
    largest_displacement,
    linear_response,
    max_node_displacement,
    mean_frequency,
    modal_sum_errors,
    nonlinear_drift,
    rayleigh_frequency,
    truncation_bound,
    vibration_amplitude,
)
from ancfsparse.plans.model_error.quasi_static_error import (
    inertia_error,
    is_dynamic,
    lowest_frequency,
    max_load_acceleration,
    start_error,
)
from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.plans.quantities.tolerances import Goal
from ancfsparse.plans.trial_runs.cost_model import STEP_OVERHEAD
from ancfsparse.plans.trial_runs.load_resolution import (
    amplitudes_over_time,
    steps_resolving_loads,
    times_with_corners,
)
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.solutions.modes import Modes
from ancfsparse.scene import Scene
from ancfsparse.solve.equilibrium_paths.quasi_static import quasi_static
from ancfsparse.solve.motion.arguments import find_start_equilibrium
from ancfsparse.solve.statics.assemble import find_initial_state
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations
from ancfsparse.solve.statics.static_equilibrium import solve_static
from ancfsparse.solve.vibration.modal_response import modal_response
from ancfsparse.solve.vibration.modes import modes
from ancfsparse.system import State, System

MIN_LOAD_SAMPLES = 65  # times at which loads and prescribed motions are sampled
MAX_SOLVED_SAMPLES = 513  # times, if each sample takes a linear solve
RAYLEIGH_SAMPLES = 5  # times at which loads are sampled for the bound of the lowest frequency
MAX_INERTIA_RATIO = 1.0  # of the error by inertia to the tolerance; above, equilibria are not tried
RAYLEIGH_MARGIN = 3.0  # by which the bound of the lowest frequency must exceed that
STEPS_PER_PERIOD = 48  # of the lowest frequency, in the run that verifies equilibria
# Measured overhead of calls, relative to a residual of one coordinate.
FACTOR_OVERHEAD = 4e4  # of a factorization in statics
STATE_OVERHEAD = 1.2e3  # of a state of a sum of modes
MODE_OVERHEAD = 2e5  # of the computation of a mode
# Work per coordinate, relative to a residual.
MODE_STATE_WORK = 0.06  # of a mode in a state: three sums
MODE_WORK = 50.0  # of the computation of a mode
IMPLICIT_STEP_WORK = 5.0
MAX_SMALL_DISPLACEMENT = 0.2  # of the extent of the scene, for linear motions
TRUNCATION_FRACTION = 0.05  # of the tolerance, for the modes left out
FIRST_MODE_COUNT = 8  # modes
MAX_MODE_COUNT = 128  # modes, about
MIN_INTERVALS = 16  # between the saved states of the first trial run
STATES_PER_PERIOD = 8.0  # saved states per period of a vibration
STEP_COUNT_MARGIN = 4.0  # implicit steps over those that the slowest vibration needs


class SolutionMethod(ABC):
    """Method for a motion without steps of an integrator.

    Attributes
    ----------
    order : int
        Order of interpolation between saved states: 2 for lines, 4 for cubics.
    min_intervals : int
        Intervals between the saved states of the first trial run.
    start : str or None
        ``"equilibrium"`` if the motion begins there.
    options : frozenset of str
        Arguments of `simulate` that it takes as well.
    """

    order: ClassVar[int]
    options: ClassVar[frozenset[str]] = frozenset()
    min_intervals: int
    start: str | None

    @classmethod
    @abstractmethod
    def fit(
        cls, system: System, t_end: float, goals: Sequence[Goal], start: str | None = None
    ) -> SolutionMethod | None:
        """Return the method if it may apply to a scene, by estimates without a run; else None."""

    @abstractmethod
    def solve(self, scene: Scene, t_end: float, steps: int, **options: Any) -> Trajectory:
        """Return the motion with a number of intervals between saved states."""

    @abstractmethod
    def overhead(self, stats: RunStats, coordinates: int) -> float:
        """Return the work of a run in addition to residuals, solves and factorizations."""

    @abstractmethod
    def neglected(self, run: Trajectory, quantity: Quantity) -> dict[str, float]:
        """Estimate the error of the method by effect [unit of the quantity]."""

    @abstractmethod
    def steps_to_verify(self, run: Trajectory, error: float) -> float:
        """Return the number of steps of an integrator with a smaller relative error."""

    def richer(self) -> SolutionMethod | None:
        """Return a method that neglects less; None if there is none."""
        return None

    @property
    @abstractmethod
    def reason(self) -> str:
        """Reason for its selection, a sentence for plans."""


@dataclass(frozen=True)
class Statics(SolutionMethod):
    """Path of equilibria, see `quasi_static`.

    Attributes as in `SolutionMethod`.
    """

    min_intervals: int = field(default=MIN_INTERVALS, compare=False)
    start: str | None = None
    order: ClassVar[int] = 2
    options: ClassVar[frozenset[str]] = frozenset({"progress", "tolerance", "factorization"})

    @classmethod
    def fit(
        cls, system: System, t_end: float, goals: Sequence[Goal], start: str | None = None
    ) -> SolutionMethod | None:
        """Return it for a scene at rest with slow loads, and goals without velocities."""
        if any(each.quantity.depends_on_velocity for each in goals):
            return None
        if system.v0.any():
            return None
        changes = _time_dependent_loads(system, t_end)
        largest = max(each.error if each.relative else 1.0 for each in goals)
        limit = min(1.0, MAX_INERTIA_RATIO * largest)
        if not changes:
            return None
        rate = max_load_acceleration(changes, t_end)
        if _is_fast(system, t_end, rate, RAYLEIGH_MARGIN * limit):
            return None
        if is_dynamic(system.scene, t_end, changes, limit):
            return None
        return cls(steps_resolving_loads(system, t_end, MIN_INTERVALS), start=start)

    def solve(self, scene: Scene, t_end: float, steps: int, **options: Any) -> Trajectory:
        """Return the path of equilibria."""
        first = None if self.start is None else solve_static(scene)
        return quasi_static(scene, t_end, t_end / steps, start=first, **options)

    def overhead(self, stats: RunStats, coordinates: int) -> float:
        """Return the overhead of calls."""
        return FACTOR_OVERHEAD * stats.factorizations

    def neglected(self, run: Trajectory, quantity: Quantity) -> dict[str, float]:
        """Estimate the effects of inertia and damping, and of a start without equilibrium."""
        if run.stats.recoveries:  # where an equilibrium ceases to exist, the motion is fast
            return {"inertia": np.inf}
        return {"inertia": inertia_error(run, quantity), "start": start_error(run, quantity)}

    def steps_to_verify(self, run: Trajectory, error: float) -> float:
        """Return the number of steps that resolves the slowest vibration."""
        duration = float(run.t[-1] - run.t[0])
        return STEPS_PER_PERIOD * lowest_frequency(run) * duration / (2.0 * np.pi)

    @property
    def reason(self) -> str:
        """Reason for its selection."""
        return (
            "loads and prescribed motions are slow compared with the lowest natural frequency, so "
            "the motion is computed as a sequence of equilibria"
        )

    def __repr__(self) -> str:
        """Return its name."""
        return "statics at all times"


def _is_fast(system: System, t_end: float, rate: float, limit: float) -> bool:
    """Return True if loads are fast compared with the frequency of the displacement they cause.

    By Rayleigh's quotient the lowest frequency is no higher, unless large displacements stiffen
    the scene.
    """
    about = system.state(system.t0, system.q0, system.v0)
    equations = factor_equations(system, about)
    if equations is None:
        return False
    times = np.linspace(0.0, t_end, RAYLEIGH_SAMPLES)
    x = largest_displacement(system, linear_response(system, about, equations, times))
    if not 0.0 < max_node_displacement(system, x) <= _small_displacement(system, system.q0):
        return False
    return rate > limit * rayleigh_frequency(system, about, equations, x) ** 2


def _small_displacement(system: System, q: Vector) -> float:
    """Return the largest displacement that may be small, by the extent of a scene [m]."""
    positions = q[system.positions].reshape(-1, system.dim)
    return MAX_SMALL_DISPLACEMENT * float(np.ptp(positions, axis=0).max())


def _time_dependent_loads(system: System, t_end: float) -> list[Vector]:
    """Return tables over time of loads and prescribed motions that change, each (k, m)."""
    times = np.linspace(0.0, t_end, steps_resolving_loads(system, t_end, MIN_LOAD_SAMPLES - 1) + 1)
    return [table for table in amplitudes_over_time(system, times) if np.ptp(table, axis=0).any()]


@dataclass(frozen=True)
class ModalSum(SolutionMethod):
    """Sum of the lowest modes about the start, stress-free or at equilibrium; see `modal_response`.

    Attributes
    ----------
    n : int
        Number of modes, at most half the number of coordinates.
    """

    n: int
    min_intervals: int = field(default=MIN_INTERVALS, compare=False)
    start: str | None = None
    order: ClassVar[int] = 4

    @classmethod
    def fit(
        cls, system: System, t_end: float, goals: Sequence[Goal], start: str | None = None
    ) -> SolutionMethod | None:
        """Return it for small motions of a scene without prescribed motions."""
        if system.prescribed or not system.conservative:
            return None
        if any(each.quantity.needs_equations for each in goals):
            return None
        about = _state(system.scene, start)
        equations = factor_equations(system, about)
        if equations is None:
            return None
        limit = _small_displacement(system, about.q)
        intervals = steps_resolving_loads(system, t_end, MIN_INTERVALS)
        samples = min(max(MIN_LOAD_SAMPLES, intervals + 1), MAX_SOLVED_SAMPLES)
        times = times_with_corners(system, np.linspace(0.0, t_end, samples))
        response = linear_response(system, about, equations, times)
        largest = largest_displacement(system, response)
        if max_node_displacement(system, largest) > limit:
            return None
        args = system, about, equations, t_end
        if not about.v.any() and not cls._pays(*args, 2.0 * largest, goals):
            return None
        n = FIRST_MODE_COUNT
        while True:
            lowest = _modes(system.scene, n, about)
            if (lowest.eigenvalues <= 0.0).any():
                return None
            vibration = vibration_amplitude(lowest, system, largest)
            size = max_node_displacement(system, vibration)
            if size > limit or not cls._pays(*args, vibration, goals):
                return None
            error = min(_relative_error(each, size) for each in goals)
            missing = truncation_bound(lowest, system, response)
            if missing <= TRUNCATION_FRACTION * error * size or len(lowest) < n:
                phase = rayleigh_frequency(system, about, equations, vibration) * t_end
                # A coarse mesh without more modes does not show those of finer meshes.
                count = 2 * n if len(lowest) < n else n
                return cls(count, max(intervals, _intervals_resolving(phase)), start)
            n *= 2

    @classmethod
    def _pays(
        cls,
        system: System,
        about: State,
        equations: EquilibriumEquations,
        t_end: float,
        x: Vector,
        goals: Sequence[Goal],
    ) -> bool:
        """Return True if forces are nearly linear up to x, and time integration takes more work."""
        size = max_node_displacement(system, x)
        if size == 0.0:
            return False
        error = min(_relative_error(each, size) for each in goals)
        phase = rayleigh_frequency(system, about, equations, x) * t_end
        if nonlinear_drift(equations, system, about, x, 0.5 * phase) > error * size:
            return False
        steps = STEP_COUNT_MARGIN * phase * math.sqrt(phase / (12.0 * error))
        work = steps * IMPLICIT_STEP_WORK * (system.n_free + STEP_OVERHEAD)
        return _modal_work(FIRST_MODE_COUNT, _intervals_resolving(phase), system.n_free) < work

    def richer(self) -> SolutionMethod | None:
        """Return a sum of four times as many modes: point loads need many."""
        return replace(self, n=4 * self.n) if self.n < MAX_MODE_COUNT else None

    def solve(self, scene: Scene, t_end: float, steps: int, **options: Any) -> Trajectory:
        """Return the sum of the modes."""
        lowest = _modes(scene, self.n, _state(scene, self.start))
        return modal_response(lowest, t_end, t_end / steps, **options)

    def overhead(self, stats: RunStats, coordinates: int) -> float:
        """Return the overhead of calls, and the work of computing and summing modes."""
        return _modal_work(self.n, stats.steps, coordinates)

    def neglected(self, run: Trajectory, quantity: Quantity) -> dict[str, float]:
        """Estimate the effects of nonlinearity and of the modes left out."""
        scene = run.system.scene
        lowest = _modes(scene, self.n, _state(scene, self.start))
        return modal_sum_errors(lowest, run, quantity)

    def steps_to_verify(self, run: Trajectory, error: float) -> float:
        """Return the number of steps with phases exact to a tenth of the error."""
        phase = mean_frequency(run) * float(run.t[-1] - run.t[0])
        return max(STEPS_PER_PERIOD, phase * math.sqrt(max(phase, 1.0) / (1.2 * error)))

    @property
    def reason(self) -> str:
        """Reason for its selection."""
        where = "start" if self.start is None else "equilibrium at which it starts"
        return f"the motion is small, so it is computed as a sum of modes about the {where}"

    def __repr__(self) -> str:
        """Return its name."""
        return f"{self.n} modes"


def _modal_work(n: int, states: int, coordinates: int) -> float:
    """Return the work of computing n modes and summing them, without residuals."""
    computing = MODE_OVERHEAD + n * (MODE_OVERHEAD + MODE_WORK * coordinates)
    return computing + states * (STATE_OVERHEAD + MODE_STATE_WORK * n * coordinates)


def _intervals_resolving(phase: float) -> int:
    """Return the number of intervals between saved states for a vibration of a phase [rad]."""
    factor = max(1.0, STATES_PER_PERIOD * phase / (2.0 * np.pi * MIN_INTERVALS))
    return MIN_INTERVALS << math.ceil(math.log2(factor))


def _state(scene: Scene, start: str | None) -> State:
    """Return the initial state of a motion."""
    if start is not None:
        return find_start_equilibrium(scene, start).state
    moved, _ = find_initial_state(scene, None)
    if moved is not None:
        return moved
    system = System(scene)
    return system.state(system.t0, system.q0, system.v0)


def _modes(scene: Scene, n: int, at: State) -> Modes:
    """Return the lowest modes about a state, at most as many as the mesh resolves."""
    system = System(scene)
    limit = (system.n_free - system.n_multipliers) // 2
    return modes(scene, max(1, min(n, limit)), at=at)


def _relative_error(goal: Goal, size: float) -> float:
    """Return the tolerance relative to a motion of a size [m], if that is known."""
    if goal.relative:
        return goal.error
    return goal.error / size if goal.quantity.is_displacement and size > 0.0 else 1e-3
