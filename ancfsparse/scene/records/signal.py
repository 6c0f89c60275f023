"""The base of signals, which are functions of time as data: sums, multiples, derivatives."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NoReturn, Self, cast

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_finite, check_reals, set_fields
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value

Value = float | tuple[float, ...]


@dataclass(frozen=True)
class TimeScale:
    """The times that steps must not miss of a signal.

    Attributes
    ----------
    shortest : float
        Shortest time in which it leaves a value and returns, or rises [s].
    times : tuple of float
        Times at which it begins, ends or kinks, ascending [s]; none if it is periodic.
    """

    shortest: float = math.inf
    times: tuple[float, ...] = ()


class Signal(ABC):
    """A function of time that can be evaluated for an array of times.

    Attributes
    ----------
    takes_arrays : bool
        True; other functions with this attribute are called with arrays of times too.
    coefficient : str
        Name of the field that its values are proportional to; empty if there is none.
    """

    takes_arrays: ClassVar[bool] = True
    coefficient: ClassVar[str] = ""

    @abstractmethod
    def __call__(self, t: ArrayLike) -> Vector:
        """Return the value at a time [s], or one row for each of an array of times (k,)."""

    def describe(self) -> str:
        """Describe the data that determine its values, for comparison with other signals."""
        return repr(self)

    @property
    def smoothness(self) -> float:
        """Number of continuous derivatives."""
        return 0.0

    @property
    def time_scale(self) -> TimeScale:
        """Its shortest time scale, and the times at which it begins, ends or kinks."""
        return TimeScale()

    @property
    def bound(self) -> float:
        """Upper bound of the magnitude of its values; zero if none is known."""
        return 0.0

    @property
    def summands(self) -> tuple[Signal, ...]:
        """The signals that it is the sum of, except for a constant."""
        return (self,)

    def rate(self, t: ArrayLike, order: int = 1) -> Vector:
        """Return its first or second derivative, shaped like its values [1/s, 1/s2 times theirs].

        Raises
        ------
        InputError
            If the derivative is not continuous.
        """
        return self._no_rate(order)

    def _no_rate(self, order: int) -> Vector:
        what = {1: "rate", 2: "second rate"}[order]
        raise InputError(f"{self!r} has no continuous {what}: take Ramp(..., smooth=True) or Sine")

    def __add__(self, other: Signal | ArrayLike) -> Signal:
        """Return the sum with another signal or a constant."""
        if isinstance(other, Signal):
            return Sum((self, other))
        return Sum((self,), checked_value("the summand of a signal", other))

    __radd__ = __add__

    def __mul__(self, factor: float) -> Signal:
        """Return the signal with its values multiplied by a number."""
        return self._scale(np.multiply, check_finite("the factor of a signal", factor))

    __rmul__ = __mul__

    def __truediv__(self, divisor: float) -> Signal:
        """Return the signal with its values divided by a number."""
        number = check_finite("the divisor of a signal", divisor)
        if number == 0.0:
            raise InputError("the divisor of a signal must not be zero")
        return self._scale(np.divide, number)

    def __neg__(self) -> Signal:
        """Return the signal with opposite values."""
        return self._scale(np.multiply, -1.0)

    def __pos__(self) -> Signal:
        """Return the signal itself."""
        return self

    def __sub__(self, other: Signal | ArrayLike) -> Signal:
        """Return the difference from another signal or a constant."""
        if isinstance(other, Signal):
            return self + -other
        return self + np.negative(checked_value("the subtrahend of a signal", other))

    def __rsub__(self, other: ArrayLike) -> Signal:
        """Return the difference of a constant from the signal."""
        return -self + other

    def _no_operation(self, *_: object) -> NoReturn:
        """Refuse an operation whose result is no signal."""
        raise InputError(
            f"{self!r} can be added to signals and numbers, multiplied by a number and divided by "
            "one: write other operations as a function of t"
        )

    __rtruediv__ = __floordiv__ = __rfloordiv__ = __mod__ = __rmod__ = _no_operation
    __pow__ = __rpow__ = __matmul__ = __rmatmul__ = __abs__ = _no_operation

    def _scale(self, operation: np.ufunc, number: float) -> Signal:
        """Return the signal with its values multiplied or divided by a checked number."""
        raise InputError(f"{self!r} has no multiples: multiply the values that define it")

    # Arrays must leave a sum with a signal to the signal.
    __array_ufunc__ = None


def is_vectorized(value: object) -> bool:
    """Return True for a load or motion that is a function of arrays of times."""
    return bool(getattr(value, "takes_arrays", False))


@dataclass(frozen=True)
class Sum(Signal):
    """A sum of signals and a constant.

    Parameters
    ----------
    parts : tuple of Signal
        The signals.
    constant : float or tuple of float, optional
        The constant [N, N m, N/m or m].
    """

    parts: tuple[Signal, ...]
    constant: Value = 0.0

    def __post_init__(self) -> None:
        """Check the parts and store the constant in double precision."""
        if not isinstance(self.parts, tuple) or not all(
            isinstance(part, Signal) for part in self.parts
        ):
            raise InputError(f"the parts of a sum must be signals, got {format_value(self.parts)}")
        set_fields(self, constant=checked_value("constant of a sum", self.constant))

    @property
    def smoothness(self) -> float:
        """Number of continuous derivatives."""
        return min(part.smoothness for part in self.parts)

    @property
    def time_scale(self) -> TimeScale:
        """All times of its signals, and their shortest time scale or interval between times."""
        scales = [part.time_scale for part in self.parts]
        times = sorted({time for scale in scales for time in scale.times})
        gap = float(np.diff(times).min(initial=math.inf))
        return TimeScale(min([gap, *(scale.shortest for scale in scales)]), tuple(times))

    @property
    def bound(self) -> float:
        """Sum of the bounds of its parts."""
        return sum(part.bound for part in self.parts) + float(np.linalg.norm(self.constant))

    @property
    def summands(self) -> tuple[Signal, ...]:
        """The signals that it is the sum of, sums resolved."""
        return tuple(each for part in self.parts for each in part.summands)

    def _scale(self, operation: np.ufunc, number: float) -> Sum:
        constant = scaled_value(operation, self.constant, number)
        return Sum(tuple(part._scale(operation, number) for part in self.parts), constant)

    def __call__(self, t: ArrayLike) -> Vector:
        """Return the value at a time [s], or one row for each of an array of times (k,)."""
        total = sum(part(t) for part in self.parts)
        return np.asarray(total + np.asarray(self.constant))

    def rate(self, t: ArrayLike, order: int = 1) -> Vector:
        """Return its first or second derivative, shaped like its values."""
        return np.asarray(sum(part.rate(t, order) for part in self.parts))

    def describe(self) -> str:
        """Describe the data that determine its values."""
        return " + ".join([*(part.describe() for part in self.parts), repr(self.constant)])


class ScaledSignal(Signal):
    """A constant value times a factor that changes with time."""

    coefficient = "value"

    @property
    def largest(self) -> Value:
        """The value at factor 1."""
        return cast(Value, getattr(self, self.coefficient))

    @property
    def bound(self) -> float:
        """Magnitude of its value."""
        return float(np.linalg.norm(self.largest))

    def _scale(self, operation: np.ufunc, number: float) -> Self:
        scaled = {self.coefficient: scaled_value(operation, self.largest, number)}
        return cast(Self, replace(cast(Any, self), **scaled))

    @abstractmethod
    def factor(self, t: Vector, order: int = 0) -> Vector:
        """Return the factor at every time, or a derivative of it [1/s, 1/s2]."""

    def rate(self, t: ArrayLike, order: int = 1) -> Vector:
        """Return its first or second derivative, shaped like its values."""
        return np.multiply.outer(self.factor(np.asarray(t, dtype=float), order), self.largest)

    def __call__(self, t: ArrayLike) -> Vector:
        """Return the value at a time [s], or one row for each of an array of times (k,)."""
        return np.multiply.outer(self.factor(np.asarray(t, dtype=float)), self.largest)


def checked_value(what: str, value: object) -> Value:
    """Return a finite number or a tuple of up to three."""
    needed = "a number, or two or three of them"
    numbers = check_reals(what, value, needed)
    if numbers.shape not in ((), (2,), (3,)):
        raise InputError(f"{what} must be {needed}, got {format_value(value)}")
    if not np.isfinite(numbers).all():
        raise InputError(f"{what} must be finite, got {format_value(value)}")
    return tuple(numbers.tolist()) if numbers.ndim else float(numbers)


def scaled_value(operation: np.ufunc, value: Value, number: float) -> Value:
    """Return a checked product or quotient of a value and a number."""
    with np.errstate(over="ignore"):
        return checked_value("the multiple of a signal", operation(value, number))
