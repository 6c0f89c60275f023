"""Swings of a quantity between its turning points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector


def find_swings(values: Vector, min_size: float) -> tuple[NDArray[np.intp], Vector]:
    """Return the swings of a quantity between successive turning points.

    Of values (k,) at equidistant times, swings above `min_size` [unit of the quantity].

    Returns
    -------
    rows : (n,) int
        Indices of the turning points at their ends.
    sizes : (n,) float
        Differences between the turning points [unit of the quantity].
    """
    turns = np.flatnonzero(np.diff(np.sign(np.diff(values)))) + 1
    sizes = np.abs(np.diff(values[turns]))
    counts = sizes > min_size
    return turns[1:][counts], sizes[counts]
