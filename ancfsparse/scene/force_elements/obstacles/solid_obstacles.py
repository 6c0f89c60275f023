"""Obstacles with edges or ends: a capsule, a block, a torus."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ancfsparse.checks import check_moderate, check_not_negative, check_vector, set_fields
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.force_elements.obstacles.cores import Core, axes_along
from ancfsparse.scene.force_elements.obstacles.obstacle import Obstacle, check_direction
from ancfsparse.scene.kinematics.rigid_motion import orientation_axes


@dataclass(frozen=True)
class Capsule(Obstacle):
    """A cylinder with hemispheres at both ends; in a planar scene a stadium.

    Parameters
    ----------
    base, end : array_like, shape (dim,)
        Ends of its axis, the centres of the hemispheres [m].
    radius : float
        Radius [m].
    """

    base: tuple[float, ...]
    end: tuple[float, ...]
    radius: float
    noun = "capsule"

    def __post_init__(self) -> None:
        """Check the arguments."""
        super().__post_init__()
        end = check_vector("the end of a capsule", self.end, self.dim, "m")
        radius = check_moderate("radius of a capsule", self.radius, "m")
        if not np.any(end - np.array(self.base)):
            raise InputError(
                f"a capsule has zero length: both ends are at {format_value(self.base)}; take a "
                "Ball, or move one of them"
            )
        set_fields(self, end=tuple(end.tolist()), radius=radius)

    @property
    def core(self) -> Core:
        """Its axis, a segment."""
        along = np.array(self.end) - np.array(self.base)
        high = np.linalg.norm(along) * np.eye(self.dim)[0]
        return Core(axes_along(along), np.stack([np.zeros(self.dim), high]))


@dataclass(frozen=True)
class Block(Obstacle):
    """A box, which can have rounded edges; in a planar scene a rectangle.

    Parameters
    ----------
    base : array_like, shape (dim,)
        Its centre [m].
    size : array_like, shape (dim,)
        Its lengths along its axes, including the rounding [m].
    radius : float, optional
        Radius of its edges and corners [m].
    orientation : float or array_like of shape (4,) or (3, 3), optional
        Rotation of its axes as in `Scene.add_body`: in a planar scene an angle [rad]; in space a
        unit quaternion (real part first) or a matrix with the axes as columns.
    """

    base: tuple[float, ...]
    size: tuple[float, ...]
    radius: float = 0.0
    orientation: float | tuple[float, ...] | tuple[tuple[float, ...], ...] | None = None
    noun = "block"

    def __post_init__(self) -> None:
        """Check the arguments."""
        super().__post_init__()
        lengths = check_vector("the size of a block", self.size, self.dim, "m").tolist()
        size = tuple(check_moderate("length of a block", each, "m") for each in lengths)
        radius = check_not_negative("radius of the edges of a block", self.radius, "m")
        if 2.0 * radius > min(size):
            raise InputError(
                f"the edges of a block have a radius of {radius:.6g} m, more than half of its "
                f"smallest length of {min(size):.6g} m: take a smaller radius"
            )
        orientation_axes("orientation of a block", self.dim, self.orientation)
        set_fields(self, size=size, radius=radius, orientation=_plain(self.orientation))

    @property
    def core(self) -> Core:
        """The block without its rounding, smaller by the radius on all sides."""
        half = 0.5 * np.array(self.size) - self.radius
        axes = orientation_axes("orientation of a block", self.dim, self.orientation)
        return Core(axes, np.stack([-half, half]))

    @property
    def circumference(self) -> float:
        """Length around its smallest section [m]."""
        straight = 2.0 * np.sort(np.array(self.size) - 2.0 * self.radius)[:2].sum()
        return float(straight + 2.0 * np.pi * self.radius)


def _plain(orientation: Any) -> Any:
    """Return an orientation as a number or tuples, which can be compared."""
    rows = np.asarray(orientation).tolist()
    if isinstance(rows, list):
        return tuple(tuple(row) if isinstance(row, list) else row for row in rows)
    return rows


@dataclass(frozen=True)
class Torus(Obstacle):
    """A ring of round section; in a planar scene the strip along a circle.

    Parameters
    ----------
    base : array_like, shape (dim,)
        Its centre [m].
    ring_radius : float
        Radius of the circle in the middle of its section [m].
    radius : float
        Radius of its section, in a planar scene half of the width of the strip [m].
    axis : array_like, shape (3,), optional
        Direction of its axis, in a spatial scene only.
    """

    base: tuple[float, ...]
    ring_radius: float
    radius: float
    axis: tuple[float, ...] | None = None
    noun = "torus"

    def __post_init__(self) -> None:
        """Check the arguments."""
        super().__post_init__()
        ring_radius = check_moderate("ring_radius of a torus", self.ring_radius, "m")
        radius = check_moderate("radius of a torus", self.radius, "m")
        if radius >= ring_radius:
            raise InputError(
                f"a torus has a radius of {radius:.6g} m and a ring_radius of {ring_radius:.6g} m, "
                "which leaves no hole: take a smaller radius, or a Ball"
            )
        if (self.dim == 3) != (self.axis is not None):
            raise InputError(
                "a torus in space needs the direction of its axis: give axis="
                if self.axis is None
                else "the axis of a torus in the plane is normal to it: leave axis out"
            )
        axis = None if self.axis is None else check_direction("the axis of a torus", self.axis, 3)
        set_fields(self, ring_radius=ring_radius, radius=radius, axis=axis)

    @property
    def core(self) -> Core:
        """The circle."""
        axes = np.eye(2) if self.axis is None else axes_along(np.array(self.axis))
        return Core(axes, np.zeros((2, self.dim)), self.ring_radius)

    @property
    def bend_radius(self) -> float:
        """Radius of the section, in a planar scene of the outer circle [m]."""
        return self.radius + (self.ring_radius if self.dim == 2 else 0.0)
