"""Fill-reducing orders of elimination: minimum degree and nested dissection."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Indices
from ancfsparse.dispatch import common_module

Method = Literal["amd", "metis"]
METHODS: tuple[Method, ...] = ("metis", "amd")


def order(indptr: Indices, indices: Indices, method: Method) -> NDArray[np.int32]:
    """Return an order of elimination, the same in every call.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns, with or without the diagonal.
    method : {"amd", "metis"}
        Approximate minimum degree, or nested dissection.

    Returns
    -------
    (n,) int32
        Unknown eliminated at each position.
    """
    pattern = np.asarray(indptr, dtype=np.int64), np.asarray(indices, dtype=np.int32)
    permutation: NDArray[np.int32] = getattr(common_module("order"), method)(*pattern)
    return permutation
