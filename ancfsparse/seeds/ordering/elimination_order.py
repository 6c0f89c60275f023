"""The order of elimination: least fill for coordinates, multipliers after what they hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled_module
from ancfsparse.seeds import ordering
from ancfsparse.seeds.interface.index_arrays import Indices, Triangle

# Orderings that are kept for matrices of the same pattern, such as those of a sweep or of pilots,
# and the most unknowns of such a matrix.
MOST, LARGEST = 8, 100_000
# Patterns of up to so many bytes are compared whole.
SMALL = 16_384
_KNOWN: dict[bytes, tuple[str, NDArray[np.int32]]] = {}


def cheapest(
    indptr: Indices, indices: Indices, n_positive: int
) -> tuple[str, NDArray[np.int32], Triangle]:
    """Return the name of the ordering with the least fill, the permutation, the upper triangle.

    Orderings of the last patterns are kept, so that runs of scenes of equal structure share them.

    A multiplier comes after the last coordinate that it holds: those of one node, which are coupled
    anyway.  Before them its pivot would be the regularization alone, over which the squares of the
    constraint's gradient would bury the stiffness: of a fine mesh of steel, all but six digits.

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
        upper = permuted(indptr, indices, permutation)
    if len(permutation) <= LARGEST:
        _KNOWN[key] = known  # the last one used is kept longest
        if len(_KNOWN) > MOST:
            del _KNOWN[next(iter(_KNOWN))]
    return name, permutation, upper


def _key(indptr: Indices, indices: Indices, n_positive: int) -> bytes:
    """Return what only equal patterns have in common: a small one whole, of others 128 bits."""
    parts = (
        f"{n_positive} {indptr.dtype} {indices.dtype} ".encode(),
        indptr.tobytes(),
        indices.tobytes(),
    )
    if sum(map(len, parts)) <= SMALL:
        return b"".join(parts)
    from hashlib import blake2b  # loads OpenSSL, which takes longer than to set up a small scene

    digest = blake2b(digest_size=16)
    for part in parts:
        digest.update(part)
    return digest.digest()


def _cheapest(
    indptr: Indices, indices: Indices, n_positive: int
) -> tuple[str, NDArray[np.int32], Triangle]:
    """Find the ordering of a matrix that is not known yet, see `cheapest`."""
    n = len(indptr) - 1
    if n_positive == n:
        return _of_coordinates(indptr, indices)
    column = np.repeat(np.arange(n), np.diff(indptr))
    inside = indices < n_positive
    starts = np.append(0, np.cumsum(np.bincount(column[inside], minlength=n_positive)))
    name, order_of_coordinates, _ = _of_coordinates(
        starts.astype(np.int64), indices[inside].astype(np.int32)
    )
    place = np.full(n, -1.0)
    place[order_of_coordinates] = np.arange(n_positive)
    holds = ~inside & (column < n_positive)
    np.maximum.at(place, indices[holds], place[column[holds]] + 0.5)
    permutation = np.argsort(place, kind="stable").astype(np.int32)
    return name, permutation, permuted(indptr, indices, permutation)


def _of_coordinates(indptr: Indices, indices: Indices) -> tuple[str, NDArray[np.int32], Triangle]:
    """Order a positive definite matrix.

    Where nothing fills in, as along a chain, the natural order is kept, or better taken from both
    ends by turns: the two fronts do not wait for each other.  Nested dissection (METIS) is best for
    nets, minimum degree (AMD) for trees and other sparse graphs; counting the fill of a bad order
    would take longer than all the rest, so it stops where the better one ended.
    """
    n = len(indptr) - 1
    tree = compiled_module("tree").elimination_tree
    no_fill = len(indices) - n
    natural = np.arange(n, dtype=np.int32)
    if tree(*permuted(indptr, indices, natural), no_fill) is not None:
        inwards = _from_both_ends(indptr, indices)
        for name, permutation in (("both ends", inwards), ("natural", natural)):
            upper = permuted(indptr, indices, permutation)
            if tree(*upper, no_fill) is not None:
                return name, permutation, upper
    best, most = None, np.iinfo(np.int64).max
    for method in ("metis", "amd"):
        permutation = ordering.order(indptr, indices, method)
        upper = permuted(indptr, indices, permutation)
        found = tree(*upper, most)
        if found is not None:
            best, most = (method, permutation, upper), int(found[1].sum()) - 1
    assert best is not None
    return best


def _from_both_ends(indptr: Indices, indices: Indices) -> NDArray[np.int32]:
    """Return the order that takes a supernode from the front and one from the back by turns."""
    n = len(indptr) - 1
    forwards = np.arange(n, dtype=np.int32)
    columns, turns = [], []
    for side, order_of_side in enumerate((forwards, forwards[::-1].copy())):
        half = (n + 1 - side) // 2
        tree = compiled_module("tree").elimination_tree(*permuted(indptr, indices, order_of_side))
        first = compiled_module("tree").supernodes(*tree)[0]
        width = np.diff(np.append(first[first < half], half))  # up to the middle
        columns.append(order_of_side[:half])
        turns.append(np.repeat(2 * np.arange(len(width), dtype=np.int32) + side, width))
    return np.concatenate(columns)[np.argsort(np.concatenate(turns), kind="stable")]


def permuted(indptr: Indices, indices: Indices, permutation: NDArray[np.int32]) -> Triangle:
    """Return the upper triangle of the permuted matrix by columns: starts and rows."""
    upper: Triangle = compiled_module("tree").permuted_upper(indptr, indices, permutation)
    return upper
