"""Points on deformed elements."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.kernels.hermite import position_weights, slope_weights
from ancfsparse.results.data.selected_columns import Readable, SelectedColumns
from ancfsparse.results.geometry.scene_outline import BodyAxis
from ancfsparse.system_memory import check_memory

MAX_PIECES = 12  # straight pieces of an element
TOTAL_PIECES = 2400  # straight pieces of all elements


def read_rows(q: Readable, rows: NDArray[np.intp]) -> Vector:
    """Read some rows of a table of states, with all stored columns."""
    if isinstance(q, SelectedColumns):  # is read like an array
        return cast(Vector, SelectedColumns(np.asarray(q.values[rows]), q.places, q.n))
    return np.asarray(q[rows])


def spread_rows(t: Vector, count: int) -> NDArray[np.intp]:
    """Return rows of at most `count` states at nearly equal distances in time [s]."""
    if len(t) <= count:
        return np.arange(len(t))
    times = np.linspace(t[0], t[-1], count)
    after = np.clip(np.searchsorted(t, times), 1, len(t) - 1)
    nearest = np.where(times - t[after - 1] < t[after] - times, after - 1, after)
    return np.unique(nearest)


def trace_elements(q: Vector, part: BodyAxis, pieces: int) -> Vector:
    """Return points on every element of a body.

    Parameters
    ----------
    q : table, shape (j, n)
        Coordinates.
    part : Part
        The body.
    pieces : int
        Pieces per element.

    Returns
    -------
    ndarray, shape (j, n_elements, pieces + 1, dim)
        Points [m], from the first end of each element: the cubic through positions and slopes at
        both ends; for strings a straight line.
    """
    return _trace(q, part, pieces, position_weights)


def trace_slopes(q: Vector, part: BodyAxis, pieces: int) -> Vector:
    """Return the slopes at the points of `trace_elements`, in the same shape [-]."""
    return _trace(q, part, pieces, slope_weights)


def count_pieces(parts: list[BodyAxis]) -> int:
    """Return the number of pieces per element for a smooth plot that is drawn quickly."""
    count = sum(len(part.lengths) for part in parts)
    return int(np.clip(TOTAL_PIECES // max(count, 1), 1, MAX_PIECES))


def _trace(
    q: Vector, part: BodyAxis, pieces: int, weigh: Callable[[Vector, Vector, bool], Vector]
) -> Vector:
    n_elements, n_vectors, dim = part.places.shape
    numbers = float(q.shape[0]) * n_elements * (pieces + 1) * dim
    check_memory("a plot of these points", 8.0 * numbers, "a smaller per_element")
    weights = weigh(np.linspace(0.0, 1.0, pieces + 1), part.lengths[:, None], n_vectors == 2)
    return np.asarray(np.einsum("epc,jecd->jepd", weights, np.asarray(q[..., part.places])))
