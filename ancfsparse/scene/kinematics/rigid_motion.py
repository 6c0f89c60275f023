"""Velocity fields of rigid motions, and inertia."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_finite, check_reals, check_vector
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value


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
