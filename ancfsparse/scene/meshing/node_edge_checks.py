"""Checks of the arrays of nodes and edges."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.array_types import Integers, Vector
from ancfsparse.checks import check_reals, is_masked
from ancfsparse.errors import InputError
from ancfsparse.scene.geometry.positions import MAX_COORDINATE, place

COINCIDENCE_RATIO = 1e-9  # distance of coincident nodes, over the size of the mesh
EPSILON = float(np.finfo(np.float64).eps)


def check_graph(
    label: str, dim: int, nodes: ArrayLike, edges: ArrayLike
) -> tuple[Vector, Integers, Vector]:
    """Check the `nodes` and `edges` of `Scene.add_mesh`.

    The message of an error names the first offender and their number.

    Returns
    -------
    positions : ndarray, shape (n, dim)
        A copy [m].
    edges : ndarray, shape (m, 2)
        A copy, int32.
    lengths : ndarray, shape (m,)
        Lengths of the edges [m].
    """
    positions = _positions(label, dim, nodes)
    pairs = _pairs(label, edges)
    n = len(positions)
    _refuse(
        ((pairs < 0) | (pairs >= n)).any(axis=1),
        lambda k, number: (
            f"{label} names nodes that do not exist in {number}, first in edge {k}, "
            f"{_pair(pairs[k])}: its nodes are 0 to {n - 1}"
        ),
        "edge",
    )
    ends = pairs.astype(np.int32)
    size = float(np.linalg.norm(np.ptp(positions, axis=0)))
    lengths = np.linalg.norm(positions[ends[:, 1]] - positions[ends[:, 0]], axis=1)
    _refuse(
        lengths <= COINCIDENCE_RATIO * size,
        lambda k, number: (
            f"{label} has {number} of zero length, first edge {k}, {_pair(ends[k])}: "
            "leave it out or move one of its nodes"
        ),
        "edge",
    )
    _check_coincidence(label, positions, COINCIDENCE_RATIO * size)
    _refuse(
        np.bincount(ends.ravel(), minlength=n) == 0,
        lambda k, number: (
            f"{label} has {number} that no edge ends at, first node {k} at "
            f"{place(positions[k])}: leave it out or connect it"
        ),
        "node",
    )
    low, high = ends.min(axis=1), ends.max(axis=1)
    keys = low.astype(np.int64) * n + high
    order = np.argsort(keys, kind="stable")
    is_repeated = np.zeros(len(ends), dtype=bool)
    is_repeated[order[1:]] = keys[order[1:]] == keys[order[:-1]]
    _refuse(
        is_repeated,
        lambda k, number: (
            f"{label} has {number} given before, first edge {k}, {_pair(ends[k])}, which "
            f"joins the nodes of edge {int(np.argmax(keys == keys[k]))}: leave it out"
        ),
        "edge",
    )
    return (
        positions,
        ends,
        _with_equal_lengths(lengths, 16.0 * EPSILON * float(np.abs(positions).max())),
    )


def _with_equal_lengths(lengths: Vector, tolerance: float) -> Vector:
    """Return lengths, equal where they differ by rounding only, so that kernels share data.

    Sorted lengths whose gaps and range are at most `tolerance` [m] are replaced by their mean.
    """
    order = np.argsort(lengths, kind="stable")
    sorted_lengths = lengths[order]
    starts = np.flatnonzero(np.diff(sorted_lengths, prepend=-np.inf) > tolerance)
    stops = np.append(starts[1:], len(lengths))
    narrow = sorted_lengths[stops - 1] - sorted_lengths[starts] <= tolerance
    sizes = stops - starts
    median = sorted_lengths[(starts + stops) // 2]
    # The mean relative to the median, so that equal lengths are not rounded.
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
        lambda k, number: (
            f"{label} has {number} whose position is not finite, first node {k}: "
            f"{place(positions[k])}"
        ),
        "node",
    )
    _refuse(
        (np.abs(positions) > MAX_COORDINATE).any(axis=1),
        lambda k, number: (
            f"{label} has {number} beyond {MAX_COORDINATE:g} m, first node {k} at "
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


def _check_coincidence(label: str, positions: Vector, tolerance: float) -> None:
    """Refuse coincident nodes, which are neighbours when sorted along a skew direction."""
    skew = np.array([1.0, 0.7548776662466927, 0.5698402909980532])[: positions.shape[1]]
    along = positions @ skew
    order = np.argsort(along, kind="stable")
    first, step = np.arange(len(order)), 1
    while True:
        first = first[first + step < len(order)]
        one, other = order[first], order[first + step]
        near = along[other] - along[one] <= 2.0 * tolerance
        first, one, other = first[near], one[near], other[near]
        if not len(first):
            return
        same = np.linalg.norm(positions[one] - positions[other], axis=1) <= tolerance
        if same.any():
            later = np.maximum(one, other)[same]
            k = int(np.argmin(later))
            before = int(np.minimum(one, other)[same][k])
            raise InputError(
                f"{label} has {_count(len(np.unique(later)), 'node')} where another is already, "
                f"first node {later[k]}, at the place of node {before}, "
                f"{place(positions[before])}: give each place one node"
            )
        step += 1


def _refuse(invalid: Any, message: Any, what: str) -> None:
    """Raise an error with the first offender and their number, if there are any."""
    count = int(np.count_nonzero(invalid))
    if count:
        raise InputError(message(int(np.argmax(invalid)), _count(count, what)))


def _count(count: int, what: str) -> str:
    return f"{count} {what}" + ("" if count == 1 else "s")


def _pair(nodes: Any) -> str:
    return f"({int(nodes[0])}, {int(nodes[1])})"
