"""Positions in space, checked and written."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_vector
from ancfsparse.errors import InputError

COINCIDENCE_RATIO = 1e-9  # distance of coincident points, over the size of the body
MIN_LENGTH_RATIO = 1e-12  # of a beam, over the distance of its ends from the origin
MAX_COORDINATE = 1e150  # [m], whose square is in the range of floating-point numbers


def check_ends(
    label: str, start: ArrayLike | None, end: ArrayLike | None, dim: int
) -> tuple[Vector, Vector]:
    """Return the two ends of a beam, each (dim,) [m].

    Raises
    ------
    InputError
        If an end is missing or invalid, or both coincide.
    """
    if start is None or end is None:
        missing = "start" if start is None else "end"
        raise InputError(f"{label} has no {missing}: give `start` and `end`, or a `curve`")
    tail = check_vector(f"start of {label}", start, dim, "m")
    head = check_vector(f"end of {label}", end, dim, "m")
    largest = max(np.abs(tail).max(), np.abs(head).max())
    if largest > MAX_COORDINATE:
        raise InputError(
            f"{label} has an end beyond {MAX_COORDINATE:g} m: it runs from {place(tail)} to "
            f"{place(head)}; give positions in metres"
        )
    if np.linalg.norm(head - tail) <= MIN_LENGTH_RATIO * largest:
        raise InputError(
            f"{label} has zero length: start and end are both at {place(tail)}, move one of them"
        )
    return tail, head


def check_position(what: str, value: ArrayLike, dim: int) -> NDArray[np.float64]:
    """Return a position as `check_vector` does, whose squared distances do not overflow.

    Raises
    ------
    InputError
        If it is not such a vector [m], or lies beyond `MAX_COORDINATE`.
    """
    point = check_vector(what, value, dim, "m")
    if np.max(np.abs(point)) > MAX_COORDINATE:
        raise InputError(
            f"{what} lies beyond {MAX_COORDINATE:g} m, at {place(point)}: give positions in metres"
        )
    return point


def place(position: Vector) -> str:
    """Return a position [m] as text for a message, such as ``(0, 1.5) m``."""
    return "(" + ", ".join(f"{x:.6g}" for x in position) + ") m"
