"""Joint coordinates as functions: the angle of a hinge, the displacement of a sliding joint."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.scene.bodies.body import ConstraintBuilder, Point
from ancfsparse.scene.geometry.section_frames import normals
from ancfsparse.scene.joints.frame_vectors import direction, point
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.kinematics.joint_coordinates import ALONG, ANGLE, LENGTH, JointCoordinate


def joint_coordinate(builder: ConstraintBuilder, joint: Joint, of: str) -> JointCoordinate:
    """Return a coordinate of a joint as a function of q.

    Parameters
    ----------
    of : str
        ``"angle"``, the rotation of the first side relative to the second one about the axis since
        the reference shape; or ``"displacement"``, of its point relative to the point of the second
        side along the axis.
    """
    return _angle(builder, joint) if of == "angle" else _displacement(builder, joint)


def reference_value(joint: Joint, of: str) -> float:
    """Return a coordinate of a joint in the reference shape [rad or m]."""
    a, b = joint.sides
    if of == "angle" or b is None or joint.axis is None:
        return 0.0
    return float((a.position - b.position) @ joint.axis)


def distance(
    builder: ConstraintBuilder, one: Point | Vector, other: Point | Vector
) -> JointCoordinate:
    """Return the distance of two points, of which one may be fixed in space."""
    difference = point(builder, one) - point(builder, other)
    return JointCoordinate.of(LENGTH, [difference, difference])


def reference_normals(axis: Vector | None) -> tuple[Vector, Vector]:
    """Return two normals of an axis, (dim,), the second rotated by +90 degrees from the first."""
    if axis is None:
        return np.array([1.0, 0.0]), np.array([0.0, 1.0])
    first = normals(axis)[0]
    return first, np.cross(axis, first)


def _angle(builder: ConstraintBuilder, joint: Joint) -> JointCoordinate:
    a, b = joint.sides
    one, other = reference_normals(joint.axis)
    normals_of_b = [direction(builder, b, vector) for vector in (one, other)]
    return JointCoordinate.of(ANGLE, [direction(builder, a, one), *normals_of_b])


def _displacement(builder: ConstraintBuilder, joint: Joint) -> JointCoordinate:
    a, b = joint.sides
    difference = point(builder, a) - point(builder, a.position if b is None else b)
    axis = joint.axis
    assert axis is not None
    return JointCoordinate.of(ALONG, [difference, direction(builder, b, axis)])
