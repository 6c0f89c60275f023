"""Joints between two points, or a point and the ground: hinges, universal and sliding joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.geometry.section_frames import normals
from ancfsparse.scene.joints.frame_vectors import (
    can_identify,
    direction,
    equate,
    make_orthogonal,
    point,
)
from ancfsparse.scene.joints.joint import Joint, Mark
from ancfsparse.scene.kinematics.linear_forms import LinearForm, Vector


@dataclass(frozen=True, eq=False)
class TwoBodyJoint(Joint):
    """A joint between a point and another one, or the ground.

    Attributes
    ----------
    a : Point
        A point.
    b : Point or None
        The other point; None is the ground.
    axes : tuple of ndarray, shape (dim,)
        Its directions in the reference shape, unit vectors.
    """

    a: Point
    b: Point | None
    axes: tuple[Vector, ...] = ()
    is_point: ClassVar[bool] = True

    @property
    def nodes(self) -> tuple[Point, ...]:
        """The points it joins."""
        return (self.a,) if self.b is None else (self.a, self.b)

    @property
    def joins(self) -> bool:
        """Whether it makes two points one."""
        return self.is_point and self.b is not None

    @property
    def mark(self) -> Mark | None:
        """How pictures show it: as a pin if it holds a point to the ground."""
        return Mark("pin") if self.b is None and self.is_point else None

    @property
    def has_multipliers(self) -> bool:
        """Whether equations are certain: numbering alone is rare."""
        return True

    @property
    def label(self) -> str:
        """Name in messages about its equations."""
        other = "the ground" if self.b is None else repr(self.b)
        return f"{self.name} joint of {self.a!r} and {other}"

    @property
    def size(self) -> float:
        """Length of the larger body, which scales directions to lengths [m]."""
        return self.arm

    @property
    def axis(self) -> Vector | None:
        """The axis that it has; None where it has none, or two."""
        return self.axes[0] if len(self.axes) == 1 else None

    def _points(self, builder: ConstraintBuilder) -> tuple[LinearForm, LinearForm]:
        other = LinearForm.fixed(self.a.position) if self.b is None else point(builder, self.b)
        return point(builder, self.a), other

    def _of_a(self, builder: ConstraintBuilder, vector: Vector) -> LinearForm:
        return direction(builder, self.a, vector)

    def _of_b(self, builder: ConstraintBuilder, vector: Vector) -> LinearForm:
        return LinearForm.fixed(vector) if self.b is None else direction(builder, self.b, vector)

    def _share_point(self, builder: ConstraintBuilder) -> None:
        equate(builder, self.label, *self._points(builder), self.size)

    def _share_axis(self, builder: ConstraintBuilder, axis: Vector) -> None:
        """Keep an axis of both parallel: one vector where it is one of each, else two equations."""
        one, other = self._of_a(builder, axis), self._of_b(builder, axis)
        if can_identify(one, other):
            equate(builder, f"{self.label}, axis", one, other, self.size, self.size)
            return
        for k, normal in enumerate(normals(axis)):
            label = f"{self.label}, axis {k + 1}"
            make_orthogonal(builder, label, one, self._of_b(builder, normal), self.size)

    def _share_frame(self, builder: ConstraintBuilder) -> None:
        """Keep all directions of both parallel."""
        axes = self.a.beam.axes_of(self.a.beam.rows_of(self.a.index).start)
        ones = [self._of_a(builder, axis) for axis in axes]
        others = [self._of_b(builder, axis) for axis in axes]
        if all(can_identify(*pair) for pair in zip(ones, others, strict=True)):
            for one, other in zip(ones, others, strict=True):
                equate(builder, f"{self.label}, axes", one, other, self.size, self.size)
            return
        pairs = [(0, 1)] if len(axes) == 2 else [(0, 1), (0, 2), (1, 2)]
        for i, j in pairs:
            label = f"{self.label}, turn {i + j}"
            make_orthogonal(builder, label, ones[i], others[j], self.size)

    def _share_line(self, builder: ConstraintBuilder, axis: Vector) -> None:
        """Keep the point of `a` on the line through that of `b` along an axis of `b`.

        Beside the ground that holds a coordinate for each axis of space across the line.
        """
        one, other = self._points(builder)
        for k, normal in enumerate(normals(axis)):
            held = None if self.b or not builder.lines else one.component(normal)
            if held is not None:
                builder.hold(held)
                continue
            label = f"{self.label}, across {k + 1}"
            make_orthogonal(builder, label, one - other, self._of_b(builder, normal), 1.0)


@dataclass(frozen=True, eq=False)
class Revolute(TwoBodyJoint):
    """Two points are one, and an axis of both is."""

    name = "revolute"

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Its angle."""
        return ("angle",)

    def lower(self, builder: ConstraintBuilder) -> None:
        """Share the point and the axis."""
        self._share_point(builder)
        self._share_axis(builder, self.axes[0])


@dataclass(frozen=True, eq=False)
class Universal(TwoBodyJoint):
    """Two points coincide, and an axis of the first stays at a right angle to one of the second."""

    name = "universal"

    def lower(self, builder: ConstraintBuilder) -> None:
        """Share the point, and hold the angle."""
        self._share_point(builder)
        one, other = self._of_a(builder, self.axes[0]), self._of_b(builder, self.axes[1])
        make_orthogonal(builder, f"{self.label}, angle", one, other, self.size)


@dataclass(frozen=True, eq=False)
class Cylindrical(TwoBodyJoint):
    """A point of one body stays on an axis of both, along and about which it is free."""

    name = "cylindrical"
    is_point = False

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Its angle and its displacement."""
        return "angle", "displacement"

    def lower(self, builder: ConstraintBuilder) -> None:
        """Share the axis, and hold the point on it."""
        self._share_axis(builder, self.axes[0])
        self._share_line(builder, self.axes[0])


@dataclass(frozen=True, eq=False)
class Prismatic(TwoBodyJoint):
    """A point of one body stays on an axis of the other, without relative rotation."""

    name = "prismatic"
    is_point = False

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Its displacement."""
        return ("displacement",)

    def lower(self, builder: ConstraintBuilder) -> None:
        """Share all directions, and hold the point on the axis."""
        self._share_frame(builder)
        self._share_line(builder, self.axes[0])
