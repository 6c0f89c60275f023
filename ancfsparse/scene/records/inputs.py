"""Inputs: values that `Simulation.set` changes during a motion."""

from __future__ import annotations

from collections.abc import Mapping
from contextvars import ContextVar
from dataclasses import dataclass
from itertools import count
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count, check_finite, check_vector, set_fields
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.records.signal import Signal

ROUNDING = 1e-9  # rounding of the time at the end of a transition, over its duration
NUMBERS = count(1)  # of inputs without a name


class Transition(NamedTuple):
    """Value of an input over time: from one value to another, then with a constant rate.

    The polynomial of fifth degree between them has given values and rates at both ends, a given
    second derivative at the first and zero at the second.

    Attributes
    ----------
    begin, duration : float
        Time of the first value, and time from there to the second [s].
    terms : (6, n) float
        Coefficients of the powers of the time from the first value over the duration.
    end, rate : (n,) float
        Second value and its rate.
    """

    begin: float
    duration: float
    terms: Vector
    end: Vector
    rate: Vector

    def evaluate(self, times: Vector, order: int = 0) -> Vector:
        """Return the value at times (k,), or a derivative of it, (k, n)."""
        x = np.maximum((times - self.begin) / self.duration, 0.0)[:, None]
        still = 0.0 * x
        terms = self.terms
        for _ in range(order):
            terms = np.arange(1.0, len(terms))[:, None] * terms[1:] / self.duration
        inside = still + terms[-1]
        for term in terms[-2::-1]:
            inside = inside * x + term
        after = (self.end + self.rate * (x - 1.0) * self.duration, self.rate + still, still)
        return np.asarray(np.where(x < 1.0 - ROUNDING, inside, after[order]))


def make_transition(
    begin: float,
    duration: float,
    value: Vector,
    first_rate: Vector,
    second_rate: Vector,
    end: Vector,
    rate: Vector,
) -> Transition:
    """Return the transition from a value with two derivatives to a value with a rate."""
    first, second = first_rate * duration, second_rate * duration**2
    change = end - value - first - 0.5 * second
    of_rate, of_second = rate * duration - first - second, -second
    cubic = 10.0 * change - 4.0 * of_rate + 0.5 * of_second
    quartic = -15.0 * change + 7.0 * of_rate - of_second
    quintic = 6.0 * change - 3.0 * of_rate + 0.5 * of_second
    terms = np.array([value, first, 0.5 * second, cubic, quartic, quintic])
    return Transition(begin, duration, terms, end, rate)


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
        name = self.name or f"input {next(NUMBERS)}"
        set_fields(self, size=size, name=name)
        default: Any = self.default if np.ndim(self.default) else [self.default] * size
        value = self.check_value("the default", default if size > 1 else self.default)
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

    @property
    def initial(self) -> Transition:
        """The default as a transition."""
        value = np.reshape(np.asarray(self.default, dtype=float), self.size)
        zero = np.zeros(self.size)
        return make_transition(0.0, 1.0, value, zero, zero, value, zero)

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
