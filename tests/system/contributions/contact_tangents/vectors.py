"""Operations on vectors, the last axis of arrays, that are analytic in their numbers."""

import numpy as np


def dot(a, b):
    """Sums of products over the last axis, without conjugates."""
    return (a * b).sum(axis=-1)


def norm(a):
    """Lengths over the last axis; their real parts are positive."""
    return np.sqrt(dot(a, a))


def without_normal(u, n):
    """Parts of vectors along the planes with the unit normals n."""
    return u - dot(u, n)[..., None] * n


def carried(u, n):
    """Vectors of other planes, projected on those with the normals n, with their lengths."""
    out = without_normal(u, n)
    size, kept = dot(out, out), dot(u, u)
    moves = np.abs(size - kept) > 1e-15 * np.abs(kept)
    ratio = np.sqrt(np.where(moves, kept, 1.0) / np.where(moves, size, 1.0))
    return np.where(moves, ratio, 1.0)[..., None] * out


def shortened(u, limit):
    """Vectors, those longer than a limit with that length."""
    square = dot(u, u)
    is_long = (square.real > limit.real**2) | (limit.real == 0.0)
    has_length = is_long & (square.real > 0.0)
    ratio = np.where(is_long, limit, 1.0) / np.sqrt(np.where(has_length, square, 1.0))
    return np.where(is_long, ratio, 1.0)[..., None] * u
