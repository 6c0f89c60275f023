"""Connections: two points coincide, with free relative rotation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.joints.joint import Joint, planar_coordinates
from ancfsparse.scene.kinematics.linear_forms import LINEAR
from ancfsparse.scene.records.record import At, PointRef, Record


@dataclass(frozen=True, eq=False)
class ConnectSpec(Record):
    """The record of `Scene.connect`."""

    a: PointRef
    b: PointRef
    apart: bool = False
    method = "connect"
    planar: ClassVar = {}

    def describe(self, at: At, made: Any) -> str:
        """Describe the data of its constraints."""
        return f"connection ({at(self.a)}; {at(self.b)})" + ", apart" * self.apart


@dataclass(frozen=True, eq=False)
class Connect(Joint):
    """Make two points coincide, with free relative rotation.

    Attributes
    ----------
    a, b, apart
        As in `Scene.connect`.
    """

    a: Point
    b: Point
    apart: bool = False
    name = "connection"
    constrains_directions = False
    joins = True

    def lower(self, builder: ConstraintBuilder) -> None:
        """Identify the positions, or add equations for points that are not nodes."""
        if not self.has_multipliers:
            builder.share(builder.position(self.a), builder.position(self.b))
            return
        ends = [(1.0, builder.point(self.a)), (-1.0, builder.point(self.b))]
        for d in range(self.a.beam.dim):
            terms = [
                (sign * w, k, LINEAR)
                for sign, (indices, weights) in ends
                for w, k in zip(weights, indices[d], strict=True)
            ]
            label = f"connection of {self.a!r} and {self.b!r}, component {d + 1}"
            size = max(node.beam.size for node in self.nodes)
            builder.equation(label, 0.0, *terms, size=size)

    @property
    def has_multipliers(self) -> bool:
        """True if it adds equations."""
        return self.apart or not (self.a.is_node and self.b.is_node)

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Its angle in the plane."""
        return planar_coordinates(self)
