"""Distances: two points keep their distance, as the ends of a rigid massless rod do."""

from __future__ import annotations

from dataclasses import dataclass

from ancfsparse.scene.bodies.body import Builder, Led, Point
from ancfsparse.scene.joints.frame_vectors import point
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.joints.rod import HalfSquare
from ancfsparse.scene.records.prescribed_motion import Course


@dataclass(frozen=True, eq=False)
class Distance(Joint):
    """Keep the distance of two points.

    Attributes
    ----------
    a, b : Point
        The points.
    length : float
        Their distance in the reference shape [m].
    course : Course, optional
        The distance over time, where it is not kept.
    """

    a: Point
    b: Point
    length: float
    course: Course | None = None
    name = "distance"

    def lower(self, builder: Builder) -> None:
        """State (|r_a - r_b|^2 - l^2) / (2 l) = 0: in metres, with gradients of length one."""
        apart = point(builder, self.a) - point(builder, self.b)
        positions = {
            int(k) for node in self.nodes for k in builder.ends(node)[:, : len(apart.terms)].ravel()
        }
        terms, about = [], []
        for own, origin in zip(apart.terms, self.a.position, strict=True):
            for k, w in own.items():
                for j, x in own.items():
                    terms.append((0.5 / self.length * w * x, k, j))
                    # Weights of positions add up to zero, so they may be counted from anywhere.
                    about.append(float(origin) if {k, j} <= positions else 0.0)
        label = f"distance of {self.a!r} and {self.b!r}"
        led = None if self.course is None else Led(self.course, 0, HalfSquare(self.length))
        offset = -0.5 * self.length if led is None else 0.0
        builder.equation(label, offset, *terms, about=about, led=led)

    @property
    def nodes(self) -> tuple[Point, ...]:
        """Both points."""
        return self.a, self.b

    @property
    def links(self) -> tuple[tuple[Point, Point], ...]:
        """The line between both."""
        return ((self.a, self.b),)

    @property
    def has_multipliers(self) -> bool:
        """Whether it is made by an equation: always."""
        return True
