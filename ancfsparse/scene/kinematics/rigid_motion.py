"""Velocity fields of rigid motions, orientations, and inertia."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_finite, check_reals, check_vector
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value

ROUNDING_RATIO = 1e-9  # relative error of inertias, unit vectors and right angles


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """The velocity field of a rigid motion.

    Parameters
    ----------
    point : ndarray, shape (dim,)
        Position of a point [m].
    velocity : ndarray, shape (dim,)
        Velocity of that point [m/s].
    spin : ndarray, shape (dim, dim)
        Skew matrix of the angular velocity: the rate of a vector is spin times the vector [rad/s].
    """

    point: Vector
    velocity: Vector
    spin: Vector

    def __call__(self, positions: Vector) -> Vector:
        """Return the velocities at positions (k, dim), (k, dim)."""
        return np.asarray(self.velocity + (positions - self.point) @ self.spin.T)

    def rates(self, vectors: Vector) -> Vector:
        """Return the rates of vectors (..., dim) that rotate with it."""
        return np.asarray(vectors @ self.spin.T)


def spin_matrix(what: str, angular_velocity: ArrayLike, dim: int) -> Vector:
    """Return the skew matrix of a checked angular velocity, (dim, dim) [rad/s]."""
    if dim == 2:
        return check_finite(what, angular_velocity, "rad/s") * np.array([[0.0, -1.0], [1.0, 0.0]])
    x, y, z = check_vector(what, angular_velocity, 3, "rad/s").tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def check_inertia(what: str, inertia: ArrayLike | None, noun: str, tolerance: float) -> Vector:
    """Return a symmetric matrix (3, 3) [kg m2] from itself or from three principal moments.

    Rounding errors are at most `tolerance`, over the largest moment.
    """
    needed = f"3 principal moments or a 3 x 3 {noun}"
    numbers = check_reals(what, inertia, needed)
    if numbers.shape not in ((3,), (3, 3)):
        raise InputError(f"{what} must be {needed}, got {format_value(inertia)}")
    if not np.isfinite(numbers).all():
        raise InputError(f"{what} must be finite, got {format_value(inertia)}")
    matrix = np.diag(numbers) if numbers.ndim == 1 else numbers
    if np.abs(matrix - matrix.T).max() > tolerance * np.abs(matrix).max():
        raise InputError(f"{what} must be symmetric, got {format_value(inertia)}")
    return matrix


def second_moments(inertia: Vector) -> Vector:
    """Return the second moments int x x^T dm of a body from its inertia tensor, (3, 3)."""
    return np.asarray(0.5 * np.trace(inertia) * np.eye(3) - inertia)


def orientation_axes(what: str, dim: int, orientation: ArrayLike | None) -> Vector:
    """Return the unit vectors of a frame in rows, (dim, dim).

    Parameters
    ----------
    what : str
        Name of the orientation, for messages.
    dim : int
        Number of its axes, 2 or 3.
    orientation : float or array_like of shape (4,) or (3, 3), optional
        Rotation: in the plane an angle [rad]; in space a unit quaternion (real part first) or a
        matrix with the axes as columns.

    Raises
    ------
    InputError
        If it is not a rotation.
    """
    if orientation is None:
        return np.eye(dim)
    if dim == 2:
        angle = check_finite(what, orientation, "rad")
        c, s = np.cos(angle), np.sin(angle)
        return np.array([[c, s], [-s, c]])
    needed = "a unit quaternion (4 numbers) or a rotation matrix (3 x 3)"
    rotation = check_reals(what, orientation, needed)
    if rotation.shape not in ((4,), (3, 3)) or not np.isfinite(rotation).all():
        raise InputError(f"{what} must be {needed}, got {format_value(orientation)}")
    if rotation.shape == (4,):
        norm = float(np.linalg.norm(rotation))
        if abs(norm - 1.0) > ROUNDING_RATIO:
            raise InputError(f"{what} must be a unit quaternion, got one of length {norm:.9g}")
        return _matrix(rotation / norm).T
    off = float(np.abs(rotation.T @ rotation - np.eye(3)).max())
    if off > ROUNDING_RATIO:
        raise InputError(f"{what} must have orthonormal columns, but they are off by {off:.3g}")
    if np.linalg.det(rotation) < 0.0:
        raise InputError(f"{what} is left-handed, a reflection: change the sign of one column")
    left, _, right = np.linalg.svd(rotation)
    return np.asarray((left @ right).T)


def _matrix(quaternion: Vector) -> Vector:
    """Return the rotation matrix of a unit quaternion, real part first, (3, 3)."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
