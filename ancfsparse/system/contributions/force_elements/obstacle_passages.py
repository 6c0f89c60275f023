"""Straight motions of points that do not enter an obstacle."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ancfsparse.array_types import Integers, Vector
from ancfsparse.system.contributions.point_weights import PointSums

# Penetration of a point over its radius.  An axis inside can leave a round obstacle on any side.
MAX_DEPTH_RATIO = 0.9
# Smallest distance between positions with evaluated depths, over the radius.  Between two of them
# a depth is larger by half of it at most, so the axis is still outside.
MIN_STRIDE_RATIO = 1.0 / 16.0


def remain_outside(
    depths: Callable[[Vector], Vector],
    q0: Vector,
    q1: Vector,
    lengths: Vector,
    radii: Vector,
    limits: Vector,
) -> bool:
    """Return whether no point goes too deep in the straight motion between two states.

    A depth changes by no more than the distance that its point moves, so depths are evaluated again
    where one of them could have become too large.

    Parameters
    ----------
    depths : callable
        Returns the penetrations of the points in a state, negative for gaps, (n,) [m].
    q0, q1 : (n_all,) float
        Both states; a point may stay as deep as in the first one.
    lengths : (n,) float
        Upper bounds of the distances that the points move relative to the obstacle [m].
    radii : (n,) float
        Distances of the surface of the body from the points [m].
    limits : (n,) float
        Largest penetrations [m].
    """
    moves = lengths > 0.0
    if not moves.any():
        return True
    depth = depths(q0)
    allowed = np.maximum(depth, limits)
    part = 0.0
    while True:
        stride = np.maximum(allowed - depth, MIN_STRIDE_RATIO * radii)[moves]
        part += float(np.min(stride / lengths[moves]))
        if part >= 1.0:
            return bool(np.all(depths(q1) <= allowed))
        depth = depths(q0 + part * (q1 - q0))
        if (depth > allowed).any():
            return False


def path_lengths(points: PointSums, turning: Integers, q0: Vector, q1: Vector) -> Vector:
    """Return upper bounds of the distances that points move relative to an obstacle, (n,) [m].

    Parameters
    ----------
    points : PointSums
        The points, relative to the base of the obstacle if that moves.
    turning : (m,) int32
        Of their coordinates, i + 1 for the vector i of the body of the obstacle.
    q0, q1 : (n_all,) float
        States between which all coordinates change in proportion.
    """
    begin, end = (
        np.add.reduceat(points.weight * q[points.place], points.start[:-1], axis=1)
        for q in (q0, q1)
    )
    lengths = np.asarray(np.linalg.norm(end - begin, axis=0))
    columns = [np.flatnonzero(turning == i)[0] for i in range(1, 1 + int(turning.max(initial=0)))]
    if columns:
        vectors = points.place[:, columns]
        arms = np.maximum(np.linalg.norm(begin, axis=0), np.linalg.norm(end, axis=0))
        lengths += float(np.linalg.norm(q1[vectors] - q0[vectors])) * arms
    return lengths
