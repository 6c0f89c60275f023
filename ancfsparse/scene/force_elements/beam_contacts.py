"""Contact of beams with each other and with themselves."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Indices, Integers
from ancfsparse.checks import check_flag, check_moderate
from ancfsparse.errors import InputError
from ancfsparse.scene import force_elements
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.loads.attachment import Attachment, ContactLaw, check_coefficient

# Arc over the radius within which a body does not touch itself: half a turn after which it lies at
# its own side.
NEIGHBOUR_ARC_RATIO = math.pi


@dataclass(frozen=True, eq=False)
class BeamContact(ContactLaw):
    """Contact of a beam or a mesh with another one or with itself.

    Attributes
    ----------
    body, other, stiffness, friction, slip_speed, restitution, static_friction
        As in `Scene.contact` and `Contact`; `other` is `body` if it touches itself.
    radii : tuple of float
        Distances of the surfaces of both from their axes [m].
    separates : bool
        `push_out`.
    """

    body: ElasticBody
    other: ElasticBody
    stiffness: float
    radii: tuple[float, float]
    friction: float
    slip_speed: float
    restitution: float
    static_friction: float
    separates: bool

    @property
    def what(self) -> str:
        """Name in messages."""
        other = "itself" if self.is_within else self.other.name
        return f"the contact of {self.body.name} with {other}"

    @property
    def is_within(self) -> bool:
        """True if the body touches itself."""
        return self.body is self.other

    def notes(self, joints: Iterable[Joint]) -> list[str]:
        """Return sentences on the parts that it leaves out."""
        pairs = force_elements.joined_points(self, joints)
        return [
            force_elements.describe_left_out(self.what, *pair)
            for pair in pairs[:: 1 + self.is_within]
        ]

    @property
    def bodies(self) -> tuple[ElasticBody, ...]:
        """The bodies, each once."""
        return (self.body,) if self.is_within else (self.body, self.other)

    def point(self, element: int, xi: float) -> Point:
        """Return a point by the number of its element among those of both bodies."""
        own = self.body.n_elements
        body, index = (self.body, element) if element < own else (self.other, element - own)
        return Point(body, index, xi)


def make_beam_contact(
    body: ElasticBody,
    other: ElasticBody,
    stiffness: float,
    radii: tuple[float, float],
    friction: float,
    slip_speed: float | None,
    restitution: float | None,
    static_friction: float | None,
    separates: bool,
    before: Iterable[Attachment],
) -> BeamContact:
    """Return the contact of two bodies of a scene, or of one with itself; see `Scene.contact`."""
    contact = BeamContact(
        body,
        other,
        check_moderate(f"stiffness of the contact of {body.name}", stiffness, "N/m2"),
        radii,
        check_coefficient(f"friction of the contact of {body.name}", friction),
        force_elements.check_slip_speed(body, slip_speed),
        force_elements.check_restitution(body, restitution),
        force_elements.check_static_friction(body, friction, static_friction, slip_speed),
        check_flag("push_out", separates),
    )
    for each in before:
        if isinstance(each, BeamContact) and {each.body, each.other} == {body, other}:
            raise InputError(f"{contact.what} was added before: leave one of them out")
    return contact


def untouched_elements(contact: BeamContact, joints: Iterable[Joint]) -> list[Indices]:
    """Return the elements that each element does not touch, numbered among those of both bodies.

    These are its neighbours along a body that touches itself, and those beyond a joint.
    """
    body, first = contact.body, 0 if contact.is_within else contact.body.n_elements
    n = sum(each.n_elements for each in contact.bodies)
    tables: list[Indices] = [np.empty(0, dtype=np.int32)] * n
    if contact.is_within:
        tables = neighbours(body, NEIGHBOUR_ARC_RATIO * contact.radii[0])
    for one, other in force_elements.joined_points(contact, joints):
        near, beyond = (
            force_elements.near_elements(one),
            force_elements.near_elements(other) + first,
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
