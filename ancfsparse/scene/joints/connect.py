"""Connections: two nodes at one place, free to turn against each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ancfsparse.scene.bodies.body import LINEAR, ConstraintBuilder, Point
from ancfsparse.scene.joints.joint import Joint, in_the_plane
from ancfsparse.scene.records.record import At, PointRef, Record


@dataclass(frozen=True, eq=False)
class ConnectSpec(Record):
    """The record of `Scene.connect`."""

    a: PointRef
    b: PointRef
    apart: bool = False
    method = "connect"

    def describe(self, at: At, made: Any) -> str:
        """Describe everything that its numbering follows from."""
        return f"connection ({at(self.a)}; {at(self.b)})" + ", apart" * self.apart


@dataclass(frozen=True, eq=False)
class Connect(Joint):
    """Let two nodes share one position, free to turn against each other.

    Attributes
    ----------
    a, b : Point
        The nodes.
    apart : bool
        Whether they may be apart in the reference shape, so that equations bring them together.
    """

    a: Point
    b: Point
    apart: bool = False
    name = "connection"

    def lower(self, builder: ConstraintBuilder) -> None:
        """Share the position; points of bodies that are not their origins by equations."""
        if not self.has_multipliers:
            builder.share(builder.position(self.a), builder.position(self.b))
            return
        ends = [(1.0, builder.point(self.a)), (-1.0, builder.point(self.b))]
        for d in range(self.a.beam.dim):
            terms = [
                (sign * w, place, LINEAR)
                for sign, (places, weights) in ends
                for w, place in zip(weights, places[d], strict=True)
            ]
            label = f"connection of {self.a!r} and {self.b!r}, component {d + 1}"
            size = max(node.beam.size for node in self.nodes)
            builder.equation(label, 0.0, *terms, size=size)

    @property
    def has_multipliers(self) -> bool:
        """Whether it is made by equations."""
        return self.apart or not (self.a.is_node and self.b.is_node)

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """In the plane its angle."""
        return in_the_plane(self)

    @property
    def nodes(self) -> tuple[Point, ...]:
        """Both nodes."""
        return self.a, self.b

    @property
    def joins(self) -> bool:
        """Whether it makes its nodes one point: always."""
        return True
