"""What joints have in common, and what they are lowered to."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from typing import ClassVar, NamedTuple

from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import RIGID
from ancfsparse.messages import format_value
from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.kinematics.linear_forms import Vector


class Mark(NamedTuple):
    """How pictures show a joint.

    Attributes
    ----------
    kind : str
        ``"pin"``, ``"clamp"`` or ``"rod"``.
    other : (dim,) float, optional
        The anchor of a rod [m]; the direction in which a beam leaves the wall it is clamped to.
    """

    kind: str
    other: Vector | None = None


class Joint(ABC):
    """The properties that every joint declares.

    Attributes
    ----------
    name : str
        What it is called in messages.
    """

    name: ClassVar[str]

    @abstractmethod
    def lower(self, builder: ConstraintBuilder) -> None:
        """Fix or share coordinates, or state equations."""

    @property
    @abstractmethod
    def nodes(self) -> tuple[Point, ...]:
        """Nodes that it holds."""

    @property
    def joins(self) -> bool:
        """Whether it makes its two nodes one point, instead of holding one beside the ground."""
        return False

    @property
    def mark(self) -> Mark | None:
        """How pictures show it at its first node; None if they do not."""
        return None

    @property
    def links(self) -> tuple[tuple[Point | Vector, Point | Vector], ...]:
        """Pairs of points between which pictures draw a line."""
        return ()

    @property
    def direction(self) -> Vector | None:
        """The only direction in which it holds its node, a unit vector (dim,); None holds all."""
        return None

    @property
    def has_multipliers(self) -> bool:
        """Whether it certainly makes equations."""
        return False

    @property
    def turns_body(self) -> bool:
        """Whether it prescribes the direction of a body, which numbering can do."""
        return False

    @property
    def sides(self) -> tuple[Point, Point | None]:
        """The point of the first side and that of the second, which None is at the ground."""
        a, *b = self.nodes
        return a, b[0] if b else None

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """What it leaves free that is one number: ``"angle"``, ``"displacement"``."""
        return ()

    @property
    def axis(self) -> Vector | None:
        """The axis of its freedoms in the reference shape, a unit vector (dim,)."""
        return None

    @property
    def arm(self) -> float:
        """Length of the larger body, which scales angles to lengths [m]."""
        return max(node.beam.size for node in self.nodes)

    @property
    def label(self) -> str:
        """Name in messages."""
        return f"{self.name} of {' and '.join(map(repr, self.nodes))}"


def in_the_plane(joint: Joint) -> tuple[str, ...]:
    """Return the freedoms of a joint of points: an angle in the plane, where nodes have slopes."""
    turn = all(
        node.beam.dim == 2 and not node.xi and not node.beam.kind.is_string for node in joint.nodes
    )
    return ("angle",) if turn else ()


def check_point(what: str, node: object) -> Point:
    """Return `node` if it is a point, at a node of the mesh or not.

    Parameters
    ----------
    what : str
        The load or result that needs it, for the message.
    node : object
        What was given.
    """
    if not isinstance(node, Point):
        raise InputError(
            f"{what} needs a point on a beam such as rod.start or rod.node(3), or on a rigid body "
            f"such as box.origin, got {format_value(node)}"
        )
    return node


def check_end(what: str, node: object) -> Point:
    """Return `node` if a joint can hold it: a node of a beam or mesh, or any point of a body.

    Parameters
    ----------
    what : str
        The joint, for the message.
    node : object
        What was given.
    """
    if isinstance(node, Point) and node.offsets and not node.xi:
        return node
    return check_node(what, node)


def check_turns(what: str, node: Point) -> Point:
    """Return `node` if it has directions, which nodes of strings do not.

    Parameters
    ----------
    what : str
        The joint or load that needs them, for the message.
    node : Point
        What was given.
    """
    if node.beam.kind.is_string:
        raise InputError(
            f"{what} needs a direction at {node!r}, and a string has positions alone: take "
            "element='thin', or hold the position by a pin"
        )
    return node


def check_other_body(what: str, a: Point, b: Point) -> None:
    """Refuse to join a rigid body to itself; points of one beam or mesh may be joined."""
    if a.beam is b.beam and a.beam.element == RIGID:
        raise InputError(
            f"{what} cannot join {a!r} to {b!r}: {a.beam.name} is rigid and holds its own points "
            "already; give a point of another body"
        )


def check_node(what: str, node: object) -> Point:
    """Return `node` if it is a node of the mesh; of a point beside it in a section, the node.

    Parameters
    ----------
    what : str
        The joint or load that needs it, for the message.
    node : object
        What was given.

    Returns
    -------
    Point
        The node.
    """
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
