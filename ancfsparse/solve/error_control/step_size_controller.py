"""Step-size control by a local error estimate.

The steps that were taken form a pattern, which another run can repeat with each step divided.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError, Parameter
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.interface.time_grid import MAX_STEPS
from ancfsparse.nonlinear import Method, Outcome
from ancfsparse.results import Event, RunStats
from ancfsparse.solve.error_models.cost_per_step import StepCostMonitor
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.initial_conditions.prescribed_start import inputs_at
from ancfsparse.solve.stepping.implicit_setup import iteration_costs, prepare_implicit
from ancfsparse.solve.stepping.outcome_reporting import (
    CAUSE_NAMES,
    FailedStep,
    count_costs,
    recovery_events,
    step_error,
)
from ancfsparse.solve.stepping.remedies import hint_for_accuracy
from ancfsparse.solve.stepping.sampled_states import SampledStates, steps_at_once
from ancfsparse.solve.stepping.step_size_change import StepSizeChange
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.seeds import Seed

# Equal steps in a row, (step [s], number), for each interval of smooth loads.
Pattern = list[list[tuple[float, int]]]

# Steps change by powers of this ratio, seldom, so that a factor serves for several.
STEP_RATIO = math.sqrt(2.0)
N_EASY_STEPS = 8  # easy steps in a row before they grow
N_LAST_STEPS = 8  # steps before the end of an interval, adjusted to hit the end exactly
SAFETY_FACTOR = 0.7  # error of a larger step over the allowed one, below which steps grow
ITERATION_RATIO = 0.03  # remaining error of the iteration over the error of a step
MIN_STEP = 1e-10  # step over the duration of the run
MAX_EVENTS = 1000  # listed events
STEP_ROUNDING = 1e-9  # relative rounding of a number of steps


class BudgetExceeded(Exception):
    """A run has exceeded its budget."""


class StepSizeController:
    """One run with a bounded local error, or with the divided steps of another run.

    Parameters
    ----------
    system : System
        The moving system.
    integrator : Implicit
        A scheme of second order.
    solver : Method or "auto"
        Nonlinear solver.
    local_error : float
        Allowed error of a step, root mean square weighted by mass [m].
    dt : float
        First step [s].
    t : (k,) float
        Output times, from the start on [s].
    max_energy_gain, threads
        As in `simulate`.
    discontinuities : LoadDiscontinuities, optional
        Discontinuities of the loads, at which steps end.
    watch : callable, optional
        Called with the states whenever more are known.
    pattern : list, optional
        Steps to take, regardless of their error.
    iteration_error_rate : float, optional
        Remaining error of the iteration in a step over the square of the step [m/s^2].  Where steps
        are not given, a fraction of their allowed error is another limit.
    budget : float, optional
        Cost in the unit of `Costs` at which the run ends with `BudgetExceeded`.

    Attributes
    ----------
    pattern : list
        The steps taken.
    costs : Costs
        Costs of a residual, a solution and a factor.
    """

    def __init__(
        self,
        system: System,
        integrator: Implicit,
        solver: Method | str,
        local_error: float,
        dt: float,
        t: Vector,
        max_energy_gain: float,
        threads: int = 1,
        *,
        discontinuities: LoadDiscontinuities | None = None,
        watch: Callable[[SampledStates], None] | None = None,
        pattern: Pattern | None = None,
        iteration_error_rate: float = math.inf,
        budget: float = math.inf,
    ) -> None:
        begin = time.perf_counter()
        self.system, self.integrator = system, integrator
        self.local_error, self.max_energy_gain = local_error, max_energy_gain
        self._longest = math.inf if discontinuities is None else discontinuities.longest_step
        self.dt = min(dt, self._longest) if pattern is None else pattern[0][0][0]
        self._given, self.pattern = pattern, list[list[tuple[float, int]]]()
        self._discontinuities, self._watch, self._budget = discontinuities, watch, budget
        self.seed: Seed
        self.time_loop, self.iteration, self.seed, self.criterion, why, a, _ = prepare_implicit(
            system, self.dt, integrator, solver, "default", max_energy_gain, threads
        )
        self.costs = iteration_costs(system, integrator, self.seed, None)
        self.iteration_error = ITERATION_RATIO * local_error if pattern is None else math.inf
        self._iteration_error_rate = iteration_error_rate
        self._set_iteration_error(self.dt)
        error = abs(integrator.velocity_constant)  # the position's is the same, 1/12 + shift^2 / 4
        limit, easy = local_error, SAFETY_FACTOR * local_error / STEP_RATIO**3
        if pattern is not None:
            limit, easy = math.inf, -1.0
        self.time_loop.control(self.seed, _mass_weights(system), error, limit, easy, N_EASY_STEPS)
        q, _, _, lam = self.time_loop.state
        n, m, h = system.n_all, system.n_multipliers, system.assembly.n_history
        self.states = SampledStates.empty(t, n, m, h)
        self.states.begin(q, system.v0, a, lam, system.assembly.history)
        self._step_change = StepSizeChange(system, integrator, self.time_loop, self.seed)
        self._cost_monitor = StepCostMonitor(self.costs, STEP_RATIO)
        self.stats = RunStats(solver=why, seconds={"set-up": time.perf_counter() - begin})
        self._buffer = [np.empty((steps_at_once(n) + 1, width)) for width in (n, n, n, m, h)]
        if h:
            self.time_loop.save_history(self._buffer[-1])

    def run(self) -> SampledStates:
        """Integrate over all output times.

        Raises
        ------
        StepError, EnergyIncreaseError
            Without a trajectory.
        BudgetExceeded
            If the run has exceeded its budget.
        """
        t_end = float(self.states.t[-1])
        t_start = self.system.t0
        spans = [(t_start, t_end)] if self._discontinuities is None else self._discontinuities.spans
        try:
            now = t_start
            for k, (begin, end) in enumerate(spans):
                t_next = t_end if k + 1 == len(spans) else spans[k + 1][0]
                self.pattern.append([])
                if self._given is None:
                    self._integrate_adaptively(now, t_next, begin, end)
                else:
                    self._repeat_pattern(self._given[k], now, t_next, begin, end)
                now = t_next
                if k + 1 < len(spans):
                    self._step_change.jump(self.dt, end, now)
                    self._continue(self.dt)
            if self.time_loop.gained_energy():
                raise self._stopped(Outcome.HAD_GAINED, now)
        finally:
            self._count()
        return self.states

    def _count(self) -> None:
        count_costs(self.stats, self.iteration, self.seed)
        self.stats.factorizations += self._step_change.factors
        self.stats.solves += self._step_change.factors

    def _integrate_adaptively(self, now: float, t_next: float, begin: float, end: float) -> None:
        """Take steps with the allowed error over an interval of smooth loads."""
        regular = self.dt
        while now < t_next:
            if (t_next - now) / self.dt > MAX_STEPS:
                raise InputError(
                    "a run to {end} would take more than {most:.0e} steps of {dt:.2g} s: use a "
                    "shorter time",
                    end=Parameter("t_end", f"{self.states.t[-1]:g} s"),
                    most=MAX_STEPS,
                    dt=self.dt,
                )
            n = math.ceil((t_next - now) / self.dt * (1.0 - STEP_ROUNDING))
            if n <= N_LAST_STEPS:
                if abs(n * self.dt - (t_next - now)) > STEP_ROUNDING * (t_next - now):
                    regular = max(regular, self.dt)
                    self._change((t_next - now) / n, now)
                n_next = n
            else:
                n_next, regular = n - N_LAST_STEPS, self.dt
            now, outcome = self._advance(now, min(n_next, 2 * N_EASY_STEPS), n, t_next, begin, end)
            is_taken = outcome in (Outcome.CONVERGED, Outcome.MAY_GROW)
            if is_taken and n > N_LAST_STEPS and self._is_hard():
                self._change(self.dt / STEP_RATIO, now)
                continue
            if outcome == Outcome.CONVERGED:
                continue
            shortest = MIN_STEP * (self.states.t[-1] - self.states.t[0])
            is_shortest = self.dt < shortest and outcome != Outcome.MAY_GROW
            if outcome in (Outcome.GAINED_ENERGY, Outcome.HAD_GAINED) or is_shortest:
                raise self._stopped(outcome, now)
            if outcome == Outcome.MAY_GROW and t_next - now < N_LAST_STEPS * self.dt * STEP_RATIO:
                continue
            dt = self._next_step(outcome)
            if dt == self.dt or dt > self._longest:
                continue
            if outcome not in (Outcome.MAY_GROW, Outcome.TOO_INACCURATE):
                name, step = f"step of {dt:.3g} s", self.stats.steps + 1
                rate = self.iteration.contraction
                self.note([Event(step, now + self.dt, name, CAUSE_NAMES[outcome], rate)])
            self._change(dt, now)
            regular = dt
        if regular != self.dt and t_next < self.states.t[-1]:
            self._change(regular, now)

    def _repeat_pattern(
        self, rows: list[tuple[float, int]], now: float, t_next: float, begin: float, end: float
    ) -> None:
        """Take given steps over an interval of smooth loads."""
        for k, (dt, steps) in enumerate(rows):
            if dt != self.dt:
                self._change(dt, now)
            last = now + steps * dt if k + 1 < len(rows) else t_next
            part = max(2 * N_EASY_STEPS, steps // N_LAST_STEPS)
            while steps:
                taken = self.stats.steps
                now, outcome = self._advance(now, min(steps, part), steps, last, begin, end)
                steps -= self.stats.steps - taken
                if outcome != Outcome.CONVERGED:
                    raise self._stopped(outcome, now)

    def _advance(
        self, now: float, n_steps: int, remaining: int, t_next: float, begin: float, end: float
    ) -> tuple[float, Outcome]:
        """Take some of the remaining steps to a time; return the time after them.

        Loads are evaluated only in their interval.
        """
        n_steps = min(n_steps, len(self._buffer[0]) - 1)
        times = now + self.dt * np.arange(n_steps + 1.0, dtype=np.float64)
        if n_steps == remaining:
            times[-1] = t_next
        start = *self.time_loop.state, self.system.assembly.history
        for table, row in zip(self._buffer, start, strict=True):
            table[0] = row
        amplitudes = inputs_at(self.system, np.clip(times[1:], begin, end))
        self.iteration.step, before = self.stats.steps, now - self.stats.steps * self.dt
        clock = time.perf_counter()
        taken, code = self.time_loop.advance(
            self.iteration, n_steps, amplitudes, 1, 0, *self._buffer[:4]
        )
        self.stats.march_seconds += time.perf_counter() - clock
        if self.seed.error is not None:
            raise self.seed.error
        if code:
            self.system.assembly.check()
        self.note(recovery_events(self.iteration.take_events(), before, self.dt))
        if taken:
            rows = slice(0, taken + 1)
            self.states.fill(times[rows], *(table[rows] for table in self._buffer))
            self.stats.steps += taken
            taken_steps = self.pattern[-1]
            if taken_steps and taken_steps[-1][0] == self.dt:
                taken_steps[-1] = (self.dt, taken_steps[-1][1] + taken)
            else:
                taken_steps.append((self.dt, taken))
            if self._watch is not None:
                self._watch(self.states)
        self._count_budget()
        return float(times[taken]), Outcome(code)

    def _count_budget(self) -> None:
        if self._budget < math.inf:
            self._count()
            if self.cost() > self._budget:
                raise BudgetExceeded

    def cost(self) -> float:
        """Return the cost of all steps, each with a solution for its error."""
        stats = self.stats
        solves = stats.solves + stats.steps + stats.rejected_steps
        return self.costs.total(stats.residual_evaluations, solves, stats.factorizations)

    def note(self, events: list[Event]) -> None:
        """Add events to the list, up to `MAX_EVENTS`."""
        self.stats.events += events[: MAX_EVENTS - len(self.stats.events)]

    def _stopped(self, outcome: Outcome, now: float) -> Exception:
        return step_error(
            self.system,
            FailedStep.record(self.time_loop, self.iteration, outcome),
            self.stats.steps,
            now,
            self.dt,
            self.max_energy_gain,
            None,
            hint_for_accuracy(self.system.scene, self.integrator),
        )

    def _is_hard(self) -> bool:
        """Return whether shorter steps may cost less than the last ones."""
        self._count()
        return self._cost_monitor.too_large(self.stats.steps, self.cost())

    def _levels(self) -> int:
        """Return the powers of the ratio by which the step may change, by the last error."""
        error = max(self.time_loop.step_error, np.finfo(float).tiny)
        ratio = (SAFETY_FACTOR * self.local_error / error) ** (1.0 / 3.0)
        return math.floor(math.log(ratio, STEP_RATIO))

    def _next_step(self, outcome: Outcome) -> float:
        """Return the step after easy ones, or for another attempt."""
        if outcome == Outcome.MAY_GROW:
            may_grow = self._cost_monitor.may_grow(self.stats.steps)
            return self.dt * STEP_RATIO if may_grow else self.dt
        if outcome == Outcome.TOO_INACCURATE:
            self.stats.rejected_steps += 1
            return self.dt * STEP_RATIO ** max(-6, min(-1, self._levels()))
        return self.dt / 2.0

    def _change(self, dt: float, now: float) -> None:
        self._step_change.change(self.dt, dt, now)
        self._continue(dt)

    def _continue(self, dt: float) -> None:
        """Continue with a step after the factor was used for another matrix."""
        self._set_iteration_error(dt)
        self.iteration.mark_stale()
        self.dt = dt

    def _set_iteration_error(self, dt: float) -> None:
        """Set the remaining error of the iteration for a step."""
        error = min(self.iteration_error, self._iteration_error_rate * dt**2)
        self.iteration.set_tolerance(self.criterion.at(dt, error))


def _mass_weights(system: System) -> Vector:
    """Return weights of squared coordinates for a mean over the mass, (n_free,)."""
    mass = system.mass_diagonal
    positions = system.positions
    total = float(mass[positions[positions < system.n_free]].sum())
    if total == 0.0:  # all nodes are constrained: the mass between them moves by the slopes alone
        uniform = np.zeros(system.n_all)
        uniform[positions[:: system.dim]] = 1.0
        total = float(uniform @ system.assembly.inertia(uniform))
    return np.asarray(mass / total)
