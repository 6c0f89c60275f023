"""Cores of obstacles; an obstacle is the set of points within a radius of its core."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.scene.force_elements import obstacles

ROUNDING = 1e-12  # of components of unit vectors [-]


@dataclass(frozen=True, eq=False)
class Core:
    """A block, a circle about the first axis of a frame, or distances sampled on a grid.

    In the plane the circle is about the origin.

    Attributes
    ----------
    axes : ndarray, shape (dim, dim)
        Axes of the frame as rows, orthonormal.
    bounds : ndarray, shape (2, dim)
        Lowest and highest coordinates of the block in the frame [m], which can be equal or
        infinite; with a grid, the ones of its inner nodes.
    ring : float
        Radius of the circle [m]; zero for a block or a grid.
    coefficients : ndarray, shape (n,) * dim, or None
        Coefficients of cubic B-splines for the distance [m].
    cell : float
        Spacing of the grid [m].
    """

    axes: Vector
    bounds: Vector
    ring: float = 0.0
    coefficients: Vector | None = None
    cell: float = 0.0

    def distances(self, arms: Vector) -> Vector:
        """Return the distances of points at vectors (k, dim) from the origin of the frame [m].

        Within a block they are minus the depth below its nearest face.
        """
        y = arms @ self.axes.T
        if self.coefficients is not None:
            nearest = np.clip(y, *self.bounds)
            nodes = (nearest - self.bounds[0]).T / self.cell + 1.0
            inside = obstacles.interpolate(self.coefficients, nodes)
            return np.asarray(inside + np.linalg.norm(y - nearest, axis=1))
        if self.ring:
            across = np.hypot(y[:, -2], y[:, -1]) - self.ring
            return np.asarray(np.hypot(across, y[:, 0] if y.shape[1] == 3 else 0.0))
        low, high = y - self.bounds[0], self.bounds[1] - y
        outside = np.linalg.norm(np.minimum(np.minimum(low, high), 0.0), axis=1)
        depth = np.minimum(low, high).min(axis=1)
        return np.asarray(np.where(outside > 0.0, outside, -np.maximum(depth, 0.0)))

    def extents(self, axes: Vector) -> Vector:
        """Return the lowest and highest coordinates along other axes (k, dim), (2, k) [m]."""
        turn = axes @ self.axes.T
        if self.ring:
            highest = self.ring * np.linalg.norm(turn[:, -2:], axis=1)
            return np.stack([-highest, highest])
        turn[np.abs(turn) < ROUNDING] = 0.0
        ends = np.zeros((2, *turn.shape))
        np.multiply(turn, self.bounds[:, None], out=ends, where=turn != 0.0)  # some are infinite
        return np.stack([ends.min(axis=0).sum(axis=1), ends.max(axis=0).sum(axis=1)])

    def has_surface_of(self, other: Core, tolerance: float) -> bool:
        """Return whether both have no grid, or grids of equal distances, within a tolerance [m].

        Only nodes within a cell of the surface are compared: rounding decides which ones are too
        far from it for an exact distance.
        """
        one, another = self.coefficients, other.coefficients
        if one is None or another is None or one.shape != another.shape:
            return one is another
        nodes = np.indices(one.shape, dtype=float)
        distances = np.stack([obstacles.interpolate(each, nodes) for each in (one, another)])
        is_near = np.abs(distances).min(axis=0) < self.cell
        return bool(np.ptp(distances, axis=0)[is_near].max(initial=0.0) < tolerance)


def axes_along(direction: Vector) -> Vector:
    """Return orthonormal axes as rows, (dim, dim), the first along a direction; right-handed."""
    first = direction / np.linalg.norm(direction)
    if len(first) == 2:
        return np.array([first, [-first[1], first[0]]])
    second = np.eye(3)[np.argmin(np.abs(first))]
    second = second - second @ first * first
    second = second / np.linalg.norm(second)
    return np.stack([first, second, np.cross(first, second)])
