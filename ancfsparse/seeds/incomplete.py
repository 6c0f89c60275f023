"""Incomplete seeds: a factor without fill, whose cost is linear in the mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled
from ancfsparse.seeds.sparse import Indices

if TYPE_CHECKING:
    import scipy.sparse as sp

# Bytes of a block: twelve numbers in double precision, and its row.
BLOCK_BYTES = 100
# What a solution from Python may leave of its right-hand side; by how much each round of conjugate
# gradients in single precision brings it down, how many iterations that may take, and rounds.
REST, SHARE, MOST, ROUNDS = 1e-13, 1e-5, 2000, 12


class IncompleteSeed:
    """Approximate inverse of a symmetric positive definite matrix through an incomplete factor.

    Cholesky's factor in blocks of up to three unknowns each, positions and slopes, of which only
    the blocks are kept that the matrix has.  Nodes stand in reverse order of Cuthill and McKee,
    which on trees is from the leaves to the root, and in a node slopes before the position: what is
    dropped is the fill between cables that cross, on chains and trees nothing.

    Compiled callers get a correction: one sweep, or a few conjugate gradients on the matrix as it
    was factored, where one sweep is found to be too little (``ic_solve.h``).

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns, diagonal included.
    triples : (n_triples, 3) int
        Unknowns that are taken together, each unknown in one row; -1 where a row has fewer.
    node : (n_triples,) int
        Which of them belong to a node, numbered from 0; in a node they are eliminated in the order
        given.

    Attributes
    ----------
    n, n_positive : int
        Number of unknowns; all must have positive pivots.
    nnz, factor_flops : int
        Entries below the diagonal, as many as the matrix has; and 0, since operations of the
        factor grow with these entries alone.
    threads : int
        1: sweeps are not divided.
    nbytes : float
        Memory of the factor, which is taken when it is first asked for [bytes].
    error : None
        What went wrong while compiled code was running: nothing can.
    """

    error: BaseException | None = None
    factor_flops = 0
    threads = 1

    def __init__(
        self,
        indptr: Indices,
        indices: Indices,
        triples: NDArray[np.integer[Any]],
        node: NDArray[np.integer[Any]],
    ) -> None:
        self.n = self.n_positive = len(indptr) - 1
        self._pattern = np.asarray(indptr, dtype=np.int64), np.asarray(indices, dtype=np.int32)
        self.nnz = len(indices) - self.n
        meeting = contract(*self._pattern, triples)
        order = line_order(*meeting, np.asarray(node, dtype=np.int32))
        tree = compiled("tree")
        self._start, self._row = tree.lower_columns(*tree.permuted_upper(*meeting, order))
        self._unknown = np.ascontiguousarray(triples[order], dtype=np.int32)
        self._own: Any = None
        self._matrix: sp.csc_array | None = None
        n_blocks = len(triples) + len(self._row)
        self.nbytes = float(BLOCK_BYTES * n_blocks + 4 * len(indices) + 172 * len(triples))

    @property
    def own(self) -> Any:
        """The compiled factor."""
        if self._own is None:
            self._own = compiled("ic").Ic(*self._pattern, self._unknown, self._start, self._row)
        return self._own

    @property
    def capsule(self) -> object:
        """The structure ``ancf_seed`` for compiled callers."""
        capsule: object = self.own.capsule
        return capsule

    @property
    def inner(self) -> tuple[int, int]:
        """Sweeps and products with the matrix in solutions for compiled callers so far."""
        return self.own.sweeps, self.own.products

    @property
    def solve_flops(self) -> int:
        """Operations of a sweep."""
        return 4 * self.nnz + 2 * self.n

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
        bad = int(self.own.factor(values))
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
        """Length of a residual by the diagonal, so that units do not count."""
        assert self._matrix is not None
        diagonal = np.abs(self._matrix.data[self._pattern[0][:-1]])
        return float(np.sqrt(np.sum(r**2 / diagonal)))


def contract(
    indptr: Indices, indices: Indices, groups: NDArray[np.integer[Any]]
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Return the lower triangle by columns of the groups of unknowns that meet.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle of the unknowns by columns.
    groups : (n_groups, k) int
        Unknowns of each group, -1 for none.
    """
    of_unknown = np.empty(len(indptr) - 1, dtype=np.int32)
    there = groups >= 0
    of_unknown[groups[there]] = np.nonzero(there)[0]
    found: tuple[NDArray[np.int64], NDArray[np.int32]] = compiled("tree").contracted(
        indptr, indices, of_unknown, len(groups)
    )
    return found


def line_order(indptr: Indices, indices: Indices, node: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the order of elimination of the members of nodes, (n,) int32.

    Nodes in reverse order of Cuthill and McKee, members of a node in the order they come in.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns of the members that meet.
    node : (n,) int32
        Node of each member.
    """
    import scipy.sparse as sp
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    n_nodes = int(node.max()) + 1
    starts, rows = compiled("tree").contracted(indptr, indices, node, n_nodes)
    lower = sp.csr_array(
        (np.ones(len(rows), dtype=np.int8), rows, starts), shape=(n_nodes, n_nodes)
    )
    rank = np.empty(n_nodes, dtype=np.int32)
    rank[reverse_cuthill_mckee((lower + lower.T).tocsr(), symmetric_mode=True)] = np.arange(n_nodes)
    return np.argsort(rank[node], kind="stable").astype(np.int32)
