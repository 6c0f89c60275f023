"""Clamps: the position and the rotation of a node are held."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.scene.bodies.body import LINEAR, ConstraintBuilder, Point
from ancfsparse.scene.joints.joint import Joint, Mark
from ancfsparse.scene.kinematics.linear_forms import Coordinates
from ancfsparse.scene.records.record import At, PointRef, Record

# A slope whose direction is within this of a coordinate axis can be clamped by numbering.
ALIGNED = 1e-14


@dataclass(frozen=True, eq=False)
class ClampSpec(Record):
    """The record of `Scene.clamp`."""

    node: PointRef
    stretch: str = "free"
    method = "clamp"

    def describe(self, at: At, made: Any) -> str:
        """Describe everything that its equations follow from."""
        return f"clamp ({at(self.node)}), stretch {self.stretch}"


@dataclass(frozen=True, eq=False)
class Clamp(Joint):
    """Hold the position and the rotation of a node.

    Attributes
    ----------
    node : Point
        The node held.
    stretch : str
        ``"free"`` leaves the slope of the axis its length, and with ``curvature="section"`` all
        of it; ``"fixed"`` holds it too.  With ``curvature="axis"`` it is always held.
    """

    node: Point
    stretch: str = "free"
    name = "clamp"

    def lower(self, builder: ConstraintBuilder) -> None:
        """Fix the position and the vectors of the section, row by row."""
        kind = builder.kind(self.node)
        first = self.node.beam.rows_of(self.node.index).start
        for row, coordinates in enumerate(builder.rows(self.node), first):
            if self.stretch == "fixed" or not self.node.beam.n_elements:
                builder.fix(coordinates)
            elif kind.is_cable:
                builder.fix(coordinates[kind.columns("r")])
                self._hold_direction(builder, row, coordinates[kind.columns("r_x")])
            else:
                for vector in ("r", *kind.section):
                    builder.fix(coordinates[kind.columns(vector)])

    def _hold_direction(self, builder: ConstraintBuilder, row: int, slope: Coordinates) -> None:
        """Hold the direction of a slope and leave it its length.

        A slope that is not along a coordinate axis is held by equations e.r_x = 0 across it.  It
        counts by the way that it moves at the distance of an element: in metres.
        """
        body, dim = self.node.beam, self.node.beam.dim
        axes = body.axes_of(row)
        along = along_axis(axes[0])
        if along is not None:
            builder.fix(np.delete(slope, along))
            return
        length = float(np.mean(body.lengths))
        for k, across in enumerate(axes[1:]):
            terms = [(length * across[d], slope[d], LINEAR) for d in range(dim)]
            builder.equation(f"clamp at {self.node!r}, direction {k + 1}", 0.0, *terms)

    @property
    def nodes(self) -> tuple[Point, ...]:
        """The node."""
        return (self.node,)

    @property
    def mark(self) -> Mark:
        """How pictures show it."""
        return Mark("clamp", self.node.beam.interior_direction(self.node))


def along_axis(slope: NDArray[np.float64]) -> int | None:
    """Return the coordinate axis that a slope is parallel to, or None."""
    direction = np.abs(slope)
    axis = int(np.argmax(direction))
    return axis if np.all(np.delete(direction, axis) <= ALIGNED) else None
