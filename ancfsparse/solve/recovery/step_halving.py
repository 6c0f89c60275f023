"""Recovery of a step in parts."""

from __future__ import annotations

import numpy as np

from ancfsparse.nonlinear import Outcome
from ancfsparse.solve.initial_conditions.prescribed_start import inputs_at
from ancfsparse.solve.recovery.recovery import RecoverableRun, StepRecovery
from ancfsparse.solve.stepping.outcome_reporting import RECOVERABLE_OUTCOMES


class StepHalving(StepRecovery):
    """Takes a step in 2, 4, 8 ... parts, each attempt from the state that the last one reached.

    It begins with half as many parts as served in the last failed step.

    Pseudo-acceleration and multipliers are not corrected for the change of the step size: for some
    steps the multipliers are of first order.

    Attributes
    ----------
    short_steps : int
        Accepted parts of steps.
    last_level : int
        Binary logarithm of the parts of the last step that succeeded in parts; 0 for none.
    """

    name = "shorter steps"

    def __init__(self, run: RecoverableRun) -> None:
        super().__init__(run)
        self._criterion, self._limit, self._dt = run.setup.criterion, run.max_halvings, run.clock.dt
        self._time_loop.may_shorten()
        self._iteration.halves = True
        self.short_steps = self.last_level = 0

    def solve(self, step: int, outcome: Outcome) -> Outcome:
        """Advance the time loop by a step; parameters as of `attempt`."""
        cause, rate, level = outcome, self._iteration.contraction, max(self.last_level - 2, 0)
        remaining = 2**level
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
            self.last_level = level
            name = f"{2**level} steps of {self._dt / 2**level:.3g} s"
            self._record(step, name, cause, rate)
        return outcome

    def _change(self, dt: float) -> None:
        zero = np.zeros(self._system.n_all)
        self._time_loop.change_step(dt, self._integrator, zero, zero)
        self._iteration.set_tolerance(self._criterion.at(dt))
        self._iteration.mark_stale()
