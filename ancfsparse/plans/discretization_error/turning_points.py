"""Vibrations that the history of a quantity shows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def swings(values: Array, least: float) -> tuple[NDArray[np.intp], Array]:
    """Return where a quantity has turned after a swing, and how large that was.

    Parameters
    ----------
    values : (k,) float
        Over time, at even distances.
    least : float
        Swings up to this do not count [unit of the quantity].

    Returns
    -------
    rows : (n,) int
        Where they end.
    sizes : (n,) float
        From turn to turn [unit of the quantity].
    """
    turns = np.flatnonzero(np.diff(np.sign(np.diff(values)))) + 1
    sizes = np.abs(np.diff(values[turns]))
    counts = sizes > least
    return turns[1:][counts], sizes[counts]
