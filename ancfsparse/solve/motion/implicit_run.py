"""Runs with a fixed step of an implicit integrator."""

from __future__ import annotations

import numpy as np

from ancfsparse.errors import AncfError
from ancfsparse.integrators import Implicit
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Event, Trajectory
from ancfsparse.seeds import Seed
from ancfsparse.solve import initial_conditions, stepping
from ancfsparse.solve.motion.arguments import Request
from ancfsparse.solve.motion.fixed_step_run import FixedStepRun
from ancfsparse.solve.preparation.memory_estimate import MemoryEstimate
from ancfsparse.solve.preparation.switch_to_direct import FIRST_COMPARISON, SwitchToDirect
from ancfsparse.solve.preparation.threads import usable_threads
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.solve.stepping.outcome_reporting import (
    CAUSE_NAMES,
    RECOVERABLE_OUTCOMES,
    count_costs,
    recovery_events,
    step_error,
)
from ancfsparse.system import System


class ImplicitRun(FixedStepRun):
    """Fixed steps, each with equations to solve; parameters as `build_run` takes them."""

    def __init__(
        self, request: Request, system: System, integrator: Implicit, needed: MemoryEstimate
    ) -> None:
        threads = usable_threads(system, request.threads)
        ready = prepare_implicit(
            system,
            request.clock.dt,
            integrator,
            request.solver,
            request.tolerance,
            request.max_energy_gain,
            threads,
            needed,
            request.factorization,
            request.state,
        )
        super().__init__(system, request, ready.march, ready.iteration, ready.a, ready.why, threads)
        self._integrator, self._loop, self._iteration = integrator, ready.march, ready.iteration
        self._solved_with: list[Seed] = [ready.seed]
        self._back, self._exact = ready.back, list[Event]()
        if self._back is not None:
            self._most, self._chunk = self._chunk, min(self._chunk, FIRST_COMPARISON)
        self._softening: stepping.CompliantConstraints | None = None
        if system.n_multipliers and any(body.masses is not None for body in system.scene.bodies):
            self._softening = stepping.CompliantConstraints(
                system, ready.march, ready.iteration, ready.seed, integrator, request.clock
            )
        self._halving: stepping.StepHalving | None = None
        if request.max_halvings:
            self._halving = stepping.StepHalving(
                system,
                ready.march,
                ready.iteration,
                integrator,
                ready.criterion,
                request.clock,
                request.max_halvings,
            )

    @property
    def _seeds(self) -> list[Seed]:
        return self._solved_with

    def _mend(self, outcome: Outcome) -> Outcome:
        if self._back is not None:
            outcome = self._consider(self._back, outcome)
        if self._softening and self._soon and outcome == Outcome.CONVERGED:
            self._soon = self._softening.settle(self._clock.at(self._stats.steps))
        for way in (self._softening, self._halving):
            if way and outcome in RECOVERABLE_OUTCOMES:
                outcome = self._cross(way, outcome)
        return outcome

    def _consider(self, back: SwitchToDirect, outcome: Outcome) -> Outcome:
        """Switch to the complete seed, if it fits, where the incomplete one fails or costs more."""
        failed, steps = outcome in RECOVERABLE_OUTCOMES, self._stats.steps
        if not failed and not back.is_cheaper(self._iteration.counts, self._solved_with[0].inner):
            self._chunk = min(2 * self._chunk, self._most)
            return outcome
        exact, self._back = back.switch(), None
        if exact is None:
            return outcome
        self._solved_with.append(exact)
        why = "which cost less"
        if failed:
            why, time = CAUSE_NAMES[outcome], self._clock.at(steps + 1)
            rate = self._iteration.contraction
            self._exact.append(Event(steps + 1, time, "complete seed", CAUSE_NAMES[outcome], rate))
        self._stats.solver += f"; from step {steps + 1} with a complete factorization ({why})"
        self._iteration.step = steps
        return Outcome.CONVERGED

    def _cross(
        self, way: stepping.CompliantConstraints | stepping.StepHalving, outcome: Outcome
    ) -> Outcome:
        """Retry a failed step with compliant constraints, or in shorter ones."""
        stats = self._stats
        self._before, seconds, begin = None, way.seconds, self._march.steps
        outcome = way.cross(stats.steps + 1, outcome)
        stats.march_seconds += way.seconds - seconds
        # A step can be taken, and the check of its energy stop the run.
        if outcome == Outcome.CONVERGED or (self._march.steps > begin and not way.stuck):
            self._soon = way.unsettled
            stats.steps += 1
            if stats.steps % self._save_every == 0:
                self._append_state()
        if not way.stuck:
            self._before = stats.steps, self._march.steps
        return outcome

    def _last_look(self) -> Outcome:
        if self._softening:
            self._softening.warn()
        return Outcome.HAD_GAINED if self._loop.gained_energy() else Outcome.CONVERGED

    def _withdraw(self, outcome: Outcome) -> Outcome:
        """Take back the steps since one that was accepted on trial."""
        stats = self._stats
        steps = 0 if outcome == Outcome.CONVERGED else self._loop.withdraw()
        if not steps:
            return outcome
        stats.steps = max(0, stats.steps - steps)
        wide, narrow = np.empty((0, self._system.n_all)), np.empty((0, self._system.n_multipliers))
        rows = stats.steps // self._save_every + 1
        self._recorder.append(np.empty(0), wide, wide, wide, narrow, begin=rows)
        self._before = None  # the march is further than the states
        return Outcome.WOULD_GAIN

    def _count_costs(self) -> None:
        stats, ways = self._stats, (self._softening, self._halving)
        crossed = [event for way in ways if way for event in way.events]
        count_costs(stats, self._iteration, *self._solved_with)
        recovered = recovery_events(self._iteration.events, self._clock.begin, self._dt)
        listed = recovered + self._exact + crossed
        stats.events = [event for event in listed if event.step <= stats.steps + 1]
        stats.short_steps = self._halving.short_steps if self._halving else 0

    def failure(self, outcome: Outcome, path: Trajectory) -> AncfError:
        """Return the error for a run that ended with an outcome."""
        request, steps = self._request, self._stats.steps
        advice = ""
        if self._system.n_multipliers and outcome in RECOVERABLE_OUTCOMES:
            advice = initial_conditions.describe_contradiction(
                self._system, self._march.state[0], self._clock.at(steps + 1)
            )
        return step_error(
            self._system,
            self._loop,
            self._iteration,
            outcome,
            steps,
            self._clock.at(steps),
            self._dt,
            request.max_energy_gain,
            path,
            advice
            or stepping.hint_for_fixed_steps(request.scene, self._integrator, request.max_halvings),
        )
