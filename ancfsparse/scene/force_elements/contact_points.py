"""Quadrature points of a contact with an obstacle on the axes of its bodies."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cache

import numpy as np

from ancfsparse.array_types import Indices, Vector
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.force_elements.beam_contacts import following_elements
from ancfsparse.scene.force_elements.obstacles import Obstacle
from ancfsparse.scene.joints.joint import Joint

POINTS_PER_PART = 3  # Gauss points, which are exact to degree five
# Longest part of an element, over sqrt(r (R + r)) of a body of radius r on an obstacle of radius R.
# With points .39 of it apart a straight axis is at most .3 r deeper between two of them.
# Without it, 8 of 500 random runs end with an axis that is inside an obstacle.
MAX_PART_RATIO = 4.0
# Longest part at a free end, over the radius.  The axis extends by .113 of it beyond its last
# point, and is not inside before this touches, at any angle.  Without it, 4 of these runs do.
MAX_END_RATIO = 8.0
# Largest number of equal parts of an element, whose points take 1 MB.
MAX_PARTS = 1000


def distribute_points(
    body: ElasticBody, radius: float, obstacle: Obstacle, joints: Iterable[Joint]
) -> tuple[Indices, Vector, Vector]:
    """Return elements, positions in them from 0 to 1 and lengths [m] of the points, (k,) each.

    Elements are divided into equal parts where they are long for a round obstacle, and the parts
    at ends that no joint holds are halved until the last one is short.
    """
    nodes, is_free = body.row_nodes[body.ends], following_elements(body) < 0
    for joint in joints:
        held = [each.index for each in joint.nodes if each.beam is body and not each.xi]
        is_free &= ~np.isin(nodes, held)
    middle, weights = _gauss_rule()
    elements, xi, lengths = [], [], []
    for e, length in enumerate(body.lengths.tolist()):
        edges = np.linspace(0.0, 1.0, count_parts(length, radius, obstacle) + 1)
        shortest = MAX_END_RATIO * radius / length
        if is_free[e, 0]:
            edges = halve_first(edges, shortest)
        if is_free[e, 1]:
            edges = 1.0 - halve_first(1.0 - edges[::-1], shortest)[::-1]
        parts = np.diff(edges)[:, None]
        elements.append(np.full(parts.size * POINTS_PER_PART, e))
        xi.append((edges[:-1, None] + parts * middle).ravel())
        lengths.append((length * parts * weights).ravel())
    return np.concatenate(elements), np.concatenate(xi), np.concatenate(lengths)


def count_parts(length: float, radius: float, obstacle: Obstacle) -> int:
    """Return the number of equal parts of an element of a length [m] on an obstacle."""
    if obstacle.radius == 0.0:
        return 1
    longest = MAX_PART_RATIO * math.sqrt(radius * (obstacle.bend_radius + radius))
    return max(1, math.ceil(length / longest))


def halve_first(edges: Vector, longest: float) -> Vector:
    """Divide the first part into halves until the first one is not longer than a length."""
    n = max(0, math.ceil(math.log2(edges[1] / longest)))
    return np.concatenate([edges[:1], edges[1] * 0.5 ** np.arange(n, 0, -1), edges[1:]])


@cache
def _gauss_rule() -> tuple[Vector, Vector]:
    """Return points and weights on the interval from 0 to 1."""
    points, weights = np.polynomial.legendre.leggauss(POINTS_PER_PART)
    return 0.5 + 0.5 * points, 0.5 * weights
