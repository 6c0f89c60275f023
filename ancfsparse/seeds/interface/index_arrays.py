"""Index arrays of sparse matrices by columns."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Triangle = tuple[NDArray[np.int64], NDArray[np.int32]]
"""Starts of the columns and rows of the entries, of an upper or a lower triangle."""

# Each equation of an incomplete factor takes a sweep, up to a seventh of a factorization, and their
# dense matrix takes at most 2 MB.
MAX_EQUATIONS = 500


def leading(indptr: NDArray[np.int64], indices: NDArray[np.int32], n: int) -> Triangle:
    """Return the pattern of the first n unknowns: a lower triangle by columns."""
    if n == len(indptr) - 1:
        return indptr, indices
    is_inside = indices[: indptr[n]] < n
    before = np.zeros(len(is_inside) + 1, dtype=np.int64)
    np.cumsum(is_inside, out=before[1:])
    return before[indptr[: n + 1]], indices[: indptr[n]][is_inside]
