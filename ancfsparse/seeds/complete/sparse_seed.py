"""Sparse seeds: complete factorizations L D L^T of the iteration matrix on a fixed pattern."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Indices
from ancfsparse.dispatch import compiled_module
from ancfsparse.seeds import ordering
from ancfsparse.seeds.complete.supernodes import divide_among_threads, find_supernodes
from ancfsparse.seeds.interface.index_arrays import Triangle
from ancfsparse.seeds.ordering.elimination_order import (
    cheapest,
    order_briefly,
    permute_upper,
)

if TYPE_CHECKING:
    from ancfsparse.seeds.interface.protocols import CompleteFactor, PythonSeed
    from ancfsparse.seeds.ordering.cholmod import Supernodal

# CHOLMOD's dense blocks, on one thread, factor a tenth slower than our loops for square nets of 200
# cables a side (665 operations per entry), as fast for 250 (791), a quarter faster for cubes of
# 40^3 unknowns (1129).  Its solves take 1.6 to 2.3 times as long.
MIN_SUPERNODAL_FLOPS = 1000.0  # per entry of L, for CHOLMOD
# Solves in single precision are faster for large factors: by a tenth for a net of 30 a side, not
# for a chain of 20 000 planar elements, by a fifth from 100 000 elements on, beyond the caches.
# With multipliers by a third for that chain on a pin by equations, and .53 to .64 of the time for
# nets of 40 to 120 a side that carry a body.
MIN_SINGLE_BYTES = 4e6  # of a factor
LDL_ENTRY_BYTES = 8.7  # of an entry of L in our factor
# CHOLMOD pads blocks, copies the matrix and has workspace: 15 to 12 for cubes of 14 to 24 cells.
CHOLMOD_ENTRY_BYTES = 13.0  # of an entry of L


class SparseSeed:
    """Inverse of a symmetric quasi-definite matrix through its sparse factor.

    METIS or AMD orders the coordinates once, unless their own order causes no fill-in, as along a
    chain; a multiplier follows the coordinates of its constraint.  A sparse factor is computed and
    applied by our compiled loops, without Python and without allocation, for a large matrix in
    single precision on request.  Where fill-in makes dense blocks faster, as in large
    lattices, CHOLMOD's supernodal factor is used where scikit-sparse is installed; for an
    indefinite matrix, our own replaces it.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns, diagonal included.
    n_positive : int
        The first ``n_positive`` unknowns must have positive pivots (coordinates), the others
        negative ones (multipliers).
    threads : int, optional
        Maximum number of threads for our factor; see `divide_among_threads`.
    briefly : bool, optional
        Whether the order is one of minimum degree, which takes a tenth of the time.

    Attributes
    ----------
    n, n_positive : int
        Number of unknowns, and of those that must have positive pivots.
    ordering : str
        ``"natural"``, ``"both ends"``, ``"amd"`` or ``"metis"``, with the least fill-in.
    supernodal : bool
        Whether CHOLMOD's factor is used.
    nnz, factor_flops : int
        Entries of L below the diagonal; operations of one factorisation, from the squares of the
        lengths of its columns.
    threads : int
        Number of threads of our factor.
    shape : SupernodeTree
        Supernodes of L and their parts.
    nbytes : float
        Estimated memory of the factor, which is allocated on first use [bytes].
    renewals : int
        Number of changes of the pattern.
    memory : int
        Choice in earlier factors that the next ones repeat; 0, since there is none.
    on_renewal : callable
        Called with each seed of another pattern.
    """

    renewals = 0
    memory = 0  # its factors depend on their matrix alone
    on_renewal: Callable[[SparseSeed], None]

    def __init__(
        self,
        indptr: Indices,
        indices: Indices,
        n_positive: int,
        threads: int = 1,
        briefly: bool = False,
    ) -> None:
        self.n = len(indptr) - 1
        self._pattern = np.asarray(indptr, dtype=np.int64), np.asarray(indices, dtype=np.int32)
        self.n_positive = n_positive
        order = order_briefly if briefly else cheapest
        self.ordering, permutation, upper = order(*self._pattern, n_positive)
        shape = find_supernodes(upper)
        owner = None
        while threads > 1 and owner is None:  # fewer parts than threads if necessary
            owner = divide_among_threads(shape, threads)
            threads -= 0 if owner is not None else (threads + 1) // 2
        if owner is not None:
            of_column = owner[shape.super_of]
            permutation = permutation[np.argsort(of_column, kind="stable")]
            upper = permute_upper(*self._pattern, permutation)
            shape = find_supernodes(upper, np.bincount(of_column, minlength=threads + 1))
        self.nnz, self.factor_flops, self.threads = shape.nnz, shape.flops, shape.n_parts
        self._permutation, self.shape = permutation, shape
        self._own: CompleteFactor | None = None
        self._upper: Triangle | None = None
        self._fallen_back = False
        self._cholmod: Supernodal | None = None
        if n_positive == self.n and self.factor_flops > MIN_SUPERNODAL_FLOPS * self.nnz:
            self._cholmod = ordering.supernodal(*self._pattern, permutation)
        self.supernodal = self._cholmod is not None
        self._callback: PythonSeed | None = None
        if self.supernodal:
            self._callback = compiled_module("callback").Callback(self, self.n, len(indices))
        else:
            self._upper = upper  # until the factor is built
        entry_bytes = CHOLMOD_ENTRY_BYTES if self.supernodal else LDL_ENTRY_BYTES
        self.nbytes = entry_bytes * (self.nnz + self.n)

    def _make_own(self) -> CompleteFactor:
        upper, self._upper = self._upper, None
        if upper is None:
            upper = permute_upper(*self._pattern, self._permutation)
        factor: CompleteFactor = compiled_module("ldl").Ldl(
            *self._pattern,
            self._permutation,
            self.n_positive,
            self.shape,
            self.shape.rows(upper),
            may_round=8.0 * (self.nnz + self.n) >= MIN_SINGLE_BYTES,
        )
        return factor

    @property
    def own(self) -> CompleteFactor:
        """Our compiled factor."""
        if self._own is None:
            self._own = self._make_own()
        return self._own

    @property
    def capsule(self) -> object:
        """The structure ``ancf_seed`` for compiled callers."""
        return (self._callback or self.own).capsule

    @property
    def error(self) -> BaseException | None:
        """Error of CHOLMOD in a call from compiled code, if any."""
        return None if self._callback is None else self._callback.error

    @property
    def inner(self) -> tuple[int, int]:
        """Sweeps and products of iterative solutions: none."""
        return 0, 0

    @property
    def solve_flops(self) -> int:
        """Operations of one solve."""
        return 4 * self.nnz + 2 * self.n

    @property
    def negative_pivots(self) -> int | None:
        """Number of negative pivots, and hence of negative eigenvalues, of the last matrix.

        None if a pivot was zero or not a number, so that there is no factor.
        """
        if self._cholmod is not None and not self._fallen_back:
            return 0
        return self.own.negative_pivots

    def factor(self, values: NDArray[np.float64]) -> int:
        """Factor again; return 0, or 1 + the first unknown whose pivot has the wrong sign.

        Parameters
        ----------
        values : (n_values,) float
            Entries of the matrix on the pattern.
        """
        if self._cholmod is not None:
            self._fallen_back = self._cholmod.factor(values) != 0
            if not self._fallen_back:
                return 0
        return self.own.factor(values)

    def solve(self, r: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the solution ``(n,)`` for the right-hand side ``r (n,)``."""
        if self._cholmod is not None and not self._fallen_back:
            return self._cholmod.solve(r)
        return self.own.solve(r)

    @property
    def pivots(self) -> NDArray[np.float64]:
        """Pivots of our factor of the last matrix, in the order of the unknowns, (n,)."""
        return self.own.pivots

    def release(self) -> None:
        """Release the factor, whose seed is not used again; CHOLMOD's would remain in memory."""
        self._own = self._cholmod = self._callback = None

    def columns(self) -> tuple[NDArray[Any], ...]:
        """Return starts, rows and values of our L by columns, its pivots, the permutation."""
        return self.own.columns()


def fill_of(indptr: Indices, indices: Indices) -> int:
    """Return the number of entries below the diagonal of a factor.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle of the matrix by columns, diagonal included.
    """
    return find_supernodes(cheapest(indptr, indices, len(indptr) - 1)[2]).nnz
