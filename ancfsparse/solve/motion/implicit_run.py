"""Runs with a fixed step of an implicit integrator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ancfsparse.errors import AncfError, InputError
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.implicit.time_integration import Start
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Event, Trajectory
from ancfsparse.solve import initial_conditions, motion, preparation, stepping
from ancfsparse.solve.motion import checkpoints
from ancfsparse.solve.motion.arguments import Request
from ancfsparse.solve.motion.checkpoints import Checkpoint, Failure, Repetition
from ancfsparse.solve.motion.fixed_step_run import FixedStepRun
from ancfsparse.solve.preparation.memory_estimate import MemoryEstimate
from ancfsparse.solve.preparation.threads import usable_threads
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.solve.stepping.outcome_reporting import (
    CAUSE_NAMES,
    RECOVERABLE_OUTCOMES,
    FailedStep,
    count_costs,
    recovery_events,
    step_error,
)
from ancfsparse.solve.stepping.state_recorder import StateRecorder, TrialRecorder
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.seeds import Seed
    from ancfsparse.solve.motion.singular_crossing import Crossing

# Of six random runs with contact that failed although Newton's method completed them, five needed
# two to four repeated steps, and one needed 16 to 32.  Checkpoints take 128 bytes per coordinate;
# chunks are shorter than this in systems with more than 40 000 coordinates, which have none.
MIN_REPEATED_CHUNK = 100  # steps, at least half of which are repeated


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
        super().__init__(
            system, request, ready.time_loop, ready.iteration, ready.a, ready.why, threads
        )
        self._integrator, self._loop, self._iteration = integrator, ready.time_loop, ready.iteration
        self._seeds: list[Seed] = [ready.seed]
        self._back, self._switches, self._solved = ready.back, list[Event](), list[Event]()
        self._repetition: Repetition | None = None
        self._failure: Failure | None = None
        self._begin: Checkpoint | None = None  # of a failed step, in a run without end
        self._report: FailedStep | None = None
        if self._chunk >= MIN_REPEATED_CHUNK:
            first = checkpoints.save(system, ready.time_loop, ready.iteration, 0)
            self._repetition = Repetition(ready.iteration, self._chunk // 2, first)
        self._full_chunk = self._chunk
        if self._back is not None:
            self._chunk = min(self._chunk, preparation.FIRST_COMPARISON)
        self._compared = 0, self._chunk  # last step before a comparison of costs, steps to the next
        self._compliant: stepping.CompliantConstraints | None = None
        if system.n_multipliers and any(body.masses is not None for body in system.scene.bodies):
            self._compliant = stepping.CompliantConstraints(
                system, ready.time_loop, ready.iteration, ready.seed, integrator, request.clock
            )
        self._projection_step = 0  # after which velocities are projected next, 0 for none
        self._search_singularities()
        self._halving: stepping.StepHalving | None = None
        if request.max_halvings:
            self._halving = stepping.StepHalving(
                system,
                ready.time_loop,
                ready.iteration,
                integrator,
                ready.criterion,
                request.clock,
                request.max_halvings,
            )

    def _search_singularities(self) -> None:
        """Look for singular configurations from the next step on."""
        system, self._ahead = self._system, None
        if self._request.is_endless:  # a crossing takes many steps at once
            return
        if system.n_multipliers and all(body.masses is not None for body in system.scene.bodies):
            self._ahead = motion.prepare_crossings(
                system, self._clock, self._n_steps, self._integrator
            )
        self._steps_to_pause = 1 if self._ahead else 0

    def _recover(self, outcome: Outcome) -> Outcome:
        if self._back is not None:
            outcome = self._consider(self._back, outcome)
        steps, pause = self._stats.steps, 0
        if outcome == Outcome.CONVERGED:
            if self._compliant and 0 < self._projection_step <= steps:
                wait = self._compliant.project_velocities(self._clock.at(steps))
                self._projection_step = steps + wait if wait else 0
            if self._ahead:
                pause = self._cross_ahead(self._ahead)
        else:
            if self._request.is_endless:
                self._begin = self._save()
            for recovery in (self._compliant, self._halving):
                if recovery and outcome in RECOVERABLE_OUTCOMES:
                    outcome = self._recover_step(recovery, outcome)
        is_last = self._stats.steps == self._n_steps
        if outcome == Outcome.CONVERGED and is_last and self._loop.gained_energy():
            outcome = Outcome.HAD_GAINED
        if outcome != Outcome.CONVERGED:
            return self._repeat(outcome)
        if self._failure and self._stats.steps >= self._failure.step:
            self._end_trial()
        if self._repetition and self._repetition.is_due(self._stats.steps):
            self._repetition.keep(self._save())
        if self._compliant and is_last:
            self._compliant.warn()
        if self._compliant or self._ahead:
            wait = max(0, self._projection_step - self._stats.steps)
            self._steps_to_pause = min(wait or pause, pause or wait)
        return outcome

    def _continue(self, crossing: Crossing) -> None:
        assert self._ahead is not None
        system, dt, t = self._system, self._dt, self._clock.at(crossing.step)
        q, v, a, lam = (table[-1] for table in crossing.states)
        # As at the start of a run (`starting_state`).
        jerk, prescribed = crossing.jerk, system.prescribed
        rate = self._integrator.velocity_constant * dt**2 * (system.constraints.jacobian(q) @ jerk)
        change = self._ahead.impulse(q, rate)
        amplitudes = system.loads.amplitudes(np.array([t]))[0]
        force = system.assembly.residual(q, v, a, lam, system.dead_load, amplitudes)[0]
        b = a + self._integrator.shift * dt * jerk
        start = Start(q, v + change, a, b, lam, amplitudes)
        lead = prescribed.at(t).s if prescribed else np.zeros(0)
        self._loop.move(start, q - dt * v, lead, force[system.n_all - prescribed.n :])
        if len(amplitudes) or prescribed:
            memory = self._loop.memory
            memory["watch"]["work"] += crossing.work
            self._loop.recall(memory)
        self._iteration.step = crossing.step
        self._iteration.mark_stale()

    def _consider(self, back: preparation.SwitchToDirect, outcome: Outcome) -> Outcome:
        """Switch to the complete seed, if it fits, where the incomplete one fails or costs more."""
        failed, steps = outcome in RECOVERABLE_OUTCOMES, self._stats.steps
        last, interval = self._compared
        if not failed and steps < last + interval:  # a simulation pauses at any step
            self._chunk = min(last + interval - steps, self._full_chunk)
            return outcome
        self._chunk = interval
        if not failed and not back.is_cheaper(self._iteration.counts, self._seeds[0].inner):
            self._chunk = min(2 * interval, self._full_chunk)
            self._compared = steps, self._chunk
            return outcome
        complete, self._back = back.switch(), None
        if complete is None:
            return outcome
        self._seeds.append(complete)
        why = "which cost less"
        if failed:
            why, time = CAUSE_NAMES[outcome], self._clock.at(steps + 1)
            rate = self._iteration.contraction
            event = Event(steps + 1, time, "complete seed", CAUSE_NAMES[outcome], rate)
            self._switches.append(event)
        self._stats.solver += f"; from step {steps + 1} with a complete factorization ({why})"
        self._iteration.step = steps
        return Outcome.CONVERGED

    def _recover_step(
        self,
        recovery: stepping.CompliantConstraints | stepping.StepHalving,
        outcome: Outcome,
    ) -> Outcome:
        """Retry a failed step with compliant constraints, or in parts."""
        stats = self._stats
        self._before, seconds, begin = None, recovery.seconds, self._time_loop.steps
        outcome = recovery.recover(stats.steps + 1, outcome)
        stats.march_seconds += recovery.seconds - seconds
        # A step can be taken, and the check of its energy stop the run.
        is_taken = self._time_loop.steps > begin and not recovery.is_inside_step
        if outcome == Outcome.CONVERGED or is_taken:
            stats.steps += 1
            pause = recovery.steps_to_projection
            self._projection_step = stats.steps + pause if pause else 0
            if stats.steps % self._save_every == 0:
                self._append_state()
        if not recovery.is_inside_step:
            self._before = stats.steps, self._time_loop.steps
        return outcome

    def _repeat(self, outcome: Outcome) -> Outcome:
        """Repeat the last steps by Newton's method after a failed one, on trial."""
        if self._failure and self._end_trial():
            return self._failure.report.outcome
        stats = self._stats
        failed = stats.steps + (outcome in RECOVERABLE_OUTCOMES)
        rate, cause = self._iteration.contraction, CAUSE_NAMES[outcome]
        outcome = self._withdraw(outcome)
        self._report = report = FailedStep.record(self._loop, self._iteration, outcome)
        self._leave_step()
        if self._repetition is None:
            return outcome
        self._check_functions(failed)
        end, inside, self._before = self._save(), self._before is None, None
        back = self._repetition.begin(failed)
        if back is None:
            self._before = None if inside else (stats.steps, self._time_loop.steps)
            return outcome
        self._count_costs()
        self._failure = Failure(
            failed, report, stats.events, end, inside, self._recorder, back.step
        )
        self._discard_events(back.step)
        name = f"Newton from step {back.step + 1} on"
        self._switches.append(Event(failed, self._clock.at(failed), name, cause, rate))
        self._recorder = TrialRecorder(back.step // self._save_every + 1)
        self._restore(back)
        self._iteration.newton = True
        self._search_singularities()
        self._before = back.step, self._time_loop.steps
        return Outcome.CONVERGED

    def _save(self) -> Checkpoint:
        interval = self._compliant.steps_to_projection if self._compliant else 0
        loops = self._loop, self._iteration
        return checkpoints.save(
            self._system, *loops, self._stats.steps, self._projection_step, interval
        )

    def _restore(self, back: Checkpoint) -> None:
        """Set the loops, the contributions and the projections of velocities to a checkpoint."""
        checkpoints.restore(self._system, self._loop, self._iteration, back)
        self._stats.steps, self._projection_step = back.step, back.next_projection
        if self._compliant:
            self._compliant.steps_to_projection = back.projection_interval

    def return_to(self, back: Checkpoint) -> None:
        """Return to a checkpoint of this run."""
        self._restore(back)
        self._failure, self._before = None, (back.step, self._time_loop.steps)
        if self._repetition:
            self._repetition = Repetition(self._iteration, self._full_chunk // 2, back)
        if self._ahead:
            self._ahead.begin_again()
            self._steps_to_pause = 1

    def _may_return(self) -> bool:
        is_repeating = self._repetition is not None and self._repetition.is_begun
        return super()._may_return() and self._failure is None and not is_repeating

    def describe_memory(self) -> dict[str, Any]:
        """Return the memory of the run that is not in a checkpoint: earlier choices."""
        counts, inner = self._iteration.counts, self._seeds[0].inner
        return {
            "chunk": self._chunk,
            "compared": self._compared,
            "is_switched": len(self._seeds) > 1,
            "since": self._back.since_comparison(counts, inner) if self._back else None,
            "seed": self._seeds[-1].memory,
            "failed": self._ahead.failed if self._ahead else None,
        }

    def take_memory(self, stored: Mapping[str, Any]) -> None:
        """Set the memory that `describe_memory` has returned."""
        if stored["is_switched"] and self._back:
            complete, self._back = self._back.switch(), None
            if complete is None:
                raise InputError(
                    "the complete factorization that the run had switched to does not fit in the "
                    "free memory: resume it where more is free"
                )
            self._seeds.append(complete)
        if len(self._seeds) > 1 and not stored["is_switched"]:
            return  # the complete factorization stays, with choices of its own
        if self._back:
            counts, inner = self._iteration.counts, self._seeds[0].inner
            self._back.continue_comparison(stored["since"], counts, inner)
        if self._ahead:
            self._ahead.failed = stored["failed"]
        self._chunk, self._compared = stored["chunk"], tuple(stored["compared"])
        self._seeds[-1].memory = stored["seed"]

    def keep_last_step(self) -> None:
        """Let the state be that after the last step, although a step has failed."""
        super().keep_last_step()
        self._leave_step()

    def _leave_step(self) -> None:
        """Return to the begin of a step that the time loop is inside, in a run without end."""
        if self._before is None and self._begin is not None:
            self._restore(self._begin)
            self._before = self._begin.step, self._time_loop.steps

    def forbid_repetition(self) -> None:
        """Let earlier steps not be repeated, since their inputs are not known any more."""
        if self._repetition:
            self._repetition.first_step = self._stats.steps

    def _end_trial(self) -> bool:
        failure, trial = self._failure, self._recorder
        if not failure or not isinstance(trial, TrialRecorder) or not self._repetition:
            return False
        if self._stats.steps >= failure.step:
            # An interruption may come here, and this is done again.
            row, states = failure.back // self._save_every + 1, trial.states()
            self._discard_states(failure.recorder, row)
            if states:
                failure.recorder.append(*states)
            self._recorder, self._failure = failure.recorder, None
            return False
        self._before = None
        self._restore(failure.end)
        self._system.assembly.forget()  # errors of functions in these steps
        self._recorder = failure.recorder
        if not failure.is_inside_step:
            self._before = self._stats.steps, self._time_loop.steps
        return True

    def _discard_events(self, step: int) -> None:
        """Discard the events after a step."""
        dt, begin = self._dt, self._clock.begin
        self._solved += recovery_events(self._iteration.take_events(), begin, dt)
        recovered = [each.events for each in (self._compliant, self._halving) if each]
        for events in (self._solved, self._switches, self._crossings, *recovered):
            events[:] = [event for event in events if event.step <= step]

    def _discard_states(self, recorder: StateRecorder, rows: int) -> None:
        """Keep a number of recorded states."""
        wide, narrow = np.empty((0, self._system.n_all)), np.empty((0, self._system.n_multipliers))
        recorder.append(np.empty(0), wide, wide, wide, narrow, begin=rows)

    def _withdraw(self, outcome: Outcome) -> Outcome:
        """Discard the steps since one that was accepted on trial."""
        stats = self._stats
        steps = 0 if outcome == Outcome.CONVERGED else self._loop.withdraw()
        if not steps:
            return outcome
        stats.steps = max(0, stats.steps - steps)
        self._discard_states(self._recorder, stats.steps // self._save_every + 1)
        self._before = None  # the time loop is ahead of the states
        return Outcome.WOULD_GAIN

    def _count_costs(self) -> None:
        stats, recoveries = self._stats, (self._compliant, self._halving)
        recovered = [event for recovery in recoveries if recovery for event in recovery.events]
        count_costs(stats, self._iteration, *self._seeds)
        solved = recovery_events(self._iteration.events, self._clock.begin, self._dt)
        listed = self._solved + solved + self._switches + recovered + self._crossings
        listed.sort(key=lambda event: event.step)
        stats.events = [event for event in listed if event.step <= stats.steps + 1]
        if self._failure:  # also in steps repeated in vain
            stats.events = self._failure.events
        stats.short_steps = self._halving.short_steps if self._halving else 0

    def failure(self, outcome: Outcome, path: Trajectory) -> AncfError:
        """Return the error of a run that ended with an outcome."""
        request, steps = self._request, self._stats.steps
        hint = ""
        if self._system.n_multipliers and outcome in RECOVERABLE_OUTCOMES:
            hint = initial_conditions.describe_contradiction(
                self._system, self._time_loop.state[0], self._clock.at(steps + 1)
            )
        report = self._failure.report if self._failure else self._report
        return step_error(
            self._system,
            report or FailedStep.record(self._loop, self._iteration, outcome),
            steps,
            self._clock.at(steps),
            self._dt,
            request.max_energy_gain,
            path,
            hint
            or stepping.hint_for_fixed_steps(
                request.scene, self._integrator, request.max_halvings or 0
            ),
        )
