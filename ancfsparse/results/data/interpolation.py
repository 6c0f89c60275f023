"""Interpolation of positions and slopes from coordinates."""

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
