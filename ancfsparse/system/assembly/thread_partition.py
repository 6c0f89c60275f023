"""Division of the elements among threads."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ancfsparse.array_types import Integers
from ancfsparse.kernels.layout import Layout

MAX_COMMON_WORK = 0.2  # work in blocks of no single thread, over all work


def partition_elements(
    layouts: Sequence[Layout], n_free: int, n_all: int, threads: int
) -> tuple[Integers, Integers] | None:
    """Assign the blocks of elements to threads that write to disjoint coordinates.

    Parameters
    ----------
    layouts : sequence of Layout
        The elements.
    n_free, n_all : int
        Numbers of free and of all coordinates.
    threads : int
        Number of parts, at least 2.

    Returns
    -------
    run_start, runs
        As `partition_blocks` returns them, with layouts as groups.
        None in place of both if too many blocks share coordinates.
    """
    places = [_places(layout, n_free) for layout in layouts]
    work = [layout.scatter[0].size for layout in layouts]
    return partition_blocks(places, work, n_all, threads)


def partition_blocks(
    places: Sequence[Integers], work_of_block: Sequence[int], n_all: int, threads: int
) -> tuple[Integers, Integers] | None:
    """Assign blocks of work to threads that write to disjoint coordinates.

    Blocks are assigned in the order of their first coordinate, so that each thread has a contiguous
    range; blocks that share coordinates with an earlier thread are evaluated at the end.

    Parameters
    ----------
    places : sequence of (n_blocks, k) int
        Coordinates of each block, in groups of blocks with the same number k of coordinates.
    work_of_block : sequence of int
        Work of one block of each group.
    n_all : int
        Number of coordinates.
    threads : int
        Number of parts, at least 2.

    Returns
    -------
    run_start : (threads + 2,) int32
        Starts of the runs of each part, of the runs after all parts, and the end.
    runs : (n_runs, 3) int32
        Group, first block and end of each run of blocks.
        None in place of both if too many blocks share coordinates.
    """
    sizes = [len(table) for table in places]
    work = np.repeat(work_of_block, sizes)
    order = np.argsort(np.concatenate([table.min(axis=1) for table in places]), kind="stable")
    part = np.empty(len(order), dtype=np.int32)
    done = np.cumsum(work[order])
    part[order] = np.minimum((done - work[order]) * threads // done[-1], threads - 1)
    ends = np.cumsum(sizes)[:-1]
    assigned = np.zeros(n_all, dtype=bool)
    for thread in range(threads):
        by_others = assigned.copy()
        for table, of_block in zip(places, np.split(part, ends), strict=True):  # split: views
            members = np.flatnonzero(of_block == thread)
            common = by_others[table[members]].any(axis=1)
            of_block[members[common]] = threads
            assigned[table[members[~common]]] = True
    if work[part == threads].sum() > MAX_COMMON_WORK * work.sum():
        return None
    runs, owners = [], []
    for group, owner in enumerate(np.split(part, ends)):
        first = np.flatnonzero(np.diff(owner, prepend=-1))
        last = np.append(first[1:], len(owner))
        runs.append(np.stack([np.full(len(first), group), first, last], axis=1))
        owners.append(owner[first])
    owner = np.concatenate(owners)
    by_owner = np.argsort(owner, kind="stable")
    run_start = np.searchsorted(owner[by_owner], np.arange(threads + 2))
    return run_start.astype(np.int32), np.concatenate(runs)[by_owner].astype(np.int32)


def _places(layout: Layout, n_free: int) -> Integers:
    """Return the coordinates of each block, (n_blocks, n lanes), with one index for fixed ones.

    Kernels write the entries of fixed coordinates to one discarded position of the matrix.
    """
    table = layout.gather.reshape(len(layout.gather), -1)
    if len(layout.table_of):
        table = table[layout.table_of] + layout.base[:, None]
    return np.minimum(table, np.int32(n_free))
