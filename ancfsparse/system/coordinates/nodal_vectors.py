"""The coordinates as vectors: the position of each node, and the slopes of its rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.scene import Point

# Numbers of a vector: components in space; in the plane, and for single ones, some remain free.
MAX_COMPONENTS = 3


def vectors_of(
    places: Sequence[NDArray[np.int32]], kinds: Sequence[ElementKind], n_free: int
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return the free coordinates vector by vector, and the node of each vector.

    Parameters
    ----------
    places : sequence of (n_rows, n_c) int32 arrays
        Per body the place of each coordinate of each row.
    kinds : sequence of ElementKind
        The element of each body.
    n_free : int
        Places from here on are fixed.

    Returns
    -------
    vectors : (n_vectors, 3) int32
        Places, -1 where there is none or it is fixed; slopes before positions.
    node : (n_vectors,) int32
        Numbers from 0 on; rows that share a position are of one node.
    """
    positions = [t[:, kind.columns("r")] for t, kind in zip(places, kinds, strict=True)]
    heads = np.concatenate([table[:, 0] for table in positions])
    number = np.zeros(max(int(table.max()) for table in places) + 1, dtype=np.int32)
    number[heads] = 1
    number = np.cumsum(number, dtype=np.int32) - np.int32(1)
    tables, nodes = list[NDArray[np.int32]](), list[NDArray[np.int32]]()
    for table, kind, position in zip(places, kinds, positions, strict=True):
        for name in kind.vectors[1:]:
            tables.append(_pad(table[:, kind.columns(name)]))
            nodes.append(number[position[:, 0]])
    _, first_of = np.unique(heads, return_index=True)
    tables.append(_pad(np.concatenate(positions)[first_of]))
    nodes.append(number[heads[first_of]])
    vectors, node = np.concatenate(tables), np.concatenate(nodes)
    vectors[vectors >= n_free] = -1
    some = (vectors >= 0).any(axis=1)
    return vectors[some], node[some]


def weigh_offsets(
    kind: ElementKind, row: NDArray[np.int32], offsets: Sequence[float]
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Return places (dim, p) and weights (p,) of a point of a rigid body or beside a node.

    Parameters
    ----------
    kind : ElementKind
        Its coordinates.
    row : (n_c,) int32 array
        Their places.
    offsets : sequence of float
        Coordinates of the point along r_x, r_y and r_z [m].
    """
    names = ("r", "r_x", "r_y", "r_z")[: len(offsets) + 1]
    places = np.stack([row[kind.columns(name)] for name in names], axis=1)
    return places, np.array([1.0, *offsets])


def weigh_ends(
    kind: ElementKind, ends: NDArray[np.int32], point: Point, weights: NDArray[np.float64]
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Return places (dim, p) and weights (p,) of a point inside an element.

    Parameters
    ----------
    kind : ElementKind
        Its coordinates.
    ends : (2, n_c) int32 array
        Their places at both of its nodes.
    point : Point
        The point, which may be beside the axis.
    weights : (k,) float array
        Of positions and slopes of both ends, see `kernels.hermite`.
    """
    each = [end[kind.columns(name)] for end in ends for name in kind.axis]
    for name, offset in zip(("r_y", "r_z"), point.offsets[1:], strict=False):
        each += [end[kind.columns(name)] for end in ends]
        weights = np.append(weights, [(1.0 - point.xi) * offset, point.xi * offset])
    return np.stack(each, axis=1), weights


def _pad(table: NDArray[np.int32]) -> NDArray[np.int32]:
    out = np.full((len(table), MAX_COMPONENTS), -1, dtype=np.int32)
    out[:, : table.shape[1]] = table
    return out
