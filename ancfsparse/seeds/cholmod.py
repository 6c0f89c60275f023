"""The only file that knows scikit-sparse: fill-reducing orderings."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from sksparse.cholmod import analyze


def order(
    indptr: NDArray[np.integer[Any]], indices: NDArray[np.integer[Any]], method: str
) -> NDArray[np.int32]:
    """Let CHOLMOD choose the order of elimination.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns, diagonal included.
    method : {"amd", "metis"}
        Approximate minimum degree, or nested dissection.

    Returns
    -------
    (n,) int32
        Unknown eliminated in each place.
    """
    n = len(indptr) - 1
    pattern = sp.csc_matrix((np.ones(len(indices)), indices, indptr), shape=(n, n))
    factor = analyze(pattern, mode="simplicial", ordering_method=method)
    return np.ascontiguousarray(factor.P(), dtype=np.int32)
