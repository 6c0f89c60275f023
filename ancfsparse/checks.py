"""Checks of arguments: each returns its argument, converted, or raises an `InputError`.

Their first parameter `what` is the name of the argument in the one sentence of the message, then
comes the argument itself, and `unit` is the SI unit of numbers in the message.
"""

from __future__ import annotations

import math
import operator
import sys
from collections.abc import Callable, Iterable
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.errors import InputError, Parameter, format_quantity
from ancfsparse.messages import MAX_INTEGER, format_value, suggest_names

MAX_MAGNITUDE = 1e100  # of a length, mass, ...: its cube and inverse cube do not overflow


def _invalid(what: str, needed: str, given: str) -> InputError:
    text = "{what} must be {needed}, got {given}"
    return InputError(text, what=Parameter(what), needed=needed, given=given)


def is_masked(value: object) -> bool:
    """Return True for an array with masked entries, which requires that `numpy.ma` is loaded."""
    return "numpy.ma" in sys.modules and bool(np.ma.is_masked(value))


def check_choice(what: str, name: object, valid: Iterable[str]) -> str:
    """Return `name` if it is one of `valid`; the message suggests the most similar name."""
    names = list(valid)
    if isinstance(name, str) and name in names:
        return name
    raise InputError(f"unknown {what} {format_value(name)}: {suggest_names(name, names)}")


def check_flag(what: str, value: object) -> bool:
    """Return `value` if it is True or False; others are truthy by mistake, such as ``"no"``."""
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    raise _invalid(what, "True or False", format_value(value))


def check_finite(what: str, value: object, unit: str = "") -> float:
    """Return `value` as a finite float.

    Valid are real numbers and arrays of shape ().  A number of less than double precision is read
    as its shortest decimal representation, because 1e-3 in single precision is not a thousandth in
    double.
    """
    array = check_reals(what, _shortest(value), "a number")
    if array.ndim:
        raise _invalid(what, "a number", format_value(value))
    number = float(array)
    if not math.isfinite(number):
        raise _invalid(what, "finite", format_quantity(number, unit))
    return number


def _shortest(value: object) -> object:
    number = value[()] if isinstance(value, np.ndarray) and not value.ndim else value
    if isinstance(number, np.floating) and number.dtype.itemsize < np.dtype(float).itemsize:
        return float(str(number))
    return value


def check_positive(what: str, value: object, unit: str = "") -> float:
    """Return `value` as a positive finite float."""
    number = check_finite(what, value, unit)
    if number <= 0.0:
        raise _invalid(what, "positive", format_quantity(number, unit))
    return number


def check_not_negative(
    what: str, value: object, unit: str = "", *, largest: float = math.inf
) -> float:
    """Return `value` as a finite float from zero to `largest`."""
    number = check_finite(what, value, unit)
    if number < 0.0:
        raise InputError(f"{what} must not be negative, got {format_quantity(number, unit)}")
    if number > largest:
        limit, given = format_quantity(largest, unit), format_quantity(number, unit)
        raise InputError(f"{what} must be at most {limit}, got {given}")
    return number


def check_integer(what: str, value: object) -> int:
    """Return `value` as an integer; a float is refused, even if it is integral."""
    try:
        return operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise _invalid(what, "an integer", format_value(value)) from None


def check_moderate(what: str, value: object, unit: str) -> float:
    """Return `value` as a positive float whose cube is in the range of floating-point numbers.

    It must lie between `MAX_MAGNITUDE` and its inverse.
    """
    number = check_positive(what, value, unit)
    if not 1.0 / MAX_MAGNITUDE <= number <= MAX_MAGNITUDE:
        raise InputError(
            f"{what} must lie between {1.0 / MAX_MAGNITUDE:g} and {MAX_MAGNITUDE:g} {unit}, whose "
            f"cubes are in the range of floating-point numbers, got {number:g} {unit}"
        )
    return number


def check_count(what: str, value: object, lowest: int = 1) -> int:
    """Return `value` as an integer not below `lowest`, as `check_integer` does."""
    count = check_integer(what, value)
    if isinstance(value, bool) or count < lowest:
        raise _invalid(what, f"an integer of at least {lowest}", format_value(value))
    if count > MAX_INTEGER:
        raise InputError(
            "{what} is {count}, more than can be counted",
            what=Parameter(what),
            count=format_value(count),
        )
    return count


def check_reals(what: str, value: object, needed: str) -> NDArray[np.float64]:
    """Return `value` as an array of real numbers, finite or not.

    Parameters
    ----------
    what, value
        As in the other checks.
    needed : str
        The requirement, for the message, such as ``"2 numbers"``.

    Returns
    -------
    ndarray
        A copy, float64, of the shape given.

    Raises
    ------
    InputError
        If it contains texts, booleans, complex numbers, masked entries, integers beyond the range
        of floating-point numbers, or rows of different lengths.
    """
    try:
        if is_masked(value):  # masked entries would be read as numbers
            raise TypeError
        given = np.asarray(value)
        if given.dtype.kind == "O":  # fractions and decimals, or integers of many digits
            if not all(_is_real(each) for each in given.flat):
                raise TypeError
        elif given.dtype.kind not in "iuf":
            raise TypeError
        if given.dtype == np.float64:
            return np.array(given)
        with np.errstate(over="ignore"):
            return np.array(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise _invalid(what, needed, format_value(value)) from None


def _is_real(value: object) -> bool:
    from decimal import Decimal

    return isinstance(value, (Real, Decimal)) and not isinstance(value, bool)


def check_vector(what: str, value: ArrayLike, dim: int, unit: str = "") -> NDArray[np.float64]:
    """Return `value` as a finite vector; `dim` is 2 in a planar scene, 3 in a spatial one.

    Returns
    -------
    ndarray, shape (dim,)
        A copy, float64, read-only.
    """
    vector = check_reals(what, value, f"{dim} numbers")
    if vector.shape != (dim,):
        kind, hint = ("planar", "(x, y)") if dim == 2 else ("spatial", "(x, y, z)")
        number = f"{vector.size} component{'s' * (vector.size != 1)}"
        got = number if vector.ndim == 1 else f"shape {vector.shape}"
        raise InputError(
            f"{what} has {got}, but the scene is {kind}: give {hint}, or give the gravity of the "
            f"scene {5 - dim} components to make it {'spatial' if dim == 2 else 'planar'}"
        )
    if not all(map(math.isfinite, vector.tolist())):
        axis = "xyz"[int(np.argmin(np.isfinite(vector)))]
        raise InputError(
            f"{what} must be finite, but its {axis} component is "
            f"{format_quantity(float(vector['xyz'.index(axis)]), unit)}"
        )
    vector.flags.writeable = False
    return vector


def call_function(what: str, function: Callable[..., Any], argument: object, at: str = "") -> Any:
    """Return the value of a function of the user.

    Parameters
    ----------
    what : str
        Name of the function in messages.
    function, argument
        The function and its argument.
    at : str, optional
        The argument in messages, such as ``"at s = 1 m"``.

    Raises
    ------
    InputError
        If it raises anything.
    """
    try:
        return function(argument)
    except Exception as error:  # a user function may raise anything
        reason = f"{type(error).__name__}: {error}".rstrip(": ")
        raise InputError(f"{what} failed {at}".rstrip() + f": {reason}") from error


def set_fields(record: object, **values: object) -> None:
    """Set fields of a frozen dataclass to checked values, in its ``__post_init__``."""
    for name, value in values.items():
        object.__setattr__(record, name, value)
