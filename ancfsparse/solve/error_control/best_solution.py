"""Track the current run and the best solution of an error-controlled simulation."""

from __future__ import annotations

import math

from ancfsparse.results import RunStats
from ancfsparse.results.data.run_statistics import MAX_EVENTS
from ancfsparse.solve.stepping.outcome_reporting import LOOP_COUNTS
from ancfsparse.solve.stepping.sampled_states import SampledStates
from ancfsparse.solve.stepping.state_recorder import StateRecorder


class BestSolution:
    """Stores the best motion so far, or the current one before there is a complete one.

    So an interrupted run, or the file of a killed process, contains the best complete motion, or
    the begin of the first.

    Parameters
    ----------
    recorder : StateRecorder
        Stores the states.
    threads : int
        Largest number of threads.

    Attributes
    ----------
    stats : RunStats
        Statistics of all runs, and the error of the best.
    """

    def __init__(self, recorder: StateRecorder, threads: int) -> None:
        self._recorder = recorder
        self._running: SampledStates | None = None
        self._recorded, self._is_complete = 0, False
        self.stats = RunStats(runs=0, threads=threads, error=math.inf)

    def watch(self, states: SampledStates) -> None:
        """Store further states of the current motion."""
        if self._is_complete:
            return
        if states is not self._running:
            self._running, self._recorded = states, 0
        self._record(states, self._recorded, states.rows)

    def keep(self, states: SampledStates) -> None:
        """Store a complete motion that is better than those before."""
        if self._is_complete or states is not self._running:
            self._record(states, 0, states.rows)
        self._is_complete = True
        self._recorder.finish(self.stats)

    def finish(self) -> None:
        """Store the statistics if there is any state."""
        if self._recorder.rows:
            self._recorder.finish(self.stats)

    def _record(self, states: SampledStates, first: int, last: int) -> None:
        rows = slice(first, last)
        q, v, a, lam, history = (table[rows] for table in states.tables)
        self._recorder.append(states.t[rows], q, v, a, lam, history, begin=first)
        self._recorded = last


def add_counts(total: RunStats, stats: RunStats) -> None:
    """Add the statistics of a run to those of all, with consecutive numbers of steps."""
    total.events += [e._replace(step=e.step + total.steps) for e in stats.events]
    del total.events[MAX_EVENTS:]
    for name in (
        *LOOP_COUNTS,
        *("march_seconds", "steps", "sweeps", "products", "recoveries", "rejected_steps", "runs"),
    ):
        setattr(total, name, getattr(total, name) + getattr(stats, name))
    for part, seconds in stats.seconds.items():
        total.seconds[part] = total.seconds.get(part, 0.0) + seconds
