"""Checkpoints of a run, and the repetition of steps from them by Newton's method."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.integrators.implicit.time_integration import Start
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Event, RunStats
from ancfsparse.solve.recovery.recovery import RecoverableRun, Recovery
from ancfsparse.solve.stepping.outcome_reporting import RECOVERABLE_OUTCOMES, FailedStep
from ancfsparse.solve.stepping.state_recorder import StateRecorder, TrialRecorder
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import ImplicitLoop, Loop
    from ancfsparse.nonlinear.loop_protocols import NonlinearLoop

# Of six random runs with contact that failed although Newton's method completed them, five needed
# two to four repeated steps, and one needed 16 to 32.  Checkpoints take 128 bytes per coordinate;
# chunks are shorter than this in systems with more than 40 000 coordinates, which have none.
MIN_REPEATED_CHUNK = 100  # steps, at least half of which are repeated


class Checkpoint(NamedTuple):
    """State of a run after a step, with all data that its next steps depend on."""

    step: int  # number of steps taken before
    state: tuple[Vector, Vector, Vector, Vector]  # coordinates, their rates, and multipliers
    memory: dict[str, Any]  # of the time loop, copied
    contributions: Vector  # their internal variables, (k,)
    solver: Vector  # memory of the nonlinear loop, (14,); empty without one
    next_projection: int = 0  # step after which velocities are projected (`ImplicitRun`)
    projection_interval: int = 0  # steps between projections


def save(
    system: System,
    time_loop: Loop,
    iteration: NonlinearLoop | None,
    step: int,
    next_projection: int = 0,
    projection_interval: int = 0,
) -> Checkpoint:
    """Return a checkpoint of the present state, after a number of steps."""
    memory = {
        name: np.copy(value) if isinstance(value, np.ndarray) else value
        for name, value in time_loop.memory.items()
    }
    return Checkpoint(
        step,
        time_loop.state,
        memory,
        np.array(system.assembly.memory),
        np.empty(0) if iteration is None else iteration.memory,
        next_projection,
        projection_interval,
    )


def restore(
    system: System, time_loop: ImplicitLoop, iteration: NonlinearLoop, back: Checkpoint
) -> None:
    """Set implicit loops and the internal variables of contributions to a checkpoint.

    The seed is renewed in the next step.  Steps accepted on trial before are final.
    """
    time_loop.withdraw()
    q, v, a, lam = back.state
    memory = back.memory
    start = Start(q, v, a, memory.get("b0", a), lam, memory["amplitudes0"])
    time_loop.move(start, memory.get("before", q), np.zeros(0), np.zeros(0))
    time_loop.recall(memory)
    restore_contributions(system, back)
    iteration.memory = back.solver
    iteration.step = back.step
    iteration.mark_stale()


def restore_contributions(system: System, back: Checkpoint) -> None:
    """Set the internal variables of contributions to a checkpoint."""
    system.assembly.begin(back.state[0])
    if len(back.contributions):
        system.assembly.memory = back.contributions


class RepeatableRun(RecoverableRun, Protocol):
    """A run whose steps can be repeated; `is_between_steps` is True in a state of the run."""

    is_between_steps: bool
    longest_chunk: int
    save_every: int
    recorder: StateRecorder

    def stop(self, outcome: Outcome) -> tuple[Outcome, FailedStep]:
        """Discard steps on trial; return the outcome and the record of a failed step."""

    def check_functions(self, step: int) -> None:
        """Raise the error of a function of the motion in a failed step, if there is one."""

    def save(self) -> Checkpoint:
        """Return the present state with its memory."""

    def restore(self, back: Checkpoint) -> None:
        """Set the state to a checkpoint."""

    def discard_states(self, recorder: StateRecorder, step: int) -> None:
        """Discard the recorded states after a step."""

    def discard_events(self, step: int) -> None:
        """Discard the events after a step."""

    def search_singularities(self) -> None:
        """Look for singular configurations from the next step on."""

    def count(self) -> RunStats:
        """Return the statistics of the steps."""


class Failure(NamedTuple):
    """Failure of the selected method, which is reported if Newton's method fails too."""

    step: int  # number of the failed step, from 1
    report: FailedStep
    events: list[Event]  # before the repetition
    end: Checkpoint  # last state that is kept
    is_inside_step: bool  # of that state, which is then not one of the run
    recorder: StateRecorder  # of the run, with its states
    back: int  # number of steps before the first repeated one


