"""Last recovery of a step that does not converge: subdivide it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.integrators import Implicit
from ancfsparse.integrators.interface.time_grid import TimeGrid
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Event
from ancfsparse.solve.initial_conditions.prescribed_start import inputs_at
from ancfsparse.solve.preparation.convergence_criterion import ConvergenceCriterion
from ancfsparse.solve.stepping.outcome_reporting import CAUSE_NAMES, RECOVERABLE_OUTCOMES
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import ImplicitLoop
    from ancfsparse.nonlinear.loop_protocols import NonlinearLoop


class StepHalving:
    """Recover failed steps by 2, 4, 8 ... parts.

    Pseudo-acceleration and multipliers are not corrected for the change of the step size: for some
    steps the multipliers are of first order.

    Parameters
    ----------
    system, time_loop, iteration
        The moving system and its compiled loops.
    integrator
        As in `simulate`.
    clock : TimeGrid
        Times of the steps.
    criterion : ConvergenceCriterion
        Bounds for steps of any size.
    max_halvings : int
        Largest number of halvings of a step.

    Attributes
    ----------
    events : list of Event
        The recovered steps.
    short_steps : int
        Accepted parts of steps.
    seconds : float
        Time of the compiled loop in them [s].
    is_inside_step : bool
        Whether the time loop is inside a step, in a state that is not one of the run.
    steps_to_projection : int
        Always 0: no projection of velocities follows.
    """

    steps_to_projection = 0

    def __init__(
        self,
        system: System,
        time_loop: ImplicitLoop,
        iteration: NonlinearLoop,
        integrator: Implicit,
        criterion: ConvergenceCriterion,
        clock: TimeGrid,
        max_halvings: int,
    ) -> None:
        self._system, self._time_loop, self._iteration = system, time_loop, iteration
        self._integrator, self._criterion, self._limit = integrator, criterion, max_halvings
        self._clock, self._dt = clock, clock.dt
        time_loop.may_shorten()
        iteration.halves = True
        self.events: list[Event] = []
        self.short_steps, self.seconds = 0, 0.0
        self.is_inside_step = False

    def recover(self, step: int, outcome: Outcome) -> Outcome:
        """Try a step in parts, each attempt from the state that the last one has reached.

        Parameters
        ----------
        step : int
            Number of the failed step, from 1.
        outcome : Outcome
            Outcome of the failed step.
        """
        cause, rate, level, remaining = outcome, self._iteration.contraction, 0, 1
        # Compliant constraints are tried for whole steps only: a part goes on to Newton's method.
        yields, self._iteration.yields = self._iteration.yields, False
        n, m = self._system.n_all, self._system.n_multipliers
        unused = [np.empty((1, width)) for width in (n, n, n, m)]
        while remaining and outcome in RECOVERABLE_OUTCOMES and level < self._limit:
            level, remaining = level + 1, 2 * remaining
            self._iteration.halves = level < self._limit
            dt = self._dt / 2**level
            self._change(dt)
            outcome = Outcome.CONVERGED
            while remaining and outcome == Outcome.CONVERGED:
                self._iteration.step = step - 1
                remaining -= 1
                when = np.array([self._clock.at(step) - dt * remaining])
                loads = inputs_at(self._system, when)
                clock = time.perf_counter()
                _, code = self._time_loop.advance(self._iteration, 1, loads, 2, 0, *unused)
                self.seconds += time.perf_counter() - clock
                outcome = Outcome(code)
                self.short_steps += outcome == Outcome.CONVERGED
            remaining += outcome != Outcome.CONVERGED
        self._iteration.halves, self._iteration.yields = True, yields
        self._change(self._dt)
        self.is_inside_step = level > 0 and remaining > 0
        if outcome == Outcome.CONVERGED:
            name = f"{2**level} steps of {self._dt / 2**level:.3g} s"
            self.events.append(Event(step, self._clock.at(step), name, CAUSE_NAMES[cause], rate))
        return outcome

    def _change(self, dt: float) -> None:
        zero = np.zeros(self._system.n_all)
        self._time_loop.change_step(dt, self._integrator, zero, zero)
        self._iteration.set_tolerance(self._criterion.at(dt))
        self._iteration.mark_stale()
