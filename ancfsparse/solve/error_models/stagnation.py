"""Detect stagnation of the errors of successive runs with shorter steps."""

from __future__ import annotations

import math

from ancfsparse.errors import AccuracyError

MIN_DECREASE = 0.7  # largest ratio of the errors of successive runs that counts as progress
MAX_STAGNANT_RUNS = 4  # such runs in a row


class StagnationCheck:
    """Estimated errors of the runs of one candidate.

    A chaotic motion amplifies rounding: the errors of its runs have no trend.  Each error is
    therefore compared with the error of the last run that made progress, and must be smaller by
    this factor for every run since.  (Otherwise half the error with 49 times as many steps counts
    as progress: a chaotic motion took 12 runs and 88 s instead of 8 runs and 2 s.)

    Parameters
    ----------
    accuracy : float
        Requested accuracy [m].

    Attributes
    ----------
    stagnant_runs : int
        Runs in a row without progress.
    """

    def __init__(self, accuracy: float) -> None:
        self._accuracy, self.stagnant_runs = accuracy, 0
        self._smallest = self._last = math.inf

    def add(self, error: float, is_stagnant: bool = False) -> AccuracyError | None:
        """Add the error of a run [m]; return an error after too many runs without progress.

        A run may also show otherwise that it is stagnant.
        """
        if is_stagnant or error > MIN_DECREASE ** (1 + self.stagnant_runs) * self._last:
            self.stagnant_runs += 1
        else:
            self.stagnant_runs, self._last = 0, error
        self._smallest = min(self._smallest, error)
        if self.stagnant_runs < MAX_STAGNANT_RUNS:
            return None
        return AccuracyError(self._accuracy, self._smallest, MAX_STAGNANT_RUNS)