class RepeatedSteps(Recovery):
    """Repeats the last steps by Newton's method, from the older of two checkpoints.

    The equations of a step can have several solutions, above all in contact.  An accepted solution
    can lead to a later step that has no solution, or only solutions that gain energy, although
    another one could have been continued.  A repetition from the start is identical to the run by
    Newton's method.

    Attributes
    ----------
    first_step : int
        Number of steps before the first one that can be repeated.
    failure : Failure or None
        The failure that has led to the present repetition.
    """

    name = "repeated steps"

    def __init__(self, run: RepeatableRun) -> None:
        super().__init__(run)
        self._repeated: RepeatableRun = run
        self._interval = run.longest_chunk // 2
        self._older: Checkpoint | None = None
        self._newer: Checkpoint | None = None
        self._failed, self.first_step = 0, 0
        self.failure: Failure | None = None
        if run.longest_chunk >= MIN_REPEATED_CHUNK:
            self._newer = self._older = run.save()

    def begin_at(self, first: Checkpoint) -> None:
        """Let a checkpoint be the first one, if any are kept."""
        self._newer = self._older = self._older and first
        self._failed, self.first_step, self.failure = 0, first.step, None

    @property
    def is_begun(self) -> bool:
        """True while Newton's method takes the steps of a repetition, or of a trial."""
        return self._failed > 0 or self.failure is not None

    def keep(self) -> None:
        """Accept steps on trial after the failed one; keep a checkpoint if it is due."""
        run = self._repeated
        if self.failure and run.stats.steps >= self.failure.step:
            self.end_trial()
        if self._newer is None or run.stats.steps < self._newer.step + self._interval:
            return
        self._older, self._newer = self._newer, run.save()
        if self._failed and self._newer.step > self._failed:
            self._iteration.newton, self._failed = False, 0

    def applies(self, outcome: Outcome) -> bool:
        """Return True: earlier steps can cause any failure."""
        return True

    def attempt(self, step: int, outcome: Outcome) -> Outcome:
        """Try to recover a step, and return its new outcome."""
        if self.failure and self.end_trial():
            return self.failure.report.outcome
        run, rate, cause = self._repeated, self._iteration.contraction, outcome
        failed = step if outcome in RECOVERABLE_OUTCOMES else step - 1
        outcome, report = run.stop(outcome)
        back = self._older
        if back is None:
            return outcome
        run.check_functions(failed)
        end, is_inside = run.save(), not run.is_between_steps
        # Newton's method failed, or only the failed step would be repeated.
        is_vain = self._iteration.newton or not self.first_step <= back.step < failed - 1
        run.is_between_steps = is_vain and not is_inside
        if is_vain:
            return outcome
        run.count()
        self._failed, self._newer = failed, back
        events, recorder = run.stats.events, run.recorder
        self.failure = Failure(failed, report, events, end, is_inside, recorder, back.step)
        run.discard_events(back.step)
        self._record(failed, f"Newton from step {back.step + 1} on", cause, rate)
        run.recorder = TrialRecorder(back.step // run.save_every + 1)
        run.restore(back)
        self._iteration.newton = True
        run.search_singularities()
        run.is_between_steps = True
        return Outcome.CONVERGED

    def end_trial(self) -> bool:
        """Accept or discard the steps on trial; return whether they were discarded."""
        failure, run, trial = self.failure, self._repeated, self._repeated.recorder
        if not failure or not isinstance(trial, TrialRecorder):
            return False
        if run.stats.steps >= failure.step:
            # An interruption may come here, and this is done again.
            states = trial.states()
            run.discard_states(failure.recorder, failure.back)
            if states:
                failure.recorder.append(*states)
            run.recorder, self.failure = failure.recorder, None
            return False
        run.is_between_steps = False
        run.restore(failure.end)
        run.system.assembly.forget()  # errors of functions in these steps
        run.recorder = failure.recorder
        run.is_between_steps = not failure.is_inside_step
        return True
