"""Unit vectors of cross-sections along a curve."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import call_function, check_finite, check_reals, check_vector
from ancfsparse.errors import InputError
from ancfsparse.scene.geometry.curves import Angle, Direction, Path
from ancfsparse.scene.geometry.section_frames import section_axes

TRANSPORT_STEPS = 4  # of a frame from one node to the next, a power of two


def frames_along(
    label: str, path: Path, s: Vector, tangents: Vector, up: Direction, twist: Angle
) -> Vector:
    """Return the unit vectors e_x, e_y and, if spatial, e_z of sections, (n, dim, dim).

    They are those at ascending arc lengths s (n,) [m] with unit tangents (n, dim); `up` and `twist`
    are those of `Scene.add_beam`.
    """
    if tangents.shape[1] == 2:
        return np.stack([tangents, tangents[:, ::-1] * [-1.0, 1.0]], axis=1)
    if up is None:
        frames = _transported(path, s, tangents, label)
    elif callable(up):
        frames = _towards(label, _values(f"`up` of {label}", up, s, (3,)), s, tangents)
    else:
        rough = np.broadcast_to(check_vector(f"`up` of {label}", up, 3), tangents.shape)
        frames = _towards(label, rough, s, tangents)
    if twist is None:
        return frames
    if callable(twist):
        angle = _values(f"twist of {label}", twist, s, ())
    else:
        angle = check_finite(f"twist of {label}", twist, "rad") * (s / path.length)
    c, sn = np.cos(angle)[:, None], np.sin(angle)[:, None]
    _, e_y, e_z = frames.transpose(1, 0, 2)
    return np.stack([tangents, c * e_y + sn * e_z, c * e_z - sn * e_y], axis=1)


def _values(
    what: str, function: Callable[[Vector], ArrayLike], s: Vector, each: tuple[int, ...]
) -> Vector:
    """Return the checked values of a function of arc lengths."""
    at = f"for an array of {len(s)} arc lengths"
    result = call_function(what, function, s.copy(), at)
    values = check_reals(f"the result of {what}", result, "an array of numbers")
    if values.shape != (len(s), *each) or not np.isfinite(values).all():
        raise InputError(
            f"{what} must return finite numbers of shape {(len(s), *each)} for arc lengths of "
            f"shape {s.shape}, got shape {values.shape}"
        )
    return values


def _towards(label: str, rough: Vector, s: Vector, tangents: Vector) -> Vector:
    """Return frames whose e_y is as near to given directions as possible."""
    sizes = np.linalg.norm(rough, axis=1)
    if not sizes.min() > 0.0:
        raise InputError(f"`up` of {label} is zero at s = {s[np.argmin(sizes)]:.6g} m")
    along = rough / sizes[:, None]
    side = along - (along * tangents).sum(axis=1)[:, None] * tangents
    sizes = np.linalg.norm(side, axis=1)
    if sizes.min() < 1e-6:
        raise InputError(
            f"`up` of {label} is parallel to the beam at s = {s[np.argmin(sizes)]:.6g} m and "
            "does not define the direction of its section: give a direction across the beam, or a "
            "function of s"
        )
    e_y = side / sizes[:, None]
    return np.stack([tangents, e_y, np.cross(tangents, e_y)], axis=1)


def _transported(path: Path, s: Vector, tangents: Vector, label: str) -> Vector:
    """Return rotation-minimising frames, transported from the start along the curve.

    A step is two reflections (Wang, Juettler, Zheng and Liu 2008), of fourth order.
    """
    fine = np.interp(
        np.arange(TRANSPORT_STEPS * (len(s) - 1) + 1) / TRANSPORT_STEPS, np.arange(len(s)), s
    )
    positions, along = path.at(fine)
    first = _reflections(np.diff(positions, axis=0))
    second = _reflections(along[1:] - (first @ along[:-1, :, None])[..., 0])
    rotations = (second @ first).reshape(-1, TRANSPORT_STEPS, 3, 3)
    while rotations.shape[1] > 1:
        rotations = rotations[:, 1::2] @ rotations[:, ::2]
    e_y = [section_axes(tangents[0], None, label)[1]]
    for rotation in rotations[:, 0]:
        e_y.append(rotation @ e_y[-1])
    sides = np.array(e_y)
    sides -= (sides * tangents).sum(axis=1)[:, None] * tangents
    sides /= np.linalg.norm(sides, axis=1)[:, None]
    return np.stack([tangents, sides, np.cross(tangents, sides)], axis=1)


def _reflections(normals: Vector) -> Vector:
    """Return the matrices that reflect in planes across normals (n, 3); identities for zero."""
    square = np.sum(normals**2, axis=1)[:, None, None]
    outer = normals[:, :, None] * normals[:, None, :]
    projection = np.divide(outer, square, out=np.zeros_like(outer), where=square > 0.0)
    return np.asarray(np.eye(3) - 2.0 * projection)
