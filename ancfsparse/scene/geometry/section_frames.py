"""Unit vectors of cross-sections."""

from __future__ import annotations

import math

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_positive
from ancfsparse.errors import InputError
from ancfsparse.scene.sections.cross_section import AnySection

MAX_SINE_UPRIGHT = 1e-8  # of the angle to the z axis of a beam that has e_y = +y
MIN_SINE_UP = 1e-6  # of the angle between a beam and `up`


def section_axes(axis: Vector, up: Vector | None, where: str) -> Vector:
    """Return the unit vectors of a section of a straight beam.

    Parameters
    ----------
    axis : ndarray, shape (dim,)
        From the start of the beam to its end [m], not zero.
    up : ndarray, shape (3,), or None
        As in `Scene.add_beam`.
    where : str
        Name of the beam, for the message.

    Returns
    -------
    ndarray, shape (dim, dim)
        Rows e_x, e_y and, if spatial, e_z: right-handed and orthonormal.  In the plane e_y is e_x
        rotated by +90 degrees.
    """
    e_x = axis / np.linalg.norm(axis)
    if len(axis) == 2:
        return np.array([e_x, [-e_x[1], e_x[0]]])
    if up is None:
        side = np.cross([0.0, 0.0, 1.0], e_x)
        if np.linalg.norm(side) < MAX_SINE_UPRIGHT:
            side = np.array([0.0, 1.0, 0.0])
    else:
        direction = up / check_positive(f"length of `up` of {where}", np.linalg.norm(up))
        side = direction - (direction @ e_x) * e_x
        if np.linalg.norm(side) < MIN_SINE_UP:
            raise InputError(
                f"`up` of {where} is parallel to the beam and does not define where its section "
                "points: give a direction across the beam"
            )
    e_z = np.cross(e_x, side)
    e_z /= np.linalg.norm(e_z)
    return np.array([e_x, np.cross(e_z, e_x), e_z])


def section_frames(slopes: Vector) -> Vector:
    """Return the unit vectors of sections as `section_axes` does without `up`, (n, dim, dim)."""
    if slopes.shape[1] == 2:
        return np.stack([slopes, np.stack([-slopes[:, 1], slopes[:, 0]], axis=1)], axis=1)
    side = np.cross([0.0, 0.0, 1.0], slopes)
    side[np.linalg.norm(side, axis=1) < MAX_SINE_UPRIGHT] = 0.0, 1.0, 0.0
    e_z = np.cross(slopes, side)
    e_z /= np.linalg.norm(e_z, axis=1)[:, None]
    return np.stack([slopes, np.cross(e_z, slopes), e_z], axis=1)


def along_principal_axes(frames: Vector, section: AnySection) -> Vector:
    """Rotate frames (..., dim, dim) about e_x to the principal axes of a section."""
    angle = section.frame_angle
    if not angle:
        return frames
    c, s = math.cos(angle), math.sin(angle)
    e_x, e_y, e_z = np.moveaxis(frames, -2, 0)
    return np.stack([e_x, c * e_y + s * e_z, c * e_z - s * e_y], axis=-2)


def normals(axis: Vector) -> Vector:
    """Return orthonormal vectors normal to a unit vector, (dim - 1, dim)."""
    if len(axis) == 2:
        return np.array([[-axis[1], axis[0]]])
    # If the axis is a coordinate axis, the normals are the others.
    order = np.argsort(np.abs(axis), kind="stable")
    first = np.eye(3)[min(order[0], order[1])]
    one = first - (first @ axis) * axis
    one /= np.linalg.norm(one)
    return np.array([one, np.cross(axis, one)])
