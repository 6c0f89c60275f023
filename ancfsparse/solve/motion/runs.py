"""The three kinds of runs behind `simulate`, with one interface."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from ancfsparse.errors import AncfError
from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Event, Trajectory
from ancfsparse.seeds import Seed
from ancfsparse.seeds.dense.block_inverse import BlockInverse
from ancfsparse.solve.motion.arguments import Request
from ancfsparse.solve.motion.fixed_step_run import FixedRun
from ancfsparse.solve.preparation.memory_estimate import Memory
from ancfsparse.solve.preparation.switch_to_direct import FIRST_LOOK, WayBack
from ancfsparse.solve.preparation.threads import usable
from ancfsparse.solve.stepping.implicit_setup import (
    CAUSES,
    CURABLE,
    count,
    events,
    prepare,
    stopped,
)
from ancfsparse.solve.stepping.state_recorder import Recorder
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.solve.stepping.compliant_constraints import Softening
    from ancfsparse.solve.stepping.step_halving import Halving


class Run(Protocol):
    """A run that is set up and ready to march."""

    def march(self, recorder: Recorder) -> Outcome:
        """March to the end and pass all states to a recorder; return the outcome."""

    def failure(self, outcome: Outcome, path: Trajectory) -> AncfError:
        """Return the error for a run whose outcome is not convergence."""


def build_run(request: Request, system: System, needed: Memory) -> Run:
    """Set a run up.

    Parameters
    ----------
    request : Request
        The checked arguments.
    system : System
        What moves, at its start.
    needed : Memory
        What the run needs in addition to factors.

    Raises
    ------
    InputError
        If the integrator does not take the scene, or a factor does not fit.
    """
    if request.accuracy is not None:
        return AccurateRun(request, system, request.accuracy)
    if isinstance(request.integrator, Explicit):
        return ExplicitRun(request, system, request.integrator)
    return ImplicitRun(request, system, request.integrator, needed)


class ImplicitRun(FixedRun):
    """Fixed steps, each with equations to solve; parameters as `build_run` takes them."""

    def __init__(
        self, request: Request, system: System, integrator: Implicit, needed: Memory
    ) -> None:
        threads = usable(system, request.threads)
        ready = prepare(
            system,
            request.clock.dt,
            integrator,
            request.solver,
            request.tolerance,
            request.max_energy_gain,
            threads,
            needed,
            request.seed,
            request.state,
        )
        super().__init__(system, request, ready.march, ready.iteration, ready.a, ready.why, threads)
        self._integrator, self._loop, self._iteration = integrator, ready.march, ready.iteration
        self._solved_with: list[Seed] = [ready.seed]
        self._back, self._exact = ready.back, list[Event]()
        if self._back is not None:
            self._most, self._chunk = self._chunk, min(self._chunk, FIRST_LOOK)
        self._softening: Softening | None = None
        if system.n_multipliers and any(body.masses is not None for body in system.scene.bodies):
            from ancfsparse.solve.stepping.compliant_constraints import Softening

            self._softening = Softening(
                system, ready.march, ready.iteration, ready.seed, integrator, request.clock
            )
        self._halving: Halving | None = None
        if request.max_halvings:
            from ancfsparse.solve.stepping.step_halving import Halving

            self._halving = Halving(
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
            if way and outcome in CURABLE:
                outcome = self._cross(way, outcome)
        return outcome

    def _consider(self, back: WayBack, outcome: Outcome) -> Outcome:
        """Continue with an exact seed where the incomplete one fails or costs more, if it fits."""
        failed, steps = outcome in CURABLE, self._stats.steps
        if not failed and not back.pays(self._iteration.counts, self._solved_with[0].inner):
            self._chunk = min(2 * self._chunk, self._most)
            return outcome
        exact, self._back = back.take(), None
        if exact is None:
            return outcome
        self._solved_with.append(exact)
        why = "which cost less"
        if failed:
            why, time = CAUSES[outcome], self._clock.at(steps + 1)
            rate = self._iteration.contraction
            self._exact.append(Event(steps + 1, time, "exact seed", CAUSES[outcome], rate))
        self._stats.solver += f"; from step {steps + 1} on an exact seed ({why})"
        self._iteration.step = steps
        return Outcome.CONVERGED

    def _cross(self, way: Softening | Halving, outcome: Outcome) -> Outcome:
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
        count(stats, self._iteration, *self._solved_with)
        recovered = events(self._iteration.events, self._clock.begin, self._dt)
        listed = recovered + self._exact + crossed
        stats.events = [event for event in listed if event.step <= stats.steps + 1]
        stats.short_steps = self._halving.short_steps if self._halving else 0

    def failure(self, outcome: Outcome, path: Trajectory) -> AncfError:
        """Return the error for a run that ended with an outcome."""
        from ancfsparse.solve.stepping.remedies import for_steps

        request, steps = self._request, self._stats.steps
        advice = ""
        if self._system.n_multipliers and outcome in CURABLE:
            from ancfsparse.solve.initial_conditions.redundant_constraints import contradiction

            advice = contradiction(self._system, self._march.state[0], self._clock.at(steps + 1))
        return stopped(
            self._system,
            self._loop,
            self._iteration,
            outcome,
            steps,
            self._clock.at(steps),
            self._dt,
            request.max_energy_gain,
            path,
            advice or for_steps(request.scene, self._integrator, request.max_halvings),
        )


class ExplicitRun(FixedRun):
    """Fixed steps without equations; parameters as `build_run` takes them."""

    takes_rates = True

    def __init__(self, request: Request, system: System, integrator: Explicit) -> None:
        from ancfsparse.solve.stepping.explicit_setup import (  # what few runs need
            check_alone,
            prepare_explicit,
        )

        check_alone(
            integrator, request.solver, request.tolerance, request.max_halvings, request.seed
        )
        dt, n_steps, gain = request.clock.dt, request.n_steps, request.max_energy_gain
        march, self._mass, why = prepare_explicit(
            system, dt, n_steps, integrator, gain, request.state
        )
        super().__init__(system, request, march, None, march.state[2], why)
        self._integrator = integrator

    @property
    def _seeds(self) -> list[Seed | BlockInverse]:
        return [self._mass]

    def _count_costs(self) -> None:
        from ancfsparse.solve.stepping.explicit_setup import count_forces

        count_forces(self._stats, self._integrator)

    def failure(self, outcome: Outcome, path: Trajectory) -> AncfError:
        """Return the error for a run that ended with an outcome."""
        from ancfsparse.solve.stepping.explicit_setup import instability

        steps = self._stats.steps
        return instability(
            self._system,
            self._march,
            self._mass,
            self._integrator,
            outcome,
            steps,
            self._clock.at(steps),
            self._dt,
            path,
        )


class AccurateRun:
    """Whole motions, until the error of one is small enough; otherwise raises an error.

    Parameters
    ----------
    request, system
        As `build_run` takes them.
    accuracy : float
        Largest error of a position [m].
    """

    def __init__(self, request: Request, system: System, accuracy: float) -> None:
        from ancfsparse.solve.error_control.error_controlled_run import (
            check_accuracy,  # what few runs need
        )

        self._request, self._system, self._accuracy = request, system, accuracy
        self._threads = 1
        if not isinstance(request.integrator, Explicit):
            self._threads = usable(system, request.threads)
        check_accuracy(
            system,
            accuracy,
            request.tolerance,
            request.named,
            request.solver,
            request.max_halvings,
        )

    def march(self, recorder: Recorder) -> Outcome:
        """March until the error is small enough."""
        from ancfsparse.solve.error_control.best_solution import Attempts
        from ancfsparse.solve.error_control.error_controlled_run import solve_accurately

        request = self._request
        solve_accurately(
            self._system,
            request.saved_times,
            self._accuracy,
            request.named,
            request.solver,
            request.max_energy_gain,
            request.progress,
            Attempts(recorder, self._threads),
        )
        return Outcome.CONVERGED

    def failure(self, outcome: Outcome, path: Trajectory) -> AncfError:
        """Unreachable: runs to an accuracy raise their errors in `march`."""
        raise AssertionError(outcome)
