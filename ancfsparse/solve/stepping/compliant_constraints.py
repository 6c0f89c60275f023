"""Steps at places where constraints depend on one another, solved with compliant constraints.

There a linkage could go on in more than one way, as bars do that lie in one line.  Multipliers of
the exact equations grow without bound towards such a place, and those of a step have no solution
close to it.  With phi(q) = epsilon lam in place of phi(q) = 0 they have one, inertia decides the
way, and the next step, with exact constraints, takes back what they gave.
"""

from __future__ import annotations

import time
import warnings
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import RedundantConstraintsWarning
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.interface.time_grid import TimeGrid
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Event
from ancfsparse.seeds import Seed
from ancfsparse.solve.initial_conditions.consistent_state import regularize
from ancfsparse.solve.initial_conditions.prescribed_start import inputs_at
from ancfsparse.solve.initial_conditions.redundant_constraints import count_near_dependent
from ancfsparse.solve.stepping.outcome_reporting import CAUSE_NAMES
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import ImplicitLoop
    from ancfsparse.nonlinear.loop_protocols import NonlinearLoop

Table = NDArray[np.float64]

# Shares of the smallest phi_q M^-1 phi_q^T that are added as compliance, in this order.
SOFTNESS = (1e-3, 1e-2, 1e-4)
# Share of a gradient that is independent of the others, from which no place is near.
NEAR = 0.1
# Steps at which velocities are put on the constraints: 1, 2, 4, ... and the last so many apart.
LAST_SETTLED = 64
# Largest violation of a constraint, as a share of how far the step moves anything.
VIOLATION = 1e-3


class CompliantConstraints:
    """Cross failed steps of a march with compliant constraints.

    Damped Newton comes after that: it could find the other way on, which takes an impact.

    Parameters
    ----------
    system, march, iteration, seed
        What moves, its compiled loops, and what their equations are solved with.
    integrator
        As in `simulate`.
    clock : Clock
        Times of the steps.

    Attributes
    ----------
    events : list of Event
        The steps that were crossed.
    seconds : float
        Time of the compiled march in them [s].
    stuck : bool
        Always False, as the march stands in a state of the run.
    unsettled : int
        Steps after which the run should `settle`, 0 if there is nothing to settle.
    """

    stuck = False

    def __init__(
        self,
        system: System,
        march: ImplicitLoop,
        iteration: NonlinearLoop,
        seed: Seed,
        integrator: Implicit,
        clock: TimeGrid,
    ) -> None:
        self._system, self._march, self._iteration = system, march, iteration
        self._seed, self._integrator, self._clock = seed, integrator, clock
        self._scale = integrator.scale * clock.dt**2
        self._largest, self.unsettled = 0.0, 0
        self._at_first: int | None = None
        self.events: list[Event] = []
        self.seconds = 0.0
        iteration.yields = True

    def cross(self, step: int, outcome: Outcome) -> Outcome:
        """Try a step again.

        Parameters
        ----------
        step : int
            Number of the failed step, from 1.
        outcome : Outcome
            Why it failed.
        """
        if outcome == Outcome.WOULD_GAIN:
            return outcome
        self.unsettled = 0
        loads = inputs_at(self._system, np.array([self._clock.at(step)]))
        clock = time.perf_counter()
        if self._is_near():
            for share in SOFTNESS:
                self._soften(share)
                crossed = self._try(step, loads, outcome)
                self._soften(0.0)
                if crossed is not None:
                    self.unsettled = 1
                    self.seconds += time.perf_counter() - clock
                    return crossed
        self._iteration.yields = False
        outcome = self._advance(step, loads)
        self._iteration.yields = True
        self.seconds += time.perf_counter() - clock
        return outcome

    def settle(self, t: float) -> int:
        """Take the velocities out that break constraints; return when to do so again.

        The exact step after a softer one moves everything back to its constraints, at a velocity
        that a scheme without damping would keep for ever, with another sign in each step.  So do
        multipliers that change much from step to step, the less the further the place is away.

        Parameters
        ----------
        t : float
            Time of the march [s].

        Returns
        -------
        int
            As `unsettled`.
        """
        system = self._system
        q, v, _, lam = self._march.state
        rate = -(system.constraints.jacobian(q) @ v)
        if system.prescribed.n_equations:
            followed = system.prescribed.at(t).s_rate
            rate[-len(followed) :] += followed
        regularize(system, self._scale, SOFTNESS[0])
        loads = system.loads.amplitudes(np.array([t]))[0]
        self._seed.factor(system.assembly.matrix(1.0, 0.0, q, 0.0 * lam, loads))
        regularize(system, self._scale)
        n, change = system.n_free, np.zeros(system.n_all)
        change[:n] = self._seed.solve(np.concatenate([np.zeros(n), rate]))[:n]
        self._march.change_step(self._clock.dt, self._integrator, 0.0 * change, change)
        self._iteration.mark_stale()
        self.unsettled = 2 * self.unsettled if self.unsettled < LAST_SETTLED else 0
        return self.unsettled

    def warn(self) -> None:
        """Warn of the steps that were crossed.

        Warns
        -----
        RedundantConstraintsWarning
            With the first of them.
        """
        if self.events:
            warnings.warn(
                f"constraints came to depend on one another at t = {self.events[0].time:.6g} s, "
                f"where a linkage can go on in several ways: {len(self.events)} steps "
                f"(stats.events) were solved with constraints that gave way by up to "
                f"{self._largest:.2g} m, so that inertia decides; shorter steps make that less",
                RedundantConstraintsWarning,
                stacklevel=5,
            )

    def _is_near(self) -> bool:
        """Whether more constraints are nearly dependent now, or after the step, than at first."""
        q, v = self._march.state[:2]
        after = q + self._clock.dt * v
        if self._at_first is None:
            self._at_first = count_near_dependent(self._system, self._system.q0, NEAR)
        return any(count_near_dependent(self._system, x, NEAR) > self._at_first for x in (q, after))

    def _soften(self, share: float) -> None:
        value = regularize(self._system, self._scale, share) if share else 0.0
        self._march.soften(value)
        if not share:
            regularize(self._system, self._scale)
        self._iteration.mark_stale()

    def _try(self, step: int, loads: Table, cause: Outcome) -> Outcome | None:
        """Take the step if its solution violates constraints by little; otherwise return None."""
        rate, velocity = self._iteration.contraction, self._march.state[1]
        self._iteration.step = step - 1
        self._march.prepare(loads)
        if Outcome(self._iteration.solve()) != Outcome.CONVERGED:
            return None
        violation = float(np.max(np.abs(self._march.unbalanced[1])))
        if violation > VIOLATION * self._clock.dt * float(np.max(np.abs(velocity))):
            return None
        begin = self._march.steps
        outcome = self._advance(step, loads)
        if self._march.steps == begin:
            return None
        self._largest = max(self._largest, violation)
        event = Event(step, self._clock.at(step), "softer constraints", CAUSE_NAMES[cause], rate)
        self.events.append(event)
        return outcome

    def _advance(self, step: int, loads: Table) -> Outcome:
        n, m = self._system.n_all, self._system.n_multipliers
        unused = [np.empty((1, width)) for width in (n, n, n, m)]
        self._iteration.step = step - 1
        _, code = self._march.advance(self._iteration, 1, loads, 2, 0, *unused)
        return Outcome(code)
