"""Steps of one length: taken compiled, handed on, counted, and none lost where a run ends early."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from ancfsparse.errors import OutputFailure
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import RunStats
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.blocks import BlockInverse
from ancfsparse.solve.halving import CURABLE, Halving
from ancfsparse.solve.record import Recorder, buffer_rows
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Steps that are taken in one go, and rows of loads that are tabulated at once: at most CHUNK, and
# of large systems so many that about so many coordinates move.
CHUNK, COORDINATES = 2000, 4_000_000


class FixedSteps:
    """A run in steps of one length, after its first state was recorded.

    Parameters
    ----------
    system : System
        What moves.
    march, iteration, seed
        Compiled loops of the integrator and of the nonlinear solver (None for explicit ones), and
        what they solve with.
    nodes : (p,) float
        Times in a step at which loads are needed, over the step.
    n_steps : int
        Steps to take.
    dt : float
        Their length [s].
    save_every : int
        Steps from one recorded state to the next.
    recorder : Recorder
        Takes the states.
    stats : RunStats
        Counts the steps and their seconds.
    halving : Halving or None
        Crosses steps that fail.
    """

    def __init__(
        self,
        system: System,
        march: Any,
        iteration: Any,
        seed: SparseSeed | BlockInverse,
        nodes: Vector,
        n_steps: int,
        dt: float,
        save_every: int,
        recorder: Recorder,
        stats: RunStats,
        halving: Halving | None,
    ) -> None:
        self._system, self._march, self._iteration, self._seed = system, march, iteration, seed
        self._nodes, self._n_steps, self._dt, self._save_every = nodes, n_steps, dt, save_every
        self._recorder, self._stats, self._halving = recorder, stats, halving
        self._chunk = max(1, min(CHUNK, COORDINATES // system.n_all))
        most = min(n_steps, self._chunk) // save_every + 1
        self._room = buffer_rows(system.n_all, most)
        self._buffer = [np.empty((self._room + 1, system.n_all)) for _ in range(3)]
        self._buffer.append(np.empty((self._room + 1, system.n_multipliers)))
        # Steps of the run, and of the march, before those whose states are in the buffer; None
        # while the march stands inside a step.
        self._before: tuple[int, int] | None = (0, march.steps)

    def run(self, progress: bool) -> Outcome:
        """Take the steps; return how they ended.

        Raises
        ------
        LoadFailure
            If a load fails, after the steps before.
        """
        try:
            outcome = self._run(progress)
        except OutputFailure:  # there is no room for more
            raise
        except BaseException:  # an interruption may come between any two lines
            self._collect()
            self._keep_last()
            raise
        self._keep_last()
        return outcome

    def _run(self, progress: bool) -> Outcome:
        stats, outcome = self._stats, Outcome.CONVERGED
        with tqdm(total=self._n_steps, unit="step", disable=not progress, leave=False) as bar:
            while stats.steps < self._n_steps and outcome == Outcome.CONVERGED:
                outcome = self._advance()
                if self._halving is not None and outcome in CURABLE:
                    outcome = self._cross(self._halving, outcome)
                bar.update(stats.steps - bar.n)
        gained = self._halving is not None and outcome == Outcome.CONVERGED
        return Outcome.GAINED_ENERGY if gained and self._march.gains_energy() else outcome

    def _advance(self) -> Outcome:
        """Take as many steps as are taken in one go."""
        begin, p = self._stats.steps, len(self._nodes)
        since = begin % self._save_every  # steps since the last recorded state
        room = self._room * self._save_every - since
        wanted = min(self._chunk, self._n_steps - begin, room)
        times = self._dt * (np.arange(wanted, dtype=np.float64)[:, None] + begin + self._nodes)
        amplitudes, failure = self._system.loads.tabulate(times.ravel())
        wanted = len(amplitudes) // p
        self._before = begin, self._march.steps
        clock = time.perf_counter()
        try:
            _, code = self._march.advance(
                self._iteration, wanted, amplitudes, self._save_every, since, *self._buffer
            )
        finally:
            self._stats.march_seconds += time.perf_counter() - clock
        if self._seed.error is not None:
            raise self._seed.error
        self._collect()
        outcome = Outcome(code)
        if failure is not None and outcome == Outcome.CONVERGED:
            raise failure
        return outcome

    def _collect(self) -> None:
        """Hand on and count what the march has taken; doing so again changes nothing."""
        if self._before is None:
            return
        begin, counted = self._before
        self._stats.steps = steps = begin + self._march.steps - counted
        first, every = begin // self._save_every, self._save_every  # recorded before: 0 to `first`
        new = slice(self._recorder.rows - first, steps // every + 1 - first)
        numbers = every * (first + np.arange(new.start, new.stop, dtype=np.float64))
        self._recorder.append(self._dt * numbers, *(table[new] for table in self._buffer))

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

    def _append_state(self) -> None:
        time = np.array([self._dt * self._stats.steps])
        self._recorder.append(time, *(x[None] for x in self._march.state))
