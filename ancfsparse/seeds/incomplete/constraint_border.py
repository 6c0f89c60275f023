"""Constraint equations as a border of an incomplete factor: entries in the matrix, and cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Integers

LongIndices = NDArray[np.int64]


@dataclass(frozen=True)
class Border:
    """Equations B x - E l = g of a matrix, for ``ic_border.h``.

    Attributes
    ----------
    n : int
        Number of equations.
    first : (n + 1,) int32
        Term of each equation, and the end.
    entry : (n_terms,) int64
        Entry of the matrix of each term.
    unknown, place : (n_terms,) int32
        Its coordinate, and the index of that in vectors over triples, four numbers each.
    own : (n_own,) int64
        Entries of the lower triangle of -E in the matrix.
    own_place : (n_own,) int32
        Their indices in E by rows.
    """

    n: int
    first: Integers
    entry: LongIndices
    unknown: Integers
    place: Integers
    own: LongIndices
    own_place: Integers

    @property
    def nbytes(self) -> float:
        """Memory of the arrays in the compiled code [bytes]."""
        return 24.0 * len(self.entry) + 8.0 * self.n**2

    @classmethod
    def from_matrix(
        cls, indptr: LongIndices, indices: Integers, n: int, unknown: NDArray[np.integer[Any]]
    ) -> Border:
        """Return the equations of a matrix with n coordinates as its first unknowns.

        Parameters
        ----------
        indptr, indices : integer arrays
            Its lower triangle by columns.
        n : int
            Number of coordinates.
        unknown : (n_triples, 3) int32
            Coordinates of each triple in order of elimination; -1 for none.
        """
        m = len(indptr) - 1 - n
        entry = np.flatnonzero(indices[: indptr[n]] >= n)
        entry = entry[np.argsort(indices[entry], kind="stable")]
        column = np.searchsorted(indptr, entry, side="right") - 1
        first = np.searchsorted(indices[entry], n + np.arange(m + 1))
        triple, lane = np.nonzero(unknown >= 0)
        place = np.empty(n, dtype=np.int32)
        place[unknown[triple, lane]] = 4 * triple + lane
        own = np.arange(indptr[n], len(indices))
        own_column = np.repeat(np.arange(m), np.diff(indptr[n:]))
        own_place = (indices[own] - n) * m + own_column
        return cls(
            m,
            first.astype(np.int32),
            entry.astype(np.int64),
            column.astype(np.int32),
            place[column],
            own.astype(np.int64),
            own_place.astype(np.int32),
        )
