"""Obstacles with simple cores: a half-space, a drum that can turn, a ball.

Each is the set of points within a radius of its core: a half-space, an axis, a centre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_moderate, set_fields
from ancfsparse.errors import InputError
from ancfsparse.scene.force_elements.obstacles.cores import Core, axes_along
from ancfsparse.scene.force_elements.obstacles.obstacle import Obstacle, check_direction
from ancfsparse.scene.kinematics.rigid_motion import spin_matrix


def _unit(direction: tuple[float, ...]) -> Vector:
    return np.asarray(np.array(direction) / np.linalg.norm(direction))


@dataclass(frozen=True)
class HalfSpace(Obstacle):
    """Everything behind a plane, such as a floor; in a planar scene behind a line.

    Parameters
    ----------
    base : array_like, shape (dim,)
        A point of the plane [m].
    normal : array_like, shape (dim,)
        Normal that points out of the half-space, of any length.
    """

    base: tuple[float, ...]
    normal: tuple[float, ...]
    noun = "half-space"
    radius = 0.0

    def __post_init__(self) -> None:
        """Check the arguments."""
        super().__post_init__()
        set_fields(
            self, normal=check_direction("the normal of a half-space", self.normal, self.dim)
        )

    @property
    def core(self) -> Core:
        """All points on the inner side of the plane."""
        high = np.where(np.arange(self.dim) == 0, 0.0, np.inf)
        bounds = np.stack([np.full(self.dim, -np.inf), high])
        return Core(axes_along(np.array(self.normal)), bounds)

    @property
    def projector(self) -> Vector:
        """Projector on the normal."""
        return np.outer(self.normal_vector, self.normal_vector)

    @property
    def normal_vector(self) -> Vector:
        """Unit normal."""
        return _unit(self.normal)


@dataclass(frozen=True)
class Drum(Obstacle):
    """An infinite cylinder, which can turn steadily about its axis; in a planar scene a disc.

    Parameters
    ----------
    base : array_like, shape (dim,)
        A point of its axis [m].
    radius : float
        Radius [m].
    axis : array_like, shape (3,), optional
        Direction of the axis, in a spatial scene only.
    angular_velocity : float, optional
        Angular velocity about the axis [rad/s], in a planar scene counterclockwise.
    """

    base: tuple[float, ...]
    radius: float
    axis: tuple[float, ...] | None = None
    angular_velocity: float = 0.0
    noun = "drum"

    def __post_init__(self) -> None:
        """Check the arguments."""
        super().__post_init__()
        radius = check_moderate("radius of a drum", self.radius, "m")
        if self.dim == 3 and self.axis is None:
            raise InputError("a drum in space needs the direction of its axis: give axis=")
        if self.dim == 2 and self.axis is not None:
            raise InputError("the axis of a drum in the plane is normal to it: leave axis out")
        axis = None if self.axis is None else check_direction("the axis of a drum", self.axis, 3)
        set_fields(self, radius=radius, axis=axis)
        spin_matrix("the angular velocity of a drum", self.angular_velocity, 2)

    @property
    def core(self) -> Core:
        """The axis, in the plane the centre."""
        if self.axis is None:
            return Core(np.eye(2), np.zeros((2, 2)))
        high = np.array([np.inf, 0.0, 0.0])
        return Core(axes_along(np.array(self.axis)), np.stack([-high, high]))

    @property
    def projector(self) -> Vector:
        """Projector on the directions normal to the axis."""
        if self.axis is None:
            return np.eye(2)
        along = _unit(self.axis)
        return np.eye(3) - np.outer(along, along)

    @property
    def spin(self) -> Vector:
        """Skew matrix of the angular velocity."""
        rate: ArrayLike = self.angular_velocity
        if self.axis is not None:
            rate = self.angular_velocity * _unit(self.axis)
        return spin_matrix("the angular velocity of a drum", rate, self.dim)


@dataclass(frozen=True)
class Ball(Obstacle):
    """A ball; in a planar scene a disc.

    Parameters
    ----------
    base : array_like, shape (dim,)
        Its centre [m].
    radius : float
        Radius [m].
    """

    base: tuple[float, ...]
    radius: float
    noun = "ball"

    def __post_init__(self) -> None:
        """Check the arguments."""
        super().__post_init__()
        set_fields(self, radius=check_moderate("radius of a ball", self.radius, "m"))

    @property
    def core(self) -> Core:
        """The centre."""
        return Core(np.eye(self.dim), np.zeros((2, self.dim)))

    @property
    def projector(self) -> Vector:
        """The unit matrix."""
        return np.eye(self.dim)
