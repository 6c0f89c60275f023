"""Contact of beams with each other and with themselves."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Indices, Integers, Vector
from ancfsparse.errors import InputError
from ancfsparse.scene import force_elements
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.loads.attachment import Attachment, Bodies, ContactLaw, names

# Arc over the radius within which a body does not touch itself: half a turn after which it lies at
# its own side.
NEIGHBOUR_ARC_RATIO = math.pi
BOTH = 3  # a body on both sides


@dataclass(frozen=True, eq=False)
class BeamContact(ContactLaw):
    """Contact of beams and meshes with each other and with themselves.

    Attributes
    ----------
    bodies, one, other : tuple of Beam or Mesh
        All bodies, and those of each side; a body on both sides touches itself.
    radii : tuple of float
        Distances of the surfaces of all bodies from their axes [m].
    stiffness, friction, slip_speed, restitution, static_friction
        As in `Scene.contact` and `Contact`.
    separates : bool
        `push_out`.
    """

    bodies: Bodies
    one: Bodies
    other: Bodies
    stiffness: float | None
    radii: tuple[float, ...]
    friction: float
    slip_speed: float
    restitution: float
    static_friction: float
    separates: bool

    @property
    def what(self) -> str:
        """Name in messages."""
        other = names(self.other)
        if len(self.one) == len(self.other) == len(self.bodies):
            other = "itself" if len(self.bodies) == 1 else "each other"
        return f"the contact of {names(self.one)} with {other}"

    @property
    def sides(self) -> Integers:
        """The sides that each of the bodies is on: 1, 2, or 3 for both."""
        one, other = set(self.one), set(self.other)
        return np.array([(body in one) + 2 * (body in other) for body in self.bodies])

    def per_element(self, values: ArrayLike) -> Vector:
        """Return values of the bodies, repeated for each of their elements."""
        return np.repeat(values, [body.n_elements for body in self.bodies])

    def notes(self, joints: Iterable[Joint]) -> list[str]:
        """Return sentences on the parts that it leaves out."""
        pairs = force_elements.joined_points(self, joints)
        return [force_elements.describe_left_out(self.what, *pair) for pair in pairs]

    def point(self, element: int, xi: float) -> Point:
        """Return a point by the number of its element among those of all bodies.

        Points a little beyond the element are at its end.
        """
        k = int(np.searchsorted(self.starts, element, side="right")) - 1
        return Point(self.bodies[k], element - int(self.starts[k]), min(max(xi, 0.0), 1.0))


def check_pairs(contact: BeamContact, before: Iterable[Attachment]) -> None:
    """Refuse a contact with a pair of bodies that an earlier contact has already."""
    own = set(contact.one), set(contact.other)
    for each in before:
        if not isinstance(each, BeamContact):
            continue
        for sides in ((each.one, each.other), (each.other, each.one)):
            if own[0].isdisjoint(sides[0]) or own[1].isdisjoint(sides[1]):
                continue
            one, other = (
                next(body for body in side if body in bodies)
                for side, bodies in zip(sides, own, strict=True)
            )
            partner = "itself" if one is other else other.name
            raise InputError(
                f"the contact of {one.name} with {partner} was added before: leave one of them out"
            )


def untouched_elements(contact: BeamContact, joints: Iterable[Joint]) -> list[Indices]:
    """Return the elements that each element does not touch, numbered among those of all bodies.

    These are its neighbours along a body that touches itself, and those beyond a joint.
    """
    tables: list[Indices] = []
    first: dict[Any, int] = dict(zip(contact.bodies, contact.starts.tolist(), strict=True))
    for body, radius, side in zip(contact.bodies, contact.radii, contact.sides, strict=True):
        if side == BOTH:
            along = neighbours(body, NEIGHBOUR_ARC_RATIO * radius)
            tables += [each + np.int32(first[body]) for each in along]
        else:
            tables += [np.empty(0, dtype=np.int32)] * body.n_elements
    for pair in force_elements.joined_points(contact, joints):
        near, beyond = (
            force_elements.near_elements(each) + first[each.point.beam] for each in pair
        )
        for own, others in ((near, beyond), (beyond, near)):
            for e in own:
                tables[e] = np.union1d(tables[e], others).astype(np.int32)
    return tables


def neighbours(body: ElasticBody, arc: float) -> list[Indices]:
    """Return the elements closer to each element than an arc along the body, and itself."""
    nodes = body.row_nodes[body.ends].tolist()
    lengths = body.lengths.tolist()
    at: list[list[int]] = [[] for _ in range(body.n_nodes)]
    for e, pair in enumerate(nodes):
        for node in pair:
            at[node].append(e)
    tables: list[Indices] = []
    for pair in nodes:
        near: dict[int, float] = dict.fromkeys(pair, 0.0)
        queue = list(near)
        elements: set[int] = set()
        for node in queue:  # which grows
            for e in at[node]:
                elements.add(e)
                reached = near[node] + lengths[e]
                for end in nodes[e]:
                    if reached < min(arc, near.get(end, math.inf)):
                        near[end] = reached
                        queue.append(end)
        tables.append(np.array(sorted(elements), dtype=np.int32))
    return tables


def following_elements(body: ElasticBody) -> Integers:
    """Return the elements that continue the axis before and after each element, or -1, (n, 2)."""
    tails, heads = body.ends.T
    at_tail = {int(node): e for e, node in enumerate(tails)}
    at_head = {int(node): e for e, node in enumerate(heads)}
    before = [at_head.get(int(node), -1) for node in tails]
    after = [at_tail.get(int(node), -1) for node in heads]
    return np.stack([before, after], axis=1).astype(np.int32)


def free_ends(body: ElasticBody) -> Integers:
    """Return whether no element continues the axis of each element at either end, (n, 2).

    At a node of a string the axis has a corner, where neither element continues the other.
    """
    if body.kind.is_string:
        return np.ones((body.n_elements, 2), dtype=np.int32)
    tails, heads = body.ends.T
    return np.stack([~np.isin(tails, heads), ~np.isin(heads, tails)], axis=1).astype(np.int32)
