"""Interpolate states between steps by polynomials through the states at their ends."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from math import prod

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector


def interpolate_smooth(
    s: Vector, k: NDArray[np.intp], h: float, q: Vector, v: Vector, a: Vector
) -> tuple[Vector, Vector]:
    """Return positions and velocities in equal steps that resolve all vibrations.

    The polynomial interpolates positions, velocities and accelerations at up to four ends of steps:
    near the limit of stability a step is almost half a vibration, and its two ends do not determine
    its continuation.

    Parameters
    ----------
    s : (j,) float
        Fractions of steps.
    k : (j,) int
        Numbers of the ends before.
    h : float
        Step [s].
    q, v, a : (n_ends, n) float
        States at the ends of the steps; two or more.
    """
    points = min(4, len(q))
    first = np.clip(k - (points - 1) // 2, 0, len(q) - points)
    x = s + (k - first) - 0.5 * (points - 1)  # from the middle of those ends
    inverse = _hermite_coefficients(points)
    powers = np.arange(3.0 * points)
    basis = x[:, None] ** powers
    rates = powers[1:] * x[:, None] ** powers[:-1]
    weights, speeds = basis @ inverse, rates @ inverse[1:]
    centre = q[k]
    position, velocity = centre.copy(), np.zeros_like(centre)
    for j in range(points):
        # Differences from the state before, so that weights are not rounded relative to positions.
        terms = (q[first + j] - centre, h * v[first + j], h**2 * a[first + j])
        for i, term in enumerate(terms):
            position += weights[:, i * points + j, None] * term
            velocity += speeds[:, i * points + j, None] * term
    return position, velocity / h


def differentiate_quintics(
    t: Vector, ends: Vector, states: tuple[Vector, ...], order: int = 0
) -> Vector:
    """Return a derivative of polynomials of degree five, each between two states.

    Parameters
    ----------
    t : (j,) float
        Times [s].
    ends : (n_ends,) float
        Times of the states [s].
    states : tuple of (n_ends, n) float
        Positions, velocities and accelerations; others are not used.
    order : int, optional
        Order of the derivative.
    """
    q, v, a = states[:3]
    k = np.clip(np.searchsorted(ends, t, side="right") - 1, 0, len(ends) - 2)
    h = (ends[k + 1] - ends[k])[:, None]
    x = (t - ends[k])[:, None] / h - 0.5
    values = (0.0 * q[k], q[k + 1] - q[k], h * v[k], h * v[k + 1], h**2 * a[k], h**2 * a[k + 1])
    coefficients = np.einsum("pi,ijn->pjn", _hermite_coefficients(2), np.array(values))
    out = q[k] if order == 0 else 0.0 * q[k]
    for power in range(order, 6):
        factor = prod(range(power - order + 1, power + 1))
        out += factor * x ** (power - order) * coefficients[power] / h**order
    return out


@lru_cache(maxsize=4)
def _hermite_coefficients(points: int) -> Vector:
    """Return coefficients, lowest power first, from values and two rates at equal distances."""
    nodes = [Fraction(2 * j + 1 - points, 2) for j in range(points)]
    size = 3 * points
    rows = [
        [
            prod(range(p - d + 1, p + 1)) * x ** (p - d) if p >= d else Fraction(0)
            for p in range(size)
        ]
        for d in range(3)
        for x in nodes
    ]
    # Exact Gauss-Jordan elimination: floating-point numbers would lose a third of the digits.
    table = [[Fraction(y) for y in row] + [Fraction(i == j) for j in range(size)]
             for i, row in enumerate(rows)]  # fmt: skip
    for i in range(size):
        pivot = next(j for j in range(i, size) if table[j][i] != 0)
        table[i], table[pivot] = table[pivot], table[i]
        table[i] = [y / table[i][i] for y in table[i]]
        for j in range(size):
            if j != i and table[j][i] != 0:
                factor = table[j][i]
                table[j] = [y - factor * z for y, z in zip(table[j], table[i], strict=True)]
    return np.array([[float(y) for y in row[size:]] for row in table])
