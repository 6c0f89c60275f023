"""Lines, arcs and helices as functions of the arc length."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_finite, check_positive, check_reals, set_fields
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.geometry.positions import MAX_COORDINATE

Direction = ArrayLike | Callable[[Vector], ArrayLike] | None
"""Direction of the height of a section in space, or a function of the arc length."""

Angle = float | Callable[[Vector], ArrayLike] | None
"""Rotation of a section at the end, or a function of the arc length [rad]."""

MAX_PLANE_DISTANCE = 1e-9  # of the start of an arc, over its radius


class Path(Protocol):
    """A smooth curve as a function of its arc length."""

    @property
    def length(self) -> float:
        """Length [m]."""

    def at(self, s: Vector) -> tuple[Vector, Vector]:
        """Return positions [m] and unit tangents, each (k, dim), at arc lengths (k,) [m]."""


@dataclass(frozen=True)
class Line:
    """A straight line.

    Parameters
    ----------
    start, end : ndarray, shape (dim,)
        Ends [m].
    """

    start: Vector
    end: Vector

    @property
    def length(self) -> float:
        """Length [m]."""
        return float(np.linalg.norm(self.end - self.start))

    def at(self, s: Vector) -> tuple[Vector, Vector]:
        """Return positions [m] and unit tangents, each (k, dim), at arc lengths (k,) [m]."""
        along = self.end - self.start
        fraction = (s / self.length)[:, None]
        tangents = np.broadcast_to(along / self.length, (len(s), len(along)))
        return (1.0 - fraction) * self.start + fraction * self.end, tangents


@dataclass(frozen=True)
class Arc:
    """A circular arc, or a full circle.

    Parameters
    ----------
    centre : array_like, shape (2,) or (3,)
        Centre of the circle [m].
    start : array_like, of the same shape
        Start of the arc [m].
    angle : float
        Angle from its start to its end [rad]: about `axis` by the right-hand rule, in a planar
        scene counterclockwise; negative in the opposite direction.  2 pi is a full circle.
    axis : array_like, shape (3,), optional
        Normal of its plane, of any length; only in a spatial scene, where it is required.

    Examples
    --------
    >>> half_ring = ancf.Arc(centre=(0, 0), start=(1, 0), angle=math.pi)
    """

    centre: tuple[float, ...]
    start: tuple[float, ...]
    angle: float
    axis: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        """Check the numbers."""
        centre = _vector("centre of the arc", self.centre)
        start = _vector("start of the arc", self.start, len(centre))
        angle = check_finite("angle of the arc", self.angle, "rad")
        axis = None if self.axis is None else _vector("axis of the arc", self.axis, 3)
        if (axis is None) != (len(centre) == 2):
            needed = "leave the axis out" if axis else "give its axis, such as axis=(0, 0, 1)"
            raise InputError(
                f"an arc with a centre of {len(centre)} components is "
                f"{'planar' if len(centre) == 2 else 'spatial'}: {needed}"
            )
        set_fields(self, centre=centre, start=start, angle=angle, axis=axis)
        if self.radius == 0.0 or angle == 0.0:
            raise InputError(
                f"the arc has zero length: its radius is {self.radius:g} m and its angle "
                f"{angle:g} rad"
            )
        if axis is not None:
            off = abs(float(self._radius_vector @ _unit("axis of the arc", axis)))
            if off > MAX_PLANE_DISTANCE * self.radius:
                raise InputError(
                    f"the start of the arc lies {off:.3g} m outside the plane through its centre "
                    "normal to its axis: move it into that plane, or take a Helix"
                )

    @cached_property
    def _radius_vector(self) -> Vector:
        """From the centre to the start [m]."""
        return np.array(self.start) - self.centre

    @property
    def radius(self) -> float:
        """Radius of the circle [m]."""
        return float(np.linalg.norm(self._radius_vector))

    @property
    def length(self) -> float:
        """Length [m]."""
        return self.radius * abs(self.angle)

    def at(self, s: Vector) -> tuple[Vector, Vector]:
        """Return positions [m] and unit tangents, each (k, dim), at arc lengths (k,) [m]."""
        one = self._radius_vector / self.radius
        if self.axis is None:
            other = np.array([-one[1], one[0]])
        else:
            other = np.cross(_unit("axis of the arc", self.axis), one)
        angle = np.asarray(s) / math.copysign(self.radius, self.angle)
        c, sn = np.cos(angle)[:, None], np.sin(angle)[:, None]
        sign = math.copysign(1.0, self.angle)
        return self.centre + self.radius * (c * one + sn * other), sign * (c * other - sn * one)


@dataclass(frozen=True)
class Helix:
    """A helix in a spatial scene.

    Parameters
    ----------
    radius : float
        Radius of the cylinder on which it lies [m].
    pitch : float
        Rise along `axis` by turn [m]; positive for a right-handed helix that climbs, negative for a
        left-handed one that descends.
    turns : float
        Number of turns, positive.
    origin : array_like, shape (3,), optional
        Point of the axis of the cylinder at the height of the start [m].
    axis : array_like, shape (3,), optional
        Direction of the cylinder's axis.
    towards : array_like, shape (3,), optional
        Approximate direction from `origin` to the start, of which the part normal to the axis is
        used.  The default is +x, or +y if the axis is along x.
    """

    radius: float
    pitch: float
    turns: float
    origin: tuple[float, ...] = (0.0, 0.0, 0.0)
    axis: tuple[float, ...] = (0.0, 0.0, 1.0)
    towards: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        """Check the numbers."""
        set_fields(
            self,
            radius=check_positive("radius of the helix", self.radius, "m"),
            pitch=check_finite("pitch of the helix", self.pitch, "m"),
            turns=check_positive("turns of the helix", self.turns),
            origin=_vector("origin of the helix", self.origin, 3),
            axis=_vector("axis of the helix", self.axis, 3),
        )
        if self.towards is not None:
            set_fields(self, towards=_vector("`towards` of the helix", self.towards, 3))
        self._frame()

    @property
    def length(self) -> float:
        """Length [m]."""
        return 2.0 * math.pi * self.turns * self._length_per_radian

    @property
    def _length_per_radian(self) -> float:
        return math.hypot(self.radius, self.pitch / (2.0 * math.pi))

    def _frame(self) -> Vector:
        """Return the unit vectors along the axis, to the start, and normal to both, (3, 3)."""
        axis = _unit("axis of the helix", self.axis)
        along_x = abs(axis[0]) > 1.0 - 1e-12
        rough = self.towards or ((0.0, 1.0, 0.0) if along_x else (1.0, 0.0, 0.0))
        one = rough - (rough @ axis) * axis
        if np.linalg.norm(one) <= 1e-9 * np.linalg.norm(rough):
            raise InputError(
                "`towards` of the helix is parallel to its axis and does not define where the "
                "helix begins: give a direction across the axis"
            )
        one = one / np.linalg.norm(one)
        return np.array([axis, one, np.cross(axis, one)])

    def at(self, s: Vector) -> tuple[Vector, Vector]:
        """Return positions [m] and unit tangents, each (k, 3), at arc lengths (k,) [m]."""
        axis, one, other = self._frame()
        angle = (np.asarray(s) / self._length_per_radian)[:, None]
        rise = self.pitch / (2.0 * math.pi)
        c, sn = np.cos(angle), np.sin(angle)
        positions = self.origin + self.radius * (c * one + sn * other) + rise * angle * axis
        tangents = (self.radius * (c * other - sn * one) + rise * axis) / self._length_per_radian
        return positions, tangents


def _vector(what: str, value: ArrayLike, dim: int | None = None) -> tuple[float, ...]:
    """Return a finite vector of `dim` components, or of 2 or 3, as a tuple."""
    needed = f"{dim or '2 or 3'} finite numbers"
    vector = check_reals(what, value, needed)
    sizes = (2, 3) if dim is None else (dim,)
    if vector.ndim != 1 or len(vector) not in sizes or not np.isfinite(vector).all():
        raise InputError(f"{what} must be {needed}, got {format_value(value)}")
    if np.abs(vector).max() > MAX_COORDINATE:
        raise InputError(
            f"{what} is beyond {MAX_COORDINATE:g}, got {format_value(value)}: give it in metres"
        )
    return tuple(vector.tolist())


def _unit(what: str, value: tuple[float, ...]) -> Vector:
    return np.array(value) / check_positive(f"length of the {what}", np.linalg.norm(value))
