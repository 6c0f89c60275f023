"""The angle of a shaft that starts to turn."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_finite, check_moderate, set_fields
from ancfsparse.scene.records.signal import Signal, TimeScale


@dataclass(frozen=True)
class SpinUp(Signal):
    """An angle whose rate rises smoothly from zero to a constant (Kane, Simo).

    During the rise the angular acceleration is ``speed / rise (1 - cos(2 pi t / rise))``.

    Parameters
    ----------
    speed : float
        Final angular velocity [rad/s].
    rise : float
        Duration of the rise from t = 0 [s].
    """

    speed: float
    rise: float
    smoothness = 3.0

    def __post_init__(self) -> None:
        """Check the numbers and store them in double precision."""
        speed = check_finite("speed of a spin-up", self.speed, "rad/s")
        set_fields(self, speed=speed, rise=check_moderate("rise of a spin-up", self.rise, "s"))

    @property
    def time_scale(self) -> TimeScale:
        """Its duration, begin and end."""
        return TimeScale(self.rise, (0.0, self.rise))

    def __call__(self, t: ArrayLike) -> Vector:
        """Return the angle at a time, or at all of an array of times [rad]."""
        t, omega = np.maximum(np.asarray(t, dtype=float), 0.0), 2.0 * math.pi / self.rise
        x = np.minimum(t, self.rise)
        integral = 0.5 * x**2 + (np.cos(omega * x) - 1.0) / omega**2
        return np.asarray(self.speed / self.rise * integral + self.speed * (t - x))

    def rate(self, t: ArrayLike, order: int = 1) -> Vector:
        """Return its first or second derivative [rad/s, rad/s2]."""
        omega = 2.0 * math.pi / self.rise
        x = np.clip(np.asarray(t, dtype=float), 0.0, self.rise)
        integral = x - np.sin(omega * x) / omega if order == 1 else 1.0 - np.cos(omega * x)
        return np.asarray(self.speed / self.rise * integral)
