"""Fixed bodies that beams touch: a half-space, a drum that may turn, a ball.

Each is the set of points within a radius of its base: a plane, an axis, a centre.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_moderate, check_vector, set_fields
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.kinematics.rigid_motion import spin_matrix

# Classes of obstacles, by their names in files and messages.
OBSTACLE_TYPES: dict[str, type[Obstacle]] = {}


class Obstacle(ABC):
    """A fixed body, described by `base` and `projector`.

    The vector from the base to a point x is ``d = projector (x - base)``, and the distance of x
    from the surface |d| - `radius`.
    """

    noun: ClassVar[str]
    radius: float
    base: tuple[float, ...]

    def __init_subclass__(cls) -> None:
        """Enter it in the table of obstacles."""
        OBSTACLE_TYPES[cls.__name__] = cls

    def __post_init__(self) -> None:
        """Check the arguments that all obstacles have."""
        size: tuple[int, ...]
        try:
            size = np.shape(self.base)
        except ValueError:  # rows that differ
            size = ()
        if size not in ((2,), (3,)):
            raise InputError(
                f"the position of a {self.noun} must have 2 components (planar) or 3, got "
                f"{format_value(self.base)}"
            )
        base = check_vector(f"the position of a {self.noun}", self.base, size[0], "m")
        set_fields(self, base=tuple(base.tolist()))

    @property
    def dim(self) -> int:
        """Number of components of a position, 2 or 3."""
        return len(self.base)

    @property
    @abstractmethod
    def projector(self) -> Vector:
        """Matrix (dim, dim) that keeps the part of a vector away from the base [-]."""

    @property
    def normal_vector(self) -> Vector | None:
        """Outward normal (dim,) if it is the same everywhere, else None."""
        return None

    @property
    def spin(self) -> Vector:
        """Skew matrix (dim, dim) of the angular velocity of its surface [rad/s]."""
        return np.zeros((self.dim, self.dim))

    def vectors(self, positions: Vector) -> Vector:
        """Return the vectors from the base to points (k, dim) [m]."""
        return np.asarray((positions - np.array(self.base)) @ self.projector.T)

    def distances(self, positions: Vector) -> Vector:
        """Return the distances of points (k, dim) from the surface, (k,) [m], negative inside."""
        if self.normal_vector is not None:
            return np.asarray((positions - np.array(self.base)) @ self.normal_vector)
        return np.asarray(np.linalg.norm(self.vectors(positions), axis=1) - self.radius)


def _check_direction(what: str, vector: ArrayLike, dim: int) -> tuple[float, ...]:
    direction = check_vector(what, vector, dim)
    if not direction.any():
        raise InputError(f"{what} must have a direction, got {format_value(vector)}")
    return tuple(direction.tolist())


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
        Normal that points out of it; its length does not matter.
    """

    base: tuple[float, ...]
    normal: tuple[float, ...]
    noun = "half-space"
    radius = 0.0

    def __post_init__(self) -> None:
        """Check the arguments."""
        super().__post_init__()
        set_fields(
            self, normal=_check_direction("the normal of a half-space", self.normal, self.dim)
        )

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
    """An endless cylinder, which may turn steadily about its axis; in a planar scene a disc.

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
        axis = None if self.axis is None else _check_direction("the axis of a drum", self.axis, 3)
        set_fields(self, radius=radius, axis=axis)
        spin_matrix("the angular velocity of a drum", self.angular_velocity, 2)

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
    def projector(self) -> Vector:
        """The unit matrix."""
        return np.eye(self.dim)
