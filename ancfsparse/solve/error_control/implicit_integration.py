"""Integrate whole motions by implicit methods, with equal steps between load discontinuities."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.errors import EnergyIncreaseError, StepError
from ancfsparse.integrators import Implicit
from ancfsparse.nonlinear import Method, Outcome
from ancfsparse.results import Event, RunStats
from ancfsparse.results.data.run_statistics import MAX_EVENTS
from ancfsparse.solve.error_control.motion_task import MotionTask
from ancfsparse.solve.initial_conditions.prescribed_start import inputs_at
from ancfsparse.solve.stepping.implicit_setup import iteration_costs, prepare_implicit
from ancfsparse.solve.stepping.outcome_reporting import (
    FailedStep,
    count_costs,
    recovery_events,
    step_error,
)
from ancfsparse.solve.stepping.remedies import hint_for_accuracy
from ancfsparse.solve.stepping.sampled_states import SampledStates, steps_at_once
from ancfsparse.solve.stepping.step_size_change import StepSizeChange

if TYPE_CHECKING:
    from ancfsparse.seeds import Seed

N_PARTS = 8  # parts of an interval, after each of which its states are stored


class ImplicitIntegration:
    """One implicit run.

    Parameters
    ----------
    task : MotionTask
        The motion.
    integrator : Implicit
        A scheme of second order.
    solver : Method or "auto"
        Nonlinear solver.
    counts : sequence of int
        Number of steps in each interval of smooth loads.
    iteration_error : float
        Error of positions by all iterations together [m].
    threads : int, optional
        Largest number of threads.

    Attributes
    ----------
    dt : float
        The present step [s].
    stats : RunStats
        Statistics of the run.
    """

    def __init__(
        self,
        task: MotionTask,
        integrator: Implicit,
        solver: Method | str,
        counts: Sequence[int],
        iteration_error: float,
        threads: int = 1,
    ) -> None:
        begin = time.perf_counter()
        self._task, self._system, self._integrator = task, task.system, integrator
        self._counts, system = counts, task.system
        self._ends = [*(begin for begin, _ in task.spans[1:]), float(task.t[-1])]
        self.dt = (self._ends[0] - task.t[0]) / counts[0]
        # A step adds the part of the error that grows with the square of its length.
        self._iteration_error_rate = iteration_error / task.length**2
        self._seed: Seed
        self.time_loop, self.iteration, self._seed, self.criterion, why, a, _ = prepare_implicit(
            system, self.dt, integrator, solver, "default", task.max_energy_gain, threads
        )
        self._costs = iteration_costs(system, integrator, self._seed, None)
        self._set_iteration_error()
        if not integrator.keeps_energy:
            self.time_loop.follow_jerk()
        q, _, _, lam = self.time_loop.state
        n, m, h = system.n_all, system.n_multipliers, system.assembly.n_history
        self._states = SampledStates.empty(task.t, n, m, h)
        self._states.begin(q, system.v0, a, lam, system.assembly.history)
        self._step_change = StepSizeChange(system, integrator, self.time_loop, self._seed)
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
        """
        now, before = float(self._task.t[0]), 0.0
        rows = zip(self._task.spans, self._ends, self._counts, strict=True)
        try:
            for k, ((begin, end), stop, steps) in enumerate(rows):
                if k:
                    self._step_change.jump(self.dt, before, now)
                    self._continue(self.dt)
                dt = (stop - now) / steps
                if dt != self.dt:
                    self.change(dt, now)
                self._integrate(now, stop, steps, begin, end)
                now, before = stop, end
            if self.time_loop.gained_energy():
                raise self._stopped(Outcome.HAD_GAINED, now)
        finally:
            count_costs(self.stats, self.iteration, self._seed)
            self.stats.factorizations += self._step_change.factors
            self.stats.solves += self._step_change.factors
        return self._states

    def change(self, dt: float, now: float) -> None:
        """Change the step size [s] at a time [s]."""
        self._step_change.change(self.dt, dt, now)
        self._continue(dt)

    def cost(self) -> float:
        """Return the cost of all steps, in the unit of `Costs`."""
        stats = self.stats
        return self._costs.total(
            stats.residual_evaluations, stats.solves + stats.steps, stats.factorizations
        )

    def note(self, events: list[Event]) -> None:
        """Add events to the list, up to `MAX_EVENTS`."""
        self.stats.events += events[: MAX_EVENTS - len(self.stats.events)]

    def _integrate(self, start: float, stop: float, steps: int, begin: float, end: float) -> None:
        """Integrate over an interval, in which alone its loads are evaluated."""
        system, first = self._system, self.stats.steps
        chunk = min(len(self._buffer[0]) - 1, math.ceil(steps / N_PARTS))
        for done in range(0, steps, chunk):
            numbers = np.arange(done, min(done + chunk, steps) + 1, dtype=np.float64)
            times = np.where(numbers < steps, start + numbers * self.dt, stop)
            state = *self.time_loop.state, system.assembly.history
            for table, row in zip(self._buffer, state, strict=True):
                table[0] = row
            inputs = inputs_at(system, np.clip(times[1:], begin, end))
            self.iteration.step = self.stats.steps
            clock = time.perf_counter()
            taken, code = self.time_loop.advance(
                self.iteration, len(times) - 1, inputs, 1, 0, *self._buffer[:4]
            )
            self.stats.march_seconds += time.perf_counter() - clock
            if self._seed.error is not None:
                raise self._seed.error
            if code:
                system.assembly.check()
            events = self.iteration.take_events()
            self.note(recovery_events(events, start - first * self.dt, self.dt))
            if taken:
                rows = slice(0, taken + 1)
                self._states.fill(
                    times[rows],
                    *(table[rows] for table in self._buffer),
                    has_means=self._integrator.keeps_energy,
                )
                self.stats.steps += taken
                self._task.watch(self._states)
            if code:
                raise self._stopped(Outcome(code), float(times[taken]))

    def _stopped(self, outcome: Outcome, now: float) -> StepError | EnergyIncreaseError:
        return step_error(
            self._system,
            FailedStep.record(self.time_loop, self.iteration, outcome),
            self.stats.steps,
            now,
            self.dt,
            self._task.max_energy_gain,
            None,
            hint_for_accuracy(self._system.scene, self._integrator),
        )

    def _continue(self, dt: float) -> None:
        """Continue with a step after the factor was used for another matrix."""
        self.dt = dt
        self._set_iteration_error()
        self.iteration.mark_stale()

    def _set_iteration_error(self) -> None:
        """Set the remaining error of the iteration for a step."""
        error = self._iteration_error_rate * self.dt**2
        self.iteration.set_tolerance(self.criterion.at(self.dt, error))
