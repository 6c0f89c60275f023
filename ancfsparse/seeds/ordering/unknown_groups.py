"""Groups of unknowns, such as the vectors of a node: their coupling and orders of elimination."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Indices
from ancfsparse.dispatch import compiled_module
from ancfsparse.seeds import ordering
from ancfsparse.seeds.interface.index_arrays import Triangle

if TYPE_CHECKING:
    import scipy.sparse as sp

# Minimum degree of nodes fills in 2.8 times as much as nested dissection in a lattice of 3 nodes a
# side, 1.9 times from 8 on, 1.2 times in nets.
FILL_MARGIN = 3.0
# Two fronts save time from a number of groups at which a second thread has enough work, and the
# middle, where both fronts meet in all directions, costs little.
MIN_TWO_FRONTS = 5000  # groups
# Nets have one independent cycle per node, and an incomplete factor in two fronts contracts half as
# fast there (284 sweeps instead of 104 in 40 steps of a net of 40); cubic lattices have two cycles
# per node, and contract as fast.
MIN_CYCLES = 1.5  # per node, for two fronts
MAX_BLOCKS = 1e15  # beyond any memory


class Fill(NamedTuple):
    """Size and cost of a complete factor, in complete groups.

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
        Unknowns of each group, each in one of them; -1 in smaller groups.
    node : (n_groups,) int32
        Node of each group, numbered from 0.
    meeting : tuple of arrays
        Lower triangle of coupled groups, by columns: starts and rows, diagonal included.
    """

    members: NDArray[np.integer[Any]]
    node: NDArray[np.int32]
    meeting: Triangle

    @classmethod
    def from_matrix(
        cls,
        indptr: Indices,
        indices: Indices,
        members: NDArray[np.integer[Any]],
        node: NDArray[np.integer[Any]],
    ) -> Groups:
        """Return the groups with their coupling in a matrix.

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
        """Return the lower triangle of coupled nodes, by columns, diagonal included."""
        lower: Triangle = compiled_module("tree").contracted(
            *self.meeting, self.node, int(self.node.max()) + 1
        )
        return lower

    @property
    def cycles(self) -> int:
        """Number of independent cycles of the graph of nodes."""
        from scipy.sparse.csgraph import connected_components

        lower = self._lower_nodes()
        n = lower.shape[0]
        return int(lower.nnz - n - (n - connected_components(lower, directed=False)[0]))

    def fronts(self) -> tuple[NDArray[np.int32], tuple[int, int, int, int]]:
        """Return the groups in order of elimination, (n,) int32, and the starts of its parts.

        Node by node, in two uncoupled fronts and then the middle, which is coupled with both: half
        of the nodes in the order of Cuthill and McKee, the others, and as the middle those of the
        others that are adjacent to the first half.  In a front, nodes come in reverse order of
        their distance from the middle.  Trees are one front, from the leaves to the root, and so
        are nets and small graphs.  Groups of a node keep their order.

        The second result is the index of the first group of each front and of the middle, and the
        number of groups.
        """
        import scipy.sparse as sp
        from scipy.sparse.csgraph import breadth_first_order, reverse_cuthill_mckee

        lower = self._lower_nodes()
        n = lower.shape[0]
        graph = (lower + lower.T).tocsr()
        reverse = reverse_cuthill_mckee(graph, symmetric_mode=True)
        if len(self.members) < MIN_TWO_FRONTS or self.cycles < MIN_CYCLES * n:
            return self._by_node(reverse), (0, *3 * (len(self.members),))
        rank = np.empty(n, dtype=np.int32)
        rank[reverse] = np.arange(n, dtype=np.int32)
        second = rank >= n // 2
        meets = np.asarray(graph @ (~second).astype(np.int32)) > 0
        part = second + np.int8(0)
        part[second & meets] = 2
        # Breadth-first search from the middle, and from the last node of other components.
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
        """Return a mask of the last nodes of components without a part in the middle."""
        from scipy.sparse.csgraph import connected_components

        n_components, component = connected_components(graph, directed=False)
        last = np.zeros(n_components, dtype=np.int32)
        np.maximum.at(last, component, rank)
        last[component[part == 2]] = -1
        out: NDArray[np.bool_] = rank == last[component]
        return out

    def exact_fill(self, max_ratio: float) -> Fill | None:
        """Return the fill-in of the complete factor in an order of nested dissection.

        This order, which takes most of the time, is not computed if an order of minimum degree of
        the nodes fills in far more than allowed.

        Parameters
        ----------
        max_ratio : float
            Blocks over those of the matrix; above, the result is None.
        """
        by_node = self._by_node(ordering.order(*self.nodes(), "amd"))
        if self._lengths(by_node, FILL_MARGIN * max_ratio) is None:
            return None
        length = self._lengths(ordering.order(*self.meeting, "metis"), max_ratio)
        if length is None:
            return None
        width, nnz = self._width, self._entries(float(np.sum(length)))
        flops = width**3 * float(np.sum(length.astype(float) ** 2))
        return Fill(nnz, flops, 4.0 * nnz + 2.0 * width * len(self.members))

    def _lengths(
        self, permutation: NDArray[np.int32], max_ratio: float
    ) -> NDArray[np.int32] | None:
        """Return the number of blocks in each column of a factor; None above the ratio."""
        upper = compiled_module("tree").permuted_upper(*self.meeting, permutation)
        blocks = len(self.meeting[1]) - len(self.members)
        limit = int(min(max_ratio * blocks, MAX_BLOCKS))
        tree = compiled_module("tree").elimination_tree(*upper, limit)
        return None if tree is None else tree[1]

    @property
    def nnz(self) -> float:
        """Entries below the diagonal of the matrix, in complete groups."""
        return self._entries(len(self.meeting[1]) - len(self.members))

    @property
    def _width(self) -> float:
        """Mean number of unknowns of a group."""
        return float(np.count_nonzero(self.members >= 0)) / len(self.members)

    def _entries(self, blocks: float) -> float:
        """Return the entries below the diagonal in a number of blocks and the diagonal blocks."""
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
