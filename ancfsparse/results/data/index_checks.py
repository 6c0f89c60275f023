"""Checks of indices."""

from __future__ import annotations

import numpy as np

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value


def check_index(what: str, value: object, n: int) -> int:
    """Return an index from 0 to n - 1 of n objects, described by `what` for the message.

    Valid are integers from -n to n - 1, where negative ones count from the end.
    """
    # Differences of times are integers to NumPy.
    if isinstance(value, (bool, np.timedelta64)) or not isinstance(value, (int, np.integer)):
        raise InputError(f"{what} is a number such as 0, got {format_value(value)}")
    if not -n <= value < n:
        raise InputError(f"{what} counts from 0 to {n - 1}, got {format_value(value)}")
    return int(value) % n
