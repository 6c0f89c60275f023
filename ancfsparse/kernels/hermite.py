"""The axis between two nodes: what the numbers of its ends weigh.

Elements with slopes have Hermite's cubic along their axis: the numbers are position and slope of
the first node, then of the second; slopes are per length of the reference shape.  Strings, which
have none, are straight: the numbers are the two positions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = NDArray[np.float64]


def position_weights(xi: ArrayLike, length: ArrayLike, straight: bool = False) -> Vector:
    """Weigh the ends for the position at a point.

    Parameters
    ----------
    xi : array_like
        Place within the element, from 0 to 1 [-].
    length : array_like
        Of the element [m], of a shape that goes with `xi`.
    straight : bool, optional
        Whether the ends have positions alone.

    Returns
    -------
    ndarray, shape (..., 4) or, where straight, (..., 2)
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
    """Weigh the ends for the slope at a point: the derivative of `position_weights` by length.

    Parameters
    ----------
    xi, length, straight
        As there.

    Returns
    -------
    ndarray, shape (..., 4) or, where straight, (..., 2)
        Weights, 1/m and 1 in turn.
    """
    x, h = np.broadcast_arrays(np.asarray(xi, dtype=float), np.asarray(length, dtype=float))
    if straight:
        return np.stack([-1.0 / h, 1.0 / h], axis=-1)
    first = 6.0 * (x**2 - x) / h
    return np.stack([first, 1.0 - 4.0 * x + 3.0 * x**2, -first, 3.0 * x**2 - 2.0 * x], axis=-1)


def bend_weights(xi: ArrayLike, length: ArrayLike, straight: bool = False) -> Vector:
    """Weigh the ends for the derivative of the slope at a point.

    Parameters
    ----------
    xi, length, straight
        As there.

    Returns
    -------
    ndarray, shape (..., 4) or, where straight, (..., 2)
        Weights, 1/m2 and 1/m in turn.
    """
    x, h = np.broadcast_arrays(np.asarray(xi, dtype=float), np.asarray(length, dtype=float))
    if straight:
        return np.zeros((*x.shape, 2))
    first = (12.0 * x - 6.0) / h**2
    return np.stack([first, (6.0 * x - 4.0) / h, -first, (6.0 * x - 2.0) / h], axis=-1)


def integral_weights(length: ArrayLike, straight: bool = False) -> Vector:
    """Weigh the ends for the integral of the position over the length of an element.

    Parameters
    ----------
    length : array_like
        Of each element [m].
    straight : bool, optional
        Whether the ends have positions alone.

    Returns
    -------
    ndarray, shape (..., 4) or, where straight, (..., 2)
        Weights, m and m^2 in turn.
    """
    h = np.asarray(length, dtype=float)
    if straight:
        return np.stack([h / 2.0, h / 2.0], axis=-1)
    return np.stack([h / 2.0, h**2 / 12.0, h / 2.0, -(h**2) / 12.0], axis=-1)
