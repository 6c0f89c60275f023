"""Describe free motions: which parts move, along which direction or about which axis."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from ancfsparse.system.rigid_motion.rigid_parts import Part

Vector = NDArray[np.float64]

# A free motion names no more of the parts that take part in it.
NAMED = 3
# Shares of a motion below this are rounding.
ROUNDING = 1e-6
# A column may lead a motion if it is not much smaller than the largest.
LEADING = 0.1


def named(dim: int, parts: list[Part], free: Vector) -> list[str]:
    """Name free motions, reduced until each is led by another mode of a part.

    Rotations lead before translations, because a turn about a distant point is a turn and a
    translation, and earlier parts before later ones.

    Parameters
    ----------
    dim : int
        Of the scene.
    parts : list of Part
        What moves.
    free : (k, n) float
        Independent motions in the modes of all parts.

    Returns
    -------
    list of str
        Such as ``"translation along x of beam 0"``.
    """
    first = np.concatenate([[0], np.cumsum([dim + len(part.axes) for part in parts])])
    turns = np.concatenate([np.arange(b + dim, e) for b, e in itertools.pairwise(first)])
    shifts = np.concatenate([np.arange(b, b + dim) for b in first[:-1]])
    rows, leads = _reduced(free, (turns, shifts))
    return [
        _name(dim, parts, first, row, int(np.searchsorted(first, lead, side="right")) - 1)
        for row, lead in zip(rows, leads, strict=True)
    ]


def _reduced(free: Vector, kinds: tuple[NDArray[np.int64], ...]) -> tuple[Vector, list[int]]:
    """Return the same motions by Gauss and Jordan, and the mode that leads each."""
    rows = free / np.max(np.abs(free), axis=1, keepdims=True)
    leads: list[int] = []
    for columns in kinds:
        while len(leads) < len(rows):
            left = np.abs(rows[len(leads) :, columns])
            if left.max(initial=0.0) <= ROUNDING:
                break
            column = columns[int(np.argmax(left.max(axis=0) >= LEADING * left.max()))]
            pivot = len(leads)
            best = pivot + int(np.argmax(np.abs(rows[pivot:, column])))
            rows[[pivot, best]] = rows[[best, pivot]]
            rows[pivot] /= rows[pivot, column]
            others = np.arange(len(rows)) != pivot
            rows[others] -= np.outer(rows[others, column], rows[pivot])
            leads.append(int(column))
    return rows, leads


def _name(dim: int, parts: list[Part], first: NDArray[np.int64], row: Vector, lead: int) -> str:
    """Name a motion by what its leading part does."""
    part = parts[lead]
    shift, turn = part.motion(row[first[lead] : first[lead + 1]], dim)
    moving = np.flatnonzero(np.maximum.reduceat(np.abs(row), first[:-1]) > ROUNDING)
    more = len(moving) - NAMED
    names = [parts[k].name for k in moving[:NAMED]] + ([f"{more} more"] if more > 0 else [])
    return f"{_motion(dim, part, shift, turn)} of {' and '.join(names)}"


def _motion(dim: int, part: Part, shift: Vector, turn: Vector) -> str:
    angle = float(np.linalg.norm(turn))
    if angle * part.size <= ROUNDING * float(np.linalg.norm(shift)):
        return f"translation along {_direction(shift, dim)}"
    along = shift @ turn / angle
    point = part.start + np.cross(turn, shift) / angle**2
    name = f"rotation about {_direction(turn, 3)} through {_numbers(point[:dim], part.size)} m"
    if abs(along) > ROUNDING * angle * part.size:
        name += f" with {abs(along) / angle:.3g} m along it per radian"
    return name


def _direction(vector: Vector, dim: int) -> str:
    """Write a direction: the name of its axis, or its components."""
    unit = vector / np.linalg.norm(vector)
    axis = int(np.argmax(np.abs(unit)))
    unit *= np.sign(unit[axis])
    return "xyz"[axis] if 1.0 - abs(unit[axis]) <= 1e-12 else _numbers(unit[:dim], 1.0)


def _numbers(values: Vector, size: float) -> str:
    """Write a point or direction, (1, 0.5, 0), with what is rounding beside its size as zero."""
    return f"({', '.join(f'{x:.4g}' for x in np.where(np.abs(values) > 1e-9 * size, values, 0.0))})"
