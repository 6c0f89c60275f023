"""Prescribed motions: a position, length or angle as a function of time, with its derivatives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.records.signal import Signal
from ancfsparse.scene.records.time_dependent import TimeDependentValue, Value

# Continuous derivatives of a prescribed motion: a jump of the acceleration excites a vibration that
# a scheme without damping never loses, a jump of the velocity is an impact.
MIN_SMOOTHNESS = 2

# Units of a motion, its velocity, and its acceleration.
UNITS = {"m": ("m", "m/s", "m/s2"), "rad": ("rad", "rad/s", "rad/s2")}


@dataclass(frozen=True, eq=False)
class PrescribedValue(TimeDependentValue):
    """A position, length or angle, or a derivative of one, over time.

    Attributes
    ----------
    subject : str
        Name in messages.
    width : int
        Number of components of a value; 0 for a scalar.
    value : number, ndarray or callable
        A value [`unit`], or a function of t [s] that returns it.
    unit : str
        Unit of the value.
    """

    subject: str
    width: int
    value: Value
    unit: str = "m"
    number = "one number"

    @property
    def what(self) -> str:
        """Name in messages."""
        return self.subject

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a value: ``(width,)``, or ``()`` for a scalar."""
        return (self.width,) if self.width else ()


@dataclass(frozen=True, eq=False)
class PrescribedMotion:
    """A prescribed motion and its derivatives.

    Attributes
    ----------
    value : PrescribedValue
        The position, length or angle.
    rate, second_rate : PrescribedValue or None
        Its derivatives; None to approximate them by differences.
    angle : PrescribedMotion or None
        The angle, if it is the motion of a vector that rotates.
    """

    value: PrescribedValue
    rate: PrescribedValue | None
    second_rate: PrescribedValue | None
    angle: PrescribedMotion | None = None

    @property
    def source(self) -> PrescribedMotion:
        """The motion that the user has prescribed."""
        return self if self.angle is None else self.angle


def define_motion(
    subject: str,
    width: int,
    value: ArrayLike | Callable[[float], ArrayLike],
    rate: Callable[[float], ArrayLike] | None = None,
    second_rate: Callable[[float], ArrayLike] | None = None,
    unit: str = "m",
) -> PrescribedMotion:
    """Check a prescribed motion, and take its derivatives from a signal or a constant.

    Parameters
    ----------
    subject, width, value
        As in `PrescribedValue`.
    rate, second_rate : callable, optional
        Derivatives of the value [`unit`/s, `unit`/s2], as functions of t; both or none.
    unit : str, optional
        ``"m"`` or ``"rad"``.

    Raises
    ------
    InputError
        If a value is invalid, one derivative is missing, or the motion is a signal that is not
        smooth.
    """
    for name, function in (("rate", rate), ("second_rate", second_rate)):
        if function is not None and not callable(function):
            raise InputError(
                f"{name} of {subject} must be a function of time, got {format_value(function)}: "
                "leave it out where the motion is a signal or constant"
            )
    if (rate is None) != (second_rate is None):
        missing = "second_rate" if second_rate is None else "rate"
        raise InputError(f"{subject} needs both of its derivatives or none: give {missing} too")
    units = UNITS[unit]
    position = PrescribedValue(subject, width, value, units[0])
    if rate is None and isinstance(value, Signal):
        if value.smoothness < MIN_SMOOTHNESS:
            raise InputError(
                f"{subject} follows {value!r}, whose acceleration is not continuous and would "
                "excite vibrations: take Ramp(..., smooth=True), Sine, or a smooth function such "
                "as scipy.interpolate.CubicSpline(times, values, bc_type='clamped')"
            )
        rate, second_rate = _SignalRate(value, 1), _SignalRate(value, 2)
    elif rate is None and not callable(value):
        rate = second_rate = _ZeroRate(position.shape)
    if rate is None or second_rate is None:
        return PrescribedMotion(position, None, None)
    return PrescribedMotion(
        position,
        PrescribedValue(f"the rate of {subject}", width, rate, units[1]),
        PrescribedValue(f"the second rate of {subject}", width, second_rate, units[2]),
    )


@dataclass(frozen=True)
class _SignalRate:
    """A derivative of a signal."""

    signal: Signal
    order: int
    takes_arrays: ClassVar[bool] = True

    def __call__(self, t: Any) -> Any:
        return self.signal.rate(t, self.order)


@dataclass(frozen=True)
class _ZeroRate:
    """The derivative of a constant."""

    shape: tuple[int, ...]
    takes_arrays: ClassVar[bool] = True

    def __call__(self, t: Any) -> Any:
        return np.zeros((*np.shape(t), *self.shape))
