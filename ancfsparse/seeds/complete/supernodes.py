"""Supernodes of a factor, and their division among threads into disjoint subtrees and a root."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled_module
from ancfsparse.seeds.interface.index_arrays import Triangle

MAX_ROOT_FRACTION = 0.2  # of the work, in the root, which one thread does alone
MIN_EFFICIENCY = 0.6  # speed-up over the number of threads


@dataclass(frozen=True)
class SupernodeTree:
    """Supernodes of L and their tree.

    Attributes
    ----------
    first : (n_super + 1,) int32
        First column of each supernode, and n.
    super_of : (n,) int32
        Supernode of each column.
    parent : (n_super,) int32
        Their tree; -1 at its roots.
    row_start : (n_super + 1,) int64
        Start of the rows below each supernode.
    part : (n_parts + 2,) int32
        First supernode of each part, of the root, and the end.
    nnz, flops : int
        Entries of L below the diagonal; operations of one factorisation.
    """

    first: NDArray[np.int32]
    super_of: NDArray[np.int32]
    parent: NDArray[np.int32]
    row_start: NDArray[np.int64]
    part: NDArray[np.int32]
    nnz: int
    flops: int

    @property
    def n_parts(self) -> int:
        """Number of parts without the root."""
        return len(self.part) - 2

    def rows(self, upper: Triangle) -> NDArray[np.int32]:
        """Return the rows below each supernode, ascending, one supernode after another."""
        rows: NDArray[np.int32] = compiled_module("tree").supernode_rows(
            *upper, self.first, self.super_of, self.parent, self.row_start
        )
        return rows


def find_supernodes(
    upper: Triangle, sizes: Sequence[int] | NDArray[np.int64] = ()
) -> SupernodeTree:
    """Return the supernodes of a permuted matrix.

    Parameters
    ----------
    upper : (starts, rows)
        Its upper triangle by columns.
    sizes : sequence of int, optional
        Number of columns in each part and in the root; by default all are one part.
    """
    parent, lengths = compiled_module("tree").elimination_tree(*upper)
    n = len(parent)
    ends = np.cumsum(sizes) if len(sizes) else np.array([n, n])
    first, super_of, up, row_start = compiled_module("tree").supernodes(parent, lengths, ends)
    part = np.append(0, np.searchsorted(first, ends)).astype(np.int32)
    wide = lengths.astype(np.int64)
    flops = int(np.sum(wide * (wide + 3)))
    return SupernodeTree(first, super_of, up, row_start, part, int(wide.sum()), flops)


def divide_among_threads(shape: SupernodeTree, threads: int) -> NDArray[np.int32] | None:
    """Assign every supernode to a part, or to the root, which is last.

    The heaviest subtree is split into the subtrees of its children, and its top goes to the root,
    while that may reduce the time of the slowest thread and the root together.

    Parameters
    ----------
    shape : Shape
        The factor.
    threads : int
        Number of parts, at least 2.

    Returns
    -------
    (n_super,) int32 or None
        Part of each supernode, `threads` for the root; None without an even division.
    """
    import heapq

    parent = shape.parent
    width = np.diff(shape.first)
    work = width * (width + 2 * np.diff(shape.row_start))
    total = int(work.sum())
    below = compiled_module("tree").subtree_sums(parent, work)
    by_parent = np.argsort(parent, kind="stable").astype(np.int32)
    child_start = np.searchsorted(parent[by_parent], np.arange(-1, len(parent) + 1))
    roots = by_parent[: child_start[1]]
    heap = [(-int(below[s]), int(s)) for s in roots]
    heapq.heapify(heap)
    in_root, split = 0, list[int]()
    best, best_time = (list[tuple[int, int]](), 0), total

    def may_improve() -> bool:
        """Return True if an even division of the work below the root would take less time."""
        return in_root + (total - in_root) / threads < best_time

    while heap and in_root <= MAX_ROOT_FRACTION * total and may_improve():
        time = in_root + max(load for load, _ in _distribute(heap, threads))
        if time < best_time:
            best, best_time = (heap.copy(), len(split)), time
        _, top = heapq.heappop(heap)
        split.append(top)
        in_root += int(work[top])
        for child in by_parent[child_start[top + 1] : child_start[top + 2]]:
            heapq.heappush(heap, (-int(below[child]), int(child)))
    if best_time * MIN_EFFICIENCY * threads > total:
        return None
    owner = np.full(len(parent), -1, dtype=np.int32)
    for part, (_, subtrees) in enumerate(_distribute(best[0], threads)):
        owner[subtrees] = part
    owner[split[: best[1]]] = threads
    compiled_module("tree").inherit(parent, owner)
    return owner


def _distribute(subtrees: list[tuple[int, int]], threads: int) -> list[tuple[int, list[int]]]:
    """Assign subtrees, the heaviest first, each to the part with the least work."""
    import heapq

    parts: list[tuple[int, int, list[int]]] = [(0, part, []) for part in range(threads)]
    for minus_work, top in sorted(subtrees):
        load, part, tops = heapq.heappop(parts)
        heapq.heappush(parts, (load - minus_work, part, [*tops, top]))
    parts.sort(key=lambda each: each[1])
    return [(load, tops) for load, _, tops in parts]
