"""Sparse seeds: a factor L D L^T of the iteration matrix, renewed on a fixed pattern."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ancfsparse.kernels.dispatch import compiled
from ancfsparse.seeds.cholmod import factorize


class SparseSeed:
    """Inverse of a symmetric quasi-definite matrix through its sparse factor.

    CHOLMOD orders the pattern and makes the first factor; every later factorisation and every solve
    runs compiled, without Python and without allocation.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns, diagonal included.
    values : (nnz,) float
        A first matrix on this pattern: the one that CHOLMOD factors.
    n_positive : int
        The first ``n_positive`` unknowns must have positive pivots (coordinates), the others
        negative ones (multipliers).
    """

    def __init__(
        self,
        indptr: NDArray[np.integer[Any]],
        indices: NDArray[np.integer[Any]],
        values: NDArray[np.float64],
        n_positive: int,
        ordering: str = "amd",
    ) -> None:
        n = len(indptr) - 1
        first = sp.csc_matrix((values, indices, indptr), shape=(n, n))
        self.first = factorize(first, ordering)
        place = np.empty(n, dtype=np.int64)
        place[self.first.permutation] = np.arange(n)
        column = np.repeat(np.arange(n), np.diff(indptr))
        i, j = place[indices], place[column]
        row, col = np.minimum(i, j), np.maximum(i, j)
        order = np.lexsort((row, col))
        sign = np.where(self.first.permutation < n_positive, 1, -1)
        self.n = n
        self._ldl = compiled("ldl").Ldl(
            self.first.permutation,
            np.searchsorted(col[order], np.arange(n + 1)).astype(np.int64),
            row[order].astype(np.int32),
            order.astype(np.int32),
            sign.astype(np.int8),
        )

    @property
    def capsule(self) -> object:
        """The structure ``ancf_seed`` for compiled callers."""
        return self._ldl.capsule

    @property
    def nnz(self) -> int:
        """Entries of L below the diagonal."""
        return int(self._ldl.nnz)

    @property
    def factor_flops(self) -> int:
        """Operations of one factorisation: the squares of the column lengths of L."""
        lengths = np.diff(self._ldl.column_start)
        return int(np.sum(lengths * (lengths + 3)))

    @property
    def solve_flops(self) -> int:
        """Operations of one solve."""
        return 4 * self.nnz + 2 * self.n

    def factor(self, values: NDArray[np.float64]) -> int:
        """Factor anew; return 0, or 1 + the first unknown whose pivot has the wrong sign."""
        return int(self._ldl.factor(values))

    def solve(self, r: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the solution ``(n,)`` for the right-hand side ``r (n,)``."""
        return np.asarray(self._ldl.solve(r))
