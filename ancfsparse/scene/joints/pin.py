"""Pins: the position of a node is held, its rotation is free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ancfsparse.scene.bodies.body import LINEAR, ConstraintBuilder, Point
from ancfsparse.scene.joints.joint import Joint, Mark, in_the_plane
from ancfsparse.scene.records.record import At, PointRef, Record


@dataclass(frozen=True, eq=False)
class PinSpec(Record):
    """The record of `Scene.pin`."""

    node: PointRef
    as_constraint: bool = False
    method = "pin"

    def describe(self, at: At, made: Any) -> str:
        """Describe everything that its equations follow from."""
        return f"pin ({at(self.node)})" + " as constraint" * self.as_constraint


@dataclass(frozen=True, eq=False)
class Pin(Joint):
    """Hold the position of a node, leave its rotation free.

    Attributes
    ----------
    node : Point
        The node held.
    as_constraint : bool
        Hold it by equations with multipliers instead of by numbering.
    """

    node: Point
    as_constraint: bool = False
    name = "pin"

    def lower(self, builder: ConstraintBuilder) -> None:
        """Fix the position, or state an equation for each component."""
        if not self.has_multipliers:
            builder.fix(builder.position(self.node))
            return
        places, weights = builder.point(self.node)
        for d, (row, held) in enumerate(zip(places, self.node.position, strict=True)):
            label = f"pin at {self.node!r}, component {d + 1}"
            terms = ((w, place, LINEAR) for w, place in zip(weights, row, strict=True))
            builder.equation(label, -held, *terms, size=self.node.beam.size)

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """In the plane its angle."""
        return in_the_plane(self)

    @property
    def nodes(self) -> tuple[Point, ...]:
        """The node."""
        return (self.node,)

    @property
    def mark(self) -> Mark:
        """How pictures show it."""
        return Mark("pin")

    @property
    def has_multipliers(self) -> bool:
        """Whether it is made by equations."""
        return self.as_constraint or not self.node.is_node
