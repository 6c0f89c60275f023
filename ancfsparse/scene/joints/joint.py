"""The base class of joints, and checks of their points.

In the checks `what` is the name of the joint, load or result in messages.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from typing import ClassVar, NamedTuple

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.kernels.element_kind import RIGID
from ancfsparse.messages import format_value
from ancfsparse.scene.bodies.body import ConstraintBuilder, Point


class Mark(NamedTuple):
    """The symbol of a joint in pictures.

    Attributes
    ----------
    kind : str
        ``"pin"``, ``"clamp"`` or ``"rod"``.
    other : (dim,) float, optional
        Anchor of a rod [m]; direction from a clamp into the beam.
    """

    kind: str
    other: Vector | None = None


class Joint(ABC):
    """A joint, which declares the constraints on its points.

    Attributes
    ----------
    name : str
        Name in messages.
    constrains_directions : bool
        True if it constrains directions too, and so transmits bending moments.
    is_rope : bool
        True if its only multiplier is the tension of a rope.
    """

    name: ClassVar[str]
    constrains_directions: ClassVar[bool] = True
    is_rope: ClassVar[bool] = False

    @abstractmethod
    def lower(self, builder: ConstraintBuilder) -> None:
        """Fix or identify coordinates, or add constraint equations."""

    @property
    def nodes(self) -> tuple[Point, ...]:
        """Points that it constrains: by default its attributes that are points."""
        return tuple(value for value in vars(self).values() if isinstance(value, Point))

    @property
    def joins(self) -> bool:
        """True if it makes its two nodes coincide; False if it constrains one to the ground."""
        return False

    @property
    def mark(self) -> Mark | None:
        """Symbol in pictures at its first node, or None."""
        return None

    @property
    def links(self) -> tuple[tuple[Point | Vector, Point | Vector], ...]:
        """Pairs of points between which pictures draw a line."""
        return ()

    @property
    def direction(self) -> Vector | None:
        """The only constrained direction, a unit vector (dim,); None constrains all directions."""
        return None

    @property
    def has_multipliers(self) -> bool:
        """True if it certainly adds equations."""
        return False

    @property
    def turns_body(self) -> bool:
        """True if it prescribes the direction of a body without an equation."""
        return False

    @property
    def sides(self) -> tuple[Point, Point | None]:
        """The points of the first and the second side; None for the ground."""
        a, *b = self.nodes
        return a, b[0] if b else None

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Names of its joint coordinates: ``"angle"``, ``"displacement"``."""
        return ()

    @property
    def axis(self) -> Vector | None:
        """Axis of its coordinates in the reference shape, a unit vector (dim,)."""
        return None

    @property
    def arm(self) -> float:
        """Length of the larger body, which scales angles and directions to lengths [m]."""
        return max(node.beam.size for node in self.nodes)

    @property
    def label(self) -> str:
        """Name in messages."""
        return f"{self.name} of {' and '.join(map(repr, self.nodes))}"


def planar_coordinates(joint: Joint) -> tuple[str, ...]:
    """Return the coordinates of a joint of points: an angle in the plane, if nodes have slopes."""
    has_angle = all(
        node.beam.dim == 2 and not node.xi and not node.beam.kind.is_string for node in joint.nodes
    )
    return ("angle",) if has_angle else ()


def check_point(what: str, node: object) -> Point:
    """Return `node` if it is a point, at a node of the mesh or not."""
    if not isinstance(node, Point):
        raise InputError(
            f"{what} needs a point on a beam such as rod.start or rod.node(3), or on a rigid body "
            f"such as box.origin, got {format_value(node)}"
        )
    return node


def check_end(what: str, node: object) -> Point:
    """Return `node` if a joint can constrain it: a node of a beam or mesh, or a point of a body."""
    if isinstance(node, Point) and node.offsets and not node.xi:
        return node
    return check_node(what, node)


def check_turns(what: str, node: Point) -> Point:
    """Return `node` if it has slopes, which nodes of strings have not."""
    if node.beam.kind.is_string:
        raise InputError(
            f"{what} needs a direction at {node!r}, but a string has only positions: take "
            "element='thin', or fix the position by a pin"
        )
    return node


def check_other_body(what: str, a: Point, b: Point) -> None:
    """Refuse a joint of a rigid body to itself; points of one beam or mesh may be joined."""
    if a.beam is b.beam and a.beam.element == RIGID:
        raise InputError(
            f"{what} cannot join {a!r} to {b!r}: both are points of the rigid body {a.beam.name}; "
            "give a point of another body"
        )


def check_node(what: str, node: object) -> Point:
    """Return `node` if it is a node of the mesh; for another point of its section, the node."""
    point = check_point(what, node)
    if point.offsets and not point.xi and point.beam.n_elements:
        return replace(point, offsets=())
    if not point.is_node:
        raise InputError(
            f"{what} needs a node, but {point!r} "
            + (f"lies inside element {point.index}" if point.xi else "is another point")
            + f": {point.beam.hint(point)}"
        )
    return point
