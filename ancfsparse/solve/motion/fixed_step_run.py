"""Fixed-step time loop: advance, record and count steps, and keep them if a run ends early."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import AncfError, LoadError, OutputError
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Event, RunStats, Trajectory
from ancfsparse.solve import motion
from ancfsparse.solve.initial_conditions.restart import save_state
from ancfsparse.solve.motion.arguments import Request
from ancfsparse.solve.preparation.memory_estimate import release_free_memory
from ancfsparse.solve.preparation.progress_bar import progress_bar
from ancfsparse.solve.recovery.checkpoints import Checkpoint
from ancfsparse.solve.stepping.state_recorder import StateRecorder, buffer_rows
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import Loop
    from ancfsparse.nonlinear.loop_protocols import NonlinearLoop
    from ancfsparse.solve.preparation.checkpoint_schedule import Schedule
    from ancfsparse.solve.recovery.singular_crossing import Crossing, SingularCrossing
    from ancfsparse.solve.stepping.state_recorder import FileRecorder
    from ancfsparse.system.coordinates.state import State


MAX_CHUNK = 2000  # steps taken together, whose loads are tabulated at once
MAX_CHUNK_COORDINATES = 4_000_000  # coordinates of all of them
MIN_RELEASE_COORDINATES = 125_000  # from which memory freed by the set-up is returned


class PythonSeed(Protocol):
    """A seed whose Python code may raise an exception in a compiled loop."""

    @property
    def error(self) -> BaseException | None:
        """The exception raised there, if any."""


class FixedStepRun(ABC):
    """A run with a fixed step.

    Parameters
    ----------
    system : System
        The moving system.
    request : Request
        The steps, and the steps to be saved.
    time_loop : Loop
        Compiled loop of the integrator, at the start.
    nonlinear : NonlinearLoop or None
        Compiled loop that solves the equations of a step.
    a : (n_all,) float
        Accelerations at the start [m/s2, 1/s2].
    why : str
        Description of the solution of a step.
    threads : int
        Number of threads.
    """

    takes_rates = False  # of prescribed motions
    seeds: Sequence[PythonSeed]  # one that is written in Python stores its exception

    def __init__(
        self,
        system: System,
        request: Request,
        time_loop: Loop,
        nonlinear: NonlinearLoop | None,
        a: Vector,
        why: str,
        threads: int = 1,
    ) -> None:
        self.system, self._request, self.clock = system, request, request.clock
        self._time_loop, self._nonlinear, self._first = time_loop, nonlinear, [a]
        self._stages, self._dt = request.integrator.stages, request.clock.dt
        self._n_steps, self.save_every = request.n_steps, request.save_every
        self._chunk = max(1, min(MAX_CHUNK, MAX_CHUNK_COORDINATES // system.n_all))
        self._takes_inputs = bool(system.loads.n_amplitudes or system.prescribed)
        self._no_inputs = np.empty((self._chunk, 0))
        self._steps_to_pause = 0  # steps until `_recover` is needed, 0 for as many as fit
        self._crossings: list[Event] = []  # of singular configurations
        seconds = {"set-up": time.perf_counter() - request.begun}
        self.stats = RunStats(solver=why, seconds=seconds, threads=threads)
        # Steps of the run, and of the time loop, before those whose states are in the buffer; None
        # while the time loop is inside a step.
        self._before: tuple[int, int] | None = (0, time_loop.steps)
        self._schedule = request.checkpoint
        self._earlier: RunStats | None = None  # of the processes before this one
        self._changes_before = system.contact_changes

    @abstractmethod
    def _count_costs(self) -> None:
        """Update the statistics with the operations of the steps so far."""

    @abstractmethod
    def failure(self, outcome: Outcome, path: Trajectory) -> AncfError:
        """Return the error of a run that ended with an outcome."""

    @abstractmethod
    def _continue(self, crossing: Crossing) -> None:
        """Set the time loop to the end of a crossing."""

    def save_checkpoint(self) -> Checkpoint:
        """Return the present state; the next steps equal those after a return to it."""
        saved = self.save()
        self.return_to(saved)
        return saved

    def _keep_checkpoint(self, schedule: Schedule) -> None:
        """Write a checkpoint into the file, and continue as a run that is resumed from it."""
        step, saved = self.stats.steps, None
        if step:
            if not self._may_return():
                schedule.skip(step)
                return
            saved = self.save_checkpoint()
            schedule.keep(step)
            self.stats.checkpoints = schedule.steps
        stored = None if saved is None else saved._asdict() | self.describe_memory()
        data = {"stored": stored, "stats": asdict(self.count())}
        cast("FileRecorder", self.recorder).keep_checkpoint(motion.pack(data))

    def _continue_from(self, resumed: Mapping[str, Any]) -> None:
        """Return to a checkpoint in a file."""
        self._earlier = RunStats(**resumed["stats"])
        assert self._schedule is not None
        self._schedule.resume(self._earlier.checkpoints)
        if resumed["stored"] is None:  # at the start
            return
        stored = dict(resumed["stored"])
        self.take_memory(stored)
        stored = {name: stored[name] for name in Checkpoint._fields}
        self.return_to(Checkpoint(**stored))
        self.stats.solver = self._earlier.solver
        self.stats.checkpoints = self._schedule.steps

    def _may_return(self) -> bool:
        """Return whether the present state can be returned to."""
        return self.is_between_steps

    def describe_memory(self) -> dict[str, Any]:
        """Return the memory of the run that is not in a checkpoint: earlier choices."""
        return {}

    def take_memory(self, stored: Mapping[str, Any]) -> None:  # noqa: B027
        """Set the memory that `describe_memory` has returned."""

    @abstractmethod
    def save(self) -> Checkpoint:
        """Return the present state with its memory."""

    @abstractmethod
    def return_to(self, back: Checkpoint) -> None:
        """Return to a checkpoint of this run."""

    def keep_last_step(self) -> None:
        """Let the state be that after the last step, although a step has failed."""
        self._collect()
        self._end_trial()

    def forbid_repetition(self) -> None:  # noqa: B027
        """Let earlier steps not be repeated, since their inputs are not known any more."""

    @property
    def steps(self) -> int:
        """Number of steps taken."""
        return self.stats.steps

    @property
    def state(self) -> tuple[Vector, Vector, Vector, Vector]:
        """Present ``(q, v, a, lam)`` as copies."""
        return self._time_loop.state

    @property
    def is_between_steps(self) -> bool:
        """True if the state of the time loop is one of the run, False inside a step."""
        return self._before is not None

    @is_between_steps.setter
    def is_between_steps(self, value: bool) -> None:
        self._before = (self.stats.steps, self._time_loop.steps) if value else None

    def _recover(self, outcome: Outcome) -> Outcome:
        """Try to recover a failed step, or change the solution of the next ones."""
        return outcome

    def _cross_ahead(self, ahead: SingularCrossing) -> int:
        """Look for a singular configuration and cross it; return the steps to the next look."""
        stats, every = self.stats, self.save_every
        begin, (q, v, _, _) = stats.steps, self._time_loop.state
        pause, crossing = ahead.anticipate(begin, q, v)
        if crossing is not None:
            self.is_between_steps = False
            self._continue(crossing)
            if crossing.event is not None:
                self._crossings.append(crossing.event)
            stats.steps = crossing.step
            rows = np.arange(begin // every + 1, crossing.step // every + 1, dtype=np.float64)
            if len(rows):
                times = self.clock.at(every * rows)
                self.recorder.append(times, *crossing.interpolate(times))
            self.is_between_steps = True
        return pause

    def _end_trial(self) -> None:  # noqa: B027
        """Accept or discard steps on trial."""

    def integrate(
        self, recorder: StateRecorder, resumed: Mapping[str, Any] | None = None
    ) -> Outcome:
        """Record the start and advance all steps; return the outcome.

        Parameters
        ----------
        recorder : StateRecorder
            It stores the states.
        resumed : mapping, optional
            Data of a checkpoint to continue from.

        Raises
        ------
        LoadError
            If a load fails, after the steps before.
        OutputError
            If the disk is full.
        """
        self.begin(recorder, resumed)
        try:
            outcome = self._run()
            self._keep_last()
            self._count()
        except OutputError:
            self._count()
            raise
        except BaseException:  # an interruption may come between any two lines
            self.keep_last_step()
            self._keep_last()
            self._count()
            raise
        return outcome

    def begin(self, recorder: StateRecorder, resumed: Mapping[str, Any] | None = None) -> None:
        """Record the start, or return to a checkpoint."""
        self.recorder = recorder
        if resumed is None:
            self._record_start()
        rows = min(self._n_steps, self._chunk) // self.save_every + 1
        self._room = buffer_rows(self.system.n_all, rows)
        self._buffer, self._other = list[Vector](), list[Vector]()
        self._take_other_buffer()
        if resumed is not None:
            self._continue_from(resumed)
        elif self._schedule is not None:
            self._keep_checkpoint(self._schedule)

    def _take_other_buffer(self) -> None:
        """Let the next states be written to the other buffer while the recorder reads one."""
        self._buffer, self._other = self._other, self._buffer
        n, m, h = self.system.n_all, self.system.n_multipliers, self.system.assembly.n_history
        if not self._buffer:
            self._buffer = [np.empty((self._room + 1, width)) for width in (n, n, n, m, h)]
        if h:
            self._time_loop.save_history(self._buffer[-1])

    def _record_start(self) -> None:
        system, first = self.system, self._time_loop.state
        # Those of the integrator differ, see `consistent_state.starting_state`.
        a = self._first.pop()
        when = np.array([system.t0])
        states = first[0][None], system.v0[None], a[None], first[3][None]
        self.recorder.append(when, *states, system.assembly.history[None])
        del first, a
        if system.n_all >= MIN_RELEASE_COORDINATES:
            release_free_memory()

    def _run(self) -> Outcome:
        with progress_bar("step", self._request.progress, self._n_steps) as bar:
            return self.advance_to(self._n_steps, lambda steps: bar.update(steps - bar.n))

    def advance_to(self, step: int, report: Callable[[int], object] | None = None) -> Outcome:
        """Advance to the end of a step; return the outcome.

        Parameters
        ----------
        step : int
            Number of the step.
        report : callable, optional
            Called with the number of steps after each chunk of them.

        Raises
        ------
        LoadError
            If a load fails, after the steps before.
        """
        stats, schedule, outcome, stop = self.stats, self._schedule, Outcome.CONVERGED, step
        while stats.steps < step and outcome == Outcome.CONVERGED:
            if schedule is not None:
                stop = schedule.next_stop(stats.steps, step)
            outcome = self._recover(self._advance(stop))
            if schedule is not None and outcome == Outcome.CONVERGED and stats.steps < step:
                if schedule.is_due(stats.steps):
                    self._keep_checkpoint(schedule)
            if report is not None:
                report(stats.steps)
        if outcome != Outcome.CONVERGED:
            self.check_functions(stats.steps + 1)
        return outcome

    def check_functions(self, step: int) -> None:
        """Raise the error of a function of the motion in a failed step, if there is one."""
        try:
            self.system.assembly.check()
        except LoadError as failure:
            time = failure.time if np.isfinite(failure.time) else self.clock.at(step)
            reason = f"{failure.reason.rstrip('.')}; that was in step {step}"
            raise LoadError(reason, time) from failure.__cause__

    def _advance(self, end: int) -> Outcome:
        """Advance one chunk of steps, at most to the end of a step."""
        begin = self.stats.steps
        since = begin % self.save_every  # steps since the last recorded state
        room = self._room * self.save_every - since
        n = min(end - begin, room, self._chunk, self._steps_to_pause or self._chunk)
        amplitudes, failure = self._no_inputs, None
        if self._takes_inputs:
            steps = np.arange(n, dtype=np.float64)[:, None] + begin
            times = self.clock.at(steps, self._stages)
            amplitudes, failure = self.system.inputs(times.ravel(), self.takes_rates)
            n = len(amplitudes) // len(self._stages)
        self._before = begin, self._time_loop.steps
        clock = time.perf_counter()
        try:
            _, code = self._time_loop.advance(
                self._nonlinear, n, amplitudes, self.save_every, since, *self._buffer[:4]
            )
        finally:
            self.stats.march_seconds += time.perf_counter() - clock
        for seed in self.seeds:
            if seed.error is not None:
                raise seed.error
        self._collect()
        outcome = Outcome(code) if code else Outcome.CONVERGED  # five times faster
        if failure is not None and outcome == Outcome.CONVERGED:
            raise failure
        return outcome

    def _collect(self) -> None:
        """Record and count the steps of the time loop; a repeated call has no effect."""
        if self._before is None or not self._buffer:  # the buffer is freed once all is recorded
            return
        begin, counted = self._before
        self.stats.steps = steps = begin + self._time_loop.steps - counted
        every, rows = self.save_every, self.recorder.rows
        if rows == steps // every + 1:
            return
        first = begin // every  # recorded before: 0 to `first`
        new = slice(rows - first, steps // every + 1 - first)
        numbers = every * (first + np.arange(new.start, new.stop, dtype=np.float64))
        if self.recorder.append(self.clock.at(numbers), *(table[new] for table in self._buffer)):
            self._take_other_buffer()

    def _keep_last(self) -> None:
        """Record the last state, even if its step is not one to be saved."""
        steps = self.stats.steps
        if self._before is not None and self.recorder.rows == steps // self.save_every + 1:
            if steps % self.save_every:
                self._append_state()

    def _count(self) -> None:
        """Store statistics and the last state."""
        stats = self.count()
        self._buffer, self._other = [], []  # makes room for the last state
        self.recorder.finish(stats, None if self._before is None else self.last_state())

    def count(self) -> RunStats:
        """Return the statistics of the steps."""
        self._count_costs()
        self.stats.contact_changes = self.system.contact_changes - self._changes_before
        return self.stats if self._earlier is None else self.stats.after(self._earlier)

    def last_state(self) -> State:
        """Return the present state, with the memory that its next steps need."""
        t, integrator = self.clock.at(self.stats.steps), self._request.integrator
        loops = self._time_loop, self._nonlinear
        return save_state(self.system, integrator, *loops, t, self._dt)

    def _append_state(self) -> None:
        time = np.array([self.clock.at(self.stats.steps)])
        history = self.system.assembly.history
        self.recorder.append(time, *(x[None] for x in (*self._time_loop.state, history)))
