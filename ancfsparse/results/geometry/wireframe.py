"""Wireframes and surfaces of rigid bodies."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.results.geometry.body_outlines import RigidOutline

Links = NDArray[np.int64]
Shape = tuple[Vector, Sequence[tuple[int, ...]], Sequence[tuple[int, ...]]]

CIRCLE_POINTS = 32  # points on a circle, a multiple of 4
MERIDIAN_PIECES = 16  # pieces of a meridian, an even number
MAX_ARM_RATIO = 0.25  # length of the arms of a body without shape, over its farthest joint


class Wireframe(NamedTuple):
    """Points, edges and facets of a rigid body.

    Attributes
    ----------
    weights : ndarray, shape (p, n_vectors + 1)
        Weights of its origin [-] and its vectors [m] in every point.
    edges : ndarray of int, shape (e, 2)
        End points of lines.
    facets : ndarray of int, shape (f, 3)
        Points of triangles; none for a body without surface.
    """

    weights: Vector
    edges: Links
    facets: Links


def make_wireframe(solid: RigidOutline) -> Wireframe:
    """Return the wireframe of a rigid body."""
    points, edges, facets = _shape(solid)
    weights = np.column_stack([np.ones(len(points)), points])
    return Wireframe(weights, np.array(edges).reshape(-1, 2), np.array(facets, int).reshape(-1, 3))


def trace_points(q: Vector, solid: RigidOutline, drawn: Wireframe) -> Vector:
    """Return the points of a wireframe (j, p, dim) [m] from coordinates (j, n), or velocities."""
    vectors = np.asarray(q[..., solid.places])
    return np.asarray(np.einsum("pk,jkd->jpd", drawn.weights, vectors))


def trace_edges(q: Vector, solid: RigidOutline) -> Vector:
    """Return the ends of the edges of a rigid body, (j, e, 2, dim), as `trace_points` does."""
    drawn = make_wireframe(solid)
    return np.asarray(trace_points(q, solid, drawn)[:, drawn.edges])


def _shape(solid: RigidOutline) -> Shape:
    """Return points in the frame of the body, edges and facets."""
    reach, form, n = solid.reach, solid.form, solid.points.shape[1]
    if form == "inertia":
        return _star(solid)
    if form == "lines":
        return solid.points, [(k, k + 1) for k in range(0, len(solid.points), 2)], []
    if n == 3 and form.startswith("cylinder"):
        parts = _cylinder(reach, "xyz".index(form[-1]))
    elif n == 3 and form == "sphere":
        parts = _sphere(reach[0])
    elif form in ("sphere", "cylinder z"):
        parts = _disc(reach[0])
    elif form == "rod":
        parts = np.outer([-reach[0], reach[0]], np.eye(n)[0]), [(0, 1)], []
    else:
        parts = _box(reach[:n])
    points, edges, facets = parts
    return points + solid.points[0], edges, facets


def _star(solid: RigidOutline) -> Shape:
    """Return lines from the centre to the joints, and along the axes in both directions.

    Light bodies with a large inertia would cover a mechanism, so these arms are limited to a
    quarter of the distance to the farthest joint.
    """
    centre = solid.points[0]
    farthest = float(np.max(np.linalg.norm(solid.points - centre, axis=1)))
    reach = solid.reach[: len(centre)]
    arms = np.diag(np.minimum(reach, MAX_ARM_RATIO * farthest) if farthest else reach)
    points = np.concatenate([solid.points, centre + arms, centre - arms])
    return points, [(0, k) for k in range(1, len(points))], []


def _box(reach: Vector) -> Shape:
    """Return a box, in the plane a rectangle."""
    corners = np.array(list(product((-1.0, 1.0), repeat=len(reach))))
    pairs = [(i, j) for j in range(len(corners)) for i in range(j)]
    edges = [(i, j) for i, j in pairs if (corners[i] != corners[j]).sum() == 1]
    if len(reach) == 2:
        return corners * reach, edges, [(0, 2, 3), (0, 3, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners * reach, edges, [(a, *two) for a, *b in quads for two in pairwise(b)]


def _circle() -> Vector:
    """Return points of the unit circle, (n, 2)."""
    angles = np.linspace(0.0, 2.0 * np.pi, CIRCLE_POINTS, endpoint=False)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _ring(first: int) -> list[tuple[int, int]]:
    """Return the edges between points of a circle."""
    return [(first + k, first + (k + 1) % CIRCLE_POINTS) for k in range(CIRCLE_POINTS)]


def _disc(radius: float) -> Shape:
    """Return a disc in the plane with a radius that shows its rotation."""
    points = np.concatenate([radius * _circle(), np.zeros((1, 2))])
    return points, [*_ring(0), (CIRCLE_POINTS, 0)], [(CIRCLE_POINTS, *pair) for pair in _ring(0)]


def _cylinder(reach: Vector, axis: int) -> Shape:
    """Return a cylinder: two circles, four axial lines, and a radius on each end."""
    aside, up = (axis + 1) % 3, (axis + 2) % 3
    one = np.zeros((CIRCLE_POINTS + 1, 3))
    one[:CIRCLE_POINTS, [aside, up]] = reach[aside] * _circle()
    along = reach[axis] * np.eye(3)[axis]
    # Points of one end and its centre, then of the other.
    n = CIRCLE_POINTS + 1
    low, high = _ring(0), _ring(n)
    edges = [*low, *high, (CIRCLE_POINTS, 0), (n + CIRCLE_POINTS, n)]
    edges += [(k, n + k) for k in range(0, CIRCLE_POINTS, CIRCLE_POINTS // 4)]
    facets = [(CIRCLE_POINTS, b, a) for a, b in low] + [(n + CIRCLE_POINTS, a, b) for a, b in high]
    for (a, b), (c, d) in zip(low, high, strict=True):
        facets += [(a, b, d), (a, d, c)]
    return np.concatenate([one - along, one + along]), edges, facets


def _sphere(radius: float) -> Shape:
    """Return a sphere: its equator and two full meridians, on a grid of parallels."""
    heights = np.linspace(-0.5 * np.pi, 0.5 * np.pi, MERIDIAN_PIECES + 1)[1:-1]
    rings = [
        np.column_stack([np.cos(height) * _circle(), np.full(CIRCLE_POINTS, np.sin(height))])
        for height in heights
    ]
    points = np.concatenate([*rings, [(0.0, 0.0, -1.0), (0.0, 0.0, 1.0)]])
    south, north = len(points) - 2, len(points) - 1
    starts = [CIRCLE_POINTS * k for k in range(len(rings))]
    edges = _ring(starts[len(rings) // 2])
    for k in range(0, CIRCLE_POINTS, CIRCLE_POINTS // 4):
        edges += pairwise([south, *(start + k for start in starts), north])
    facets = [(south, b, a) for a, b in _ring(0)] + [(north, *pair) for pair in _ring(starts[-1])]
    for one, other in pairwise(starts):
        for (a, b), (c, d) in zip(_ring(one), _ring(other), strict=True):
            facets += [(a, b, d), (a, d, c)]
    return radius * points, edges, facets
