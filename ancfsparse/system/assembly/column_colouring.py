"""Columns of a sparse matrix that may be found together, since they have no row in common."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import scipy.sparse as sp


def colour_columns(entries: sp.csc_array) -> NDArray[np.int64]:
    """Give columns the same number only if they have no row in common; empty ones -1."""
    n = entries.shape[1]
    starts, rows = entries.indptr, entries.indices
    group = np.full(n, -1)
    columns_of = entries.tocsr()
    for column in np.flatnonzero(np.diff(starts)):
        taken = set()
        for row in rows[starts[column] : starts[column + 1]]:
            first, last = columns_of.indptr[row : row + 2]
            taken.update(group[columns_of.indices[first:last]].tolist())
        group[column] = next(k for k in range(len(taken) + 1) if k not in taken)
    return group
