"""What joints leave free: the angle of a hinge, the displacement of a sliding joint."""

from __future__ import annotations

import numpy as np

from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.geometry.section_frames import normals
from ancfsparse.scene.joints.frame_vectors import direction, point
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.kinematics.joint_coordinates import ALONG, ANGLE, LENGTH, JointCoordinate
from ancfsparse.scene.kinematics.linear_forms import LinearForm, Vector


def joint_coordinate(builder: ConstraintBuilder, joint: Joint, of: str) -> JointCoordinate:
    """Return a freedom of a joint.

    Parameters
    ----------
    builder : ConstraintBuilder
        What gives the coordinates.
    joint : Joint
        One that has the freedom.
    of : str
        ``"angle"``, by which the first side is turned against the second one about the axis since
        the reference shape; or ``"displacement"`` of its point along the axis, from that of the
        second one.
    """
    return _angle(builder, joint) if of == "angle" else _displacement(builder, joint)


def at_reference(joint: Joint, of: str) -> float:
    """Return a freedom of a joint in the reference shape [rad or m]."""
    a, b = joint.sides
    if of == "angle" or b is None or joint.axis is None:
        return 0.0
    return float((a.position - b.position) @ joint.axis)


def distance(
    builder: ConstraintBuilder, one: Point | Vector, other: Point | Vector
) -> JointCoordinate:
    """Return the distance of two points, of which one may be fixed in space."""
    apart = _place(builder, one) - _place(builder, other)
    return JointCoordinate.of(LENGTH, [apart, apart])


def first_across(axis: Vector | None) -> tuple[Vector, Vector]:
    """Return two directions across an axis, (dim,), the second a quarter turn after the first."""
    if axis is None:
        return np.array([1.0, 0.0]), np.array([0.0, 1.0])
    first = normals(axis)[0]
    return first, np.cross(axis, first)


def _angle(builder: ConstraintBuilder, joint: Joint) -> JointCoordinate:
    a, b = joint.sides
    one, other = first_across(joint.axis)
    across = [_direction(builder, b, each) for each in (one, other)]
    return JointCoordinate.of(ANGLE, [direction(builder, a, one), *across])


def _displacement(builder: ConstraintBuilder, joint: Joint) -> JointCoordinate:
    a, b = joint.sides
    apart = point(builder, a) - _place(builder, a.position if b is None else b)
    axis = joint.axis
    assert axis is not None
    return JointCoordinate.of(ALONG, [apart, _direction(builder, b, axis)])


def _direction(builder: ConstraintBuilder, node: Point | None, vector: Vector) -> LinearForm:
    return LinearForm.fixed(vector) if node is None else direction(builder, node, vector)


def _place(builder: ConstraintBuilder, end: Point | Vector) -> LinearForm:
    return point(builder, end) if isinstance(end, Point) else LinearForm.fixed(end)
