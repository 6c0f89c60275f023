"""Lines of obstacles by their cores: of blocks, segments and circles, with a radius around them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.scene.force_elements.obstacles import Obstacle

CIRCLE_PIECES = 64  # pieces of a circle, a multiple of `SECTIONS`
SECTIONS = 8  # of a torus


def trace_core(obstacle: Obstacle) -> Vector:
    """Return the ends of the lines of an obstacle with a bounded core, (n, 2, dim) [m]."""
    core, radius = obstacle.core, obstacle.radius
    if core.ring:
        lines = _trace_ring(core.ring, radius, obstacle.dim)
    else:
        middle, half = core.bounds.mean(axis=0), 0.5 * np.ptp(core.bounds, axis=0)
        lines = np.concatenate(_trace_block(half, radius)) + middle
    return np.asarray(lines @ core.axes + np.array(obstacle.base))


def trace_circle(centre: Vector, arms: Vector) -> Vector:
    """Return the pieces of a circle with two radius vectors (2, dim), (n, 2, dim) [m]."""
    angles = np.linspace(0.0, 2.0 * np.pi, CIRCLE_PIECES + 1)
    points = centre + np.stack([np.cos(angles), np.sin(angles)], axis=1) @ arms
    return np.stack([points[:-1], points[1:]], axis=1)


def _trace_block(half: Vector, radius: float) -> list[Vector]:
    """Return rounded rectangles around a block with half lengths (dim,), each (n, 2, dim)."""
    dim = len(half)
    if dim == 2:
        return [_round_rectangle(half, radius, np.eye(2))]
    rectangles = []
    for k in range(3):
        pair = np.delete(np.arange(3), k)
        # In the two faces of the core normal to axis k, which coincide for a segment.
        for height in sorted({-half[k], half[k]}):
            rectangle = _round_rectangle(half[pair], radius, np.eye(3)[pair])
            rectangles.append(rectangle + height * np.eye(3)[k])
    return rectangles


def _round_rectangle(half: Vector, radius: float, axes: Vector) -> Vector:
    """Return the pieces of a rectangle with half lengths (2,), widened by a radius, (n, 2, dim)."""
    quarter = np.linspace(0.0, 0.5 * np.pi, CIRCLE_PIECES // 4 + 1 if radius else 1)
    points = []
    for turn, signs in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
        angles = quarter + 0.5 * np.pi * turn
        arc = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        points.append(arc + half * np.array(signs))
    closed = np.concatenate([*points, points[0][:1]])
    return np.array([[start, end] for start, end in pairwise(closed @ axes)])


def _trace_ring(ring: float, radius: float, dim: int) -> Vector:
    """Return circles along and across a torus about the first axis, in the plane two circles."""
    plane = np.eye(dim)[-2:]
    circles = [trace_circle(np.zeros(dim), (ring + side) * plane) for side in (-radius, radius)]
    if dim == 3:
        axis = np.eye(3)[0]
        circles += [trace_circle(side * axis, ring * plane) for side in (-radius, radius)]
        for angle in 2.0 * np.pi * np.arange(SECTIONS) / SECTIONS:
            arm = np.array([np.cos(angle), np.sin(angle)]) @ plane
            circles.append(trace_circle(ring * arm, radius * np.stack([arm, axis])))
    return np.concatenate(circles)
