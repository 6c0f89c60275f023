"""Unknowns in groups, such as the vectors of a node: which groups meet, and in which orders."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled_module
from ancfsparse.seeds import ordering
from ancfsparse.seeds.interface.index_arrays import Indices, Triangle

if TYPE_CHECKING:
    import scipy.sparse as sp

# By how much a factor may fill in more where whole nodes are eliminated in an order of minimum
# degree: 2.8 times in a lattice of 3 nodes a side, 1.9 from 8 on, 1.2 in nets.
ROUGHLY = 3.0
# Groups from which two fronts pay: so much work that a second thread can share it, and that what
# the middle costs, where both meet in all directions, is little.
TWO_FRONTS_FROM = 5000
# Independent cycles per node from which they pay: nets have one, and there a factor without fill in
# two fronts contracts half as fast (284 sweeps instead of 104 in 40 steps of a net of 40); cubic
# lattices have two, and lose nothing.
CYCLES_FROM = 1.5
# More than any memory holds.
MOST_BLOCKS = 1e15


class Fill(NamedTuple):
    """What a complete factor costs, counted in whole groups.

    Attributes
    ----------
    nnz, factor_flops : float
        Entries of L below the diagonal; operations of one factorisation.
    solve_flops : float
        Operations of one solve.
    """

    nnz: float
    factor_flops: float
    solve_flops: float


@dataclass(frozen=True)
class Groups:
    """Groups of unknowns, all of which are eliminated together.

    Attributes
    ----------
    members : (n_groups, k) int
        Unknowns of each group, each in one of them; -1 where a group has fewer.
    node : (n_groups,) int32
        Node of each group, numbered from 0.
    meeting : tuple of arrays
        Lower triangle of the groups that meet, by columns: starts and rows, diagonal included.
    """

    members: NDArray[np.integer[Any]]
    node: NDArray[np.int32]
    meeting: Triangle

    @classmethod
    def of(
        cls,
        indptr: Indices,
        indices: Indices,
        members: NDArray[np.integer[Any]],
        node: NDArray[np.integer[Any]],
    ) -> Groups:
        """Find out which groups meet in a matrix.

        Parameters
        ----------
        indptr, indices : integer arrays
            Its lower triangle by columns, diagonal included.
        members, node
            As above.
        """
        indptr, indices = np.asarray(indptr, dtype=np.int64), np.asarray(indices, dtype=np.int32)
        of_unknown = np.empty(len(indptr) - 1, dtype=np.int32)
        there = members >= 0
        of_unknown[members[there]] = np.nonzero(there)[0]
        meeting = compiled_module("tree").contracted(indptr, indices, of_unknown, len(members))
        return cls(members, np.asarray(node, dtype=np.int32), meeting)

    def nodes(self) -> Triangle:
        """Return the lower triangle of the nodes that meet, by columns, diagonal included."""
        lower: Triangle = compiled_module("tree").contracted(
            *self.meeting, self.node, int(self.node.max()) + 1
        )
        return lower

    @property
    def cycles(self) -> int:
        """Number of edges between nodes that a tree, or several, would not have."""
        from scipy.sparse.csgraph import connected_components

        lower = self._lower_nodes()
        n = lower.shape[0]
        return int(lower.nnz - n - (n - connected_components(lower, directed=False)[0]))

    def fronts(self) -> tuple[NDArray[np.int32], tuple[int, int, int, int]]:
        """Return the groups in order of elimination, (n,) int32, and where its parts begin.

        Node by node, in two fronts that do not meet and then the middle, which both meet: half of
        the nodes in the order of Cuthill and McKee, the others, and in the middle what of those is
        beside the half.  In a front, nodes come in reverse order of their distance from the middle.
        Trees are one front, from the leaves to the root, and so are nets and what is small.  Groups
        of a node come in their own order.

        The second result is the place of the first group of each front and of the middle, and the
        number of groups.
        """
        import scipy.sparse as sp
        from scipy.sparse.csgraph import breadth_first_order, reverse_cuthill_mckee

        lower = self._lower_nodes()
        n = lower.shape[0]
        graph = (lower + lower.T).tocsr()
        reverse = reverse_cuthill_mckee(graph, symmetric_mode=True)
        if len(self.members) < TWO_FRONTS_FROM or self.cycles < CYCLES_FROM * n:
            return self._by_node(reverse), (0, *3 * (len(self.members),))
        rank = np.empty(n, dtype=np.int32)
        rank[reverse] = np.arange(n, dtype=np.int32)
        second = rank >= n // 2
        meets = np.asarray(graph @ (~second).astype(np.int32)) > 0
        part = second + np.int8(0)
        part[second & meets] = 2
        # A breadth-first search from all of the middle, and from the last node of other components.
        root = np.flatnonzero((part == 2) | self._ends_component(graph, rank, part))
        star = sp.csr_array(
            (np.ones(len(root), np.int8), (np.zeros(len(root), np.int32), root)), shape=(1, n)
        )
        rooted = sp.block_array([[None, star], [star.T, graph]], format="csr")
        nodes = breadth_first_order(rooted, 0, directed=True, return_predecessors=False)[:0:-1] - 1
        nodes = nodes[np.argsort(part[nodes], kind="stable")]
        order = self._by_node(nodes)
        sizes = np.cumsum(np.bincount(part[self.node], minlength=3))
        return order, (0, int(sizes[0]), int(sizes[1]), int(sizes[2]))

    @staticmethod
    def _ends_component(
        graph: sp.csr_array, rank: NDArray[np.int32], part: NDArray[np.int8]
    ) -> NDArray[np.bool_]:
        """Return which nodes are the last of a component that has no part in the middle."""
        from scipy.sparse.csgraph import connected_components

        n_components, component = connected_components(graph, directed=False)
        last = np.zeros(n_components, dtype=np.int32)
        np.maximum.at(last, component, rank)
        last[component[part == 2]] = -1
        out: NDArray[np.bool_] = rank == last[component]
        return out

    def exact_fill(self, most: float) -> Fill | None:
        """Count the complete factor in an order of nested dissection.

        It is not ordered, which takes longest, if an order of minimum degree of the nodes shows
        that it fills in far more.

        Parameters
        ----------
        most : float
            Blocks for each of the matrix beyond which counting ends with None.
        """
        by_node = self._by_node(ordering.order(*self.nodes(), "amd"))
        if self._lengths(by_node, ROUGHLY * most) is None:
            return None
        length = self._lengths(ordering.order(*self.meeting, "metis"), most)
        if length is None:
            return None
        width, nnz = self._width, self._entries(float(np.sum(length)))
        flops = width**3 * float(np.sum(length.astype(float) ** 2))
        return Fill(nnz, flops, 4.0 * nnz + 2.0 * width * len(self.members))

    def _lengths(self, permutation: NDArray[np.int32], most: float) -> NDArray[np.int32] | None:
        """Return how many blocks each column of a factor has; None where they are too many."""
        upper = compiled_module("tree").permuted_upper(*self.meeting, permutation)
        blocks = len(self.meeting[1]) - len(self.members)
        limit = int(min(most * blocks, MOST_BLOCKS))
        found = compiled_module("tree").elimination_tree(*upper, limit)
        return None if found is None else found[1]

    @property
    def nnz(self) -> float:
        """Entries below the diagonal of the matrix, counted in whole groups."""
        return self._entries(len(self.meeting[1]) - len(self.members))

    @property
    def _width(self) -> float:
        """Mean number of unknowns of a group."""
        return float(np.count_nonzero(self.members >= 0)) / len(self.members)

    def _entries(self, blocks: float) -> float:
        """Entries below the diagonal in so many blocks and those at the diagonal."""
        width = self._width
        return width**2 * blocks + 0.5 * width * (width - 1.0) * len(self.members)

    def _lower_nodes(self) -> sp.csr_array:
        import scipy.sparse as sp

        starts, rows = self.nodes()
        n = len(starts) - 1
        return sp.csr_array((np.ones(len(rows), dtype=np.int8), rows, starts), shape=(n, n))

    def _by_node(self, permutation: NDArray[np.int32]) -> NDArray[np.int32]:
        rank = np.empty(len(permutation), dtype=np.int32)
        rank[permutation] = np.arange(len(permutation), dtype=np.int32)
        return np.argsort(rank[self.node], kind="stable").astype(np.int32)
