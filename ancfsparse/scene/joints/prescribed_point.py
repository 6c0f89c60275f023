"""Prescribed points: supports with a prescribed motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from numpy.typing import ArrayLike

from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.joints.joint import Joint, Mark
from ancfsparse.scene.kinematics.linear_forms import LINEAR, RheonomicTerm
from ancfsparse.scene.records.record import At, PointRef, Record, text

if TYPE_CHECKING:
    from ancfsparse.scene.records.prescribed_motion import PrescribedMotion


@dataclass(frozen=True, eq=False)
class DriveSpec(Record):
    """The record of `Scene.drive`."""

    node: PointRef
    position: Any
    rate: Callable[[float], ArrayLike] | None = None
    second_rate: Callable[[float], ArrayLike] | None = None
    as_constraint: bool = False
    method = "drive"
    planar: ClassVar = {"position": "put", "rate": "into", "second_rate": "into"}
    units: ClassVar = {"position": "m", "rate": "m/s", "second_rate": "m/s2"}

    def describe(self, at: At, made: Any) -> str:
        """Describe the data of its constraints."""
        kind = "drive as constraint" if self.as_constraint else "drive"
        return f"{kind} ({at(self.node)}) along {text(self.position, at)}"


@dataclass(frozen=True, eq=False)
class PrescribedPoint(Joint):
    """Prescribe the position of a node, leave its rotation free.

    Attributes
    ----------
    node, as_constraint
        As in `Scene.drive`.
    motion : PrescribedMotion
        The motion of its position.
    """

    node: Point
    motion: PrescribedMotion
    as_constraint: bool = False
    name = "drive"
    constrains_directions = False
    mark = Mark("pin")

    def lower(self, builder: ConstraintBuilder) -> None:
        """Prescribe the position, or add an equation for each component."""
        if not self.has_multipliers:
            builder.drive(builder.position(self.node), self.motion)
            return
        indices, weights = builder.point(self.node)
        for d, row in enumerate(indices):
            label = f"drive at {self.node!r}, component {d + 1}"
            terms = ((w, k, LINEAR) for w, k in zip(weights, row, strict=True))
            builder.equation(label, 0.0, *terms, rheonomic=RheonomicTerm(self.motion, d))

    @property
    def has_multipliers(self) -> bool:
        """True if it adds equations."""
        return self.as_constraint or not self.node.is_node
