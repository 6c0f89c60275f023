"""Sparse seeds: a factor L D L^T of the iteration matrix, renewed on a fixed pattern."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled
from ancfsparse.seeds.cholmod import order

Indices = NDArray[np.integer[Any]]
Upper = tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.int32]]

# Entries of L beside those of the matrix from which another ordering is worth a try.
HEAVY_FILL = 3.0


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

    Attributes
    ----------
    ordering : str
        ``"natural"``, ``"amd"`` or ``"metis"``: what was found cheapest to factor.
    """

    def __init__(self, indptr: Indices, indices: Indices, n_positive: int) -> None:
        self.n = len(indptr) - 1
        self.ordering, permutation, upper = _cheapest(indptr, indices)
        sign = np.where(permutation < n_positive, 1, -1).astype(np.int8)
        self._ldl = compiled("ldl").Ldl(permutation, *upper, sign)

    @property
    def capsule(self) -> object:
        """The structure ``ancf_seed`` for compiled callers."""
        return self._ldl.capsule

    @property
    def nnz(self) -> int:
        """Entries of L below the diagonal."""
        return int(self._ldl.column_length.sum())

    @property
    def factor_flops(self) -> int:
        """Operations of one factorisation: the squares of the column lengths of L."""
        lengths = self._ldl.column_length
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

    def columns(self) -> tuple[NDArray[Any], ...]:
        """Return column starts, rows and values of L, the pivots and the permutation, as copies."""
        arrays: tuple[NDArray[Any], ...] = self._ldl.columns()
        return arrays


def _cheapest(indptr: Indices, indices: Indices) -> tuple[str, NDArray[np.int32], Upper]:
    """Return the name of an ordering, the permutation, and the permuted upper triangle.

    The natural order is kept where nothing fills in.  Minimum degree (AMD) is best for chains and
    trees; where it fills in heavily, as on nets, nested dissection (METIS) is tried too.
    """
    n = len(indptr) - 1
    permutation = np.arange(n, dtype=np.int32)
    upper = _upper(indptr, indices, permutation)
    if _lengths(upper).sum() <= len(indices) - n:
        return "natural", permutation, upper
    best, cost = ("natural", permutation, upper), np.inf
    for method in ("amd", "metis"):
        permutation = order(indptr, indices, method)
        upper = _upper(indptr, indices, permutation)
        lengths = _lengths(upper)
        flops = float(np.sum(lengths.astype(float) ** 2))
        if flops < cost:
            best, cost = (method, permutation, upper), flops
        if lengths.sum() < HEAVY_FILL * len(indices):
            break
    return best


def _lengths(upper: Upper) -> NDArray[np.int64]:
    """Lengths of the columns of L below the diagonal."""
    _, lengths = compiled("ldl").elimination_tree(*upper[:2])
    return np.asarray(lengths)


def _upper(indptr: Indices, indices: Indices, permutation: NDArray[np.int32]) -> Upper:
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
