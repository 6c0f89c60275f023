"""Numbers by which a caller picks one of several."""

from __future__ import annotations

import numpy as np

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value


def check_index(what: str, value: object, n: int) -> int:
    """Return which one of `n` is addressed, counting from 0.

    Parameters
    ----------
    what : str
        What is counted, for the message.
    value : object
        What was given: an integer, from -n to n - 1.
    n : int
        How many there are.

    Returns
    -------
    int
        From 0 to n - 1.

    Raises
    ------
    InputError
        If it is no integer, or beyond the last one.
    """
    # Differences of times are integers to NumPy.
    if isinstance(value, (bool, np.timedelta64)) or not isinstance(value, (int, np.integer)):
        raise InputError(f"{what} is a number such as 0, got {format_value(value)}")
    if not -n <= value < n:
        raise InputError(f"{what} counts from 0 to {n - 1}, got {format_value(value)}")
    return int(value) % n
