"""Interpolation: positions from coordinates, and states between two others."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector


def interpolate(places: tuple[NDArray[np.integer[Any]], Vector], q: Vector) -> Vector:
    """Evaluate a position or slope for all states.

    Parameters
    ----------
    places : tuple of ndarray
        Places (dim, p) and weights (p,) of its coordinates, as a system returns them.
    q : ndarray, shape (..., n)
        Coordinates, or velocities or accelerations: interpolation is linear.

    Returns
    -------
    ndarray, shape (..., dim)
        The interpolated vectors.
    """
    indices, weights = places
    return np.asarray(q[..., indices] @ weights)


def interpolate_cubic(
    s: Vector, h: Vector, q0: Vector, q1: Vector, v0: Vector, v1: Vector
) -> Vector:
    """Return the cubic with these values and rates at the ends of a step, at the fraction `s`."""
    r = 1.0 - s
    return (1.0 + 2.0 * s) * r**2 * q0 + (1.0 + 2.0 * r) * s**2 * q1 + h * s * r * (r * v0 - s * v1)
