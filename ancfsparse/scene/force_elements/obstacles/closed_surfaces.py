"""The check that triangles form a closed surface with one orientation."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Indices, Vector
from ancfsparse.errors import InputError
from ancfsparse.messages import format_numbers


def check_closed(vertices: Vector, triangles: Indices) -> None:
    """Refuse a surface unless each edge belongs to two triangles, in opposite directions."""
    owners = np.tile(np.arange(len(triangles)), 3)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    has_no_length = edges[:, 0] == edges[:, 1]
    if has_no_length.any():
        raise InputError(
            f"{_describe(owners[np.argmax(has_no_length)], triangles)} of a mesh has one vertex "
            "twice: leave it out"
        )
    ends, edge, counts = np.unique(
        np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    single = np.flatnonzero(counts == 1)
    if len(single):
        raise InputError(
            f"a mesh has a hole: {len(single)} of its edges belong to one triangle, the first "
            f"{_span(vertices[ends[single[0]]])}; close it, with common vertices"
        )
    if counts.max() > 2:
        raise InputError(
            "more than two triangles of a mesh meet at the edge "
            f"{_span(vertices[ends[np.argmax(counts)]])}: give each body a mesh"
        )
    rows = np.argsort(edge.ravel(), kind="stable").reshape(-1, 2)
    tails = edges[rows, 0]
    _check_orientation(triangles, owners[rows], tails[:, 0] == tails[:, 1])


def _check_orientation(triangles: Indices, pairs: Indices, differ: Indices) -> None:
    """Refuse pairs (k, 2) of triangles at one edge whose orientations differ, (k,) bool.

    Of the first pair the triangle in the larger part with one orientation is right.
    """
    if not differ.any():
        return
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    n, alike = len(triangles), pairs[~differ]
    graph = coo_array((np.ones(len(alike)), alike.T), shape=(n, n))
    part = connected_components(graph, directed=False)[1]
    size = np.bincount(part)[part]
    k = np.argmax(np.where(differ, size[pairs].max(axis=1), 0))
    right, wrong = pairs[k][np.argsort(-size[pairs[k]], kind="stable")]
    raise InputError(
        f"{_describe(wrong, triangles)} of a mesh has another orientation than its neighbour, "
        f"{_describe(right, triangles)}: reverse the order of its vertices"
    )


def _describe(number: int, triangles: Indices) -> str:
    return f"triangle {number} {tuple(triangles[number].tolist())}"


def _span(ends: Vector) -> str:
    return f"from {format_numbers(ends[0])} m to {format_numbers(ends[1])} m"
