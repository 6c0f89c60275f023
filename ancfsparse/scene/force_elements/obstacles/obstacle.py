"""The base class of obstacles."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_vector, set_fields
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.force_elements.obstacles.cores import Core

# Of lengths, relative to the largest one of an obstacle [-].  Places and directions of the same
# obstacle that are computed in two ways differ by up to 1e-15.
ROUNDING = 1e-9


class Obstacle(ABC):
    """The set of points within a `radius` of a `core`, which is placed at `base`.

    For a half-space, a drum and a ball, the vector from its plane, axis or centre to a point x is
    ``d = projector (x - base)``.
    """

    noun: ClassVar[str]
    radius: float
    base: tuple[float, ...]

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
    def core(self) -> Core:
        """The core, in a frame with the base as origin."""

    @property
    def projector(self) -> Vector | None:
        """Projector (dim, dim) on the directions normal to plane, axis or centre, else None [-]."""
        return None

    @property
    def is_alike(self) -> bool:
        """True if it has no orientation: a ball, or in the plane a disc."""
        return np.array_equal(self.core.bounds, np.zeros((2, self.dim))) and not self.core.ring

    @property
    def bend_radius(self) -> float:
        """Smallest radius of curvature of a line around its surface, zero for an edge [m]."""
        return self.radius

    @property
    def circumference(self) -> float:
        """Smallest length around a section of it, infinite for a plane [m]."""
        return math.inf if self.is_flat else 2.0 * math.pi * self.bend_radius

    @property
    def reach(self) -> float:
        """Largest radius of a body that can touch it [m]."""
        return math.inf

    @property
    def is_flat(self) -> bool:
        """True if it is not curved anywhere."""
        return self.normal_vector is not None

    @property
    def normal_vector(self) -> Vector | None:
        """Outward normal (dim,) if it is the same everywhere, else None."""
        return None

    @property
    def spin(self) -> Vector:
        """Skew matrix (dim, dim) of the angular velocity of its surface [rad/s]."""
        return np.zeros((self.dim, self.dim))

    def distances(self, positions: Vector) -> Vector:
        """Return the distances of points (k, dim) from the surface, (k,) [m], negative inside."""
        return self.core.distances(positions - np.array(self.base)) - self.radius

    def coincides_with(self, other: Obstacle) -> bool:
        """Return whether another obstacle is the same set of points, perhaps by other arguments.

        This is so if radii are equal, and each core is within the bounds of the other one.
        """
        one, another = self.core, other.core
        lengths = np.array([*self.base, *other.base, *one.bounds.flat, one.ring, self.radius])
        tolerance = ROUNDING * float(np.abs(lengths[np.isfinite(lengths)]).max())
        arm = np.array(self.base) - np.array(other.base)
        pairs = [(np.array([self.radius, one.ring]), np.array([other.radius, another.ring]))]
        for axes in (one.axes, another.axes):
            pairs.append((one.extents(axes) + axes @ arm, another.extents(axes)))
        return all(
            np.allclose(a, b, rtol=0.0, atol=tolerance) for a, b in pairs
        ) and one.has_surface_of(another, tolerance)


def check_direction(what: str, vector: ArrayLike, dim: int) -> tuple[float, ...]:
    """Return a nonzero direction as numbers."""
    direction = check_vector(what, vector, dim)
    if not direction.any():
        raise InputError(f"{what} must have a direction, got {format_value(vector)}")
    return tuple(direction.tolist())
