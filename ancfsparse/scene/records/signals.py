"""Signals: tables, ramps, sines and pulses.

A signal is called with a time t [s] and returns a value, or with an array (k,) of times and returns
k values.  A value is a number or a vector in the unit of the load: N, N m or N/m.
``Ramp(...) + Sine(...)`` is their sum, ``Ramp(...) + (2.0, 0.0)`` a ramp from another value, and
``-2.0 * Ramp(...)`` and ``Ramp(...) / 3.0`` are multiples.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import (
    check_choice,
    check_finite,
    check_flag,
    check_moderate,
    check_reals,
    set_fields,
)
from ancfsparse.errors import InputError
from ancfsparse.messages import checksum, format_value
from ancfsparse.scene.records.signal import (
    ScaledSignal,
    Signal,
    TimeScale,
    Value,
    checked_value,
)

# Relative rounding of a time as a multiple of a step.  Without it a pulse from 0.05012 s to
# 0.05018 s acted for 31 steps of 2 us.
TIME_ROUNDING = 8.0 * np.finfo(float).eps
# Of the last time of a run, as `count_steps` admits it.  The last of 50 steps to .21 s was 3e-17 s
# after the end of a table, and the run was refused.
END_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class Table(Signal):
    """Values at given times, interpolated linearly or smoothly.

    Parameters
    ----------
    times : array_like, shape (k,)
        Increasing times [s].
    values : array_like, shape (k,) or (k, n)
        The value at each of them [N, N m or N/m].
    outside : str, optional
        Value before the first time and after the last: ``"error"``, a call raises an error;
        ``"hold"``, the first and the last value; ``"zero"``.
    smooth : bool, optional
        If True, interpolate by a spline of fifth degree with four continuous derivatives, whose
        velocity and acceleration vanish at both ends, as a prescribed motion with
        ``outside="hold"`` requires.  It may overshoot values that change abruptly.

    Raises
    ------
    InputError
        If the shapes do not match, a number is not finite or the times do not increase; when it is
        called, if a time is outside and ``outside`` is ``"error"``.
    """

    times: Vector
    values: Vector
    outside: str = "error"
    smooth: bool = False
    coefficient = "values"

    def __post_init__(self) -> None:
        """Check the table and store a read-only copy."""
        times = check_reals("times of a table", self.times, "a list of numbers")
        values = check_reals("values of a table", self.values, "a list of numbers or of rows")
        if times.ndim != 1 or not len(times):
            raise InputError(
                f"times of a table must be a list of numbers, got {format_value(self.times)}"
            )
        if values.ndim not in (1, 2) or len(values) != len(times):
            raise InputError(
                f"values of a table must be one for each of its {len(times)} times, got shape "
                f"{values.shape}"
            )
        for what, numbers in (("times", times), ("values", values)):
            if not np.isfinite(numbers).all():
                row = int(np.argwhere(~np.isfinite(numbers))[0][0])
                raise InputError(f"{what} of a table must be finite, but in row {row} they are not")
        not_increasing = np.flatnonzero(np.diff(times) <= 0.0)
        if len(not_increasing):
            row = int(not_increasing[0])
            raise InputError(
                f"times of a table must increase, but {times[row + 1]:.6g} s follows "
                f"{times[row]:.6g} s in row {row + 1}: write a jump as a short interval"
            )
        check_choice("outside of a table", self.outside, ("error", "hold", "zero"))
        smooth = check_flag("smooth of a table", self.smooth)
        if smooth and (len(times) < 2 or self.outside == "zero"):
            raise InputError(
                "a smooth table needs two times or more, and the last value after them: take "
                "outside='hold'"
            )
        times.flags.writeable = values.flags.writeable = False
        set_fields(self, times=times, values=values, smooth=smooth)

    def __call__(self, t: ArrayLike) -> Vector:
        """Return the value at a time [s], or one row for each of an array of times (k,)."""
        t = np.asarray(t, dtype=float)
        first, last = float(self.times[0]), float(self.times[-1])
        is_outside = (t < first) | (t > last)
        if self.outside == "error" and is_outside.any():
            beyond = np.maximum(first - t, t - last)
            if beyond.max() > END_ROUNDING * max(abs(first), abs(last)):
                raise InputError(
                    f"the table has values from t = {first:.6g} s to {last:.6g} s, and none at "
                    f"{float(t.flat[beyond.argmax()]):.6g} s: extend it, or choose outside='hold' "
                    "or 'zero'"
                )
        if self.smooth:
            return np.asarray(self._spline(np.clip(t, first, last)))
        columns = self.values.reshape(len(self.times), -1).T
        out = np.stack([np.interp(t, self.times, column) for column in columns], axis=-1)
        if self.outside == "zero":
            out[is_outside] = 0.0
        return out if self.values.ndim == 2 else out[..., 0]

    @property
    def smoothness(self) -> float:
        """Number of continuous derivatives."""
        return 2.0 if self.smooth else 0.0

    @property
    def time_scale(self) -> TimeScale:
        """Its times, and the shortest interval between them."""
        return TimeScale(
            float(np.diff(self.times).min(initial=math.inf)), tuple(self.times.tolist())
        )

    @property
    def bound(self) -> float:
        """Largest magnitude of its values."""
        return float(np.linalg.norm(self.values.reshape(len(self.values), -1), axis=1).max())

    def _scale(self, operation: np.ufunc, number: float) -> Table:
        with np.errstate(over="ignore"):
            return replace(self, values=operation(self.values, number))

    def rate(self, t: ArrayLike, order: int = 1) -> Vector:
        """Return its first or second derivative, shaped like its values."""
        if not self.smooth:
            return self._no_rate(order)
        t = np.asarray(t, dtype=float)
        inside = (t >= self.times[0]) & (t <= self.times[-1])
        rates = self._spline(np.clip(t, self.times[0], self.times[-1]), order)
        return np.where(inside[..., None] if self.values.ndim == 2 else inside, rates, 0.0)

    @cached_property
    def _spline(self) -> Any:
        from scipy.interpolate import make_interp_spline

        ends = [(order, np.zeros(self.values.shape[1:])) for order in (1, 2)]
        return make_interp_spline(self.times, self.values, k=5, bc_type=(ends, ends))

    def __repr__(self) -> str:
        """Return the number of values and the interval."""
        shape = f", {self.values.shape[1]} in each row" if self.values.ndim == 2 else ""
        return (
            f"Table({len(self.times)} times from {self.times[0]:.6g} s to {self.times[-1]:.6g} s"
            f"{shape}, outside={self.outside!r}" + ", smooth=True" * self.smooth + ")"
        )

    def __eq__(self, other: object) -> bool:
        """Compare all values."""
        return isinstance(other, Table) and self.describe() == other.describe()

    def __hash__(self) -> int:
        """Hash all values."""
        return hash(self.describe())

    def describe(self) -> str:
        """Describe the table by a checksum of its numbers."""
        numbers = np.concatenate([self.times, self.values.ravel()]).astype("<f8")
        return f"{self!r} {checksum(numbers.tobytes())}"


@dataclass(frozen=True)
class Ramp(ScaledSignal):
    """A rise from zero to a constant value.

    Parameters
    ----------
    value : float or sequence of float
        The value from `end` on [N, N m or N/m].
    end : float
        Time at which the rise ends [s].
    start : float, optional
        Time at which the rise begins [s].
    smooth : bool, optional
        If True, the rise is ``10 x^3 - 15 x^4 + 6 x^5``, whose velocity and acceleration vanish at
        both ends, and else linear.
    """

    value: Value
    end: float
    start: float = 0.0
    smooth: bool = False

    def __post_init__(self) -> None:
        """Check the numbers and store them in double precision."""
        value = checked_value("value of a ramp", self.value)
        start, end = _interval("a ramp", self.start, self.end)
        smooth = check_flag("smooth of a ramp", self.smooth)
        set_fields(self, value=value, start=start, end=end, smooth=smooth)

    @property
    def smoothness(self) -> float:
        """Number of continuous derivatives."""
        return 2.0 if self.smooth else 0.0

    @property
    def time_scale(self) -> TimeScale:
        """Its duration, begin and end."""
        return TimeScale(self.end - self.start, (self.start, self.end))

    def factor(self, t: Vector, order: int = 0) -> Vector:
        """Return the fraction of the value, or a derivative of it [1/s, 1/s2]."""
        length = self.end - self.start
        x = np.clip((t - self.start) / length, 0.0, 1.0)
        if not self.smooth:
            return x if order == 0 else self._no_rate(order)
        if order == 0:
            return x**3 * (10.0 + x * (6.0 * x - 15.0))
        if order == 1:
            return 30.0 * (x * (1.0 - x)) ** 2 / length
        return 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / length**2


@dataclass(frozen=True)
class Sine(ScaledSignal):
    """``amplitude sin(2 pi frequency t + phase)``.

    Parameters
    ----------
    amplitude : float or sequence of float
        The largest value [N, N m or N/m].
    frequency : float
        Oscillations per second [Hz].
    phase : float, optional
        Phase at t = 0 [rad]; pi / 2 makes a cosine.
    """

    amplitude: Value
    frequency: float
    phase: float = 0.0
    smoothness = math.inf
    coefficient = "amplitude"

    def __post_init__(self) -> None:
        """Check the numbers and store them in double precision."""
        set_fields(
            self,
            amplitude=checked_value("amplitude of a sine", self.amplitude),
            frequency=check_moderate("frequency of a sine", self.frequency, "Hz"),
            phase=check_finite("phase of a sine", self.phase, "rad"),
        )

    @property
    def time_scale(self) -> TimeScale:
        """Half its period."""
        return TimeScale(0.5 / self.frequency)

    def factor(self, t: Vector, order: int = 0) -> Vector:
        """Return the sine, or a derivative of it [1/s, 1/s2]."""
        omega = 2.0 * math.pi * self.frequency
        return np.asarray(omega**order * np.sin(omega * t + self.phase + 0.5 * math.pi * order))


@dataclass(frozen=True)
class Pulse(ScaledSignal):
    """A value between two times and zero before and after.

    Parameters
    ----------
    value : float or sequence of float
        The value [N, N m or N/m].
    start, end : float
        Times at which it begins and ends [s].
    rise : float, optional
        Duration of the linear rise after `start`, and of the fall before `end` [s]; at most half
        the pulse.  With 0 the value jumps: it acts for ``start <= t < end``, up to rounding of t.
    """

    value: Value
    start: float
    end: float
    rise: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers and store them in double precision."""
        value = checked_value("value of a pulse", self.value)
        start, end = _interval("a pulse", self.start, self.end)
        rise = check_finite("rise of a pulse", self.rise, "s")
        if rise > 0.0:
            check_moderate("rise of a pulse", rise, "s")
        if not 0.0 <= rise <= 0.5 * (end - start):
            raise InputError(
                f"rise of a pulse must be between 0 and half of its {end - start:.6g} s, got "
                f"{rise:.6g} s"
            )
        set_fields(self, value=value, start=start, end=end, rise=rise)

    @property
    def time_scale(self) -> TimeScale:
        """Its impulse over its value, and the times of its corners."""
        corners = {self.start, self.start + self.rise, self.end - self.rise, self.end}
        return TimeScale(self.end - self.start - self.rise, tuple(sorted(corners)))

    def factor(self, t: Vector, order: int = 0) -> Vector:
        """Return the fraction of the value."""
        if order:
            return self._no_rate(order)
        if self.rise == 0.0:
            early = t + TIME_ROUNDING * np.abs(t)
            return ((self.start <= early) & (early < self.end)).astype(float)
        distance = np.minimum(t - self.start, self.end - t)
        return np.clip(distance / self.rise, 0.0, 1.0)


def _interval(what: str, start: object, end: object) -> tuple[float, float]:
    """Return the checked times at which a signal begins and ends [s]."""
    begin = check_finite(f"start of {what}", start, "s")
    stop = check_finite(f"end of {what}", end, "s")
    if stop <= begin:
        raise InputError(
            f"{what} must end after it starts, got start = {begin:.6g} s and end = {stop:.6g} s"
        )
    check_moderate(f"duration of {what}", stop - begin, "s")
    return begin, stop
