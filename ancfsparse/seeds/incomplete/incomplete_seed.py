"""Incomplete seeds: factorizations without fill-in, with a cost linear in the mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Indices
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import InputError
from ancfsparse.seeds.incomplete.constraint_border import Border
from ancfsparse.seeds.incomplete.sliding_modes import Slides, SlidingModes
from ancfsparse.seeds.ordering.unknown_groups import Groups

if TYPE_CHECKING:
    import scipy.sparse as sp

    from ancfsparse.seeds.incomplete.factor_protocol import IncompleteFactor

BLOCK_BYTES = 76  # nine numbers in double precision, and the row
TRIPLE_BYTES = 144  # of three unknowns: five vectors in single precision, scales, indices
RESIDUAL_RATIO = 1e-13  # of a solution from Python to its right-hand side
ROUND_RATIO = 1e-5  # of residuals, by a round of conjugate gradients in single precision
MAX_ITERATIONS = 2000  # of conjugate gradients in a round
MAX_ROUNDS = 12
MAX_BLOCKS = (2**31 - 1) // 9  # nine numbers each, counted in 32 bits
FACTOR_FLOPS = 45  # per entry: a factorization takes as long as seven sweeps
# The ratio is .01 in lattices; cables that cross at other than right angles cause fill-in.
MAX_COARSE_RATIO = 0.1  # entries of the factor of the coarse matrix over those of the matrix


class IncompleteSeed:
    """Approximate inverse of a symmetric quasi-definite matrix through an incomplete factor.

    Incomplete Cholesky factorization in blocks of up to three unknowns each, positions and slopes,
    with the block pattern of the matrix.  Nodes are in reverse order of Cuthill and McKee, from the
    leaves to the root on trees, and in a node slopes come before the position: fill-in between
    crossing cables is dropped; chains and trees have none.

    Compiled callers get a correction: one sweep, or a few iterations of conjugate gradients on the
    factored matrix, if one sweep has proved insufficient (``ic_solve.h``).  A few constraint
    equations, with multipliers after the coordinates, are satisfied to single precision by a second
    sweep (``ic_border.h``); multipliers of redundant equations are not changed.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns, diagonal included.
    groups : Groups
        Groups of up to three coordinates, and their nodes; in a node they are eliminated in the
        given order.
    threads : int, optional
        Maximum number of threads, at most two of which are used; results do not depend on it.
    slides : Slides, optional
        Modes for conjugate gradients, used if counts show that they save work; not with equations.

    Attributes
    ----------
    n, n_positive : int
        Number of unknowns, and of coordinates, which come first.
    nnz, factor_flops : int
        Entries below the diagonal between coordinates, as in the matrix; operations of one
        factorization, as measured per entry.
    threads : int
        2 if the factor has two fronts and two threads are allowed, else 1.
    nbytes : float
        Memory of the factor, which is allocated on first use [bytes].
    error : None
        Errors in calls from compiled code: there are none.
    """

    error: BaseException | None = None

    renewals = 0

    def __init__(
        self,
        indptr: Indices,
        indices: Indices,
        groups: Groups,
        threads: int = 1,
        slides: Slides | None = None,
    ) -> None:
        self.n, self.n_positive = len(indptr) - 1, int(np.count_nonzero(groups.members >= 0))
        self._pattern = np.asarray(indptr, dtype=np.int64), np.asarray(indices, dtype=np.int32)
        equations = self.n - self.n_positive
        self._sweeps = 2 if equations else 1
        (order, self._first), tree = groups.fronts(), compiled_module("tree")
        start, row = tree.lower_columns(*tree.permuted_upper(*groups.meeting, order))
        self._unknown = np.ascontiguousarray(groups.members[order], dtype=np.int32)
        self._own: IncompleteFactor | None = None
        self._matrix: sp.csc_array | None = None
        blocks, triples = len(order) + len(row), len(order)
        if blocks > MAX_BLOCKS:
            raise InputError(
                f"an incomplete factor has at most {MAX_BLOCKS:,} blocks, and this one would have "
                f"{blocks:,}: try fewer elements"
            )
        self._border: Border | None = None
        self.nnz = int(self._pattern[0][self.n_positive]) - self.n_positive
        if equations:
            self._border = Border.from_matrix(*self._pattern, self.n_positive, self._unknown)
            self.nnz -= len(self._border.entry)
        self.factor_flops = FACTOR_FLOPS * self.nnz + equations * self.sweep_flops
        self._coarse: SlidingModes | None = None
        if slides is not None and len(slides.mode) and not equations:
            coarse = SlidingModes.from_matrix(slides, self._unknown, start, row)
            self._coarse = coarse if coarse.factor.nnz <= MAX_COARSE_RATIO * self.nnz else None
        # The second front numbers the rows of the middle from the end on, see ic.h.
        _, second, middle, end = self._first
        rows = row[start[second] : start[middle]]
        rows[rows >= middle] += end - middle
        self._start, self._row = start.astype(np.int32), row
        self.threads = min(threads, 1 + (second < middle))
        self.nbytes = float(BLOCK_BYTES * blocks + TRIPLE_BYTES * triples + 4 * len(indices))
        for part in (self._coarse, self._border):
            self.nbytes += 0.0 if part is None else part.nbytes

    @property
    def own(self) -> IncompleteFactor:
        """The compiled factor."""
        if self._own is None:
            factor: IncompleteFactor = compiled_module("ic").Ic(
                *self._pattern,
                self.n_positive,
                self._unknown,
                self._start,
                self._row,
                self._first,
            )
            factor.set_threads(self.threads)
            if self._coarse is not None:
                factor.take_modes(self._coarse)
            if self._border is not None:
                factor.take_border(self._border)
            self._own = factor
        return self._own

    @property
    def capsule(self) -> object:
        """The structure ``ancf_seed`` for compiled callers; `solve` then needs a new `factor`."""
        self._matrix = None
        return self.own.capsule

    @property
    def inner(self) -> tuple[int, int]:
        """Numbers of sweeps and of products with the matrix for compiled callers."""
        return self.own.sweeps, self.own.products

    @property
    def memory(self) -> int:
        """Choice in earlier factors that the next ones repeat: the use of the modes."""
        return self.own.use

    @memory.setter
    def memory(self, use: int) -> None:
        self.own.use = use

    @property
    def solve_flops(self) -> int:
        """Operations of the simplest solve: a sweep, or two with equations."""
        return self._sweeps * self.sweep_flops

    @property
    def sweep_flops(self) -> int:
        """Operations of a sweep."""
        return 4 * self.nnz + 2 * self.n_positive

    def factor(self, values: NDArray[np.float64]) -> int:
        """Factor again; return 0, or 1 + the first unknown whose pivot was not positive.

        In the second case the factor is that of a matrix with a larger diagonal.

        Parameters
        ----------
        values : (n_values,) float
            Entries of the matrix on the pattern; `solve` reads them later.
        """
        import scipy.sparse as sp

        indptr, indices = self._pattern
        self._matrix = sp.csc_array((values, indices, indptr), shape=(self.n, self.n))
        bad = self.own.factor(values)
        if bad:
            self.own.mend(values)
        return bad

    def solve(self, r: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the solution ``(n,)`` for the right-hand side ``r (n,)``, to rounding.

        Iterative refinement with residuals in double precision, to thirteen digits if the matrix is
        definite.
        """
        assert self._matrix is not None
        diagonal = self._matrix.data[self._pattern[0][:-1]]
        best, best_norm, residual = np.zeros(self.n), np.inf, r
        initial = self._norm(r)
        for _ in range(MAX_ROUNDS):
            x = best + self.own.solve_to(residual, ROUND_RATIO, MAX_ITERATIONS)[0]
            residual = r - self._matrix @ x - self._matrix.T @ x + diagonal * x
            norm = self._norm(residual)
            if not norm < 0.5 * best_norm:
                break
            best, best_norm = x, norm
            if norm <= RESIDUAL_RATIO * initial:
                break
        return best

    def _norm(self, r: NDArray[np.float64]) -> float:
        """Return the norm of a residual scaled by the diagonals of A and S, free of units."""
        assert self._matrix is not None
        n = self.n_positive
        diagonal = np.abs(self._matrix.data[self._pattern[0][:n]])
        of_equations = np.sum((r[n:] * self.own.sizes) ** 2)
        return float(np.sqrt(np.sum(r[:n] ** 2 / diagonal) + of_equations))
