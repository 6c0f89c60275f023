"""Whether the errors of successive runs, each with shorter steps, still decrease."""

from __future__ import annotations

import math

from ancfsparse.errors import AccuracyError

# An error that decreases by less than this, in so many runs, is not one of the steps.
STUCK, MOST_STUCK = 0.7, 4


class StagnationCheck:
    """Estimated errors of the runs of one way to an accuracy.

    A chaotic motion amplifies rounding: the errors of its runs go up and down without a trend.  So
    each is compared with the smallest before it, not with the last.

    Parameters
    ----------
    accuracy : float
        Requested [m].

    Attributes
    ----------
    stuck : int
        Runs in a row without progress.
    """

    def __init__(self, accuracy: float) -> None:
        self._accuracy, self._smallest, self.stuck = accuracy, math.inf, 0

    def add(self, error: float, still: bool = False) -> AccuracyError | None:
        """Add the error of a run; return a failure after too many runs without progress.

        Parameters
        ----------
        error : float
            Estimated [m].
        still : bool, optional
            Whether the run shows otherwise that there is no progress.
        """
        self.stuck = self.stuck + 1 if still or error > STUCK * self._smallest else 0
        self._smallest = min(self._smallest, error)
        if self.stuck < MOST_STUCK:
            return None
        return AccuracyError(self._accuracy, self._smallest, MOST_STUCK)
