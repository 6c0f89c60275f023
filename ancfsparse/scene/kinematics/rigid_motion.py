"""Velocity fields of rigid motions, and inertia."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class UniformVelocity:
    """The same velocity everywhere.

    Parameters
    ----------
    velocity : ndarray, shape (dim,)
        It [m/s].
    """

    velocity: Vector

    def __call__(self, places: Vector) -> Vector:
        """Return it for every place, shape (k, dim)."""
        return np.broadcast_to(self.velocity, np.shape(places)).copy()


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """The velocity field of a rigid motion.

    Parameters
    ----------
    place : ndarray, shape (dim,)
        A point [m].
    velocity : ndarray, shape (dim,)
        Velocity of that point [m/s].
    spin : ndarray, shape (dim, dim)
        The skew matrix that takes a vector to its rate [rad/s].
    """

    place: Vector
    velocity: Vector
    spin: Vector

    def __call__(self, places: Vector) -> Vector:
        """Return the velocities of places, shape (k, dim)."""
        return np.asarray(self.velocity + (places - self.place) @ self.spin.T)

    def turned(self, vectors: Vector) -> Vector:
        """Return the rates of vectors (..., dim) that rotate with it."""
        return np.asarray(vectors @ self.spin.T)


def second_moments(inertia: Vector) -> Vector:
    """Return the integral of x x^T over the mass of a body from its moments of inertia, (3, 3)."""
    return np.asarray(0.5 * np.trace(inertia) * np.eye(3) - inertia)
