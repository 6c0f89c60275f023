"""The base of signals, which are functions of time as data: sums, multiples, derivatives."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_reals, set_fields
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value

Value = float | tuple[float, ...]


class Signal(ABC):
    """A function of time that can be evaluated for an array of times.

    Attributes
    ----------
    takes_arrays : bool
        True; other functions with this attribute are called with arrays of times too.
    """

    takes_arrays: ClassVar[bool] = True

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

    value: Value

    @property
    def largest(self) -> Value:
        """The value at factor 1."""
        return self.value

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
