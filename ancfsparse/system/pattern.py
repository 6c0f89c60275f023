"""The sparsity pattern of the saddle point matrix, made once, and the maps that write into it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Places = NDArray[np.integer[Any]]


@dataclass(frozen=True)
class Pattern:
    """Lower triangle by columns of the matrix over (free coordinates, multipliers).

    Attributes
    ----------
    indptr, indices : int64 and int32 arrays
        Columns; rows are sorted within each.
    n_free : int
        Coordinates; the unknowns after them are multipliers.
    """

    indptr: NDArray[np.int64]
    indices: NDArray[np.int32]
    n_free: int

    @property
    def n(self) -> int:
        """Number of unknowns."""
        return len(self.indptr) - 1

    @property
    def n_values(self) -> int:
        """Number of stored entries; this is also the slot for what must be thrown away."""
        return len(self.indices)

    def slots(self, i: Places, j: Places) -> NDArray[np.int32]:
        """Return where entries (i, j) are stored; anything at a fixed coordinate goes to the bin.

        Parameters
        ----------
        i, j : integer arrays of one shape
            Places of unknowns, in either order; out of range means fixed.
        """
        low, high = np.minimum(i, j).astype(np.int64), np.maximum(i, j).astype(np.int64)
        keys = low * self.n + high
        inside = (low >= 0) & (high < self.n)
        own = np.repeat(np.arange(self.n), np.diff(self.indptr)) * self.n + self.indices
        slots = np.searchsorted(own, np.where(inside, keys, 0))
        return np.where(inside, slots, self.n_values).astype(np.int32)


def build(n_free: int, n_multipliers: int, pairs: list[tuple[Places, Places]]) -> Pattern:
    """Collect the pattern from all pairs of unknowns that meet somewhere.

    The diagonal is always part of it.  Pairs with a fixed coordinate (any number from
    ``n_free + n_multipliers`` on, or negative) are left out.

    Parameters
    ----------
    n_free, n_multipliers : int
        Unknowns.
    pairs : list of (i, j)
        Integer arrays of equal shape.
    """
    n = n_free + n_multipliers
    keys = [np.arange(n, dtype=np.int64) * (n + 1)]
    for i, j in pairs:
        low, high = np.minimum(i, j).ravel(), np.maximum(i, j).ravel()
        inside = (low >= 0) & (high < n)
        keys.append(np.unique(low[inside].astype(np.int64) * n + high[inside]))
    every = np.unique(np.concatenate(keys))
    column, row = np.divmod(every, n)
    indptr = np.searchsorted(column, np.arange(n + 1)).astype(np.int64)
    return Pattern(indptr, row.astype(np.int32), n_free)


def element_pairs(places: Places) -> tuple[Places, Places]:
    """Return rows and columns, (n_e, n (n + 1) / 2), of each element's lower triangle by rows."""
    i, j = np.tril_indices(places.shape[1])
    return places[:, i], places[:, j]
