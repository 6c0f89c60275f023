"""A plane in space, and projections of the data of a scene into it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.scene.records.signal import Signal, Sum, Value
from ancfsparse.scene.records.signals import Pulse, Ramp, Sine, Table

ROUNDING = 1e-13  # relative component normal to a plane, by rounding along tilted axes


class LeavesPlaneError(Exception):
    """A vector or position leaves the plane, or a part of the scene has no planar form."""


@dataclass(frozen=True, eq=False)
class Plane:
    """Plane in space with axes.

    Attributes
    ----------
    origin : ndarray, shape (3,)
        Origin of the planar scene [m].
    axes : ndarray, shape (2, 3)
        Unit vectors e_x and e_y, as rows.
    normal : ndarray, shape (3,)
        Unit vector e_x x e_y.
    size : float
        Extent of the scene in the plane [m].
    """

    origin: Vector
    axes: Vector
    normal: Vector
    size: float

    def into(self, vectors: ArrayLike) -> Vector:
        """Return the components of vectors (..., 3) in the plane, (..., 2).

        Raises
        ------
        LeavesPlaneError
            If one of them is not parallel to the plane.
        """
        given = np.asarray(vectors, dtype=float)
        self._check(given @ self.normal, np.linalg.norm(given, axis=-1).max(initial=0.0))
        return given @ self.axes.T

    def put(self, positions: ArrayLike) -> Vector:
        """Return the coordinates of points (..., 3) [m] in the plane, (..., 2) [m].

        Raises
        ------
        LeavesPlaneError
            If one of them is not in the plane.
        """
        given = np.asarray(positions, dtype=float)
        offsets = given - self.origin
        self._check(offsets @ self.normal, self.size + np.linalg.norm(given, axis=-1))
        return offsets @ self.axes.T

    def across(self, vectors: ArrayLike) -> Vector:
        """Return the component along the normal of vectors (..., 3) that are parallel to it.

        Raises
        ------
        LeavesPlaneError
            If one of them is not.
        """
        given = np.asarray(vectors, dtype=float)
        along = given @ self.normal
        rest = given - along[..., None] * self.normal
        self._check(np.linalg.norm(rest, axis=-1), np.abs(along))
        return along

    def lift(self, vectors: ArrayLike) -> Vector:
        """Return vectors (..., 2) of the plane in space, (..., 3)."""
        return cast(Vector, np.asarray(vectors, dtype=float) @ self.axes)

    def place(self, positions: ArrayLike) -> Vector:
        """Return points (..., 2) of the plane [m] in space, (..., 3) [m]."""
        return self.origin + self.lift(positions)

    def project(self, value: Any, how: str) -> Any:
        """Return a value of shape (3,), a signal or a function of time in the planar scene.

        `how`: ``"into"`` for vectors, ``"put"`` for positions, ``"across"`` for vectors along the
        normal.
        """
        if isinstance(value, Signal):
            return self._signal(value, how)
        if callable(value):
            return PlanarFunction(value, self, how)
        return self._data(value, how)

    def _signal(self, signal: Signal, how: str) -> Signal:
        """Project the coefficients of a signal."""
        if how == "put" and not isinstance(signal, Table):
            parts, constant = _parts(signal)
            there = self._data(np.broadcast_to(constant, 3), "put")
            return Sum(tuple(self._signal(each, "into") for each in parts), there)
        if isinstance(signal, Sum):
            constant = self._data(np.broadcast_to(signal.constant, 3), how)
            return Sum(tuple(self._signal(each, how) for each in signal.parts), constant)
        if isinstance(signal, Table):
            return replace(signal, values=getattr(self, how)(signal.values))
        if isinstance(signal, Sine):
            return replace(signal, amplitude=self._data(signal.amplitude, how))
        if isinstance(signal, Ramp | Pulse):
            return replace(signal, value=self._data(signal.value, how))
        raise LeavesPlaneError

    def _data(self, value: Any, how: str) -> Any:
        projected = getattr(self, how)(value)
        return tuple(projected.tolist()) if projected.ndim else float(projected)

    def _check(self, off: Any, size: Any) -> None:
        if not (np.abs(off) <= ROUNDING * size).all():
            raise LeavesPlaneError


@dataclass(frozen=True, eq=False)
class PlanarFunction:
    """Function with values in space, projected into the planar scene.

    Attributes
    ----------
    function : callable
        Returns vectors or positions (..., 3), of the time or of positions.
    plane : Plane
        The plane.
    how : str
        See `Plane.project`.
    lifted : bool
        Whether the argument of the function is positions, (k, 2) in the planar scene.
    """

    function: Any
    plane: Plane
    how: str
    lifted: bool = False

    def __call__(self, argument: Any) -> Any:
        """Return the value of the function in the plane.

        Raises
        ------
        InputError
            If it leaves the plane.
        """
        value = self.function(self.plane.place(argument) if self.lifted else argument)
        try:
            return getattr(self.plane, self.how)(value)
        except LeavesPlaneError:
            raise InputError(
                f"it returned {np.array2string(np.asarray(value), threshold=6)}, which leaves the "
                "plane of the scene: solve the scene in space"
            ) from None


def find_plane(points: Vector, vectors: Vector, down: Vector) -> Plane:
    """Return the plane that contains points (k, 3) [m] and vectors (m, 3) of any length.

    The first point is the origin; gravity, if there is any, is `down` and along -e_y.

    Raises
    ------
    LeavesPlaneError
        If there is none.
    """
    offsets = points - points[0]
    size = float(np.linalg.norm(offsets, axis=1).max(initial=0.0))
    given = np.concatenate([vectors, down[None]])
    lengths = np.linalg.norm(given, axis=1)
    units = given[lengths > 0.0] / lengths[lengths > 0.0, None]
    rows = np.concatenate([offsets / size, units]) if size else units
    if not len(rows):
        raise LeavesPlaneError
    # Zeros complete fewer than three rows: all three right singular vectors are needed.
    rows = np.concatenate([rows, np.zeros((3, 3))])
    axes = np.linalg.svd(rows, full_matrices=False)[2]
    normal = _unit(axes[2])
    up = -down if down.any() else axes[0] - (axes[0] @ normal) * normal
    side = np.cross(up, normal)
    if np.linalg.norm(side) <= ROUNDING * np.linalg.norm(up):
        raise LeavesPlaneError
    e_x = _unit(side)
    plane = Plane(points[0], np.stack([e_x, _unit(np.cross(normal, e_x))]), normal, size)
    plane.put(points)
    plane.into(units)
    return plane


def _parts(signal: Signal) -> tuple[tuple[Signal, ...], Value]:
    """Return the parts of a sum and its constant; any other signal is the only part of its sum."""
    return (signal.parts, signal.constant) if isinstance(signal, Sum) else ((signal,), 0.0)


def _unit(vector: Vector) -> Vector:
    """Return a unit vector, with zeros in place of rounding errors."""
    unit = vector / np.linalg.norm(vector)
    unit[np.abs(unit) < 4.0 * np.finfo(float).eps] = 0.0
    return cast(Vector, unit / np.linalg.norm(unit))
