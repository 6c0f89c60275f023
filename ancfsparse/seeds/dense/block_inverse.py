"""Dense inverse of a small matrix by uncoupled blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Indices
from ancfsparse.dispatch import compiled_module

if TYPE_CHECKING:
    from ancfsparse.seeds.interface.protocols import CompiledSeed


class BlockInverse:
    """Inverse of a constant symmetric positive definite matrix.

    A mass matrix couples the x components of a beam with one another, not with the y components:
    its inverse has one dense block for each.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns.
    values : (n_values,) float
        Entries; zeros do not couple.

    Attributes
    ----------
    n : int
        Number of unknowns.
    solve_flops : int
        Operations of one product.
    error : None
        Errors in calls from compiled code: there are none.
    """

    error: BaseException | None = None

    def __init__(self, indptr: Indices, indices: Indices, values: NDArray[np.float64]) -> None:
        import scipy.sparse as sp
        from scipy.sparse.csgraph import connected_components

        self.n = len(indptr) - 1
        lower = sp.csc_array((values, indices, indptr), shape=(self.n, self.n))
        self._matrix = (lower + sp.tril(lower, -1).T).tocsr()
        self._matrix.eliminate_zeros()
        count, label = connected_components(self._matrix, directed=False)
        order = np.argsort(label, kind="stable")
        self._members = np.split(order, np.cumsum(np.bincount(label, minlength=count))[:-1])
        self.solve_flops = 2 * sum(len(block) ** 2 for block in self._members)
        self._blocks: CompiledSeed | None = None

    @property
    def capsule(self) -> object:
        """The structure ``ancf_seed`` for compiled callers; its ``factor`` is null."""
        return self._invert().capsule

    def solve(self, r: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the solution ``(n,)`` for the right-hand side ``r (n,)``."""
        return self._invert().solve(r)

    def _invert(self) -> CompiledSeed:
        """Invert on first use, since operation counts alone may be needed."""
        if self._blocks is None:
            dense = [self._matrix[np.ix_(block, block)].toarray() for block in self._members]
            inverses = [np.linalg.inv(a) for a in dense]
            blocks: CompiledSeed = compiled_module("blocks").Blocks(self._members, inverses)
            self._blocks = blocks
        return self._blocks
