"""Springs and dampers between two points."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.errors import InputError, LoadError, trial_call
from ancfsparse.messages import format_numbers
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.geometry.positions import COINCIDENCE_RATIO, check_position
from ancfsparse.scene.joints.joint import check_point
from ancfsparse.scene.loads.attachment import Attachment, check_coefficient
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.compiled_callbacks import (
    check_signature,
    is_compiled,
    picklable_callback,
)
from ancfsparse.scene.records.record import At, PointRef, Record, as_data

Stiffness = float | Callable[[float], float]

# Signatures of C functions from the elongation [m] to the force [N].
LAW_SIGNATURES = ("double (double)", "double (double, void *)")


@dataclass(frozen=True, eq=False)
class SpringSpec(Record):
    """The record of `Scene.spring`."""

    a: PointRef
    b: PointRef | tuple[float, ...]
    stiffness: Any = 0.0
    damping: float = 0.0
    length: float | None = None
    method = "spring"
    planar: ClassVar = {"b": "put"}
    units: ClassVar = {"b": "m", "stiffness": "N/m", "damping": "N s/m", "length": "m"}

    def describe(self, at: At, made: Any) -> str:
        """Describe its ends and its numbers; a force law is not described."""
        other = at(self.b) if isinstance(self.b, PointRef) else format_numbers(self.b)
        law = callable(self.stiffness) or is_compiled(self.stiffness)
        stiffness = "a force law" if law else f"{self.stiffness:.9g}"
        values = f"{stiffness}, {self.damping:.9g}, {made.length:.9g}"
        return f"spring ({at(self.a)}; {other}): ({values})"


@dataclass(frozen=True, eq=False)
class Spring(Attachment):
    """A massless spring and a damper in parallel, along the line between two points.

    Attributes
    ----------
    a, b, stiffness, damping, length
        As in `Scene.spring`.
    """

    a: Point
    b: Point | NDArray[np.float64]
    stiffness: Any
    damping: float
    length: float
    contribution = "force_elements.springs"

    @property
    def signature(self) -> str:
        """Signature of a force law that is a C function."""
        return check_signature(f"the force law of {self.what}", self.stiffness, *LAW_SIGNATURES)

    @property
    def what(self) -> str:
        """Name in messages."""
        return f"the spring between {self.a!r} and {place(self.b)}"

    @property
    def links(self) -> tuple[tuple[Point | NDArray[np.float64], Point | NDArray[np.float64]], ...]:
        """The line between its ends."""
        return ((self.a, self.b),)

    def pull(self, elongation: float) -> float:
        """Return the force at an elongation [N]; 0 for a C function, which is not called."""
        if is_compiled(self.stiffness):
            return 0.0
        law = self.stiffness
        return float(law(elongation)) if callable(law) else float(law * elongation)

    def failure(self, elongation: float, raised: Exception | None = None) -> LoadError:
        """Return the error for a force law that raised an exception or is not finite."""
        law = f"the force law of {self.what}, at an elongation of {elongation:.6g} m,"
        if raised is None:
            return LoadError(f"{law} returned no finite number of newtons", math.nan)
        error = LoadError(f"{law} failed: {type(raised).__name__}: {raised}".rstrip(": "), math.nan)
        error.__cause__ = raised
        return error

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling."""
        return self.__dict__ | {"stiffness": picklable_callback(self.stiffness, self.what)}


class Springs(SceneBase):
    """Springs and dampers of a scene."""

    def spring(
        self,
        a: Point,
        b: Point | ArrayLike,
        *,
        stiffness: Stiffness = 0.0,
        damping: float = 0.0,
        length: float | None = None,
    ) -> Spring:
        """Add a massless spring and damper between two points.

        With the distance l of the points it pulls them together with
        ``stiffness * (l - length) + damping * dl/dt``.

        Parameters
        ----------
        a : Point
            One end, for example ``rod.end`` or ``rod.at(0.3)``.
        b : Point or array_like of shape (dim,)
            The other end: a point of a beam, or one fixed in space [m].
        stiffness : float or callable, optional
            Stiffness [N/m], zero or more; or a force law, a function that takes the elongation
            l - length [m] and returns the force [N], positive if it pulls.  As a Python function it
            is called with one number, about a microsecond each time, once in a residual and three
            times in a matrix; its energy is found by quadrature.  A `scipy.LowLevelCallable` with
            the signature ``double (double)`` or ``double (double, void *)`` costs no more than a
            number.
        damping : float, optional
            Damping [N s/m], zero or more.
        length : float, optional
            Free length [m], by default the distance of the points in the reference shape.

        Raises
        ------
        InputError
            If a number is negative or not finite, both ends are one point, or a force law gives no
            number.
        """
        one = check_point("a spring", a)
        self._own("a spring", one.beam)
        other: Point | NDArray[np.float64]
        if isinstance(b, Point):
            other, there = b, b.position
            self._own("a spring", b.beam)
        else:
            other = there = check_position(f"the end of the spring at {one!r}", b, self.dim)
        what = f"the spring between {one!r} and {place(other)}"
        distance = float(np.linalg.norm(there - one.position))
        if isinstance(other, Point) and one == other:
            raise InputError(f"{what} has both ends at one point")
        if length is None and distance <= COINCIDENCE_RATIO * one.beam.size:
            raise InputError(
                f"{what}: the end points coincide, so the free length is undefined; pass length="
            )
        law = callable(stiffness) or is_compiled(stiffness)
        k = stiffness if law else check_coefficient(f"stiffness of {what}", stiffness, "N/m")
        c = check_coefficient(f"damping of {what}", damping, "N s/m")
        rest = None if length is None else check_coefficient(f"length of {what}", length, "m")
        spring = Spring(one, other, k, c, distance if rest is None else rest)
        if not law and k == 0.0 and c == 0.0:
            raise InputError(f"{what} does nothing: give it a stiffness or a damping")
        if is_compiled(stiffness):
            check_signature(f"the force law of {what}", stiffness, *LAW_SIGNATURES)
        elif law:
            check_law(spring, distance - spring.length)
        end = other.reference if isinstance(other, Point) else as_data(other)
        return self._attach(spring, SpringSpec(one.reference, end, k, c, rest))


def check_law(spring: Spring, elongation: float) -> None:
    """Call a force law once, so that errors are raised where it is defined."""
    with trial_call():
        try:
            force = float(spring.stiffness(elongation))
        except Exception as error:  # a user function may raise anything
            raise spring.failure(elongation, error) from error
        if not math.isfinite(force):
            raise spring.failure(elongation)


def place(end: Point | NDArray[np.float64]) -> str:
    """Return an end of a spring as text."""
    if isinstance(end, Point):
        return repr(end)
    return "(" + ", ".join(f"{x:.9g}" for x in end) + ")"
