"""Detect stagnation of the errors of successive runs with shorter steps."""

from __future__ import annotations

import math

from ancfsparse.errors import AccuracyError

MIN_DECREASE = 0.7  # error over the smallest before, above which a run brings no progress
MAX_STAGNANT_RUNS = 4  # such runs in a row


class StagnationCheck:
    """Estimated errors of the runs of one candidate.

    A chaotic motion amplifies rounding: the errors of its runs have no trend.  So each is compared
    with the smallest before it, not with the last.

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
        self._accuracy, self._smallest, self.stagnant_runs = accuracy, math.inf, 0

    def add(self, error: float, is_stagnant: bool = False) -> AccuracyError | None:
        """Add the error of a run; return an error after too many runs without progress.

        Parameters
        ----------
        error : float
            Estimated error [m].
        is_stagnant : bool, optional
            Whether the run shows otherwise that there is no progress.
        """
        is_stagnant = is_stagnant or error > MIN_DECREASE * self._smallest
        self.stagnant_runs = self.stagnant_runs + 1 if is_stagnant else 0
        self._smallest = min(self._smallest, error)
        if self.stagnant_runs < MAX_STAGNANT_RUNS:
            return None
        return AccuracyError(self._accuracy, self._smallest, MAX_STAGNANT_RUNS)
