"""Shapes of rigid bodies of uniform density: volume, centre, and second moments."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice, check_moderate, set_fields
from ancfsparse.scene.sections.cross_section import power

# Classes of shapes, by their names in files and messages.
SHAPE_TYPES: dict[str, type[RigidShape]] = {}


class RigidShape(ABC):
    """A shape in the frame of a body; its centre is the origin unless it says otherwise.

    Attributes
    ----------
    noun : str
        Its name in messages.
    lengths : tuple of str
        Fields that are lengths [m], checked when it is made.
    is_line : bool
        Whether all of its mass is on the x axis.
    """

    noun: ClassVar[str]
    lengths: ClassVar[tuple[str, ...]]
    is_line: ClassVar[bool] = False

    def __init_subclass__(cls) -> None:
        """Enter it in the table of shapes."""
        SHAPE_TYPES[cls.__name__] = cls

    def __post_init__(self) -> None:
        """Check the lengths and store them in double precision."""
        for name in self.lengths:
            length = check_moderate(f"{name} of a {self.noun}", getattr(self, name), "m")
            set_fields(self, **{name: length})

    @property
    @abstractmethod
    def volume(self) -> float:
        """Volume [m3]."""

    @property
    def centre(self) -> Vector:
        """Centre of mass, (3,) [m]."""
        return np.zeros(3)

    @property
    @abstractmethod
    def spread(self) -> Vector:
        """Mean of x x^T over the mass about its centre, (3, 3) [m2]."""

    @property
    @abstractmethod
    def half_extent(self) -> Vector:
        """Half the extent along each axis, (3,) [m]."""


@dataclass(frozen=True, kw_only=True)
class Box(RigidShape):
    """A box with its centre at the origin of the body and its edges along the axes.

    Parameters
    ----------
    length : float
        Length along x [m].
    width : float
        Width along z [m].
    height : float
        Height along y [m].
    """

    length: float
    width: float
    height: float
    noun = "box"
    lengths = ("length", "width", "height")

    @property
    def volume(self) -> float:
        """Volume [m3]."""
        return self.length * self.height * self.width

    @property
    def spread(self) -> Vector:
        """Mean of x x^T over the mass about its centre, (3, 3) [m2]."""
        return np.diag([power(self.length, 2), power(self.height, 2), power(self.width, 2)]) / 12.0

    @property
    def half_extent(self) -> Vector:
        """Half the extent along each axis, (3,) [m]."""
        return 0.5 * np.array([self.length, self.height, self.width])


@dataclass(frozen=True)
class Cylinder(RigidShape):
    """A cylinder with its centre at the origin of the body; a short one is a disc.

    Parameters
    ----------
    radius : float
        Radius [m].
    length : float
        Length along the axis [m].
    axis : str, optional
        Axis of the body along which it is, ``"x"``, ``"y"`` or ``"z"``.
    """

    radius: float
    length: float
    axis: str = "z"
    noun = "cylinder"
    lengths = ("radius", "length")

    def __post_init__(self) -> None:
        """Check the lengths and the axis."""
        super().__post_init__()
        check_choice("axis of a cylinder", self.axis, ("x", "y", "z"))

    @property
    def volume(self) -> float:
        """Volume [m3]."""
        return math.pi * power(self.radius, 2) * self.length

    @property
    def spread(self) -> Vector:
        """Mean of x x^T over the mass about its centre, (3, 3) [m2]."""
        return np.diag(
            np.where(self._is_axis, power(self.length, 2) / 12.0, power(self.radius, 2) / 4.0)
        )

    @property
    def half_extent(self) -> Vector:
        """Half the extent along each axis, (3,) [m]."""
        return np.where(self._is_axis, 0.5 * self.length, self.radius)

    @property
    def _is_axis(self) -> NDArray[np.bool_]:
        return np.array([axis == self.axis for axis in "xyz"])


@dataclass(frozen=True)
class Sphere(RigidShape):
    """A sphere with its centre at the origin of the body.

    Parameters
    ----------
    radius : float
        Radius [m].
    """

    radius: float
    noun = "sphere"
    lengths = ("radius",)

    @property
    def volume(self) -> float:
        """Volume [m3]."""
        return 4.0 / 3.0 * math.pi * power(self.radius, 3)

    @property
    def spread(self) -> Vector:
        """Mean of x x^T over the mass about its centre, (3, 3) [m2]."""
        return power(self.radius, 2) / 5.0 * np.eye(3)

    @property
    def half_extent(self) -> Vector:
        """Half the extent along each axis, (3,) [m]."""
        return np.full(3, self.radius)


@dataclass(frozen=True)
class Rod(RigidShape):
    """A thin straight rod from the origin of the body along its x axis.

    It has no inertia about its axis, so in space it has five degrees of freedom: its rotation
    about itself is undefined.

    Parameters
    ----------
    length : float
        Length [m].
    """

    length: float
    noun = "rod"
    lengths = ("length",)
    is_line = True
    volume = 0.0  # which a thin rod does not have

    @property
    def centre(self) -> Vector:
        """Centre of mass, (3,) [m]."""
        return np.array([0.5 * self.length, 0.0, 0.0])

    @property
    def spread(self) -> Vector:
        """Mean of x x^T over the mass about its centre, (3, 3) [m2]."""
        return np.diag([power(self.length, 2) / 12.0, 0.0, 0.0])

    @property
    def half_extent(self) -> Vector:
        """Half the extent along each axis, (3,) [m]."""
        return np.array([0.5 * self.length, 0.0, 0.0])
