"""Joints between two points, or a point and the ground: hinges, universal and sliding joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ancfsparse.array_types import Vector
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
from ancfsparse.scene.kinematics.linear_forms import LinearForm


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
        Its axes in the reference shape, unit vectors.
    """

    a: Point
    b: Point | None
    axes: tuple[Vector, ...] = ()
    is_point: ClassVar[bool] = True
    has_multipliers = True  # joints without equations are rare

    @property
    def joins(self) -> bool:
        """True if it makes two points coincide."""
        return self.is_point and self.b is not None

    @property
    def mark(self) -> Mark | None:
        """Symbol in pictures: a pin if it fixes a point to the ground."""
        return Mark("pin") if self.b is None and self.is_point else None

    @property
    def label(self) -> str:
        """Name in messages about its equations."""
        other = "the ground" if self.b is None else repr(self.b)
        return f"{self.name} joint of {self.a!r} and {other}"

    @property
    def axis(self) -> Vector | None:
        """Its only axis; None if it has none or two."""
        return self.axes[0] if len(self.axes) == 1 else None

    def _points(self, builder: ConstraintBuilder) -> tuple[LinearForm, LinearForm]:
        other = self.a.position if self.b is None else self.b
        return point(builder, self.a), point(builder, other)

    def _share_point(self, builder: ConstraintBuilder) -> None:
        equate(builder, self.label, *self._points(builder), self.arm)

    def _share_axis(self, builder: ConstraintBuilder, axis: Vector) -> None:
        """Keep an axis of both parallel: identify vectors if possible, else add two equations."""
        one, other = direction(builder, self.a, axis), direction(builder, self.b, axis)
        if can_identify(one, other):
            equate(builder, f"{self.label}, axis", one, other, self.arm, self.arm)
            return
        for k, normal in enumerate(normals(axis)):
            label = f"{self.label}, axis {k + 1}"
            make_orthogonal(builder, label, one, direction(builder, self.b, normal), self.arm)

    def _share_frame(self, builder: ConstraintBuilder) -> None:
        """Keep the frames of both parallel."""
        axes = self.a.beam.axes_of(self.a.beam.rows_of(self.a.index).start)
        ones = [direction(builder, self.a, axis) for axis in axes]
        others = [direction(builder, self.b, axis) for axis in axes]
        if all(can_identify(*pair) for pair in zip(ones, others, strict=True)):
            for one, other in zip(ones, others, strict=True):
                equate(builder, f"{self.label}, axes", one, other, self.arm, self.arm)
            return
        pairs = [(0, 1)] if len(axes) == 2 else [(0, 1), (0, 2), (1, 2)]
        for i, j in pairs:
            label = f"{self.label}, turn {i + j}"
            make_orthogonal(builder, label, ones[i], others[j], self.arm)

    def _share_line(self, builder: ConstraintBuilder, axis: Vector) -> None:
        """Keep the point of `a` on the line through the point of `b` along an axis of `b`.

        At the ground this fixes the coordinates along the axes of space normal to the line.
        """
        one, other = self._points(builder)
        for k, normal in enumerate(normals(axis)):
            coordinate = None if self.b or not builder.lines else one.component(normal)
            if coordinate is not None:
                builder.hold(coordinate)
                continue
            label = f"{self.label}, across {k + 1}"
            make_orthogonal(builder, label, one - other, direction(builder, self.b, normal), 1.0)


@dataclass(frozen=True, eq=False)
class Revolute(TwoBodyJoint):
    """Two points coincide, and an axis of both."""

    name = "revolute"
    coordinate_names = ("angle",)

    def lower(self, builder: ConstraintBuilder) -> None:
        """Share the point and the axis."""
        self._share_point(builder)
        self._share_axis(builder, self.axes[0])


@dataclass(frozen=True, eq=False)
class Universal(TwoBodyJoint):
    """Two points coincide, and an axis of the first stays normal to one of the second."""

    name = "universal"

    def lower(self, builder: ConstraintBuilder) -> None:
        """Share the point, and keep the axes orthogonal."""
        self._share_point(builder)
        one, other = (
            direction(builder, self.a, self.axes[0]),
            direction(builder, self.b, self.axes[1]),
        )
        make_orthogonal(builder, f"{self.label}, angle", one, other, self.arm)


@dataclass(frozen=True, eq=False)
class Cylindrical(TwoBodyJoint):
    """A point stays on an axis of both bodies, free to move along it and rotate about it."""

    name = "cylindrical"
    is_point = False
    coordinate_names = ("angle", "displacement")

    def lower(self, builder: ConstraintBuilder) -> None:
        """Share the axis, and keep the point on it."""
        self._share_axis(builder, self.axes[0])
        self._share_line(builder, self.axes[0])


@dataclass(frozen=True, eq=False)
class Prismatic(TwoBodyJoint):
    """A point stays on an axis of the other body, without relative rotation."""

    name = "prismatic"
    is_point = False
    coordinate_names = ("displacement",)

    def lower(self, builder: ConstraintBuilder) -> None:
        """Share the frame, and keep the point on the axis."""
        self._share_frame(builder)
        self._share_line(builder, self.axes[0])
