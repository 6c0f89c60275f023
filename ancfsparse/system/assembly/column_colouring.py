"""Colouring of the columns of a sparse matrix (Curtis, Powell and Reid, 1974)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import scipy.sparse as sp


def colour_columns(entries: sp.csc_array) -> NDArray[np.int64]:
    """Return a colour for each column, equal only without common rows; -1 for empty columns."""
    n = entries.shape[1]
    starts, rows = entries.indptr, entries.indices
    group = np.full(n, -1)
    columns_of = entries.tocsr()
    for column in np.flatnonzero(np.diff(starts)):
        used = set()
        for row in rows[starts[column] : starts[column + 1]]:
            first, last = columns_of.indptr[row : row + 2]
            used.update(group[columns_of.indices[first:last]].tolist())
        group[column] = next(k for k in range(len(used) + 1) if k not in used)
    return group
