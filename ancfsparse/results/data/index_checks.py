"""Checks of indices."""

from __future__ import annotations

import numpy as np

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value


def check_index(what: str, value: object, n: int) -> int:
    """Return an index from 0 to n - 1.

    Parameters
    ----------
    what : str
        The indexed objects, for the message.
    value : object
        The argument: an integer from -n to n - 1.
    n : int
        Number of objects.

    Returns
    -------
    int
        From 0 to n - 1.

    Raises
    ------
    InputError
        If it is not an integer, or out of range.
    """
    # Differences of times are integers to NumPy.
    if isinstance(value, (bool, np.timedelta64)) or not isinstance(value, (int, np.integer)):
        raise InputError(f"{what} is a number such as 0, got {format_value(value)}")
    if not -n <= value < n:
        raise InputError(f"{what} counts from 0 to {n - 1}, got {format_value(value)}")
    return int(value) % n
