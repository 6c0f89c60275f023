"""Coordinates as nodal vectors: positions of nodes and slopes of rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.scene import Point

MAX_COMPONENTS = 3  # of a vector; others are padded


def vectors_of(
    places: Sequence[NDArray[np.int32]], kinds: Sequence[ElementKind], n_free: int
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return the free coordinates by vectors, and the node of each vector.

    Parameters
    ----------
    places : sequence of (n_rows, n_c) int32 arrays
        Indices of the coordinates of each row, per body.
    kinds : sequence of ElementKind
        The element of each body.
    n_free : int
        Number of free coordinates, which come first.

    Returns
    -------
    vectors : (n_vectors, 3) int32
        Indices, -1 for padding and fixed coordinates; slopes before positions.
    node : (n_vectors,) int32
        Numbers of the nodes; rows with a common position belong to one node.
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
    has_free = (vectors >= 0).any(axis=1)
    return vectors[has_free], node[has_free]


def weigh_offsets(
    kind: ElementKind, row: NDArray[np.int32], offsets: Sequence[float]
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Return indices (dim, p) and weights (p,) of a point with offsets from a node.

    Parameters
    ----------
    kind : ElementKind
        The element type.
    row : (n_c,) int32 array
        Their indices.
    offsets : sequence of float
        Coordinates of the point along r_x, r_y and r_z [m].
    """
    names = ("r", "r_x", "r_y", "r_z")[: len(offsets) + 1]
    places = np.stack([row[kind.columns(name)] for name in names], axis=1)
    return places, np.array([1.0, *offsets])


def weigh_ends(
    kind: ElementKind, ends: NDArray[np.int32], point: Point, weights: NDArray[np.float64]
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Return indices (dim, p) and weights (p,) of a point inside an element.

    Parameters
    ----------
    kind : ElementKind
        The element type.
    ends : (2, n_c) int32 array
        Indices of the coordinates of both nodes.
    point : Point
        The point, which may have an offset from the axis.
    weights : (k,) float array
        Weights of positions and slopes of both ends, see `kernels.hermite`.
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
