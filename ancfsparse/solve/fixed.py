"""Steps of one length: taken compiled, handed on, counted, and none lost where a run ends early."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from ancfsparse.errors import LoadFailure, OutputFailure
from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Event, RunStats
from ancfsparse.seeds import Seed
from ancfsparse.seeds.blocks import BlockInverse
from ancfsparse.solve.continuation import remember
from ancfsparse.solve.explicit import count_forces
from ancfsparse.solve.halving import CURABLE, Halving
from ancfsparse.solve.progress import progress_bar
from ancfsparse.solve.record import Recorder, buffer_rows
from ancfsparse.solve.setup import CAUSES, count, events
from ancfsparse.solve.times import Clock
from ancfsparse.solve.way_back import FIRST_LOOK, WayBack
from ancfsparse.system import System

# Steps that are taken in one go, and rows of loads that are tabulated at once: at most CHUNK, and
# of large systems so many that about so many coordinates move.
CHUNK, COORDINATES = 2000, 4_000_000


class FixedSteps:
    """A run in steps of one length, after its first state was recorded.

    Parameters
    ----------
    system : System
        What moves.
    integrator : Implicit or Explicit
        How.
    march, iteration, seed
        Compiled loops of the integrator and of the nonlinear solver (None for explicit ones), and
        what they solve with.
    back : WayBack or None
        Leads to an exact seed.
    halving : Halving or None
        Crosses steps that fail.
    stats : RunStats
        Where steps, iterations and seconds are counted.
    recorder : Recorder
        Takes the states.
    save_every : int
        Steps from one recorded state to the next.
    clock : Clock
        Times of the steps.
    """

    def __init__(
        self,
        system: System,
        integrator: Implicit | Explicit,
        march: Any,
        iteration: Any,
        seed: Seed | BlockInverse,
        back: WayBack | None,
        halving: Halving | None,
        stats: RunStats,
        recorder: Recorder,
        save_every: int,
        clock: Clock,
    ) -> None:
        self._system, self._integrator = system, integrator
        self._march, self._iteration, self._seeds = march, iteration, [seed]
        self._back, self._events = back, list[Event]()
        self._halving, self._stats, self._recorder = halving, stats, recorder
        self._save_every, self._clock, self._dt = save_every, clock, clock.dt
        # Times in a step at which loads are needed, over the step.
        self._nodes = np.ones(1)
        if isinstance(integrator, Explicit):
            self._nodes = integrator.tableau.c[1:]
        self._chunk = max(1, min(CHUNK, COORDINATES // system.n_all))
        if back is not None:
            self._most, self._chunk = self._chunk, min(self._chunk, FIRST_LOOK)
        # Steps of the run, and of the march, before those whose states are in the buffer; None
        # while the march stands inside a step.
        self._before: tuple[int, int] | None = (0, march.steps)

    def run(self, n_steps: int, progress: bool) -> Outcome:
        """Take steps; return how they ended.

        Raises
        ------
        LoadFailure
            If a load fails, after the steps before.
        OutputFailure
            If there is no room for their states.
        """
        self._n_steps = n_steps
        most = min(n_steps, self._chunk) // self._save_every + 1
        self._room = buffer_rows(self._system.n_all, most)
        self._buffer = [np.empty((self._room + 1, self._system.n_all)) for _ in range(3)]
        self._buffer.append(np.empty((self._room + 1, self._system.n_multipliers)))
        try:
            outcome = self._run(progress)
            self._keep_last()
            self._count()
        except OutputFailure:
            self._count()
            raise
        except BaseException:  # an interruption may come between any two lines
            self._collect()
            self._keep_last()
            self._count()
            raise
        return outcome

    def _run(self, progress: bool) -> Outcome:
        stats, outcome = self._stats, Outcome.CONVERGED
        with progress_bar("step", progress, self._n_steps) as bar:
            while stats.steps < self._n_steps and outcome == Outcome.CONVERGED:
                outcome = self._advance()
                if self._back is not None:
                    outcome = self._consider(self._back, outcome)
                if self._halving is not None and outcome in CURABLE:
                    outcome = self._cross(self._halving, outcome)
                bar.update(stats.steps - bar.n)
        if outcome != Outcome.CONVERGED:
            self._check_functions(stats.steps + 1)
        gained = self._halving is not None and outcome == Outcome.CONVERGED
        return Outcome.HAD_GAINED if gained and self._march.gained_energy() else outcome

    def _check_functions(self, step: int) -> None:
        """Raise what a function of the motion has done wrong in a step that failed, if it did."""
        try:
            self._system.assembly.check()
        except LoadFailure as failure:
            time = failure.time if np.isfinite(failure.time) else self._clock.at(step)
            reason = f"{failure.reason.rstrip('.')}; that was in step {step}"
            raise LoadFailure(reason, time) from failure.__cause__

    def _advance(self) -> Outcome:
        """Take as many steps as are taken in one go."""
        begin, p = self._stats.steps, len(self._nodes)
        since = begin % self._save_every  # steps since the last recorded state
        room = self._room * self._save_every - since
        wanted = min(self._chunk, self._n_steps - begin, room)
        steps = np.arange(wanted, dtype=np.float64)[:, None] + begin
        times = self._clock.at(steps + self._nodes)
        amplitudes, failure = self._system.inputs(times.ravel())
        wanted = len(amplitudes) // p
        self._before = begin, self._march.steps
        clock = time.perf_counter()
        try:
            _, code = self._march.advance(
                self._iteration, wanted, amplitudes, self._save_every, since, *self._buffer
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

    def _consider(self, back: WayBack, outcome: Outcome) -> Outcome:
        """Go on with an exact seed where the incomplete one fails or costs more, and it fits."""
        failed, steps = outcome in CURABLE, self._stats.steps
        assert not isinstance(self._seeds[0], BlockInverse)
        if not failed and not back.pays(self._iteration.counts, self._seeds[0].inner):
            self._chunk = min(2 * self._chunk, self._most)
            return outcome
        exact, self._back = back.take(), None
        if exact is None:
            return outcome
        self._seeds.append(exact)
        why = "which cost less"
        if failed:
            why, time = CAUSES[outcome], self._clock.at(steps + 1)
            rate = self._iteration.contraction
            self._events.append(Event(steps + 1, time, "exact seed", CAUSES[outcome], rate))
        self._stats.solver += f"; from step {steps + 1} on an exact seed ({why})"
        self._iteration.step = steps
        return Outcome.CONVERGED

    def _collect(self) -> None:
        """Hand on and count what the march has taken; doing so again changes nothing."""
        if self._before is None or not self._buffer:  # the buffer goes once all is handed on
            return
        begin, counted = self._before
        self._stats.steps = steps = begin + self._march.steps - counted
        first, every = begin // self._save_every, self._save_every  # recorded before: 0 to `first`
        new = slice(self._recorder.rows - first, steps // every + 1 - first)
        numbers = every * (first + np.arange(new.start, new.stop, dtype=np.float64))
        self._recorder.append(self._clock.at(numbers), *(table[new] for table in self._buffer))

    def _cross(self, halving: Halving, outcome: Outcome) -> Outcome:
        """Cross a step that failed in shorter ones."""
        self._before, seconds = None, halving.seconds
        outcome = halving.cross(self._stats.steps + 1, outcome)
        self._stats.march_seconds += halving.seconds - seconds
        if outcome == Outcome.CONVERGED:
            self._stats.steps += 1
            if self._stats.steps % self._save_every == 0:
                self._append_state()
        if not halving.stuck:
            self._before = self._stats.steps, self._march.steps
        return outcome

    def _keep_last(self) -> None:
        """Record the last state too, whatever its number."""
        steps = self._stats.steps
        if self._before is not None and self._recorder.rows == steps // self._save_every + 1:
            if steps % self._save_every:
                self._append_state()

    def _count(self) -> None:
        """Hand on what the steps have cost so far."""
        stats = self._stats
        if isinstance(self._integrator, Explicit):
            count_forces(stats, self._integrator)
        else:
            count(
                stats, self._iteration, *(s for s in self._seeds if not isinstance(s, BlockInverse))
            )
            stats.events = (
                events(self._iteration.events, self._clock.begin, self._dt) + self._events
            )
        if self._halving is not None:
            stats.short_steps = self._halving.short_steps
            stats.events += self._halving.events
        last = None
        self._buffer = []  # makes room for the last state
        if self._before is not None:
            t = self._clock.at(stats.steps)
            iteration = self._iteration
            last = remember(self._system, self._integrator, self._march, iteration, t, self._dt)
        self._recorder.finish(stats, last)

    def _append_state(self) -> None:
        time = np.array([self._clock.at(self._stats.steps)])
        self._recorder.append(time, *(x[None] for x in self._march.state))
