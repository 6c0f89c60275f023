"""Checks of what a person gives, which say in a sentence what is wrong with it."""

from __future__ import annotations

import difflib
import math
import operator
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.errors import InputError, with_unit


def suggest(name: object, valid: Iterable[str]) -> str:
    """Say which names are valid, the nearest one first.

    Parameters
    ----------
    name : object
        What was given; anything but a string has no nearest name.
    valid : iterable of str
        The names that would have been understood.

    Returns
    -------
    str
        For example ``did you mean 'thin'? Valid are 'l2t2', 'thin', 'thick'``.
    """
    names = list(valid)
    listing = "valid are " + ", ".join(repr(each) for each in names)
    near = difflib.get_close_matches(name.lower(), names, 1, 0.5) if isinstance(name, str) else []
    return f"did you mean {near[0]!r}? V{listing[1:]}" if near else listing


def check_choice(what: str, name: object, valid: Iterable[str]) -> str:
    """Return `name` if it is one of `valid`.

    Parameters
    ----------
    what : str
        What the name stands for, as it should appear in the message.
    name : object
        What was given.
    valid : iterable of str
        The names that are understood.

    Returns
    -------
    str
        `name`, unchanged.

    Raises
    ------
    InputError
        If it is not, with the nearest valid name.
    """
    names = list(valid)
    if isinstance(name, str) and name in names:
        return name
    raise InputError(f"unknown {what} {name!r}: {suggest(name, names)}")


def check_finite(what: str, value: object, unit: str = "") -> float:
    """Return `value` as a finite float.

    Parameters
    ----------
    what : str
        Name of the quantity in the message.
    value : object
        What was given.
    unit : str, optional
        SI unit in the message.

    Returns
    -------
    float
        The value.

    Raises
    ------
    InputError
        If `value` is not a real number, or is infinite or NaN.
    """
    if isinstance(value, (bool, np.bool_, str, bytes)) or np.ndim(value) != 0:  # type: ignore[arg-type]
        raise InputError(f"{what} must be a number, got {value!r}")
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise InputError(f"{what} must be a number, got {value!r}") from None
    if not math.isfinite(number):
        raise InputError(f"{what} must be finite, got {with_unit(number, unit)}")
    return number


def check_positive(what: str, value: object, unit: str = "") -> float:
    """Return `value` as a positive finite float.

    Parameters
    ----------
    what : str
        Name of the quantity in the message.
    value : object
        What was given.
    unit : str, optional
        SI unit in the message.

    Returns
    -------
    float
        The value.

    Raises
    ------
    InputError
        If `value` is not a number, not finite, zero or negative.
    """
    number = check_finite(what, value, unit)
    if number <= 0.0:
        raise InputError(f"{what} must be positive, got {with_unit(number, unit)}")
    return number


def check_count(what: str, value: object, lowest: int = 1) -> int:
    """Return `value` as an integer not below `lowest`.

    Parameters
    ----------
    what : str
        Name of the count in the message.
    value : object
        What was given; a float is refused even when it is whole.
    lowest : int, optional
        Smallest valid count.

    Returns
    -------
    int
        The count.

    Raises
    ------
    InputError
        If `value` is not an integer or too small.
    """
    try:
        count = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise InputError(f"{what} must be an integer, got {value!r}") from None
    if isinstance(value, bool) or count < lowest:
        raise InputError(f"{what} must be an integer of at least {lowest}, got {value!r}")
    return count


def check_vector(what: str, value: ArrayLike, dim: int, unit: str = "") -> NDArray[np.float64]:
    """Return `value` as a finite vector of `dim` components that cannot be written to.

    Parameters
    ----------
    what : str
        Name of the vector in the message.
    value : array_like
        What was given.
    dim : int
        2 in a planar scene, 3 in a spatial one.
    unit : str, optional
        SI unit in the message.

    Returns
    -------
    ndarray, shape (dim,)
        A copy, float64, read-only.

    Raises
    ------
    InputError
        If the shape is not ``(dim,)`` or a component is not a finite number.
    """
    try:
        vector = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{what} must be {dim} numbers, got {value!r}") from None
    if vector.shape != (dim,):
        kind, hint = ("planar", "(x, y)") if dim == 2 else ("spatial", "(x, y, z)")
        got = f"{vector.size} components" if vector.ndim == 1 else f"shape {vector.shape}"
        raise InputError(
            f"{what} has {got}, but the scene is {kind}: give {hint}, or give the gravity of the "
            f"scene {5 - dim} components to make it {'spatial' if dim == 2 else 'planar'}"
        )
    if not np.isfinite(vector).all():
        axis = "xyz"[int(np.argmin(np.isfinite(vector)))]
        raise InputError(
            f"{what} must be finite, but its {axis} component is "
            f"{with_unit(float(vector['xyz'.index(axis)]), unit)}"
        )
    vector.flags.writeable = False
    return vector
