"""Parts of bodies that contact leaves out, since a joint fixes them to the other side.

A beam that is fixed on the surface of a body begins inside it.  Contact leaves out its axis over
the penetration at the fixed point plus the distance at which surfaces touch.  A beam that is fixed
on a surface, and leaves it at 30 degrees or more, is outside from there on; so are two beams that
are joined at such an angle.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ancfsparse.array_types import Indices, Vector
from ancfsparse.scene.bodies.body import Point

if TYPE_CHECKING:
    from ancfsparse.scene.force_elements.beam_contacts import BeamContact
    from ancfsparse.scene.force_elements.contacts import Contact
    from ancfsparse.scene.joints.joint import Joint
# Penetration at the start over the distance at which surfaces touch: bodies at rest on each other
# have a hundredth, ones that were placed into each other by mistake mostly more.
MAX_START_DEPTH_RATIO = 0.05


class FixedPoint(NamedTuple):
    """A point that contact leaves out, with a length of the axis around it [m]."""

    point: Point
    length: float


def fixed_points(contact: Contact, joints: Iterable[Joint]) -> list[FixedPoint]:
    """Return the points that are fixed to an obstacle and begin inside it."""
    points = []
    for joint in joints:
        ends: tuple[Point, ...]
        if contact.on is None:
            ends = joint.nodes if len(joint.nodes) == 1 and joint.mark is not None else ()
        else:
            ends = tuple(
                one for one, other in _coincident_points(joint) if other.beam is contact.on
            )
        for end in ends:
            if end.beam not in contact.bodies:
                continue
            axis, radius = Point(end.beam, end.index, end.xi), contact.radius(end.beam)
            depth = radius - float(contact.obstacle.distances(axis.position[None])[0])
            if depth > MAX_START_DEPTH_RATIO * radius:
                points.append(FixedPoint(axis, depth + radius))
    return points


def joined_points(
    contact: BeamContact, joints: Iterable[Joint]
) -> list[tuple[FixedPoint, FixedPoint]]:
    """Return pairs of points at which joints make two axes meet, the first side first."""
    points = []
    for joint in joints:
        for one, other in _coincident_points(joint):
            if one.beam in contact.one and other.beam in contact.other:
                length = 2.0 * (contact.radius(one.beam) + contact.radius(other.beam))
                points.append((FixedPoint(one, length), FixedPoint(other, length)))
                break
    return points


def _coincident_points(joint: Joint) -> Iterator[tuple[Point, Point]]:
    """Yield both orders of two points that a joint makes coincide."""
    if joint.joins:
        one, other = joint.nodes
        yield one, other
        yield other, one


def is_left_out(contact: Contact, points: Iterable[FixedPoint]) -> Indices:
    """Return whether each quadrature point of a contact is near a fixed point, (n,) bool."""
    out = np.zeros(len(contact.points), dtype=bool)
    at = np.array([(each.index, each.xi) for each in contact.points])
    owner = contact.per_point(range(len(contact.bodies)))
    for point, length in points:
        body: Any = point.beam
        rows = owner == contact.bodies.index(body)
        elements, xi = at[rows, 0].astype(int), at[rows, 1]
        tails, heads = arcs_from(point).T
        lengths = body.lengths[elements]
        arcs = np.minimum(tails[elements] + xi * lengths, heads[elements] + (1.0 - xi) * lengths)
        if point.xi:
            own = elements == point.index
            arcs[own] = np.abs(xi[own] - point.xi) * lengths[own]
        out[rows] |= arcs < length
    return out


def near_elements(fixed: FixedPoint) -> Indices:
    """Return the elements that have a part near a fixed point."""
    point, length = fixed
    near = arcs_from(point).min(axis=1) < length
    if point.xi:
        near[point.index] = True
    return np.flatnonzero(near)


def arcs_from(point: Point) -> Vector:
    """Return the arcs along a body from a point of it to the ends of its elements, (n, 2) [m]."""
    body: Any = point.beam
    nodes, lengths = body.row_nodes[body.ends].tolist(), body.lengths.tolist()
    at: list[list[tuple[int, float]]] = [[] for _ in range(body.n_nodes)]
    for (tail, head), length in zip(nodes, lengths, strict=True):
        at[tail].append((head, length))
        at[head].append((tail, length))
    queue = [(0.0, point.index)]
    if point.xi:
        (tail, head), length = nodes[point.index], lengths[point.index]
        queue = [(point.xi * length, tail), ((1.0 - point.xi) * length, head)]
    arcs = np.full(body.n_nodes, np.inf)
    heapq.heapify(queue)
    while queue:
        arc, node = heapq.heappop(queue)
        if arc < arcs[node]:
            arcs[node] = arc
            for other, length in at[node]:
                heapq.heappush(queue, (arc + length, other))
    return np.asarray(arcs[np.array(nodes)])


def describe_left_out(what: str, *fixed: FixedPoint) -> str:
    """Return a sentence on a fixed point of a contact, or on two that are joined."""
    points = " and ".join(repr(each.point) for each in fixed)
    return f"{what} leaves out {fixed[0].length:.3g} m along the axis from the joint at {points}"
