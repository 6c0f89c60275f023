"""Sides of axes: whether points pass through an obstacle, or curves through each other."""

import numpy as np

MOMENTS = 9  # within a step, between which curves pass through each other or not


def away(obstacle, vectors):
    """Return the parts of vectors away from the plane, axis or centre of an obstacle."""
    if getattr(obstacle, "normal", None) is not None:
        normal = np.array(obstacle.normal) / np.linalg.norm(obstacle.normal)
        return (vectors @ normal)[..., None]
    if getattr(obstacle, "axis", None) is not None:
        axis = np.array(obstacle.axis) / np.linalg.norm(obstacle.axis)
        return vectors - (vectors @ axis)[..., None] * axis
    return vectors


def passes_base(obstacle, vectors):
    """Return the first step in which a point passes to the other side, or None.

    That is the side behind a plane.  Of a round obstacle it is any that the straight way from one
    state to the next reaches through its inside, so one seen under more than a right angle.
    """
    d = away(obstacle, vectors)
    if d.shape[-1] == 1:
        behind = (d[..., 0] < 0.0).any(axis=1)
        return int(np.argmax(behind)) if behind.any() else None
    begin, moved = d[:-1], np.diff(d, axis=0)
    square = np.maximum((moved**2).sum(axis=-1), np.finfo(float).tiny)
    nearest = np.clip(-(begin * moved).sum(axis=-1) / square, 0.0, 1.0)
    least = np.linalg.norm(begin + nearest[..., None] * moved, axis=-1)
    passes = (least < obstacle.radius) & ((begin * d[1:]).sum(axis=-1) < 0.0)
    steps = passes.any(axis=1)
    return 1 + int(np.argmax(steps)) if steps.any() else None


def passes_between(one, other):
    """Return the first step in which two polygons pass through each other, or None.

    Vertices (k, n, 3) move straight from state to state.  Two segments pass through each other
    where the volume that they span changes its sign while their lines cross inside both.
    """
    for k in range(len(one) - 1):
        rows = slice(k, k + 2)
        first, second = near(one[rows], other[rows])
        if len(first) and meet(one[rows], other[rows], first, second):
            return k + 1
    return None


def near(one, other):
    """Return the pairs of segments whose boxes over a step overlap."""

    def boxes(points):
        ends = np.stack([points[:, :-1], points[:, 1:]])
        return ends.min(axis=(0, 1)), ends.max(axis=(0, 1))

    (low, high), (least, most) = boxes(one), boxes(other)
    overlap = (low[:, None] <= most[None]) & (least[None] <= high[:, None])
    return np.nonzero(overlap.all(axis=-1))


def meet(one, other, first, second):
    """Return True if one of the pairs of segments meets within a step."""
    s = np.linspace(0.0, 1.0, MOMENTS)[:, None, None]

    def at(points, vertices):
        return (1.0 - s) * points[0, vertices] + s * points[1, vertices]

    a, b = at(one, first), at(one, first + 1) - at(one, first)
    c, d = at(other, second), at(other, second + 1) - at(other, second)
    normal = np.cross(b, d)
    volume = ((c - a) * normal).sum(axis=-1)
    square = np.maximum((normal**2).sum(axis=-1), np.finfo(float).tiny)
    along = (np.cross(c - a, d) * normal).sum(axis=-1) / square
    across = (np.cross(c - a, b) * normal).sum(axis=-1) / square
    change = volume[1:] * volume[:-1] < 0.0
    share = np.where(change, volume[:-1] / np.where(change, volume[:-1] - volume[1:], 1.0), 0.0)

    def is_inside(places):
        then = (1.0 - share) * places[:-1] + share * places[1:]
        return (then >= 0.0) & (then <= 1.0)

    return bool((change & is_inside(along) & is_inside(across)).any())
