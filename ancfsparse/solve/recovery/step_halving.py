"""Recovery of a step in parts."""

from __future__ import annotations

import numpy as np

from ancfsparse.nonlinear import Outcome
from ancfsparse.solve.initial_conditions.prescribed_start import inputs_at
from ancfsparse.solve.recovery.recovery import RecoverableRun, StepRecovery
from ancfsparse.solve.stepping.outcome_reporting import RECOVERABLE_OUTCOMES


class StepHalving(StepRecovery):
    """Takes a step in 2, 4, 8 ... parts, each attempt from the state that the last one reached.

    Pseudo-acceleration and multipliers are not corrected for the change of the step size: for some
    steps the multipliers are of first order.

    Attributes
    ----------
    short_steps : int
        Accepted parts of steps.
    """

    name = "shorter steps"

    def __init__(self, run: RecoverableRun) -> None:
        super().__init__(run)
        self._criterion, self._limit, self._dt = run.setup.criterion, run.max_halvings, run.clock.dt
        self._time_loop.may_shorten()
        self._iteration.halves = True
        self.short_steps = 0

    def solve(self, step: int, outcome: Outcome) -> Outcome:
        """Advance the time loop by a step; parameters as of `attempt`."""
        cause, rate, level, remaining = outcome, self._iteration.contraction, 0, 1
        # Compliant constraints are tried for whole steps only: a part goes on to Newton's method.
        yields, self._iteration.yields = self._iteration.yields, False
        while remaining and outcome in RECOVERABLE_OUTCOMES and level < self._limit:
            level, remaining = level + 1, 2 * remaining
            self._iteration.halves = level < self._limit
            dt = self._dt / 2**level
            self._change(dt)
            outcome = Outcome.CONVERGED
            while remaining and outcome == Outcome.CONVERGED:
                remaining -= 1
                when = np.array([self._clock.at(step) - dt * remaining])
                outcome = self._advance(step, inputs_at(self._system, when))
                self.short_steps += outcome == Outcome.CONVERGED
            remaining += outcome != Outcome.CONVERGED
        self._iteration.halves, self._iteration.yields = True, yields
        self._change(self._dt)
        self.is_inside_step = level > 0 and remaining > 0
        if outcome == Outcome.CONVERGED:
            name = f"{2**level} steps of {self._dt / 2**level:.3g} s"
            self._record(step, name, cause, rate)
        return outcome

    def _change(self, dt: float) -> None:
        zero = np.zeros(self._system.n_all)
        self._time_loop.change_step(dt, self._integrator, zero, zero)
        self._iteration.set_tolerance(self._criterion.at(dt))
        self._iteration.mark_stale()
