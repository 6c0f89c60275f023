"""Sparse seeds: a factor L D L^T of the iteration matrix, renewed on a fixed pattern."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled_module
from ancfsparse.seeds import ordering
from ancfsparse.seeds.complete.supernodes import parts_of, shape_of
from ancfsparse.seeds.interface.index_arrays import Indices, Triangle
from ancfsparse.seeds.ordering.elimination_order import cheapest, permuted

if TYPE_CHECKING:
    from ancfsparse.seeds.interface.protocols import CompleteFactor, PythonSeed
    from ancfsparse.seeds.ordering.cholmod import Supernodal

# Operations for each entry of L from which CHOLMOD's dense blocks factor faster than our loops, on
# one thread: a tenth slower for square nets of 200 cables a side (665), as fast for 250 (791), a
# quarter faster for cubes of 40^3 unknowns (1129).  Its solves take 1.6 to 2.3 times as long.
DENSE_BLOCKS = 1000.0
# Bytes of a factor from which solves in single precision are faster: a tenth for a net of 30 a
# side, nothing yet for a chain of 20 000 planar elements, a fifth from 100 000 on, past the caches.
# With multipliers a third for that chain on a pin by equations, .53 to .64 of the time for nets of
# 40 to 120 a side from which a body hangs.
SINGLE_FROM = 4e6
# Bytes that an entry of L takes: in our own factor, and in CHOLMOD's, which pads its blocks, copies
# the matrix and has room to work: 15 to 12 on cubes of 14 to 24 cells a side.
OWN_ENTRY, BLOCK_ENTRY = 8.7, 13.0


class SparseSeed:
    """Inverse of a symmetric quasi-definite matrix through its sparse factor.

    CHOLMOD orders the coordinates once, unless their own order causes no fill, as along a chain;
    a multiplier follows what it holds. Where the factor is sparse, every factorisation and every
    solve runs in our own compiled loops, without Python and without allocation, those of a large
    matrix in single precision if the caller likes. Where it fills in so much that dense
    blocks pay, as on large nets, CHOLMOD's supernodal factor takes over; if that meets an
    indefinite matrix, our own steps in.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns, diagonal included.
    n_positive : int
        The first ``n_positive`` unknowns must have positive pivots (coordinates), the others
        negative ones (multipliers).
    threads : int, optional
        Most threads for our own factor; see `parts_of`.

    Attributes
    ----------
    n, n_positive : int
        Number of unknowns, and of those that must have positive pivots.
    ordering : str
        ``"natural"``, ``"both ends"``, ``"amd"`` or ``"metis"``: what fills in least.
    supernodal : bool
        Whether CHOLMOD factors.
    nnz, factor_flops : int
        Entries of L below the diagonal; operations of one factorisation, from the squares of the
        lengths of its columns.
    threads : int
        How many take part in our own factor.
    shape : Shape
        Supernodes of L and their parts.
    nbytes : float
        Estimated memory of the factor, which is taken when it is first asked for [bytes].
    """

    def __init__(
        self, indptr: Indices, indices: Indices, n_positive: int, threads: int = 1
    ) -> None:
        self.n = len(indptr) - 1
        self._pattern = np.asarray(indptr, dtype=np.int64), np.asarray(indices, dtype=np.int32)
        self.n_positive = n_positive
        self.ordering, permutation, upper = cheapest(*self._pattern, n_positive)
        shape = shape_of(upper)
        owner = None
        while threads > 1 and owner is None:  # fewer parts than threads if need be
            owner = parts_of(shape, threads)
            threads -= 0 if owner is not None else (threads + 1) // 2
        if owner is not None:
            of_column = owner[shape.super_of]
            permutation = permutation[np.argsort(of_column, kind="stable")]
            upper = permuted(*self._pattern, permutation)
            shape = shape_of(upper, np.bincount(of_column, minlength=threads + 1))
        self.nnz, self.factor_flops, self.threads = shape.nnz, shape.flops, shape.n_parts
        self._permutation, self.shape = permutation, shape
        self._own: CompleteFactor | None = None
        self._upper: Triangle | None = None
        self._fallen_back = False
        self.supernodal = n_positive == self.n and self.factor_flops > DENSE_BLOCKS * self.nnz
        self._cholmod: Supernodal | None = None
        self._callback: PythonSeed | None = None
        if self.supernodal:
            self._cholmod = ordering.Supernodal(indptr, indices, self.ordering)
            self._callback = compiled_module("callback").Callback(self, self.n, len(indices))
        else:
            self._upper = upper  # until the factor is made
        self.nbytes = (BLOCK_ENTRY if self.supernodal else OWN_ENTRY) * (self.nnz + self.n)

    def _make_own(self) -> CompleteFactor:
        upper, self._upper = self._upper, None
        if upper is None:
            upper = permuted(*self._pattern, self._permutation)
        made: CompleteFactor = compiled_module("ldl").Ldl(
            *self._pattern,
            self._permutation,
            self.n_positive,
            self.shape,
            self.shape.rows(upper),
            may_round=8.0 * (self.nnz + self.n) >= SINGLE_FROM,
        )
        return made

    @property
    def own(self) -> CompleteFactor:
        """Our own compiled factor."""
        if self._own is None:
            self._own = self._make_own()
        return self._own

    @property
    def capsule(self) -> object:
        """The structure ``ancf_seed`` for compiled callers."""
        return (self._callback or self.own).capsule

    @property
    def error(self) -> BaseException | None:
        """What went wrong in CHOLMOD while compiled code was running, if anything."""
        return None if self._callback is None else self._callback.error

    @property
    def inner(self) -> tuple[int, int]:
        """Sweeps and products in solutions that are more than a sweep each: none."""
        return 0, 0

    @property
    def solve_flops(self) -> int:
        """Operations of one solve."""
        return 4 * self.nnz + 2 * self.n

    @property
    def negative_pivots(self) -> int | None:
        """Number of negative pivots, and so of negative eigenvalues, of the last matrix.

        None if a pivot was zero or no number, and there is no factor.
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
        """Pivots of our own factor of the last matrix, in the order of the unknowns, (n,)."""
        return self.own.pivots

    def columns(self) -> tuple[NDArray[Any], ...]:
        """Return starts, rows and values of our own L by columns, its pivots, the permutation."""
        return self.own.columns()


def fill_of(indptr: Indices, indices: Indices) -> int:
    """Return the number of entries below the diagonal that a factor would have.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle of the matrix by columns, diagonal included.
    """
    return shape_of(cheapest(indptr, indices, len(indptr) - 1)[2]).nnz
