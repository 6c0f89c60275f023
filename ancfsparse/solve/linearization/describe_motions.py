"""Describe free motions: the moving parts, and direction or axis of the motion."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.system.rigid_motion.rigid_parts import RigidPart

MAX_NAMED_PARTS = 3  # parts in the description of a motion
ROUNDING_RATIO = 1e-6  # components of a motion, relative to the largest, that are rounding
MIN_PIVOT_RATIO = 0.1  # pivot of an earlier column over the largest entry, to be preferred


def name_motions(dim: int, parts: list[RigidPart], free: Vector) -> list[str]:
    """Name free motions after reduction to row echelon form.

    Rotations are pivots before translations, because a rotation about a distant point is a rotation
    and a translation; earlier parts before later ones.

    Parameters
    ----------
    dim : int
        Dimension of the scene.
    parts : list of Part
        The rigid parts.
    free : (k, n) float
        Independent motions in the modes of all parts.

    Returns
    -------
    list of str
        Such as ``"translation along x of beam 0"``.
    """
    first = np.concatenate([[0], np.cumsum([dim + len(part.axes) for part in parts])])
    rotations = np.concatenate([np.arange(b + dim, e) for b, e in itertools.pairwise(first)])
    translations = np.concatenate([np.arange(b, b + dim) for b in first[:-1]])
    rows, pivots = _reduce_to_echelon(free, (rotations, translations))
    return [
        _name_motion(dim, parts, first, row, int(np.searchsorted(first, pivot, side="right")) - 1)
        for row, pivot in zip(rows, pivots, strict=True)
    ]


def _reduce_to_echelon(
    free: Vector, kinds: tuple[NDArray[np.int64], ...]
) -> tuple[Vector, list[int]]:
    """Return the motions after Gauss-Jordan elimination, and the pivot column of each."""
    rows = free / np.max(np.abs(free), axis=1, keepdims=True)
    pivots: list[int] = []
    for columns in kinds:
        while len(pivots) < len(rows):
            remaining = np.abs(rows[len(pivots) :, columns])
            if remaining.max(initial=0.0) <= ROUNDING_RATIO:
                break
            is_large = remaining.max(axis=0) >= MIN_PIVOT_RATIO * remaining.max()
            column = columns[int(np.argmax(is_large))]
            k = len(pivots)
            best = k + int(np.argmax(np.abs(rows[k:, column])))
            rows[[k, best]] = rows[[best, k]]
            rows[k] /= rows[k, column]
            others = np.arange(len(rows)) != k
            rows[others] -= np.outer(rows[others, column], rows[k])
            pivots.append(int(column))
    return rows, pivots


def _name_motion(
    dim: int, parts: list[RigidPart], first: NDArray[np.int64], row: Vector, k: int
) -> str:
    """Name a motion by the displacement of its k-th part."""
    part = parts[k]
    shift, turn = part.motion(row[first[k] : first[k + 1]], dim)
    moving = np.flatnonzero(np.maximum.reduceat(np.abs(row), first[:-1]) > ROUNDING_RATIO)
    more = len(moving) - MAX_NAMED_PARTS
    names = [parts[i].name for i in moving[:MAX_NAMED_PARTS]] + (
        [f"{more} more"] if more > 0 else []
    )
    return f"{_describe_motion(dim, part, shift, turn)} of {' and '.join(names)}"


def _describe_motion(dim: int, part: RigidPart, shift: Vector, turn: Vector) -> str:
    angle = float(np.linalg.norm(turn))
    if angle * part.size <= ROUNDING_RATIO * float(np.linalg.norm(shift)):
        return f"translation along {_format_direction(shift, dim)}"
    along = shift @ turn / angle
    point = part.start + np.cross(turn, shift) / angle**2
    where = _format_vector(point[:dim], part.size)
    name = f"rotation about {_format_direction(turn, 3)} through {where} m"
    if abs(along) > ROUNDING_RATIO * angle * part.size:
        name += f" with {abs(along) / angle:.3g} m along it per radian"
    return name


def _format_direction(vector: Vector, dim: int) -> str:
    """Format a direction: the name of its axis, or its components."""
    unit = vector / np.linalg.norm(vector)
    axis = int(np.argmax(np.abs(unit)))
    unit *= np.sign(unit[axis])
    return "xyz"[axis] if 1.0 - abs(unit[axis]) <= 1e-12 else _format_vector(unit[:dim], 1.0)


def _format_vector(values: Vector, size: float) -> str:
    """Format a point or direction as (1, 0.5, 0), with rounding relative to a size as zero."""
    return f"({', '.join(f'{x:.4g}' for x in np.where(np.abs(values) > 1e-9 * size, values, 0.0))})"
