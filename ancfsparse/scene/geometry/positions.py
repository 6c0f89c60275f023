"""Positions in space, checked and written."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import check_vector
from ancfsparse.errors import InputError

Vector = NDArray[np.float64]

# Start and end closer than this share of their distance from the origin differ by rounding only.
NO_LENGTH = 1e-12


# Farther away [m], squares of lengths leave the range of floating-point numbers.
FARTHEST = 1e150


def check_ends(
    label: str, start: ArrayLike | None, end: ArrayLike | None, dim: int
) -> tuple[Vector, Vector]:
    """Return the two ends of a beam, each (dim,) [m].

    Raises
    ------
    InputError
        If one is missing or no position, or both are one.
    """
    if start is None or end is None:
        missing = "start" if start is None else "end"
        raise InputError(f"{label} has no {missing}: give `start` and `end`, or a `curve`")
    tail = check_vector(f"start of {label}", start, dim, "m")
    head = check_vector(f"end of {label}", end, dim, "m")
    far = max(np.abs(tail).max(), np.abs(head).max())
    if far > FARTHEST:
        raise InputError(
            f"{label} has an end beyond {FARTHEST:g} m: it runs from {place(tail)} to "
            f"{place(head)}; give positions in metres"
        )
    if np.linalg.norm(head - tail) <= NO_LENGTH * far:
        raise InputError(
            f"{label} has zero length: start and end are both at {place(tail)}, move one of them"
        )
    return tail, head


def check_position(what: str, value: ArrayLike, dim: int) -> NDArray[np.float64]:
    """Return a point in space as `check_vector` does, whose distances do not overflow.

    Raises
    ------
    InputError
        If it is no such vector [m], or lies beyond `FARTHEST`.
    """
    point = check_vector(what, value, dim, "m")
    if np.max(np.abs(point)) > FARTHEST:
        raise InputError(
            f"{what} lies beyond {FARTHEST:g} m, at {place(point)}: give positions in metres"
        )
    return point


def place(position: Vector) -> str:
    """Write a position for a message.

    Parameters
    ----------
    position : ndarray, shape (dim,)
        Position [m].

    Returns
    -------
    str
        For example ``(0, 1.5) m``.
    """
    return "(" + ", ".join(f"{each:.6g}" for each in position) + ") m"


# Share of a beam's length within which two nodes count as being at one place.
SAME_PLACE = 1e-9
