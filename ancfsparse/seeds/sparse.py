"""Sparse seeds: a factor L D L^T of the iteration matrix, renewed on a fixed pattern."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.kernels.dispatch import compiled
from ancfsparse.seeds.cholmod import order

Indices = NDArray[np.integer[Any]]


class SparseSeed:
    """Inverse of a symmetric quasi-definite matrix through its sparse factor.

    CHOLMOD orders the unknowns once, unless their own order causes no fill, as along a chain; every
    factorisation and every solve runs compiled, without Python and without allocation.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns, diagonal included.
    n_positive : int
        The first ``n_positive`` unknowns must have positive pivots (coordinates), the others
        negative ones (multipliers).
    ordering : {"amd", "metis", "nesdis", "best"}, optional
        What CHOLMOD should use.
    """

    def __init__(
        self, indptr: Indices, indices: Indices, n_positive: int, ordering: str = "amd"
    ) -> None:
        n = self.n = len(indptr) - 1
        permutation = np.arange(n, dtype=np.int32)
        upper = _upper(indptr, indices, permutation)
        _, column_start = compiled("ldl").elimination_tree(*upper[:2])
        if column_start[-1] > len(indices) - n:
            permutation = order(indptr, indices, ordering)
            upper = _upper(indptr, indices, permutation)
        sign = np.where(permutation < n_positive, 1, -1).astype(np.int8)
        self._ldl = compiled("ldl").Ldl(permutation, *upper, sign)

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
        """Factor anew; return 0, or 1 + the first unknown whose pivot has the wrong sign.

        Parameters
        ----------
        values : (n_values,) float
            Entries of the matrix on the pattern.
        """
        return int(self._ldl.factor(values))

    def solve(self, r: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the solution ``(n,)`` for the right-hand side ``r (n,)``."""
        return np.asarray(self._ldl.solve(r))

    def arrays(self) -> tuple[NDArray[Any], ...]:
        """Return column starts, rows and values of L, the pivots and the permutation, as copies."""
        arrays: tuple[NDArray[Any], ...] = self._ldl.arrays()
        return arrays


def _upper(
    indptr: Indices, indices: Indices, permutation: NDArray[np.int32]
) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.int32]]:
    """Return the upper triangle of the permuted matrix by columns: starts, rows, slots."""
    n = len(permutation)
    place = np.empty(n, dtype=np.int32)
    place[permutation] = np.arange(n, dtype=np.int32)
    i, j = place[indices], place[np.repeat(np.arange(n, dtype=np.int32), np.diff(indptr))]
    row, column = np.minimum(i, j), np.maximum(i, j)
    slots = np.argsort(column, kind="stable").astype(np.int32)
    start = np.zeros(n + 1, dtype=np.int64)
    np.cumsum(np.bincount(column, minlength=n), out=start[1:])
    return start, row[slots], slots
