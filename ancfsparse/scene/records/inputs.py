"""Inputs: values that `Simulation.set` changes during a motion."""

from __future__ import annotations

from collections.abc import Mapping
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count, check_finite, check_vector, set_fields
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.records.signal import Signal

ROUNDING = 1e-9  # rounding of the time at the end of a transition, over its duration
UNNAMED = "input "  # begin of the name of an input without one; its number follows
LAST_NUMBER = [0]  # of such names in this process


POWERS = np.arange(6.0)
# Coefficients of the powers of x for each given value: the first value with its first and second
# derivative, the second value and its rate.  From 0 to 1 the quintic of Hermite, its second
# derivative zero at 1; then a straight line.
DURING = np.array(
    [
        [1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.5, 0.0, 0.0],
        [-10.0, -6.0, -1.5, 10.0, -4.0],
        [15.0, 8.0, 1.5, -15.0, 7.0],
        [-6.0, -3.0, -0.5, 6.0, -3.0],
    ]
)
AFTER = np.array([[0.0, 0.0, 0.0, 1.0, -1.0], [0.0, 0.0, 0.0, 0.0, 1.0], *np.zeros((4, 5))])
RATE = np.diag(POWERS[1:], 1)  # coefficients of the derivative of a polynomial
COEFFICIENTS = np.array([[c, RATE @ c, RATE @ RATE @ c] for c in (DURING, AFTER)])


class Transition(NamedTuple):
    """Value of an input over time: from one value to another, then with a constant rate.

    The polynomial of fifth degree between them has given values and rates at both ends, a given
    second derivative at the first and zero at the second.

    Attributes
    ----------
    begin, duration : float
        Time of the first value, and time from there to the second [s].
    terms : (2, 3, 6, n) float
        Coefficients of the powers of the time from the first value over the duration: during the
        transition and after it; of the value, its rate and its second derivative.
    """

    begin: float
    duration: float
    terms: Vector

    def derivatives(self, t: float) -> Vector:
        """Return the value and its first and second derivative at a time, (3, n)."""
        x = max(0.0, (t - self.begin) / self.duration)
        return np.asarray(x**POWERS @ self.terms[int(x >= 1.0 - ROUNDING)])

    def evaluate(self, times: Vector, order: int = 0) -> Vector:
        """Return the value at times (k,), or a derivative of it, (k, n)."""
        x = np.maximum((times - self.begin) / self.duration, 0.0)[:, None]
        during, after = x**POWERS @ self.terms[:, order]
        return np.asarray(np.where(x < 1.0 - ROUNDING, during, after))


def make_transition(
    begin: float, duration: float, start: Vector, end: Vector, rate: Vector
) -> Transition:
    """Return a transition.

    Parameters
    ----------
    begin, duration : float
        As in `Transition` [s].
    start : (3, n) float
        First value with its first and second derivative.
    end, rate : (n,) float
        Second value and its rate.
    """
    scales = duration ** np.arange(3.0)[:, None]
    conditions = np.concatenate([start * scales, [end, rate * duration]])
    return Transition(begin, duration, COEFFICIENTS @ conditions / scales[:, None])


# The transitions in the simulation that is running, by the name of the input.
TRANSITIONS: ContextVar[Mapping[str, Transition]] = ContextVar("transitions")


@dataclass(frozen=True)
class Input(Signal):
    """A value that a `Simulation` sets while it runs: a load, a motion or a length.

    Parameters
    ----------
    size : int, optional
        Number of components: 1 for a number, 2 or 3 for a vector.
    default : float or array_like, shape (size,), optional
        The value before it is set, and in all runs other than a `Simulation` [unit of its use]; a
        number applies to all components.
    name : str, optional
        Name; inputs of the same name are the same input.

    Raises
    ------
    InputError
        If an argument is invalid.
    """

    size: int = 1
    default: Any = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        """Check the arguments."""
        size = check_count("size of an input", self.size)
        if size > 3:
            raise InputError(f"the size of an input must be 1, 2 or 3, got {size}")
        if not isinstance(self.name, str):
            raise InputError(f"the name of an input must be a text, got {format_value(self.name)}")
        name = self.name or f"{UNNAMED}{LAST_NUMBER[0] + 1}"
        number = name.removeprefix(UNNAMED)
        # Also from a file; later ones are others.  Very long numbers are names like others.
        if name != number and number.isdecimal() and len(number) < 10:
            LAST_NUMBER[0] = max(LAST_NUMBER[0], int(number))
        set_fields(self, size=size, name=name)
        default = self.default
        if size > 1 and (
            np.isscalar(default) or (isinstance(default, np.ndarray) and not default.ndim)
        ):
            default = [default] * size
        value = self.check_value("the default", default)
        set_fields(self, default=tuple(value.tolist()) if size > 1 else float(value[0]))

    def check_value(self, what: str, value: ArrayLike) -> Vector:
        """Return a value, or a rate, as an array (size,) after checking it."""
        if self.size > 1:
            return check_vector(f"{what} of {self.name}", value, self.size)
        return np.array([check_finite(f"{what} of {self.name}", value)])

    @property
    def smoothness(self) -> float:
        """Number of continuous derivatives."""
        return 2.0

    @cached_property
    def initial(self) -> Transition:
        """The default as a transition."""
        value = np.reshape(np.asarray(self.default, dtype=float), self.size)
        zero = np.zeros(self.size)
        return make_transition(0.0, 1.0, np.array([value, zero, zero]), value, zero)

    def evaluate(self, times: ArrayLike, order: int) -> Vector:
        """Return the value or a derivative at a time, or at an array (k,) of them."""
        t = np.asarray(times, dtype=float)
        transition = TRANSITIONS.get({}).get(self.name) or self.initial
        values = transition.evaluate(t.reshape(-1), order)
        return values.reshape((*t.shape, self.size) if self.size > 1 else t.shape)

    def __call__(self, t: ArrayLike) -> Vector:
        """Return the value at a time [s], or one row for each of an array of times (k,)."""
        return self.evaluate(t, 0)

    def rate(self, t: ArrayLike, order: int = 1) -> Vector:
        """Return its first or second derivative, shaped like its values."""
        return self.evaluate(t, order)
