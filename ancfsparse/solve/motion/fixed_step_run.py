"""Steps of one length: taken compiled, recorded, counted, and none lost if a run ends early."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import AncfError, LoadError, OutputError
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.solve.initial_conditions.restart import save_state
from ancfsparse.solve.motion.arguments import Request
from ancfsparse.solve.preparation.memory_estimate import release_free_memory
from ancfsparse.solve.preparation.progress_bar import progress_bar
from ancfsparse.solve.stepping.state_recorder import StateRecorder, buffer_rows
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import Loop
    from ancfsparse.nonlinear.loop_protocols import NonlinearLoop

Vector = NDArray[np.float64]

# Steps that are taken in one go, and rows of loads that are tabulated at once: at most CHUNK, and
# of large systems so many that about so many coordinates move.
CHUNK, COORDINATES = 2000, 4_000_000

# Number of coordinates from which memory freed by the set-up is returned: vectors of a megabyte.
LARGE = 125_000


class Failing(Protocol):
    """An object whose Python code may have failed inside a compiled loop."""

    @property
    def error(self) -> BaseException | None:
        """The exception that it raised there."""


class FixedStepRun(ABC):
    """A run in steps of one length.

    Parameters
    ----------
    system : System
        What moves.
    request : Request
        The steps, and which of them are recorded.
    march : Loop
        Compiled loop of the integrator, at the start.
    nonlinear : NonlinearLoop or None
        Compiled loop that solves the equations of a step.
    a : (n_all,) float
        Accelerations at the start, to be recorded [m/s2, 1/s2].
    why : str
        How the steps are solved.
    threads : int
        How many share the work.
    """

    takes_rates = False  # of what equations follow

    def __init__(
        self,
        system: System,
        request: Request,
        march: Loop,
        nonlinear: NonlinearLoop | None,
        a: Vector,
        why: str,
        threads: int = 1,
    ) -> None:
        self._system, self._request, self._clock = system, request, request.clock
        self._march, self._nonlinear, self._first = march, nonlinear, [a]
        self._stages, self._dt = request.integrator.stages, request.clock.dt
        self._n_steps, self._save_every = request.n_steps, request.save_every
        self._chunk = max(1, min(CHUNK, COORDINATES // system.n_all))
        self._soon = 0  # steps after which something is due, 0 if nothing is
        seconds = {"set-up": time.perf_counter() - request.begun}
        self._stats = RunStats(solver=why, seconds=seconds, threads=threads)
        # Steps of the run, and of the march, before those whose states are in the buffer; None
        # while the march stands inside a step.
        self._before: tuple[int, int] | None = (0, march.steps)

    @property
    @abstractmethod
    def _seeds(self) -> Sequence[Failing]:
        """The seed; one that is written in Python keeps its exception."""

    @abstractmethod
    def _count_costs(self) -> None:
        """Update the statistics with the cost of the steps so far."""

    @abstractmethod
    def failure(self, outcome: Outcome, path: Trajectory) -> AncfError:
        """Return the error for a run that ended with an outcome."""

    def _mend(self, outcome: Outcome) -> Outcome:
        """Try other ways across a step that failed, or choose another way for the next ones."""
        return outcome

    def _last_look(self) -> Outcome:
        """Check a run that has taken all its steps."""
        return Outcome.CONVERGED

    def _withdraw(self, outcome: Outcome) -> Outcome:
        """Take back what a failed run must not keep; return what it has failed for."""
        return outcome

    def march(self, recorder: StateRecorder) -> Outcome:
        """Record the start and take the steps; return how they ended.

        Raises
        ------
        LoadError
            If a load fails, after the steps before.
        OutputError
            If there is no room for their states.
        """
        self._recorder = recorder
        self._record_start()
        most = min(self._n_steps, self._chunk) // self._save_every + 1
        self._room = buffer_rows(self._system.n_all, most)
        self._buffer = [np.empty((self._room + 1, self._system.n_all)) for _ in range(3)]
        self._buffer.append(np.empty((self._room + 1, self._system.n_multipliers)))
        try:
            outcome = self._run()
            self._keep_last()
            self._count()
        except OutputError:
            self._count()
            raise
        except BaseException:  # an interruption may come between any two lines
            self._collect()
            self._keep_last()
            self._count()
            raise
        return outcome

    def _record_start(self) -> None:
        system, first = self._system, self._march.state
        # Velocity and acceleration that the integrator continues from differ, see solve.start.
        a = self._first.pop()
        when = np.array([system.t0])
        self._recorder.append(when, first[0][None], system.v0[None], a[None], first[3][None])
        del first, a
        if system.n_all >= LARGE:
            release_free_memory()

    def _run(self) -> Outcome:
        stats, outcome = self._stats, Outcome.CONVERGED
        with progress_bar("step", self._request.progress, self._n_steps) as bar:
            while stats.steps < self._n_steps and outcome == Outcome.CONVERGED:
                outcome = self._mend(self._advance())
                bar.update(stats.steps - bar.n)
        if outcome != Outcome.CONVERGED:
            self._check_functions(stats.steps + 1)
            return self._withdraw(outcome)
        return self._withdraw(self._last_look())

    def _check_functions(self, step: int) -> None:
        """Raise what a function of the motion has done wrong in a step that failed, if it did."""
        try:
            self._system.assembly.check()
        except LoadError as failure:
            time = failure.time if np.isfinite(failure.time) else self._clock.at(step)
            reason = f"{failure.reason.rstrip('.')}; that was in step {step}"
            raise LoadError(reason, time) from failure.__cause__

    def _advance(self) -> Outcome:
        """Take as many steps as are taken in one go."""
        begin, p = self._stats.steps, len(self._stages)
        since = begin % self._save_every  # steps since the last recorded state
        room = self._room * self._save_every - since
        most = min(self._soon or self._chunk, self._chunk)
        wanted = min(most, self._n_steps - begin, room)
        steps = np.arange(wanted, dtype=np.float64)[:, None] + begin
        times = self._clock.at(steps, self._stages)
        amplitudes, failure = self._system.inputs(times.ravel(), self.takes_rates)
        wanted = len(amplitudes) // p
        self._before = begin, self._march.steps
        clock = time.perf_counter()
        try:
            _, code = self._march.advance(
                self._nonlinear, wanted, amplitudes, self._save_every, since, *self._buffer
            )
        finally:
            self._stats.march_seconds += time.perf_counter() - clock
        for seed in self._seeds:
            if seed.error is not None:
                raise seed.error
        self._collect()
        outcome = Outcome(code)
        if failure is not None and outcome == Outcome.CONVERGED:
            raise failure
        return outcome

    def _collect(self) -> None:
        """Hand on and count what the march has taken; doing so again changes nothing."""
        if self._before is None or not self._buffer:  # the buffer is freed once all is recorded
            return
        begin, counted = self._before
        self._stats.steps = steps = begin + self._march.steps - counted
        first, every = begin // self._save_every, self._save_every  # recorded before: 0 to `first`
        new = slice(self._recorder.rows - first, steps // every + 1 - first)
        numbers = every * (first + np.arange(new.start, new.stop, dtype=np.float64))
        self._recorder.append(self._clock.at(numbers), *(table[new] for table in self._buffer))

    def _keep_last(self) -> None:
        """Record the last state too, whatever its number."""
        steps = self._stats.steps
        if self._before is not None and self._recorder.rows == steps // self._save_every + 1:
            if steps % self._save_every:
                self._append_state()

    def _count(self) -> None:
        """Hand on what the steps have cost so far."""
        stats = self._stats
        self._count_costs()
        last = None
        self._buffer = []  # makes room for the last state
        if self._before is not None:
            t = self._clock.at(stats.steps)
            integrator, loop = self._request.integrator, self._nonlinear
            last = save_state(self._system, integrator, self._march, loop, t, self._dt)
        self._recorder.finish(stats, last)

    def _append_state(self) -> None:
        time = np.array([self._clock.at(self._stats.steps)])
        self._recorder.append(time, *(x[None] for x in self._march.state))
