"""Shapes of rigid bodies: volume, centre, and second moments."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import (
    check_choice,
    check_moderate,
    set_fields,
)

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Box:
    """A box with its centre at the origin of the body and its edges along the axes.

    Parameters
    ----------
    length, height, width : float
        Along x, y and z of the body [m].
    """

    length: float
    height: float
    width: float
    is_line: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Check the edges."""
        for name in ("length", "height", "width"):
            set_fields(self, **{name: check_moderate(f"{name} of a box", getattr(self, name), "m")})

    @property
    def volume(self) -> float:
        """Volume [m3]."""
        return self.length * self.height * self.width

    @property
    def centre(self) -> Vector:
        """Centre of mass, (3,) [m]."""
        return np.zeros(3)

    @property
    def spread(self) -> Vector:
        """Mean of x x^T over the mass about its centre, (3, 3) [m2]."""
        return np.diag([self.length**2, self.height**2, self.width**2]) / 12.0

    @property
    def reach(self) -> Vector:
        """Half the extent along each axis, (3,) [m]."""
        return 0.5 * np.array([self.length, self.height, self.width])


@dataclass(frozen=True)
class Cylinder:
    """A cylinder with its centre at the origin of the body; a short one is a disc.

    Parameters
    ----------
    radius, length : float
        Its radius, and its length along the axis [m].
    axis : str, optional
        Its axis in the body, ``"x"``, ``"y"`` or ``"z"``.
    """

    radius: float
    length: float
    axis: str = "z"
    is_line: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ("radius", "length"):
            set_fields(
                self, **{name: check_moderate(f"{name} of a cylinder", getattr(self, name), "m")}
            )
        check_choice("axis of a cylinder", self.axis, ("x", "y", "z"))

    @property
    def volume(self) -> float:
        """Volume [m3]."""
        return math.pi * self.radius**2 * self.length

    @property
    def centre(self) -> Vector:
        """Centre of mass, (3,) [m]."""
        return np.zeros(3)

    @property
    def spread(self) -> Vector:
        """Mean of x x^T over the mass about its centre, (3, 3) [m2]."""
        return np.diag(np.where(self._along, self.length**2 / 12.0, self.radius**2 / 4.0))

    @property
    def reach(self) -> Vector:
        """Half the extent along each axis, (3,) [m]."""
        return np.where(self._along, 0.5 * self.length, self.radius)

    @property
    def _along(self) -> NDArray[np.bool_]:
        return np.array([each == self.axis for each in "xyz"])


@dataclass(frozen=True)
class Sphere:
    """A sphere with its centre at the origin of the body.

    Parameters
    ----------
    radius : float
        Its radius [m].
    """

    radius: float
    is_line: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Check the radius."""
        set_fields(self, radius=check_moderate("radius of a sphere", self.radius, "m"))

    @property
    def volume(self) -> float:
        """Volume [m3]."""
        return 4.0 / 3.0 * math.pi * self.radius**3

    @property
    def centre(self) -> Vector:
        """Centre of mass, (3,) [m]."""
        return np.zeros(3)

    @property
    def spread(self) -> Vector:
        """Mean of x x^T over the mass about its centre, (3, 3) [m2]."""
        return self.radius**2 / 5.0 * np.eye(3)

    @property
    def reach(self) -> Vector:
        """Half the extent along each axis, (3,) [m]."""
        return np.full(3, self.radius)


@dataclass(frozen=True)
class Rod:
    """A thin straight rod from the origin of the body along its x axis.

    It has no inertia about its axis, so in space it has five degrees of freedom: its rotation
    about itself is undefined.

    Parameters
    ----------
    length : float
        Its length [m].
    """

    length: float
    is_line: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the length."""
        set_fields(self, length=check_moderate("length of a rod", self.length, "m"))

    @property
    def volume(self) -> float:
        """Volume, which a thin rod does not have [m3]."""
        return 0.0

    @property
    def centre(self) -> Vector:
        """Centre of mass, (3,) [m]."""
        return np.array([0.5 * self.length, 0.0, 0.0])

    @property
    def spread(self) -> Vector:
        """Mean of x x^T over the mass about its centre, (3, 3) [m2]."""
        return np.diag([self.length**2 / 12.0, 0.0, 0.0])

    @property
    def reach(self) -> Vector:
        """Half the extent along each axis, (3,) [m]."""
        return np.array([0.5 * self.length, 0.0, 0.0])


Shape = Box | Cylinder | Sphere | Rod
