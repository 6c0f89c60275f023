"""Nodes and edges as arrays: everything that can be wrong with them, one sentence each."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import check_reals, is_masked
from ancfsparse.errors import InputError
from ancfsparse.scene.bodies.body import Numbers, Vector
from ancfsparse.scene.geometry.positions import MAX_COORDINATE, place

# Nodes closer than this share of the whole mesh are at one place.
COINCIDENCE_RATIO = 1e-9
EPSILON = float(np.finfo(np.float64).eps)


def checked_graph(
    label: str, dim: int, nodes: ArrayLike, edges: ArrayLike
) -> tuple[Vector, Numbers, Vector]:
    """Check the arrays of a mesh.

    Parameters
    ----------
    label : str
        Name of the mesh, for messages.
    dim : int
        Dimension of the scene.
    nodes : array_like, shape (n, dim)
        Positions [m].
    edges : array_like, shape (m, 2)
        Numbers of the nodes at the ends of each edge.

    Returns
    -------
    positions : ndarray, shape (n, dim)
        A copy [m].
    edges : ndarray, shape (m, 2)
        A copy, int32.
    lengths : ndarray, shape (m,)
        Lengths of the edges [m].

    Raises
    ------
    InputError
        With the first offender and how many there are.
    """
    positions = _positions(label, dim, nodes)
    pairs = _pairs(label, edges)
    n = len(positions)
    _refuse(
        ((pairs < 0) | (pairs >= n)).any(axis=1),
        lambda k, some: (
            f"{label} names nodes that do not exist in {some}, first in edge {k}, "
            f"{_pair(pairs[k])}: its nodes are 0 to {n - 1}"
        ),
        "edge",
    )
    ends = pairs.astype(np.int32)
    size = float(np.linalg.norm(np.ptp(positions, axis=0)))
    lengths = np.linalg.norm(positions[ends[:, 1]] - positions[ends[:, 0]], axis=1)
    _refuse(
        lengths <= COINCIDENCE_RATIO * size,
        lambda k, some: (
            f"{label} has {some} of zero length, first edge {k}, {_pair(ends[k])}: "
            "leave it out or move one of its nodes"
        ),
        "edge",
    )
    _check_apart(label, positions, COINCIDENCE_RATIO * size)
    _refuse(
        np.bincount(ends.ravel(), minlength=n) == 0,
        lambda k, some: (
            f"{label} has {some} that no edge ends at, first node {k} at "
            f"{place(positions[k])}: leave it out or connect it"
        ),
        "node",
    )
    low, high = ends.min(axis=1), ends.max(axis=1)
    keys = low.astype(np.int64) * n + high
    order = np.argsort(keys, kind="stable")
    again = np.zeros(len(ends), dtype=bool)
    again[order[1:]] = keys[order[1:]] == keys[order[:-1]]
    _refuse(
        again,
        lambda k, some: (
            f"{label} has {some} given before, first edge {k}, {_pair(ends[k])}, which "
            f"joins the nodes of edge {int(np.argmax(keys == keys[k]))}: leave it out"
        ),
        "edge",
    )
    return positions, ends, _evened(lengths, 16.0 * EPSILON * float(np.abs(positions).max()))


def _evened(lengths: Vector, reach: float) -> Vector:
    """Make lengths equal that differ by the rounding of positions only, so that kernels share data.

    A run of sorted lengths with gaps and span within reach becomes its mean.
    """
    order = np.argsort(lengths, kind="stable")
    sorted_lengths = lengths[order]
    starts = np.flatnonzero(np.diff(sorted_lengths, prepend=-np.inf) > reach)
    stops = np.append(starts[1:], len(lengths))
    narrow = sorted_lengths[stops - 1] - sorted_lengths[starts] <= reach
    sizes = stops - starts
    median = sorted_lengths[(starts + stops) // 2]
    # Their mean, summed from the median on so that it does not round.
    mean = median + np.add.reduceat(sorted_lengths - np.repeat(median, sizes), starts) / sizes
    even = lengths.copy()
    even[order] = np.where(np.repeat(narrow, sizes), np.repeat(mean, sizes), sorted_lengths)
    even.flags.writeable = False
    return even


def _positions(label: str, dim: int, nodes: ArrayLike) -> Vector:
    positions = check_reals(
        f"nodes of {label}", nodes, f"a table of real numbers with {dim} columns"
    )
    if positions.ndim != 2 or positions.shape[1] != dim or len(positions) < 2:
        kind = "planar" if dim == 2 else "spatial"
        raise InputError(
            f"nodes of {label} must have shape (n, {dim}) with at least 2 rows, because the scene "
            f"is {kind}, got shape {positions.shape}"
        )
    _refuse(
        ~np.isfinite(positions).all(axis=1),
        lambda k, some: (
            f"{label} has {some} whose position is not finite, first node {k}: "
            f"{place(positions[k])}"
        ),
        "node",
    )
    _refuse(
        (np.abs(positions) > MAX_COORDINATE).any(axis=1),
        lambda k, some: (
            f"{label} has {some} beyond {MAX_COORDINATE:g} m, first node {k} at "
            f"{place(positions[k])}: give positions in metres"
        ),
        "node",
    )
    return positions


def _pairs(label: str, edges: ArrayLike) -> NDArray[np.integer[Any]]:
    try:
        pairs = np.asarray(edges)
    except ValueError:
        raise InputError(f"edges of {label} must be pairs of node numbers: rows differ") from None
    if is_masked(edges):
        raise InputError(f"edges of {label} have masked entries: leave those edges out")
    if pairs.ndim != 2 or pairs.shape[1] != 2 or len(pairs) == 0:
        raise InputError(
            f"edges of {label} must have shape (m, 2) with at least one row, got shape "
            f"{pairs.shape}"
        )
    if not np.issubdtype(pairs.dtype, np.integer):
        raise InputError(
            f"edges of {label} must be numbers of nodes, that is integers, got {pairs.dtype}"
        )
    return pairs


def _check_apart(label: str, positions: Vector, reach: float) -> None:
    """Refuse nodes at one place.

    Along a skew direction such nodes stand next to each other, or nearly so.
    """
    skew = np.array([1.0, 0.7548776662466927, 0.5698402909980532])[: positions.shape[1]]
    along = positions @ skew
    order = np.argsort(along, kind="stable")
    first, step = np.arange(len(order)), 1
    while True:
        first = first[first + step < len(order)]
        one, other = order[first], order[first + step]
        near = along[other] - along[one] <= 2.0 * reach
        first, one, other = first[near], one[near], other[near]
        if not len(first):
            return
        same = np.linalg.norm(positions[one] - positions[other], axis=1) <= reach
        if same.any():
            later = np.maximum(one, other)[same]
            k = int(np.argmin(later))
            before = int(np.minimum(one, other)[same][k])
            raise InputError(
                f"{label} has {_some(len(np.unique(later)), 'node')} where another is already, "
                f"first node {later[k]}, at the place of node {before}, "
                f"{place(positions[before])}: give each place one node"
            )
        step += 1


def _refuse(wrong: Any, sentence: Any, what: str) -> None:
    """Raise with the first offender and how many there are, if there are any."""
    count = int(np.count_nonzero(wrong))
    if count:
        raise InputError(sentence(int(np.argmax(wrong)), _some(count, what)))


def _some(count: int, what: str) -> str:
    return f"{count} {what}" + ("" if count == 1 else "s")


def _pair(nodes: Any) -> str:
    return f"({int(nodes[0])}, {int(nodes[1])})"
