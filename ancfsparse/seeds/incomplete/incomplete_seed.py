"""Incomplete seeds: a factor without fill, whose cost is linear in the mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import InputError
from ancfsparse.seeds.incomplete.constraint_border import Border
from ancfsparse.seeds.incomplete.sliding_modes import Slides, SlidingModes
from ancfsparse.seeds.interface.index_arrays import Indices
from ancfsparse.seeds.ordering.unknown_groups import Groups

if TYPE_CHECKING:
    import scipy.sparse as sp

    from ancfsparse.seeds.incomplete.factor_protocol import IncompleteFactor

# Bytes of a block: nine numbers in double precision, and its row; and of three unknowns: five
# vectors in single precision, their scale twice, and where they are.
BLOCK_BYTES, TRIPLE_BYTES = 76, 144
# What a solution from Python may leave of its right-hand side; by how much each round of conjugate
# gradients in single precision brings it down, how many iterations that may take, and rounds.
REST, SHARE, MOST, ROUNDS = 1e-13, 1e-5, 2000, 12


# Blocks whose numbers, nine each, can be counted in 32 bits.
MOST_BLOCKS = (2**31 - 1) // 9
# Operations for each entry: a factorisation takes as long as seven sweeps.
FACTOR_FLOPS = 45


# Entries of the factor of the coarse matrix for each of the matrix: in lattices .01, but cables
# that cross at other than right angles fill it in.
MOST_COARSE = 0.1


class IncompleteSeed:
    """Approximate inverse of a symmetric quasi-definite matrix through an incomplete factor.

    Cholesky's factor in blocks of up to three unknowns each, positions and slopes, of which only
    the blocks are kept that the matrix has.  Nodes stand in reverse order of Cuthill and McKee,
    which on trees is from the leaves to the root, and in a node slopes before the position: what is
    dropped is the fill between cables that cross, on chains and trees nothing.

    Compiled callers get a correction: one sweep, or a few conjugate gradients on the matrix as it
    was factored, where one sweep is found to be too little (``ic_solve.h``).  A few equations, the
    multipliers of which come after the coordinates, are held to single precision in each, by a
    second sweep (``ic_border.h``); of those that follow from others the multipliers are left alone.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns, diagonal included.
    groups : Groups
        Up to three coordinates that are taken together, and the nodes that they belong to; in a
        node they are eliminated in the order given.
    threads : int, optional
        Most threads, of which two find work; digits do not depend on it.
    slides : Slides, optional
        Modes that conjugate gradients use where counts show that they pay; not with equations.

    Attributes
    ----------
    n, n_positive : int
        Number of unknowns, and of coordinates, which come first.
    nnz, factor_flops : int
        Entries below the diagonal between coordinates, as many as the matrix has; operations of one
        factorisation, as they are measured to be for each of these.
    threads : int
        2 where the factor has two fronts and two threads are allowed, else 1.
    nbytes : float
        Memory of the factor, which is taken when it is first asked for [bytes].
    error : None
        What went wrong while compiled code was running: nothing can.
    """

    error: BaseException | None = None

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
        if blocks > MOST_BLOCKS:
            raise InputError(
                f"an incomplete factor has at most {MOST_BLOCKS:,} blocks, and this one would have "
                f"{blocks:,}: try fewer elements"
            )
        self._border: Border | None = None
        self.nnz = int(self._pattern[0][self.n_positive]) - self.n_positive
        if equations:
            self._border = Border.of(*self._pattern, self.n_positive, self._unknown)
            self.nnz -= len(self._border.entry)
        self.factor_flops = FACTOR_FLOPS * self.nnz + equations * self.sweep_flops
        self._coarse: SlidingModes | None = None
        if slides is not None and len(slides.mode) and not equations:
            coarse = SlidingModes.of(slides, self._unknown, start, row)
            self._coarse = coarse if coarse.factor.nnz <= MOST_COARSE * self.nnz else None
        # The second front counts the rows of the middle from the end on, see ic.h.
        _, second, middle, end = self._first
        beside = row[start[second] : start[middle]]
        beside[beside >= middle] += end - middle
        self._start, self._row = start.astype(np.int32), row
        self.threads = min(threads, 1 + (second < middle))
        self.nbytes = float(BLOCK_BYTES * blocks + TRIPLE_BYTES * triples + 4 * len(indices))
        for beside in (self._coarse, self._border):
            self.nbytes += 0.0 if beside is None else beside.nbytes

    @property
    def own(self) -> IncompleteFactor:
        """The compiled factor."""
        if self._own is None:
            made: IncompleteFactor = compiled_module("ic").Ic(
                *self._pattern,
                self.n_positive,
                self._unknown,
                self._start,
                self._row,
                self._first,
            )
            made.set_threads(self.threads)
            if self._coarse is not None:
                made.take_modes(self._coarse)
            if self._border is not None:
                made.take_border(self._border)
            self._own = made
        return self._own

    @property
    def capsule(self) -> object:
        """The structure ``ancf_seed`` for compiled callers; `solve` then needs a new `factor`."""
        self._matrix = None
        return self.own.capsule

    @property
    def inner(self) -> tuple[int, int]:
        """Sweeps and products with the matrix in solutions for compiled callers so far."""
        return self.own.sweeps, self.own.products

    @property
    def solve_flops(self) -> int:
        """Operations of the plainest solve: a sweep, or two where there are equations."""
        return self._sweeps * self.sweep_flops

    @property
    def sweep_flops(self) -> int:
        """Operations of a sweep."""
        return 4 * self.nnz + 2 * self.n_positive

    def factor(self, values: NDArray[np.float64]) -> int:
        """Factor again; return 0, or 1 + the first unknown whose pivot was not positive.

        In the second case there is a factor of a neighbour, with a larger diagonal.

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

        The residual in double precision is solved for again and again, to thirteen digits where the
        matrix is definite.
        """
        assert self._matrix is not None
        diagonal = self._matrix.data[self._pattern[0][:-1]]
        best, least, left = np.zeros(self.n), np.inf, r
        whole = self._size(r)
        for _ in range(ROUNDS):
            x = best + self.own.solve_to(left, SHARE, MOST)[0]
            left = r - self._matrix @ x - self._matrix.T @ x + diagonal * x
            size = self._size(left)
            if not size < 0.5 * least:
                break
            best, least = x, size
            if size <= REST * whole:
                break
        return best

    def _size(self, r: NDArray[np.float64]) -> float:
        """Length of a residual by the diagonals of A and S, so that units do not count."""
        assert self._matrix is not None
        n = self.n_positive
        diagonal = np.abs(self._matrix.data[self._pattern[0][:n]])
        of_equations = np.sum((r[n:] * self.own.sizes) ** 2)
        return float(np.sqrt(np.sum(r[:n] ** 2 / diagonal) + of_equations))
