"""Motions that are prescribed: a position or a length as a function of time, and its rates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.records.signal import Signal
from ancfsparse.scene.records.time_dependent import Applied, Value

# Derivatives of a prescribed motion that must be continuous: a jump of the acceleration rings for
# ever in a scheme without damping, one of the velocity is an impact.
SMOOTH = 2


@dataclass(frozen=True, eq=False)
class Places(Applied):
    """Positions over time.

    Attributes
    ----------
    subject : str
        What moves, for messages.
    width : int
        Components of a value; 0 for a number.
    value : number, ndarray or callable
        A value [`unit`], or a function of t [s] that returns it.
    """

    subject: str
    width: int
    value: Value
    unit = "m"
    number = "one number"

    @property
    def what(self) -> str:
        """Name in messages."""
        return self.subject

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a value: ``(width,)``, or ``()`` for a number."""
        return (self.width,) if self.width else ()


@dataclass(frozen=True, eq=False)
class Rates(Places):
    """Velocities over time, as `Places`."""

    unit = "m/s"


@dataclass(frozen=True, eq=False)
class SecondRates(Places):
    """Accelerations over time, as `Places`."""

    unit = "m/s2"


@dataclass(frozen=True, eq=False)
class Angles(Places):
    """Angles over time, as `Places`."""

    unit = "rad"


@dataclass(frozen=True, eq=False)
class Spins(Places):
    """Angular velocities over time, as `Places`."""

    unit = "rad/s"


@dataclass(frozen=True, eq=False)
class SpinRates(Places):
    """Angular accelerations over time, as `Places`."""

    unit = "rad/s2"


KINDS = {"m": (Places, Rates, SecondRates), "rad": (Angles, Spins, SpinRates)}


@dataclass(frozen=True, eq=False)
class Course:
    """A prescribed motion.

    Attributes
    ----------
    places : Places
        Where it is.
    rates, second_rates : Places or None
        Its derivatives; None if not given, so that differences replace them.
    """

    places: Places
    rates: Places | None
    second_rates: Places | None


def course_of(
    subject: str,
    width: int,
    value: ArrayLike | Callable[[float], ArrayLike],
    rate: Callable[[float], ArrayLike] | None = None,
    second_rate: Callable[[float], ArrayLike] | None = None,
    unit: str = "m",
) -> Course:
    """Check a prescribed motion, and find its derivatives where they are known.

    Parameters
    ----------
    subject : str
        What moves, for messages.
    width : int
        Components of a value; 0 for a number.
    value : array_like or callable
        The motion [m], or a function of t [s] that returns it.
    rate, second_rate : callable, optional
        Its derivatives [m/s, m/s2], as functions of t; both or none.
    unit : str, optional
        ``"m"``; or ``"rad"`` of angles [rad, rad/s, rad/s2].

    Raises
    ------
    InputError
        If a value is invalid, a derivative is missing, or the motion is a signal that is not
        smooth.
    """
    for name, given in (("rate", rate), ("second_rate", second_rate)):
        if given is not None and not callable(given):
            raise InputError(
                f"{name} of {subject} must be a function of time, got {format_value(given)}: leave "
                "it out where the motion is a signal or does not change"
            )
    if (rate is None) != (second_rate is None):
        missing = "second_rate" if second_rate is None else "rate"
        raise InputError(f"{subject} needs both of its derivatives or none: give {missing} too")
    kinds = KINDS[unit]
    places = kinds[0](subject, width, value)
    if rate is None and isinstance(value, Signal):
        if value.smoothness < SMOOTH:
            raise InputError(
                f"{subject} follows {value!r}, whose acceleration is not continuous, so it would "
                "ring: take Ramp(..., smooth=True), Sine, or a smooth function such as "
                "scipy.interpolate.CubicSpline(times, values, bc_type='clamped')"
            )
        rate, second_rate = _Rate(value, 1), _Rate(value, 2)
    elif rate is None and not callable(value):
        rate = second_rate = _Rest((width,) if width else ())
    if rate is None or second_rate is None:
        return Course(places, None, None)
    return Course(
        places,
        kinds[1](f"the rate of {subject}", width, rate),
        kinds[2](f"the second rate of {subject}", width, second_rate),
    )


@dataclass(frozen=True)
class _Rate:
    signal: Signal
    order: int
    takes_arrays: ClassVar[bool] = True

    def __call__(self, t: Any) -> Any:
        return self.signal.rate(t, self.order)


@dataclass(frozen=True)
class _Rest:
    shape: tuple[int, ...]
    takes_arrays: ClassVar[bool] = True

    def __call__(self, t: Any) -> Any:
        return np.zeros((*np.shape(t), *self.shape))
