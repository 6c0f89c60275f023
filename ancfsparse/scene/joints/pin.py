"""Pins: the position of a node is fixed, its rotation is free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.joints.joint import Joint, Mark, planar_coordinates
from ancfsparse.scene.kinematics.linear_forms import LINEAR
from ancfsparse.scene.records.record import At, PointRef, Record


@dataclass(frozen=True, eq=False)
class PinSpec(Record):
    """The record of `Scene.pin`."""

    node: PointRef
    as_constraint: bool = False
    method = "pin"
    planar: ClassVar = {}

    def describe(self, at: At, made: Any) -> str:
        """Describe the data of its constraints."""
        return f"pin ({at(self.node)})" + " as constraint" * self.as_constraint


@dataclass(frozen=True, eq=False)
class Pin(Joint):
    """Fix the position of a node, leave its rotation free.

    Attributes
    ----------
    node, as_constraint
        As in `Scene.pin`.
    """

    node: Point
    as_constraint: bool = False
    name = "pin"
    constrains_directions = False
    mark = Mark("pin")

    def lower(self, builder: ConstraintBuilder) -> None:
        """Fix the position, or add an equation for each component."""
        if not self.has_multipliers:
            builder.fix(builder.position(self.node))
            return
        indices, weights = builder.point(self.node)
        for d, (row, position) in enumerate(zip(indices, self.node.position, strict=True)):
            label = f"pin at {self.node!r}, component {d + 1}"
            terms = ((w, k, LINEAR) for w, k in zip(weights, row, strict=True))
            builder.equation(label, -position, *terms, size=self.node.beam.size)

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Its angle in the plane."""
        return planar_coordinates(self)

    @property
    def has_multipliers(self) -> bool:
        """True if it adds equations."""
        return self.as_constraint or not self.node.is_node
