"""Interpolation of the axis between two nodes.

Elements with slopes have a cubic Hermite axis with the positions and slopes of both nodes; slopes
are derivatives by the length of the reference shape.  Strings are straight between two positions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector


def position_weights(xi: ArrayLike, length: ArrayLike, straight: bool = False) -> Vector:
    """Return the weights of the nodal values in the position at a point.

    Parameters
    ----------
    xi : array_like
        Relative position in the element, from 0 to 1 [-].
    length : array_like
        Length of the element [m], of a shape compatible with `xi`.
    straight : bool, optional
        Whether the nodes have positions only.

    Returns
    -------
    ndarray, shape (..., 4), or (..., 2) if straight
        Weights, 1 and m in turn.
    """
    x, h = np.broadcast_arrays(np.asarray(xi, dtype=float), np.asarray(length, dtype=float))
    if straight:
        return np.stack([1.0 - x, x], axis=-1)
    return np.stack(
        [
            1.0 - 3.0 * x**2 + 2.0 * x**3,
            h * (x - 2.0 * x**2 + x**3),
            3.0 * x**2 - 2.0 * x**3,
            h * (x**3 - x**2),
        ],
        axis=-1,
    )


def slope_weights(xi: ArrayLike, length: ArrayLike, straight: bool = False) -> Vector:
    """Return the weights in the slope at a point, the derivative of `position_weights` by length.

    Parameters
    ----------
    xi, length, straight
        As in `position_weights`.

    Returns
    -------
    ndarray, shape (..., 4), or (..., 2) if straight
        Weights, 1/m and 1 in turn.
    """
    x, h = np.broadcast_arrays(np.asarray(xi, dtype=float), np.asarray(length, dtype=float))
    if straight:
        return np.stack([-1.0 / h, 1.0 / h], axis=-1)
    first = 6.0 * (x**2 - x) / h
    return np.stack([first, 1.0 - 4.0 * x + 3.0 * x**2, -first, 3.0 * x**2 - 2.0 * x], axis=-1)


def bend_weights(xi: ArrayLike, length: ArrayLike, straight: bool = False) -> Vector:
    """Return the weights in the derivative of the slope at a point.

    Parameters
    ----------
    xi, length, straight
        As in `position_weights`.

    Returns
    -------
    ndarray, shape (..., 4), or (..., 2) if straight
        Weights, 1/m2 and 1/m in turn.
    """
    x, h = np.broadcast_arrays(np.asarray(xi, dtype=float), np.asarray(length, dtype=float))
    if straight:
        return np.zeros((*x.shape, 2))
    first = (12.0 * x - 6.0) / h**2
    return np.stack([first, (6.0 * x - 4.0) / h, -first, (6.0 * x - 2.0) / h], axis=-1)


def integral_weights(length: ArrayLike, straight: bool = False) -> Vector:
    """Return the weights in the integral of the position over the length of an element.

    Parameters
    ----------
    length : array_like
        Length of each element [m].
    straight : bool, optional
        Whether the nodes have positions only.

    Returns
    -------
    ndarray, shape (..., 4), or (..., 2) if straight
        Weights, m and m^2 in turn.
    """
    h = np.asarray(length, dtype=float)
    if straight:
        return np.stack([h / 2.0, h / 2.0], axis=-1)
    return np.stack([h / 2.0, h**2 / 12.0, h / 2.0, -(h**2) / 12.0], axis=-1)
