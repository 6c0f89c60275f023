"""The coordinates as vectors: the position of each node, and the slopes of its rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

# Numbers of a vector: components in space; in the plane, and for single ones, some remain free.
WIDTH = 3


def vectors_of(
    places: Sequence[NDArray[np.int32]], dim: int, n_free: int
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return the free coordinates vector by vector, and the node of each vector.

    Parameters
    ----------
    places : sequence of (n_rows, n_c) int32 arrays
        Per beam the place of each coordinate of each row, position first.
    dim : int
        Dimension of the scene.
    n_free : int
        Places from here on are fixed.

    Returns
    -------
    vectors : (n_vectors, 3) int32
        Places, -1 where there is none or it is fixed; slopes before positions.
    node : (n_vectors,) int32
        Numbers from 0 on; rows that share a position are of one node.
    """
    heads = np.concatenate([table[:, 0] for table in places])
    number = np.zeros(max(int(table.max()) for table in places) + 1, dtype=np.int32)
    number[heads] = 1
    number = np.cumsum(number, dtype=np.int32) - np.int32(1)
    tables, nodes = list[NDArray[np.int32]](), list[NDArray[np.int32]]()
    for table in places:
        for first in range(dim, table.shape[1], dim):
            tables.append(_padded(table[:, first : first + dim]))
            nodes.append(number[table[:, 0]])
    positions = np.concatenate([table[:, :dim] for table in places])
    _, first_of = np.unique(heads, return_index=True)
    tables.append(_padded(positions[first_of]))
    nodes.append(number[heads[first_of]])
    vectors, node = np.concatenate(tables), np.concatenate(nodes)
    vectors[vectors >= n_free] = -1
    some = (vectors >= 0).any(axis=1)
    return vectors[some], node[some]


def _padded(table: NDArray[np.int32]) -> NDArray[np.int32]:
    out = np.full((len(table), WIDTH), -1, dtype=np.int32)
    out[:, : table.shape[1]] = table
    return out
