"""Runs with a fixed step of an implicit integrator."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ancfsparse.errors import AncfError
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.implicit.time_integration import Start
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Event, Trajectory
from ancfsparse.results.data.run_statistics import MAX_EVENTS
from ancfsparse.solve import initial_conditions, recovery, stepping
from ancfsparse.solve.motion.arguments import Request
from ancfsparse.solve.motion.fixed_step_run import FixedStepRun
from ancfsparse.solve.preparation.memory_estimate import MemoryEstimate
from ancfsparse.solve.preparation.threads import usable_threads
from ancfsparse.solve.recovery import checkpoints
from ancfsparse.solve.recovery.checkpoints import Checkpoint
from ancfsparse.solve.recovery.recovery import RECOVERIES, Recovery, StepRecovery
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.solve.stepping.outcome_reporting import (
    RECOVERABLE_OUTCOMES,
    FailedStep,
    count_costs,
    recovery_events,
    step_error,
)
from ancfsparse.solve.stepping.state_recorder import StateRecorder
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.seeds import Seed
    from ancfsparse.solve.recovery import (
        CompleteSeed,
        CompliantConstraints,
        RepeatedSteps,
        StepHalving,
    )
    from ancfsparse.solve.recovery.singular_crossing import Crossing


class ImplicitRun(FixedStepRun):
    """Fixed steps, each with equations to solve; parameters as `build_run` takes them."""

    seeds: list[Seed]

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
        super().__init__(
            system, request, ready.time_loop, ready.iteration, ready.a, ready.why, threads
        )
        self.setup, self.integrator, self._loop = ready, integrator, ready.time_loop
        self._iteration, self.seeds = ready.iteration, [ready.seed]
        self.recovered, self._solved = list[Event](), list[Event]()
        self.max_halvings, self.longest_chunk = request.max_halvings or 0, self._chunk
        self._begin: Checkpoint | None = None  # of a failed step, in a run without end
        self._report: FailedStep | None = None
        self._projection_step = 0  # after which velocities are projected next, 0 for none
        self._compliant: CompliantConstraints | None = None
        serving: dict[str, Any] = {
            name: getattr(recovery, name)(self)
            for name, serves in RECOVERIES.items()
            if serves(self)
        }
        del self.setup  # frees the arrays that no recovery keeps
        self._recoveries: list[Recovery] = list(serving.values())
        self._complete: CompleteSeed | None = serving.get("CompleteSeed")
        self._chunk = self._complete.interval if self._complete else self._chunk
        self._compliant = serving.get("CompliantConstraints")
        self._halving: StepHalving | None = serving.get("StepHalving")
        self._repeated: RepeatedSteps = serving["RepeatedSteps"]
        self.search_singularities()

    def search_singularities(self) -> None:
        """Look for singular configurations from the next step on."""
        system, self._ahead = self.system, None
        if self._request.is_endless:  # a crossing takes many steps at once
            return
        if system.n_multipliers and all(body.masses is not None for body in system.scene.bodies):
            self._ahead = recovery.prepare_crossings(
                system, self.clock, self._n_steps, self.integrator
            )
        self._steps_to_pause = 1 if self._ahead else 0

    def _recover(self, outcome: Outcome) -> Outcome:
        steps, pause = self.stats.steps, 0
        if outcome != Outcome.CONVERGED:
            if self._request.is_endless:
                self._begin = self.save()
            outcome = self._attempt(outcome)
        elif self._complete:
            self._complete.compare()
        if self._complete:
            self._chunk = self._complete.interval
        pauses = self._compliant or self._ahead
        if pauses and outcome == Outcome.CONVERGED and self.stats.steps == steps:
            pause = self._prepare_next_steps()
        is_last = self.stats.steps == self._n_steps
        if outcome == Outcome.CONVERGED and is_last and self._loop.gained_energy():
            outcome = self._attempt(Outcome.HAD_GAINED)
        if outcome != Outcome.CONVERGED or self.stats.steps < steps:
            return outcome
        self._repeated.keep()
        if self._compliant and is_last:
            self._compliant.warn()
        if pauses:
            wait = max(0, self._projection_step - self.stats.steps)
            self._steps_to_pause = min(wait or pause, pause or wait)
        return outcome

    def _attempt(self, outcome: Outcome) -> Outcome:
        """Attempt the recoveries of a failed step in their order, until one succeeds."""
        for each in self._recoveries:
            if outcome != Outcome.CONVERGED and each.applies(outcome):
                outcome = each.attempt(self.stats.steps + 1, outcome)
        return outcome

    def _prepare_next_steps(self) -> int:
        """Project velocities if that is due; return the steps to the next pause, 0 for none."""
        steps = self.stats.steps
        if self._compliant and 0 < self._projection_step <= steps:
            pause = self._compliant.project_velocities(self.clock.at(steps))
            self._projection_step = steps + pause if pause else 0
        return self._cross_ahead(self._ahead) if self._ahead else 0

    def _continue(self, crossing: Crossing) -> None:
        assert self._ahead is not None
        system, dt, t = self.system, self._dt, self.clock.at(crossing.step)
        q, v, a, lam = (table[-1] for table in crossing.states)
        # As at the start of a run (`starting_state`).
        jerk, prescribed = crossing.jerk, system.prescribed
        rate = self.integrator.velocity_constant * dt**2 * (system.constraints.jacobian(q) @ jerk)
        change = self._ahead.impulse(q, rate)
        amplitudes = system.loads.amplitudes(np.array([t]))[0]
        force = system.assembly.residual(q, v, a, lam, system.dead_load, amplitudes)[0]
        b = a + self.integrator.shift * dt * jerk
        start = Start(q, v + change, a, b, lam, amplitudes)
        lead = prescribed.at(t).s if prescribed else np.zeros(0)
        self._loop.move(start, q - dt * v, lead, force[system.n_all - prescribed.n :])
        if len(amplitudes) or prescribed:
            memory = self._loop.memory
            memory["watch"]["work"] += crossing.work
            self._loop.recall(memory)
        self._iteration.step = crossing.step
        self._iteration.mark_stale()

    def take_step(self, recovery: StepRecovery, outcome: Outcome) -> Outcome:
        """Take a failed step by a recovery; count and record it."""
        stats, begin, clock = self.stats, self._time_loop.steps, time.perf_counter()
        self.is_between_steps = False
        outcome = recovery.solve(stats.steps + 1, outcome)
        stats.march_seconds += time.perf_counter() - clock
        # A step can be taken, and the check of its energy stop the run.
        is_taken = self._time_loop.steps > begin and not recovery.is_inside_step
        if outcome == Outcome.CONVERGED or is_taken:
            stats.steps += 1
            pause = recovery.steps_to_projection
            self._projection_step = stats.steps + pause if pause else 0
            if stats.steps % self.save_every == 0:
                self._append_state()
        self.is_between_steps = not recovery.is_inside_step
        return outcome

    def stop(self, outcome: Outcome) -> tuple[Outcome, FailedStep]:
        """Discard steps on trial; return the outcome and the record of a failed step."""
        steps = self._loop.withdraw()
        if steps:
            self.stats.steps = max(0, self.stats.steps - steps)
            self.discard_states(self.recorder, self.stats.steps)
            self.is_between_steps = False  # the time loop is ahead of the states
            outcome = Outcome.WOULD_GAIN
        self._report = FailedStep.record(self._loop, self._iteration, outcome)
        self._leave_step()
        return outcome, self._report

    def save(self) -> Checkpoint:
        """Return the present state with its memory."""
        interval = self._compliant.steps_to_projection if self._compliant else 0
        loops = self._loop, self._iteration
        return checkpoints.save(
            self.system, *loops, self.stats.steps, self._projection_step, interval
        )

    def restore(self, back: Checkpoint) -> None:
        """Set the loops, the contributions and the projections of velocities to a checkpoint."""
        checkpoints.restore(self.system, self._loop, self._iteration, back)
        self.stats.steps, self._projection_step = back.step, back.next_projection
        if self._compliant:
            self._compliant.steps_to_projection = back.projection_interval
        if self._halving:
            self._halving.last_level = 0

    def return_to(self, back: Checkpoint) -> None:
        """Return to a checkpoint of this run."""
        self.restore(back)
        self.is_between_steps = True
        self._repeated.begin_at(back)
        if self._ahead:
            self._ahead.begin_again()
            self._steps_to_pause = 1

    def _may_return(self) -> bool:
        return super()._may_return() and not self._repeated.is_begun

    def describe_memory(self) -> dict[str, Any]:
        """Return the memory of the run that is not in a checkpoint: earlier choices."""
        comparison = {"chunk": self._chunk, "compared": (0, self._chunk), "since": None}
        return {
            **(self._complete.describe_memory() if self._complete else comparison),
            "is_switched": len(self.seeds) > 1,
            "seed": self.seeds[-1].memory,
            "failed": self._ahead.failed if self._ahead else None,
        }

    def take_memory(self, stored: Mapping[str, Any]) -> None:
        """Set the memory that `describe_memory` has returned."""
        if len(self.seeds) > 1 and not stored["is_switched"]:
            return  # the complete factorization stays, with choices of its own
        if self._complete:
            self._complete.take_memory(stored)
        if self._ahead:
            self._ahead.failed = stored["failed"]
        self._chunk, self.seeds[-1].memory = stored["chunk"], stored["seed"]

    def keep_last_step(self) -> None:
        """Let the state be that after the last step, although a step has failed."""
        super().keep_last_step()
        self._leave_step()

    def _leave_step(self) -> None:
        """Return to the begin of a step that the time loop is inside, in a run without end."""
        if not self.is_between_steps and self._begin is not None:
            self.restore(self._begin)
            self.is_between_steps = True

    def forbid_repetition(self) -> None:
        """Let earlier steps not be repeated, since their inputs are not known any more."""
        self._repeated.first_step = self.stats.steps

    def _end_trial(self) -> None:
        self._repeated.end_trial()

    def discard_events(self, step: int) -> None:
        """Discard the events after a step."""
        self._solved += recovery_events(self._iteration.take_events(), self.clock.begin, self._dt)
        for events in (self._solved, self.recovered, self._crossings):
            events[:] = [event for event in events if event.step <= step]

    def discard_states(self, recorder: StateRecorder, step: int) -> None:
        """Discard the recorded states after a step."""
        wide, narrow = np.empty((0, self.system.n_all)), np.empty((0, self.system.n_multipliers))
        rows = step // self.save_every + 1
        recorder.append(np.empty(0), wide, wide, wide, narrow, begin=rows)

    def _count_costs(self) -> None:
        stats, failure = self.stats, self._repeated.failure
        count_costs(stats, self._iteration, *self.seeds)
        solved = recovery_events(self._iteration.events, self.clock.begin, self._dt)
        listed = [*self._solved, *solved, *self.recovered, *self._crossings]
        listed.sort(key=lambda event: event.step)
        # The loop lists a thousand after each restart, and restarts depend on the checkpoints.
        past = [event for event in listed if event.step <= stats.steps + 1]
        stats.events = past[:MAX_EVENTS]
        if failure:  # also in steps repeated in vain
            stats.events = failure.events
        stats.short_steps = self._halving.short_steps if self._halving else 0

    def failure(self, outcome: Outcome, path: Trajectory) -> AncfError:
        """Return the error of a run that ended with an outcome."""
        request, steps = self._request, self.stats.steps
        hint = ""
        if self.system.n_multipliers and outcome in RECOVERABLE_OUTCOMES:
            hint = initial_conditions.describe_contradiction(
                self.system, self._time_loop.state[0], self.clock.at(steps + 1)
            )
        report = self._repeated.failure.report if self._repeated.failure else self._report
        return step_error(
            self.system,
            report or FailedStep.record(self._loop, self._iteration, outcome),
            steps,
            self.clock.at(steps),
            self._dt,
            request.max_energy_gain,
            path,
            hint
            or stepping.hint_for_fixed_steps(
                request.scene,
                self.integrator,
                self.max_halvings,
                self._dt,
                min(each.resolving_step() for each in self.system.contributions),
            ),
        )
