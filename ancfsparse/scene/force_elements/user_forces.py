"""Forces that are functions of the motion, given as Python or C functions."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_flag
from ancfsparse.errors import InputError, LoadError, trial_call
from ancfsparse.messages import format_value
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.joints.joint import check_point
from ancfsparse.scene.loads.attachment import Attachment, Marks
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.compiled_callbacks import (
    check_signature,
    is_compiled,
    picklable_callback,
)
from ancfsparse.scene.records.record import At, PointRef, Record, text
from ancfsparse.scene.records.signal import Signal

Function = Callable[[Vector, Vector, float], ArrayLike]

SIGNATURE = "int (ptrdiff_t, double *, double *, double, double *, void *)"


@dataclass(frozen=True, eq=False)
class ForceSpec(Record):
    """The record of `Scene.force`."""

    points: tuple[PointRef, ...]
    function: Any
    coupled: bool = False
    method = "force"

    def describe(self, at: At, made: Any) -> str:
        """Describe its points; the function is not described."""
        return f"force ({text(self.points, at)}): a function of the motion"


@dataclass(frozen=True, eq=False)
class Force(Attachment):
    """Forces on points as a function of their positions and velocities, and of time.

    Attributes
    ----------
    points, function, coupled
        As in `Scene.force`.
    """

    points: tuple[Point, ...]
    function: Any
    coupled: bool
    contribution = "applied.user_forces"

    @property
    def what(self) -> str:
        """Name in messages."""
        more = f" and {len(self.points) - 1} more points" if len(self.points) > 1 else ""
        return f"the force on {self.points[0]!r}{more}"

    @property
    def marks(self) -> Marks:
        """Symbols in pictures, without a direction."""
        return [("force", point, None) for point in self.points]

    def checked(self, q: Vector, v: Vector, t: float) -> Vector:
        """Call the Python function; return its forces, (k, dim) [N].

        Raises
        ------
        LoadError
            If it raises an exception, or its result is not valid.
        """
        try:
            result = self.function(q, v, t)
        except Exception as error:  # a user function may raise anything
            raise self.failure(t, f"{type(error).__name__}: {error}".rstrip(": ")) from error
        try:
            forces = np.asarray(result, dtype=np.float64)
        except (TypeError, ValueError):
            raise self.failure(
                t, f"it returned {format_value(result)}, not an array of numbers"
            ) from None
        if forces.shape != q.shape:
            raise self.failure(
                t, f"it returned shape {forces.shape}, where {q.shape} is needed: a row for a point"
            )
        invalid = np.argwhere(~np.isfinite(forces))
        if len(invalid):
            row, column = invalid[0]
            raise self.failure(
                t, f"it returned {forces[row, column]} N along {'xyz'[column]} at point {row}"
            )
        return forces

    def failure(self, t: float, reason: str) -> LoadError:
        """Return the error for a function that has failed."""
        return LoadError(f"{self.what}, a function, failed at t = {t:.6g} s: {reason}", t)

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling."""
        return self.__dict__ | {"function": picklable_callback(self.function, self.what)}


class Forces(SceneBase):
    """User-defined forces of a scene."""

    def force(
        self,
        points: Point | Iterable[Point],
        function: Function,
        *,
        coupled: bool = False,
    ) -> Force:
        """Apply forces that are a function of the motion, such as drag, thrust or a control.

        Parameters
        ----------
        points : Point or sequence of Point
            Where they act, k points of beams such as ``[rod.end, rod.at(0.3)]``.
        function : callable
            Takes positions (k, dim) [m], velocities (k, dim) [m/s] and the time [s], and returns
            forces (k, dim) [N].  It must depend on these alone, because it is called for trial
            states too.  As a Python function it is called once for each residual, with all points
            at once; a call costs about 5 microseconds besides the function itself, and a matrix
            needs 4 dim calls.  A `scipy.LowLevelCallable`, or a capsule with the
            signature as its name, costs next to nothing: ``int f(ptrdiff_t k, double *q, double *v,
            double t, double *force, void *data)``, rows behind each other, which sets `force` and
            returns 0, or another number if it fails.
        coupled : bool, optional
            Whether the force on a point depends on the motion of the other points.  The residual
            has all of the force in any case, so equilibria and motions are right; if it is False,
            what points do to each other is left out of the matrix, which costs more iterations,
            and what depends on the matrix alone is wrong: ``stats.negative_pivots`` of an
            equilibrium; `modes`, `load_path`, `stable_step` and similar functions refuse it.  If it
            is True, the matrix has a dense block for all k points, made by 4 k dim calls: for
            a few points only.

        Raises
        ------
        InputError
            If there are no points, or one twice; if the function fails in the reference shape at
            rest at t = 0, where it is tried out.

        Notes
        -----
        The matrix of a step takes the symmetric part of the derivative, by central differences; the
        residual has all of the force.
        """
        try:
            given = (points,) if isinstance(points, Point) else tuple(points)
        except TypeError:  # an array without axes is an Iterable, too
            raise InputError(f"a force needs points of beams, got {format_value(points)}") from None
        where = tuple(check_point("a force", point) for point in given)
        if not where:
            raise InputError("a force needs at least one point, got none")
        for point in where:
            self._own("a force", point.beam)
        twice = next((point for k, point in enumerate(where) if point in where[:k]), None)
        if twice is not None:
            raise InputError(f"a force was given {twice!r} twice: leave one of them out")
        force = Force(where, function, check_flag("coupled of a force", coupled))
        if is_compiled(function):
            check_signature(force.what, function, SIGNATURE)
        elif isinstance(function, Signal):
            raise InputError(
                f"{force.what} must be a function of positions, velocities and time, got the "
                f"signal {function!r}: what depends on time alone is a point_force"
            )
        elif callable(function):
            positions = np.array([point.position for point in where])
            with trial_call():
                force.checked(positions, np.zeros_like(positions), 0.0)
        else:
            raise InputError(
                f"{force.what} must be a function of positions, velocities and time, got "
                f"{format_value(function)}"
            )
        record = ForceSpec(tuple(point.reference for point in where), function, force.coupled)
        return self._attach(force, record)
