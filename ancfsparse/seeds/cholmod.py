"""The only file that knows scikit-sparse: fill-reducing ordering and reference factor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from sksparse.cholmod import analyze


@dataclass(frozen=True)
class Factorization:
    """What CHOLMOD makes of a matrix.

    Attributes
    ----------
    permutation : (n,) int32
        Unknown eliminated in each place.
    lower : sparse matrix (n, n)
        L with unit diagonal.
    pivots : (n,) float
        The diagonal of D.
    """

    permutation: NDArray[np.int32]
    lower: sp.csc_matrix
    pivots: NDArray[np.float64]


def factorize(lower_triangle: sp.csc_matrix, ordering: str = "amd") -> Factorization:
    """Let CHOLMOD order, analyse and factor a quasi-definite matrix once.

    The simplicial mode is asked for because it factors indefinite matrices as L D L^T; it never
    raises, so the signs of the pivots must be looked at.

    Parameters
    ----------
    lower_triangle : sparse matrix (n, n)
        Lower triangle, diagonal included.
    ordering : {"amd", "metis", "nesdis", "natural"}
        Fill-reducing ordering: AMD suits chains and trees, METIS nets.
    """
    factor = analyze(lower_triangle, mode="simplicial", ordering_method=ordering)
    factor.cholesky_inplace(lower_triangle)
    lower, diagonal = factor.L_D()
    return Factorization(
        permutation=np.ascontiguousarray(factor.P(), dtype=np.int32),
        lower=lower.tocsc(),
        pivots=diagonal.diagonal(),
    )
