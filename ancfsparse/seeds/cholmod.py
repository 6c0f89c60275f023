"""The only file that knows scikit-sparse: ordering, symbolic analysis, reference factor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from sksparse.cholmod import analyze


@dataclass(frozen=True)
class Analysis:
    """What CHOLMOD found out about a pattern.

    Attributes
    ----------
    permutation : (n,) int32
        Unknown eliminated in each place.
    column_start : (n + 1,) int64
        Column starts of L, strictly below the diagonal.
    parent : (n,) int32
        Elimination tree, -1 at a root.
    lower : sparse matrix (n, n)
        L with unit diagonal, of the matrix that was given.
    pivots : (n,) float
        The diagonal of D.
    """

    permutation: NDArray[np.int32]
    column_start: NDArray[np.int64]
    parent: NDArray[np.int32]
    lower: sp.csc_matrix
    pivots: NDArray[np.float64]


def analyze_and_factor(lower_triangle: sp.csc_matrix, ordering: str = "amd") -> Analysis:
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
    lower = lower.tocsc()
    lower.sort_indices()
    n = lower.shape[0]
    # Each column holds its diagonal first; the next entry is the parent in the elimination tree.
    start = lower.indptr.astype(np.int64)
    has_parent = np.diff(start) > 1
    parent = np.full(n, -1, dtype=np.int32)
    parent[has_parent] = lower.indices[start[:-1][has_parent] + 1]
    return Analysis(
        permutation=np.ascontiguousarray(factor.P(), dtype=np.int32),
        column_start=start - np.arange(n + 1),
        parent=parent,
        lower=lower,
        pivots=diagonal.diagonal(),
    )
