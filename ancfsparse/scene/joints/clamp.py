"""Clamps: the position and the rotation of a node are fixed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Integers
from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.joints.joint import Joint, Mark
from ancfsparse.scene.kinematics.linear_forms import LINEAR
from ancfsparse.scene.records.record import At, PointRef, Record

MAX_AXIS_DEVIATION = 1e-14  # of a unit slope along a coordinate axis


@dataclass(frozen=True, eq=False)
class ClampSpec(Record):
    """The record of `Scene.clamp`."""

    node: PointRef
    stretch: str = "free"
    method = "clamp"
    planar: ClassVar = {}

    def describe(self, at: At, made: Any) -> str:
        """Describe the data of its constraints."""
        return f"clamp ({at(self.node)}), stretch {self.stretch}"


@dataclass(frozen=True, eq=False)
class Clamp(Joint):
    """Fix the position and the rotation of a node.

    Attributes
    ----------
    node, stretch
        As in `Scene.clamp`.
    """

    node: Point
    stretch: str = "free"
    name = "clamp"

    def lower(self, builder: ConstraintBuilder) -> None:
        """Fix the position and the section vectors of every row."""
        kind = builder.kind(self.node)
        first = self.node.beam.rows_of(self.node.index).start
        for row, coordinates in enumerate(builder.rows(self.node), first):
            if self.stretch == "fixed" or not self.node.beam.n_elements:
                builder.fix(coordinates)
            elif kind.is_cable:
                builder.fix(coordinates[kind.columns("r")])
                self._fix_direction(builder, row, coordinates[kind.columns("r_x")])
            else:
                for vector in ("r", *kind.section):
                    builder.fix(coordinates[kind.columns(vector)])

    def _fix_direction(self, builder: ConstraintBuilder, row: int, slope: Integers) -> None:
        """Fix the direction of a slope, not its length.

        A slope that is not along a coordinate axis is constrained by equations L e.r_x = 0 for its
        normals e, scaled by the length L of an element to metres.
        """
        body, dim = self.node.beam, self.node.beam.dim
        axes = body.axes_of(row)
        along = along_axis(axes[0])
        if along is not None:
            builder.fix(np.delete(slope, along))
            return
        length = float(np.mean(body.lengths))
        for k, normal in enumerate(axes[1:]):
            terms = [(length * normal[d], slope[d], LINEAR) for d in range(dim)]
            builder.equation(f"clamp at {self.node!r}, direction {k + 1}", 0.0, *terms)

    @property
    def mark(self) -> Mark:
        """Symbol in pictures."""
        return Mark("clamp", self.node.beam.interior_direction(self.node))


def along_axis(slope: NDArray[np.float64]) -> int | None:
    """Return the coordinate axis that a slope is parallel to, or None."""
    direction = np.abs(slope)
    axis = int(np.argmax(direction))
    return axis if np.all(np.delete(direction, axis) <= MAX_AXIS_DEVIATION) else None
