"""Attachments: point masses, springs and forces at points of bodies."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, ClassVar, TypeAlias

import numpy as np

from ancfsparse.array_types import Indices, Vector
from ancfsparse.checks import MAX_MAGNITUDE, check_not_negative

if TYPE_CHECKING:
    from ancfsparse.scene.bodies.body import Body, Point
    from ancfsparse.scene.bodies.elastic_body import ElasticBody
    from ancfsparse.scene.joints.joint import Joint

Bodies: TypeAlias = "tuple[ElasticBody, ...]"
Marks: TypeAlias = "Iterable[tuple[str, Point, Vector | None]]"

# Check of the coefficients of force elements and of lengths: zero or positive, and moderate.
check_coefficient = partial(check_not_negative, largest=MAX_MAGNITUDE)


class Attachment(ABC):
    """A mass, a force element or a force at points of bodies.

    Attributes
    ----------
    contribution : str
        Module of `ancfsparse.system.contributions` that adds it to the equations of motion.
    separates : bool
        True if bodies that begin inside each other are moved apart.
    is_rope : bool
        True if its contribution gives its tension.
    """

    contribution: ClassVar[str]
    separates = False
    is_rope = False

    @property
    @abstractmethod
    def what(self) -> str:
        """Name in messages."""

    @property
    def function_of_time(self) -> object:
        """The function of time that its force follows, if there is one, such as a length."""
        return None

    def notes(self, joints: Iterable[Joint]) -> list[str]:
        """Return sentences on the effect of the joints of its scene on it."""
        return []

    @property
    def marks(self) -> Marks:
        """Symbols in pictures, each with its point and, if it is fixed in space, its direction."""
        return ()

    @property
    def links(self) -> tuple[tuple[Point | Vector, Point | Vector], ...]:
        """Pairs of points between which pictures draw a line."""
        return ()


def names(bodies: Sequence[Body]) -> str:
    """Return the names of bodies as text."""
    more = {1: "", 2: f" and {bodies[-1].name}"}.get(len(bodies), f" and {len(bodies) - 1} others")
    return bodies[0].name + more


class ContactLaw(Attachment):
    """Bodies and law of contacts with obstacles and of beams with each other."""

    bodies: Bodies
    radii: tuple[float, ...]
    friction: float
    slip_speed: float
    static_friction: float
    restitution: float
    contribution: ClassVar[str] = "force_elements.contact.contacts"

    def radius(self, body: ElasticBody) -> float:
        """Return the distance of the surface of one of the bodies from its axis [m]."""
        return self.radii[self.bodies.index(body)]

    @cached_property
    def starts(self) -> Indices:
        """Numbers of the first element of each body among those of all."""
        return np.cumsum([0, *(body.n_elements for body in self.bodies[:-1])])

    def describe_touch(self, first: Point, last: Point) -> str:
        """Return the place between two points that touch, as text."""
        return f"{first!r}, {last!r}"

    @property
    def sticks(self) -> bool:
        """True if friction is that of bristles, which have deflections."""
        return self.friction > 0.0 and self.slip_speed == 0.0

    @property
    def has_static_friction(self) -> bool:
        """True if bristles that stick have a larger coefficient of friction."""
        return self.static_friction > self.friction
