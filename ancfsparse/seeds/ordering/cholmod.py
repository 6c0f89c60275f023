"""The only file that uses scikit-sparse, which is optional: supernodal factors."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ancfsparse.array_types import Indices
from ancfsparse.seeds.ordering.openmp import short_spin_waits

try:
    with short_spin_waits():  # SuiteSparse brings OpenMP with it
        from sksparse.cholmod import CholmodNotPositiveDefiniteError, analyze
except ImportError:  # the extra `cholmod` is not installed
    analyze = None


def supernodal(
    indptr: Indices, indices: Indices, permutation: NDArray[np.int32]
) -> Supernodal | None:
    """Return CHOLMOD's supernodal factor of a pattern in an order, or None without scikit-sparse.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns, diagonal included.
    permutation : (n,) int32
        Unknown eliminated at each position.
    """
    return None if analyze is None else Supernodal(indptr, indices, permutation)


class Supernodal:
    """CHOLMOD's supernodal L L^T of a positive definite matrix: dense blocks, by the BLAS.

    Parameters
    ----------
    indptr, indices, permutation
        As for `supernodal`.
    """

    def __init__(self, indptr: Indices, indices: Indices, permutation: NDArray[np.int32]) -> None:
        n, n_values = len(permutation), len(indices)
        self._permutation = permutation
        position = np.empty(n, dtype=np.int32)
        position[permutation] = np.arange(n, dtype=np.int32)
        row, column = position[indices], np.repeat(position, np.diff(indptr))
        lower = np.maximum(row, column), np.minimum(row, column)
        self._matrix = sp.csc_matrix((np.arange(n_values, dtype=float), lower), shape=(n, n))
        self._value = self._matrix.data.astype(np.int64)
        self._factor = analyze(self._matrix, mode="supernodal", ordering_method="natural")

    def factor(self, values: NDArray[np.float64]) -> int:
        """Factor again; return 0, or 1 + the first column with a pivot that is not positive."""
        self._matrix.data[:] = values[self._value]
        try:
            self._factor.cholesky_inplace(self._matrix)
        except CholmodNotPositiveDefiniteError as indefinite:
            return 1 + int(indefinite.column)
        return 0

    def solve(self, r: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the solution ``(n,)`` for the right-hand side ``r (n,)``."""
        x = np.empty(len(r))
        x[self._permutation] = self._factor.solve_A(r[self._permutation])
        return x
