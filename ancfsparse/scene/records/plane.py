"""A plane in space, and projections of the data of a scene into it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NoReturn, cast

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.scene.records.signal import Signal, Sum
from ancfsparse.scene.records.signals import Table

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
        self.check(given @ self.normal, np.linalg.norm(given, axis=-1).max(initial=0.0))
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
        self.check(offsets @ self.normal, self.size + np.linalg.norm(given, axis=-1))
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
        self.check(np.linalg.norm(rest, axis=-1), np.abs(along))
        return along

    def lift(self, vectors: ArrayLike) -> Vector:
        """Return vectors (..., 2) of the plane in space, (..., 3)."""
        return cast(Vector, np.asarray(vectors, dtype=float) @ self.axes)

    def place(self, positions: ArrayLike) -> Vector:
        """Return points (..., 2) of the plane [m] in space, (..., 3) [m]."""
        return self.origin + self.lift(positions)

    def absent(self, value: Any) -> NoReturn:
        """Refuse a value that has no planar form."""
        self.refuse()

    def refuse(self) -> NoReturn:
        """Refuse a part that has no planar form."""
        raise LeavesPlaneError

    def is_normal(self, vectors: ArrayLike) -> bool:
        """Return whether all vectors (..., 3) are parallel to the normal."""
        try:
            self.across(vectors)
        except LeavesPlaneError:
            return False
        return True

    def project(self, value: Any, form: str, of_positions: bool = False) -> Any:
        """Return a value of shape (3,), a signal or a function in the planar scene.

        Parameters
        ----------
        value : tuple of float, Signal, callable, None or False
            The last two are returned as they are.
        form : str
            As in `Record.planar`.
        of_positions : bool, optional
            True for a function of positions, False for one of the time.
        """
        if value is None or value is False:
            return value
        if isinstance(value, Signal):
            return self._signal(value, form)
        if callable(value):
            return PlanarFunction(value, self, form, of_positions)
        return self._data(value, form)

    def _signal(self, signal: Signal, form: str) -> Signal:
        """Project the coefficients of a signal."""
        if form == "put" and not isinstance(signal, Table):
            parts, constant = (
                (signal.parts, signal.constant) if isinstance(signal, Sum) else ((signal,), 0.0)
            )
            there = self._data(np.broadcast_to(constant, 3), "put")
            return Sum(tuple(self._signal(each, "into") for each in parts), there)
        if isinstance(signal, Sum):
            constant = self._data(np.broadcast_to(signal.constant, 3), form)
            return Sum(tuple(self._signal(each, form) for each in signal.parts), constant)
        if not signal.coefficient:
            self.refuse()
        values = self._data(getattr(signal, signal.coefficient), form)
        return cast(Signal, replace(cast(Any, signal), **{signal.coefficient: values}))

    def _data(self, value: Any, form: str) -> Any:
        projected = getattr(self, form)(value)
        return tuple(projected.tolist()) if projected.ndim else float(projected)

    def check(self, off: Any, size: Any) -> None:
        """Refuse components off the plane that are more than the rounding of a size."""
        if not (np.abs(off) <= ROUNDING * size).all():
            self.refuse()


@dataclass(frozen=True, eq=False)
class PlanarFunction:
    """Function with values in space, projected into the planar scene.

    Attributes
    ----------
    function : callable
        Returns vectors or positions (..., 3), of the time or of positions.
    plane : Plane
        The plane.
    form : str
        As in `Record.planar`.
    of_positions : bool
        Whether the argument of the function is positions, (k, 2) in the planar scene.
    """

    function: Any
    plane: Plane
    form: str
    of_positions: bool = False

    def __call__(self, argument: Any) -> Any:
        """Return the value of the function in the plane.

        Raises
        ------
        InputError
            If it leaves the plane.
        """
        value = self.function(self.plane.place(argument) if self.of_positions else argument)
        try:
            return getattr(self.plane, self.form)(value)
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


def _unit(vector: Vector) -> Vector:
    """Return a unit vector, with zeros in place of rounding errors."""
    unit = vector / np.linalg.norm(vector)
    unit[np.abs(unit) < 4.0 * np.finfo(float).eps] = 0.0
    return cast(Vector, unit / np.linalg.norm(unit))
