"""A value of a run next to its reference, with the interval in which it is correct."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

NO_VALUE = math.nan  # of a run that fails


@dataclass(frozen=True)
class Comparison:
    """A value, its reference, and the bounds of correct values.

    A value of a run that fails is not a number, and is outside of all bounds.
    """

    quantity: str
    value: float
    reference: float
    tolerance: str  # in words
    lower: float
    upper: float

    @property
    def is_met(self) -> bool:
        """True if the value is between its bounds."""
        return bool(self.lower <= self.value <= self.upper)


Check = Callable[[], Sequence[Comparison]]
"""A function that makes runs and compares their values."""


def compare_relative(quantity: str, value: float, reference: float, tolerance: float) -> Comparison:
    """Compare a value with a reference within a fraction of its size."""
    width = tolerance * abs(reference)
    bounds = reference - width, reference + width
    return Comparison(quantity, float(value), reference, f"{100.0 * tolerance:g} %", *bounds)


def compare_absolute(quantity: str, value: float, reference: float, tolerance: float) -> Comparison:
    """Compare a value with a reference within a difference in their unit."""
    bounds = reference - tolerance, reference + tolerance
    return Comparison(quantity, float(value), reference, f"{tolerance:g}", *bounds)


def limit_above(quantity: str, value: float, bound: float) -> Comparison:
    """Compare a value with an upper bound."""
    return Comparison(quantity, float(value), bound, "at most", -math.inf, bound)


def limit_below(quantity: str, value: float, bound: float) -> Comparison:
    """Compare a value with a lower bound."""
    return Comparison(quantity, float(value), bound, "at least", bound, math.inf)


def state_value(quantity: str, value: float) -> Comparison:
    """State a value that depends on the machine, and has no reference."""
    return Comparison(quantity, float(value), math.nan, "", -math.inf, math.inf)
