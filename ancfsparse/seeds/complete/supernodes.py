"""Supernodes of a factor, and their division among threads: disjoint subtrees, and a root."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled_module
from ancfsparse.seeds.interface.index_arrays import Triangle

# Share of the work at which the root, which one thread does alone, ends the search; and share of
# the ideal gain that a division must bring.
MOST_ROOT, SMALLEST_GAIN = 0.2, 0.6


@dataclass(frozen=True)
class Shape:
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
        Where the rows below each supernode start.
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


def shape_of(upper: Triangle, sizes: Sequence[int] | NDArray[np.int64] = ()) -> Shape:
    """Find the supernodes of a permuted matrix.

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
    return Shape(first, super_of, up, row_start, part, int(wide.sum()), flops)


def parts_of(shape: Shape, threads: int) -> NDArray[np.int32] | None:
    """Give every supernode to a part, or to the root, which comes last.

    The heaviest subtree is split into the subtrees of its children, its top going to the root, for
    as long as that may shorten what the slowest thread and the root take together.

    Parameters
    ----------
    shape : Shape
        The factor.
    threads : int
        Number of parts, at least 2.

    Returns
    -------
    (n_super,) int32 or None
        Part of each supernode, `threads` for the root; None where no even division is found.
    """
    import heapq

    parent = shape.parent
    width = np.diff(shape.first)
    work = width * (width + 2 * np.diff(shape.row_start))
    total = int(work.sum())
    below = compiled_module("tree").subtree_sums(parent, work)
    by_parent = np.argsort(parent, kind="stable").astype(np.int32)
    child_start = np.searchsorted(parent[by_parent], np.arange(-1, len(parent) + 1))
    children = [by_parent[: child_start[1]]]  # of nobody: the roots of the tree
    heap = [(-int(below[s]), int(s)) for s in children[0]]
    heapq.heapify(heap)
    in_root, split = 0, list[int]()
    best, least = (list[tuple[int, int]](), 0), total
    # With all below it dealt out evenly the root alone shows when no better division is possible.
    while heap and in_root <= MOST_ROOT * total and in_root + (total - in_root) / threads < least:
        time = in_root + max(load for load, _ in _deal(heap, threads))
        if time < least:
            best, least = (heap.copy(), len(split)), time
        _, top = heapq.heappop(heap)
        split.append(top)
        in_root += int(work[top])
        for child in by_parent[child_start[top + 1] : child_start[top + 2]]:
            heapq.heappush(heap, (-int(below[child]), int(child)))
    if least * SMALLEST_GAIN * threads > total:
        return None
    owner = np.full(len(parent), -1, dtype=np.int32)
    for part, (_, subtrees) in enumerate(_deal(best[0], threads)):
        owner[subtrees] = part
    owner[split[: best[1]]] = threads
    compiled_module("tree").inherit(parent, owner)
    return owner


def _deal(subtrees: list[tuple[int, int]], threads: int) -> list[tuple[int, list[int]]]:
    """Give the heaviest subtree left to the part with the least work, again and again."""
    import heapq

    parts: list[tuple[int, int, list[int]]] = [(0, part, []) for part in range(threads)]
    for minus_work, top in sorted(subtrees):
        load, part, mine = heapq.heappop(parts)
        heapq.heappush(parts, (load - minus_work, part, [*mine, top]))
    parts.sort(key=lambda each: each[1])
    return [(load, mine) for load, _, mine in parts]
