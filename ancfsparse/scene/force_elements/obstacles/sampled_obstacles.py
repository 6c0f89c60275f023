"""Obstacles by their surface: closed meshes of triangles, and heights on a grid."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_moderate, check_not_negative, check_reals, set_fields
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.force_elements import obstacles
from ancfsparse.scene.force_elements.obstacles.cores import Core
from ancfsparse.scene.force_elements.obstacles.obstacle import ROUNDING, Obstacle

MIN_VOLUME_RATIO = 1e-12  # of a mesh over the cube of its longest side: less is rounding
CELLS = 64  # of the default grid along the longest side of a mesh
# Of the grid around a surface.  An error decays by the factor 0.27 per cell in a cubic spline, and
# at the ends of the grid it is a tenth of a cell: 3e-6 of a cell at the surface, with six cells
# 4e-5.
MARGIN_CELLS = 8
REACH_CELLS = 5  # largest radius of bodies that can touch the surface
MAX_NODES = 2e7  # of a grid: 160 MB
# Facets per spacing of heights, used to compute distances: they are below the surface by 1/128 of
# the curvature times the square of the spacing, less than the errors of the grid.
PIECES = 4
MAX_GRID_LINES = 17  # in a picture, in each direction


class SampledObstacle(Obstacle):
    """An obstacle whose distance is sampled on a grid with the spacing `cell`."""

    radius = 0.0
    cell: float

    @property
    def core(self) -> Core:
        """The distances on a grid."""
        return _core_of(self)

    @property
    def reach(self) -> float:
        """Largest radius of a body that can touch it [m]."""
        return REACH_CELLS * self.cell

    @property
    def bend_radius(self) -> float:
        """Inverse of the largest sum of principal curvatures of its surface [m]."""
        return obstacles.smallest_bend(self.core)

    @property
    @abstractmethod
    def lines(self) -> Vector:
        """Ends of lines on its surface, (n, 2, dim) [m]."""

    @abstractmethod
    def sample(self) -> Core:
        """Return the distances on a grid."""

    def _axes(self, low: Vector, high: Vector) -> list[Vector]:
        """Return the coordinates of nodes around a surface between two corners."""
        low, high = low - MARGIN_CELLS * self.cell, high + MARGIN_CELLS * self.cell
        sizes = np.ceil((high - low) / self.cell - ROUNDING).astype(int) + 1
        if np.prod(sizes.astype(float)) > MAX_NODES:
            raise InputError(
                f"the grid of a {self.noun} would have {' x '.join(map(str, sizes))} nodes, more "
                f"than {MAX_NODES:g}: give it a cell larger than {self.cell:.6g} m"
            )
        return [start + self.cell * np.arange(n) for start, n in zip(low, sizes, strict=True)]


@lru_cache(maxsize=16)
def _core_of(obstacle: SampledObstacle) -> Core:
    return obstacle.sample()


@dataclass(frozen=True)
class TriangleMesh(SampledObstacle):
    """A body with a closed surface of triangles, in a spatial scene.

    Its distance is sampled on a grid and interpolated by cubic splines, which round edges by
    about a cell.

    Parameters
    ----------
    base : array_like, shape (3,)
        The origin of its vertices [m].
    vertices : array_like, shape (n, 3)
        Corners of triangles [m].
    triangles : array_like of int, shape (m, 3)
        Corners of each, counterclockwise seen from outside.
    cell : float, optional
        Spacing of the grid [m]; by default 1/64 of the longest side of the mesh.

    Raises
    ------
    InputError
        If the surface has a hole, different orientations or no volume, or is inside out, or the
        cell is larger than it.
    """

    base: tuple[float, ...]
    vertices: tuple[tuple[float, ...], ...]
    triangles: tuple[tuple[int, ...], ...]
    cell: float = 0.0
    noun = "mesh"

    def __post_init__(self) -> None:
        """Check the arguments."""
        super().__post_init__()
        if self.dim != 3:
            raise InputError("a mesh of triangles is in space: give its base 3 components")
        vertices = _table("vertices of a mesh", self.vertices, 3)
        corners = _table("triangles of a mesh", self.triangles, 3)
        if (
            np.any(corners != np.round(corners))
            or corners.min() < 0
            or corners.max() >= len(vertices)
        ):
            raise InputError(
                f"triangles of a mesh must be numbers of its {len(vertices)} vertices from 0 on, "
                f"got {format_value(self.triangles)}"
            )
        triangles = corners.astype(int)
        obstacles.check_closed(vertices, triangles)
        sides = vertices[triangles]
        volume = np.sum(np.cross(sides[:, 0], sides[:, 1]) * sides[:, 2]) / 6.0
        extent = float(np.ptp(vertices, axis=0).max())
        if abs(volume) <= MIN_VOLUME_RATIO * extent**3:
            raise InputError(
                f"a mesh of {extent:.6g} m has no volume, so it has no inside: give it a thickness"
            )
        if volume < 0.0:
            raise InputError(
                f"a mesh is inside out: its volume is {volume:.6g} m3; reverse the order of the "
                "vertices of all triangles"
            )
        cell = check_not_negative("cell of a mesh", self.cell, "m") or extent / CELLS
        cell = check_moderate("cell of a mesh", cell, "m")
        thickness = float(np.ptp(vertices, axis=0).min())
        if cell > thickness:
            raise InputError(
                f"a cell of {cell:.6g} m rounds off a mesh whose smallest side is {thickness:.6g} "
                "m: take a smaller one, such as a tenth of that"
            )
        set_fields(
            self,
            vertices=tuple(map(tuple, vertices.tolist())),
            triangles=tuple(map(tuple, triangles.tolist())),
            cell=cell,
        )

    @property
    def circumference(self) -> float:
        """Approximate length around the smallest section of the ellipsoid in its box [m]."""
        sides = np.sort(np.ptp(np.array(self.vertices), axis=0))
        return float(0.5 * math.pi * sides[:2].sum())

    @property
    def lines(self) -> Vector:
        """Ends of the edges of its triangles, (n, 2, 3) [m]."""
        triangles = np.array(self.triangles)
        pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        edges = np.unique(np.sort(pairs, axis=1), axis=0)
        return np.asarray(np.array(self.vertices)[edges] + np.array(self.base))

    def sample(self) -> Core:
        """Return the distances on a grid."""
        vertices, triangles = np.array(self.vertices), np.array(self.triangles)
        axes = self._axes(vertices.min(axis=0), vertices.max(axis=0))
        distances = obstacles.distances_to_surface(
            axes, vertices[triangles], MARGIN_CELLS * self.cell
        )
        inside = obstacles.winding_numbers(axes, vertices, triangles) > 0.5
        low = np.array([axis[0] for axis in axes])
        return obstacles.sampled_core(np.where(inside, -distances, distances), low, self.cell)


@dataclass(frozen=True)
class HeightField(SampledObstacle):
    """Ground below a surface given by heights along the last axis; in a planar scene a profile.

    Between the heights the surface is a cubic spline; it continues level for eight spacings
    beyond its edges.

    Parameters
    ----------
    base : array_like, shape (dim,)
        Position of the first point if its height were zero [m].
    heights : array_like, shape (n,) or (n, m)
        Heights at equal distances along x, or along x and y [m].
    spacing : float
        Distance between heights [m].
    """

    base: tuple[float, ...]
    heights: tuple[Any, ...]
    spacing: float
    noun = "height field"

    def __post_init__(self) -> None:
        """Check the arguments."""
        super().__post_init__()
        spacing = check_moderate("spacing of a height field", self.spacing, "m")
        needed = "a row of numbers" if self.dim == 2 else "a table of numbers"
        heights = check_reals("heights of a height field", self.heights, needed)
        if heights.ndim != self.dim - 1 or min(heights.shape) < 2 or not np.isfinite(heights).all():
            raise InputError(
                f"heights of a height field must be {needed}, at least two in each direction, got "
                f"{format_value(self.heights)}"
            )
        rows = heights.tolist()
        values = tuple(map(tuple, rows)) if self.dim == 3 else tuple(rows)
        set_fields(self, spacing=spacing, heights=values)

    @property
    def cell(self) -> float:  # type: ignore[override]
        """Spacing of the grid, equal to the one of the heights [m]."""
        return self.spacing

    @property
    def circumference(self) -> float:
        """Infinite, since the surface is open."""
        return math.inf

    @property
    def lines(self) -> Vector:
        """Ends of the lines along and across a grid of heights, (n, 2, dim) [m]."""
        points, dim = self._surface(1) + np.array(self.base), self.dim
        if dim == 3:
            rows = [np.linspace(0, n - 1, min(n, MAX_GRID_LINES)) for n in points.shape[:2]]
            points = points[np.ix_(*(np.rint(each).astype(int) for each in rows))]
        pairs = [np.stack([points[:-1], points[1:]], axis=-2).reshape(-1, 2, dim)]
        if dim == 3:
            pairs.append(np.stack([points[:, :-1], points[:, 1:]], axis=-2).reshape(-1, 2, dim))
        return np.concatenate(pairs)

    def _surface(self, pieces: int, margin: int = 0) -> Vector:
        """Return points of the surface, with some pieces per spacing, (..., dim) [m].

        It continues by a margin of spacings beyond its edges.
        """
        ends = [(-margin, n - 1 + margin) for n in np.shape(self.heights)]
        rows = [np.linspace(low, high, pieces * (high - low) + 1) for low, high in ends]
        where = np.stack(np.meshgrid(*rows, indexing="ij"), axis=-1)
        return np.concatenate([self.spacing * where, self._height(where)[..., None]], axis=-1)

    def _height(self, where: Vector) -> Vector:
        """Return heights at points (..., dim - 1), in spacings from the first one [m]."""
        heights = np.pad(self.heights, MARGIN_CELLS, mode="edge")
        nodes = np.moveaxis(where, -1, 0) + MARGIN_CELLS
        return obstacles.interpolate(obstacles.fit_spline(heights), nodes)

    def sample(self) -> Core:
        """Return the distances on a grid."""
        points = self._surface(PIECES, MARGIN_CELLS)
        flat = points.reshape(-1, self.dim)
        axes = self._axes(flat.min(axis=0), flat.max(axis=0))
        for c in range(self.dim - 1):
            axes[c] = axes[c][MARGIN_CELLS:-MARGIN_CELLS]
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
        distances = obstacles.distances_to_surface(axes, _strips(points), MARGIN_CELLS * self.cell)
        is_below = nodes[..., -1] < self._height(nodes[..., :-1] / self.spacing)
        low = np.array([axis[0] for axis in axes])
        return obstacles.sampled_core(np.where(is_below, -distances, distances), low, self.cell)


def _strips(points: Vector) -> Vector:
    """Return the triangles of a grid of points (n, m, 3), or the segments of a row (n, 2)."""
    if points.ndim == 2:
        return np.stack([points[:-1], points[1:], points[1:]], axis=1)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    pairs = [np.stack([a, b, c], axis=-2), np.stack([a, c, d], axis=-2)]
    return np.concatenate([each.reshape(-1, 3, 3) for each in pairs])


def _table(what: str, values: object, columns: int) -> Vector:
    """Return a table of finite numbers with some columns and at least four rows."""
    needed = f"a table of numbers with {columns} columns and at least 4 rows"
    table = check_reals(what, values, needed)
    if (
        table.ndim != 2
        or table.shape[1] != columns
        or len(table) < 4
        or not np.isfinite(table).all()
    ):
        raise InputError(f"{what} must be {needed}, got {format_value(values)}")
    return table
