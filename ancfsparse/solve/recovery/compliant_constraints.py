"""Recovery of steps near singular configurations by compliant constraints.

In a singular configuration, such as collinear bars, a linkage has several continuations.  The
multipliers of the exact equations grow without bound towards it, and a step close to it has no
solution.  With phi(q) = epsilon lam in place of phi(q) = 0 it has one, inertia selects the
continuation, and the next step with exact constraints removes the violation.
"""

from __future__ import annotations

import warnings

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import RedundantConstraintsWarning
from ancfsparse.nonlinear import Outcome
from ancfsparse.solve.initial_conditions.consistent_state import regularize
from ancfsparse.solve.initial_conditions.prescribed_start import inputs_at
from ancfsparse.solve.initial_conditions.redundant_constraints import count_near_dependent
from ancfsparse.solve.recovery.recovery import RecoverableRun, StepRecovery

COMPLIANCES = (1e-3, 1e-2, 1e-4)  # compliance over the smallest phi_q M^-1 phi_q^T, in this order
MAX_INDEPENDENT_RATIO = 0.1  # independent part of a gradient near a singular configuration
LAST_PROJECTION = 64  # last step after a recovery, of 1, 2, 4, ..., with a projection of velocities
COMPLIANT_STEP = "softer constraints"  # in the events of a run
MAX_VIOLATION_RATIO = 1e-3  # of a constraint, over the largest displacement in the step


class CompliantConstraints(StepRecovery):
    """Takes a step near a singular configuration with compliant constraints.

    Damped Newton is tried afterwards: it can converge to another continuation, which would require
    an impact.
    """

    name = "compliant constraints"

    def __init__(self, run: RecoverableRun) -> None:
        super().__init__(run)
        self._seed, self._scale = run.setup.seed, run.integrator.scale * run.clock.dt**2
        self._largest = 0.0
        self._at_first: int | None = None
        self._iteration.yields = True

    def applies(self, outcome: Outcome) -> bool:
        """Return whether a step with an outcome can be recovered in this way."""
        return outcome != Outcome.WOULD_GAIN and super().applies(outcome)

    def solve(self, step: int, outcome: Outcome) -> Outcome:
        """Advance the time loop by a step; parameters as of `attempt`."""
        self.steps_to_projection = 0
        loads = inputs_at(self._system, np.array([self._clock.at(step)]))
        if self._is_near():
            for ratio in COMPLIANCES:
                self._soften(ratio)
                crossed = self._try(step, loads, outcome)
                self._soften(0.0)
                if crossed is not None:
                    self.steps_to_projection = 1
                    return crossed
        self._iteration.yields = False
        outcome = self._advance(step, loads)
        self._iteration.yields = True
        return outcome

    def project_velocities(self, t: float) -> int:
        """Remove velocities that violate constraints; return the steps until the next projection.

        The exact step after a compliant one corrects the violation, at a velocity that a scheme
        without damping would retain with alternating sign.  Multipliers that change quickly have a
        similar effect, which decreases with the distance from the configuration.

        Parameters
        ----------
        t : float
            Time of the state [s].

        Returns
        -------
        int
            As `steps_to_projection`.
        """
        system = self._system
        q, v, _, lam = self._time_loop.state
        rate = -(system.constraints.jacobian(q) @ v)
        if system.prescribed.n_equations:
            prescribed = system.prescribed.at(t).s_rate
            rate[-len(prescribed) :] += prescribed
        regularize(system, self._scale, COMPLIANCES[0])
        loads = system.loads.amplitudes(np.array([t]))[0]
        self._seed.factor(system.assembly.matrix(1.0, 0.0, q, 0.0 * lam, loads))
        regularize(system, self._scale)
        n, change = system.n_free, np.zeros(system.n_all)
        change[:n] = self._seed.solve(np.concatenate([np.zeros(n), rate]))[:n]
        self._time_loop.change_step(self._clock.dt, self._integrator, 0.0 * change, change)
        self._iteration.mark_stale()
        self.steps_to_projection = (
            2 * self.steps_to_projection if self.steps_to_projection < LAST_PROJECTION else 0
        )
        return self.steps_to_projection

    def warn(self) -> None:
        """Warn of the recovered steps.

        Warns
        -----
        RedundantConstraintsWarning
            With the first of them.
        """
        events = [event for event in self._run.recovered if event.rung == COMPLIANT_STEP]
        if events:
            warnings.warn(
                f"constraints became dependent at t = {events[0].time:.6g} s, where a linkage "
                f"has several continuations: {len(events)} steps (stats.events) were solved "
                f"with compliant constraints, violated by up to {self._largest:.2g} m, so that "
                "inertia selects one; shorter steps reduce that",
                RedundantConstraintsWarning,
                stacklevel=8,
            )

    def _is_near(self) -> bool:
        """Return whether more constraints are near dependent than at first, now or after a step."""
        q, v = self._time_loop.state[:2]
        after = q + self._clock.dt * v
        if self._at_first is None:
            self._at_first = count_near_dependent(
                self._system, self._system.q0, MAX_INDEPENDENT_RATIO
            )
        return any(
            count_near_dependent(self._system, x, MAX_INDEPENDENT_RATIO) > self._at_first
            for x in (q, after)
        )

    def _soften(self, ratio: float) -> None:
        """Set the compliance of the constraints; zero restores exact ones."""
        value = regularize(self._system, self._scale, ratio) if ratio else 0.0
        self._time_loop.soften(value)
        if not ratio:
            regularize(self._system, self._scale)
        self._iteration.mark_stale()

    def _try(self, step: int, loads: Vector, cause: Outcome) -> Outcome | None:
        """Take the step if its solution hardly violates constraints; otherwise return None."""
        rate, velocity = self._iteration.contraction, self._time_loop.state[1]
        self._iteration.step = step - 1
        self._time_loop.prepare(loads)
        if Outcome(self._iteration.solve()) != Outcome.CONVERGED:
            return None
        violation = float(np.max(np.abs(self._time_loop.unbalanced[1])))
        if violation > MAX_VIOLATION_RATIO * self._clock.dt * float(np.max(np.abs(velocity))):
            return None
        begin = self._time_loop.steps
        outcome = self._advance(step, loads)
        if self._time_loop.steps == begin:
            return None
        self._largest = max(self._largest, violation)
        self._record(step, COMPLIANT_STEP, cause, rate)
        return outcome
