"""The catenary, in which an inextensible cable hangs."""

from __future__ import annotations

import math

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError

MIN_SPAN_RATIO = 1e-6  # horizontal distance of the ends, over the length


class Catenary:
    """An inextensible cable that hangs between two points.

    Parameters
    ----------
    what : str
        Name of the cable in messages.
    start, end : ndarray, shape (dim,)
        Its ends [m].
    length : float
        Its length [m], more than the distance of the ends.
    gravity : ndarray, shape (dim,)
        Of the scene [m/s2].

    Raises
    ------
    InputError
        If there is no gravity, or one end is above the other.
    """

    def __init__(
        self, what: str, start: Vector, end: Vector, length: float, gravity: Vector
    ) -> None:
        weight = float(np.linalg.norm(gravity))
        if weight == 0.0:
            raise InputError(
                f"{what} is longer than the distance of its ends and has no gravity to hang in: "
                "give the scene a gravity, or the beam a curve"
            )
        self.length, self._start, self._up = length, start, -gravity / weight
        rise = float((end - start) @ self._up)
        across = end - start - rise * self._up
        span = float(np.linalg.norm(across))
        if span <= MIN_SPAN_RATIO * length:
            raise InputError(
                f"{what} would hang folded, since its ends are on one vertical: give it a curve "
                "with a bow at the bottom, or move an end aside"
            )
        self._across = across / span
        # With x = 0 at the lowest point: length = 2 a sinh(half) cosh(middle), and the rise with
        # sinh(middle), where half is half the span and middle the middle between the ends, over a.
        middle = math.atanh(rise / length)
        ratio = math.sqrt((length - rise) * (length + rise)) / span
        half = _inverse_sinhc(ratio)
        self._a = 0.5 * span / half
        self._before = self._a * math.sinh(half - middle)

    def at(self, s: Vector) -> tuple[Vector, Vector]:
        """Return positions [m] and unit tangents, each (k, dim), at arc lengths (k,) [m]."""
        first, here = -self._before / self._a, (s - self._before) / self._a
        x = self._a * (np.arcsinh(here) - np.arcsinh(first))
        # hypot(1, u) - hypot(1, v), without cancellation
        y = (s / self._a) * (here + first) / (np.hypot(1.0, here) + np.hypot(1.0, first))
        positions = self._start + x[:, None] * self._across + self._a * y[:, None] * self._up
        tangents = self._across + here[:, None] * self._up
        return positions, tangents / np.hypot(1.0, here)[:, None]


def _inverse_sinhc(ratio: float) -> float:
    """Return x > 0 with sinh(x) / x equal to a ratio above 1, by Newton's method."""
    x = math.sqrt(6.0 * (ratio - 1.0)) if ratio < 3.0 else math.log(2.0 * ratio)
    for _ in range(60):
        slope = (x * math.cosh(x) - math.sinh(x)) / x**2
        change = (math.sinh(x) / x - ratio) / slope
        x -= change
        if abs(change) <= 4e-16 * x:
            break
    return x
