"""The check of lengths in sections."""

from __future__ import annotations

from ancfsparse.checks import check_positive
from ancfsparse.errors import InputError

SMALLEST = 1e-75  # side [m] whose fourth power, and that of its inverse, are still numbers


def check_side(what: str, value: object) -> float:
    """Return a side [m], refused if its fourth power is not among the floating-point numbers."""
    side = check_positive(what, value, "m")
    if not SMALLEST <= side <= 1.0 / SMALLEST:
        raise InputError(
            f"{what} must lie between {SMALLEST:g} and {1.0 / SMALLEST:g} m, whose fourth powers "
            f"are in the range of floating-point numbers, got {side:g} m"
        )
    return side
