"""The only file that uses scikit-sparse: fill-reducing orderings and supernodal factors."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ancfsparse.array_types import Indices
from ancfsparse.openmp import short_spin_waits

with short_spin_waits():  # SuiteSparse brings OpenMP with it
    from sksparse.cholmod import CholmodNotPositiveDefiniteError, analyze


def order(indptr: Indices, indices: Indices, method: str) -> NDArray[np.int32]:
    """Return CHOLMOD's order of elimination.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns, diagonal included.
    method : {"amd", "metis"}
        Approximate minimum degree, or nested dissection.

    Returns
    -------
    (n,) int32
        Unknown eliminated at each position.
    """
    factor = analyze(_matrix(indptr, indices), mode="simplicial", ordering_method=method)
    return np.ascontiguousarray(factor.P(), dtype=np.int32)


class Supernodal:
    """CHOLMOD's supernodal L L^T of a positive definite matrix: dense blocks, by the BLAS.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns, diagonal included.
    method : {"amd", "metis"}
        Ordering.
    """

    def __init__(self, indptr: Indices, indices: Indices, method: str) -> None:
        self._matrix = _matrix(indptr, indices)
        self._factor = analyze(self._matrix, mode="supernodal", ordering_method=method)

    def factor(self, values: NDArray[np.float64]) -> int:
        """Factor again; return 0, or 1 + the first column with a pivot that is not positive."""
        self._matrix.data[:] = values
        try:
            self._factor.cholesky_inplace(self._matrix)
        except CholmodNotPositiveDefiniteError as indefinite:
            return 1 + int(indefinite.column)
        return 0

    def solve(self, r: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the solution ``(n,)`` for the right-hand side ``r (n,)``."""
        return np.asarray(self._factor.solve_A(r))


def _matrix(indptr: Indices, indices: Indices) -> sp.csc_matrix:
    n = len(indptr) - 1
    return sp.csc_matrix((np.ones(len(indices)), indices, indptr), shape=(n, n))
