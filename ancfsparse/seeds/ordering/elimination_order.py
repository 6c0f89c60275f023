"""Order of elimination: least fill-in for coordinates, multipliers after their coordinates."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Indices
from ancfsparse.dispatch import compiled_module
from ancfsparse.seeds import ordering
from ancfsparse.seeds.interface.index_arrays import Triangle

# Orderings are cached for matrices of the same pattern, as in sweeps and trial runs.
CACHE_SIZE = 8  # orderings
MAX_CACHED_UNKNOWNS = 100_000
MAX_KEY_BYTES = 16_384  # of a pattern that is compared itself; of larger ones a digest is
_KNOWN: dict[bytes, tuple[str, NDArray[np.int32]]] = {}


def cheapest(
    indptr: Indices, indices: Indices, n_positive: int
) -> tuple[str, NDArray[np.int32], Triangle]:
    """Return the name of the ordering with the least fill-in, the permutation, the upper triangle.

    Orderings of the last patterns are cached, so that runs of scenes of equal structure share them.

    A multiplier follows the last coordinate of its constraint: those of one node are coupled
    anyway.  Before them its pivot would be the regularization only, and the squares of the
    constraint gradient over it would cancel the stiffness: in a fine mesh of steel, all but six
    digits.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle of the matrix by columns, diagonal included.
    n_positive : int
        Number of coordinates among the unknowns, which come first.
    """
    key = _key(indptr, indices, n_positive)
    known = _KNOWN.pop(key, None)
    if known is None:
        name, permutation, upper = _cheapest(indptr, indices, n_positive)
        known = name, permutation.copy()
    else:
        name, permutation = known[0], known[1].copy()
        upper = permute_upper(indptr, indices, permutation)
    if len(permutation) <= MAX_CACHED_UNKNOWNS:
        _KNOWN[key] = known  # the least recently used one is first
        if len(_KNOWN) > CACHE_SIZE:
            del _KNOWN[next(iter(_KNOWN))]
    return name, permutation, upper


def _key(indptr: Indices, indices: Indices, n_positive: int) -> bytes:
    """Return the key of a pattern: a small pattern itself, or a digest of 128 bits."""
    parts = (
        f"{n_positive} {indptr.dtype} {indices.dtype} ".encode(),
        indptr.tobytes(),
        indices.tobytes(),
    )
    if sum(map(len, parts)) <= MAX_KEY_BYTES:
        return b"".join(parts)
    from hashlib import blake2b  # loads OpenSSL, which takes longer than setting up a small scene

    digest = blake2b(digest_size=16)
    for part in parts:
        digest.update(part)
    return digest.digest()


def order_briefly(
    indptr: Indices, indices: Indices, n_positive: int
) -> tuple[str, NDArray[np.int32], Triangle]:
    """Return as `cheapest` an order of minimum degree of groups of unknowns.

    It takes a tenth of the time, 1.5 in place of 16 ms for 1320 unknowns of 20 cables in a heap,
    and fills in up to 4 % more.
    """
    return _arrange(indptr, indices, n_positive, _order_groups)


def _cheapest(
    indptr: Indices, indices: Indices, n_positive: int
) -> tuple[str, NDArray[np.int32], Triangle]:
    """Return the ordering of a matrix that is not cached, see `cheapest`."""
    return _arrange(indptr, indices, n_positive, _order_coordinates)


def _order_groups(indptr: Indices, indices: Indices) -> tuple[str, NDArray[np.int32], Triangle]:
    """Return the ordering of a positive definite matrix, of consecutive unknowns alike together."""
    tree = compiled_module("tree")
    group = tree.alike(indptr, indices)
    n_groups = int(group[-1]) + 1
    meeting: Triangle = tree.contracted(indptr, indices, group, n_groups)
    order_of_groups = ordering.order(*meeting, "amd")
    upper = permute_upper(*meeting, order_of_groups)
    order_of_groups = order_of_groups[tree.postorder(*tree.elimination_tree(*upper))]
    rank = np.empty(n_groups, dtype=np.int32)
    rank[order_of_groups] = np.arange(n_groups, dtype=np.int32)
    permutation = np.argsort(rank[group], kind="stable").astype(np.int32)
    return "amd", permutation, permute_upper(indptr, indices, permutation)


def _arrange(
    indptr: Indices,
    indices: Indices,
    n_positive: int,
    order_coordinates: Callable[[Indices, Indices], tuple[str, NDArray[np.int32], Triangle]],
) -> tuple[str, NDArray[np.int32], Triangle]:
    """Order coordinates, and insert each multiplier after the last one of its constraint."""
    n = len(indptr) - 1
    if n_positive == n:
        return order_coordinates(indptr, indices)
    column = np.repeat(np.arange(n), np.diff(indptr))
    inside = indices < n_positive
    starts = np.append(0, np.cumsum(np.bincount(column[inside], minlength=n_positive)))
    name, order_of_coordinates, _ = order_coordinates(
        starts.astype(np.int64), indices[inside].astype(np.int32)
    )
    position = np.full(n, -1.0)
    position[order_of_coordinates] = np.arange(n_positive)
    constrains = ~inside & (column < n_positive)
    np.maximum.at(position, indices[constrains], position[column[constrains]] + 0.5)
    permutation = np.argsort(position, kind="stable").astype(np.int32)
    return name, permutation, permute_upper(indptr, indices, permutation)


def _order_coordinates(
    indptr: Indices, indices: Indices
) -> tuple[str, NDArray[np.int32], Triangle]:
    """Return the ordering of a positive definite matrix.

    Without fill-in, as along a chain, the natural order is used, preferably from both ends in turn:
    the two fronts do not wait for each other.  Nested dissection (METIS) is best for nets, minimum
    degree (AMD) for trees and other sparse graphs; the fill-in of a bad order is counted up to that
    of the better one only, since it would take longer than everything else.
    """
    n = len(indptr) - 1
    tree = compiled_module("tree").elimination_tree
    no_fill = len(indices) - n
    natural = np.arange(n, dtype=np.int32)
    if tree(*permute_upper(indptr, indices, natural), no_fill) is not None:
        inwards = _from_both_ends(indptr, indices)
        for name, permutation in (("both ends", inwards), ("natural", natural)):
            upper = permute_upper(indptr, indices, permutation)
            if tree(*upper, no_fill) is not None:
                return name, permutation, upper
    best, limit = None, np.iinfo(np.int64).max
    for method in ordering.METHODS:
        permutation = ordering.order(indptr, indices, method)
        counted = tree(*permute_upper(indptr, indices, permutation), limit)
        if counted is not None:
            best, limit = (method, permutation, counted), int(counted[1].sum()) - 1
    assert best is not None
    name, permutation, counted = best
    permutation = permutation[compiled_module("tree").postorder(*counted)]
    return name, permutation, permute_upper(indptr, indices, permutation)


def _from_both_ends(indptr: Indices, indices: Indices) -> NDArray[np.int32]:
    """Return the order that takes supernodes from the front and from the back in turn."""
    n = len(indptr) - 1
    forwards = np.arange(n, dtype=np.int32)
    columns, turns = [], []
    for side, order_of_side in enumerate((forwards, forwards[::-1].copy())):
        half = (n + 1 - side) // 2
        tree = compiled_module("tree").elimination_tree(
            *permute_upper(indptr, indices, order_of_side)
        )
        first = compiled_module("tree").supernodes(*tree)[0]
        width = np.diff(np.append(first[first < half], half))  # up to the middle
        columns.append(order_of_side[:half])
        turns.append(np.repeat(2 * np.arange(len(width), dtype=np.int32) + side, width))
    return np.concatenate(columns)[np.argsort(np.concatenate(turns), kind="stable")]


def permute_upper(indptr: Indices, indices: Indices, permutation: NDArray[np.int32]) -> Triangle:
    """Return the upper triangle of the permuted matrix by columns: starts and rows."""
    upper: Triangle = compiled_module("tree").permuted_upper(indptr, indices, permutation)
    return upper
