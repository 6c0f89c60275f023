"""What functions of time that are data have in common: sums, multiples, and their rates."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import check_reals, set_fields
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value

Vector = NDArray[np.float64]
Value = float | tuple[float, ...]


class Signal(ABC):
    """A function of time that is evaluated for all times at once.

    Attributes
    ----------
    takes_arrays : bool
        That it is, which other functions with this attribute are too.
    """

    takes_arrays: ClassVar[bool] = True

    @abstractmethod
    def __call__(self, t: ArrayLike) -> Vector:
        """Return the value at a time, or one in each row for an array of times (k,) [s]."""

    def describe(self) -> str:
        """Describe everything that its values follow from, for comparison with another one."""
        return repr(self)

    @property
    def smoothness(self) -> float:
        """Number of continuous derivatives: none by default."""
        return 0.0

    def rate(self, t: ArrayLike, order: int = 1) -> Vector:
        """Return its first or second derivative, shaped like its values [1/s, 1/s2 times theirs].

        Raises
        ------
        InputError
            If that is not continuous.
        """
        return self._no_rate(order)

    def _no_rate(self, order: int) -> Vector:
        what = {1: "rate", 2: "second rate"}[order]
        raise InputError(f"{self!r} has no continuous {what}: take Ramp(..., smooth=True) or Sine")

    def __add__(self, other: Signal | ArrayLike) -> Signal:
        """Return the sum with another signal, or with a value that does not change."""
        if isinstance(other, Signal):
            return Sum((self, other))
        return Sum((self,), checked_value("what is added to a signal", other))

    __radd__ = __add__

    # Arrays must not take a signal for one of their numbers.
    __array_ufunc__ = None


def is_vectorized(value: object) -> bool:
    """Whether a load or motion is a function that takes arrays of any times."""
    return bool(getattr(value, "takes_arrays", False))


@dataclass(frozen=True)
class Sum(Signal):
    """A sum of signals and a value that does not change.

    Parameters
    ----------
    parts : tuple of Signal
        The signals.
    constant : float or tuple of float, optional
        The value [N, N m, N/m or m].
    """

    parts: tuple[Signal, ...]
    constant: Value = 0.0

    def __post_init__(self) -> None:
        """Check the parts and keep the constant in double precision."""
        if not isinstance(self.parts, tuple) or not all(
            isinstance(each, Signal) for each in self.parts
        ):
            raise InputError(f"the parts of a sum must be signals, got {format_value(self.parts)}")
        set_fields(self, constant=checked_value("constant of a sum", self.constant))

    @property
    def smoothness(self) -> float:
        """How many of its derivatives are continuous."""
        return min(part.smoothness for part in self.parts)

    def __call__(self, t: ArrayLike) -> Vector:
        """Return the value at a time, or one in each row for an array of times (k,) [s]."""
        total = sum(part(t) for part in self.parts)
        return np.asarray(total + np.asarray(self.constant))

    def rate(self, t: ArrayLike, order: int = 1) -> Vector:
        """Return its first or second derivative, shaped like its values."""
        return np.asarray(sum(part.rate(t, order) for part in self.parts))

    def describe(self) -> str:
        """Describe everything that its values follow from."""
        return " + ".join([*(part.describe() for part in self.parts), repr(self.constant)])


class ScaledSignal(Signal):
    """A value that is multiplied by a number which changes with time."""

    @property
    @abstractmethod
    def largest(self) -> Value:
        """The value where that number is 1."""

    @abstractmethod
    def factor(self, t: Vector, order: int = 0) -> Vector:
        """Return that number for every time, or a derivative of it [1/s, 1/s2]."""

    def rate(self, t: ArrayLike, order: int = 1) -> Vector:
        """Return its first or second derivative, shaped like its values."""
        return np.multiply.outer(self.factor(np.asarray(t, dtype=float), order), self.largest)

    def __call__(self, t: ArrayLike) -> Vector:
        """Return the value at a time, or one in each row for an array of times (k,) [s]."""
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
