"""Gears: the coordinate of one joint follows that of another at a fixed ratio."""

from __future__ import annotations

from dataclasses import dataclass

from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.mechanisms.coordinate_functions import joint_coordinate, reference_value


@dataclass(frozen=True, eq=False)
class Gear(Joint):
    """Keep ``h_one - ratio h_other`` of the coordinates of two joints constant.

    Attributes
    ----------
    one, other, ratio
        As in `Scene.gear`.
    of : (str, str)
        ``"angle"`` or ``"displacement"`` of each.
    """

    one: Joint
    other: Joint
    of: tuple[str, str]
    ratio: float
    name = "gear"
    has_multipliers = True

    def lower(self, builder: ConstraintBuilder) -> None:
        """Add the equation ``factor (h_one - ratio h_other - c) = 0``, in metres."""
        factor = self.one.arm if self.of[0] == "angle" else 1.0
        terms = (factor, self.one, self.of[0]), (-factor * self.ratio, self.other, self.of[1])
        offset = -sum(f * reference_value(joint, of) for f, joint, of in terms)
        coordinates = [(f, joint_coordinate(builder, joint, of)) for f, joint, of in terms]
        builder.equation(self.label, offset, measures=coordinates)

    @property
    def nodes(self) -> tuple[Point, ...]:
        """Points of both joints."""
        return *self.one.nodes, *self.other.nodes

    @property
    def sides(self) -> tuple[Point, Point | None]:
        """Sides of the first joint."""
        return self.one.sides

    @property
    def label(self) -> str:
        """Name in messages."""
        return f"gear of the {self.one.label} and the {self.other.label}"
