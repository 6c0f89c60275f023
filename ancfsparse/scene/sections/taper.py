"""Sections that change along a beam, and their means over elements."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.scene.sections.cross_section import (
    AnySection,
    CrossSection,
    list_section_types,
)

GAUSS_POINTS = 3  # of an element with a section that changes


@dataclass(frozen=True)
class Taper(AnySection):
    """A section that changes linearly along a beam.

    The sides, or numbers, are those of `start` at the start of the beam, those of `end` at its end,
    and linear between.  An element has the means over its length: in statics the error decreases
    with the square of the element length, and the mass is exact.

    Parameters
    ----------
    start, end : CrossSection
        Two sections of one class, which is not a `Polygon`.
    """

    start: CrossSection
    end: CrossSection
    is_uniform = False

    def __post_init__(self) -> None:
        """Check that both are of one class."""
        is_valid = isinstance(self.start, CrossSection) and self.start.can_taper
        if not is_valid or type(self.start) is not type(self.end):
            raise InputError(
                f"a Taper needs two sections of one kind, both "
                f"{list_section_types(can_taper=True)}, got {type(self.start).__name__} and "
                f"{type(self.end).__name__}"
            )

    def at(self, fraction: float) -> CrossSection:
        """Return the section at a fraction of the length, from 0 to 1."""
        pairs = {name: (value, getattr(self.end, name)) for name, value in vars(self.start).items()}
        return type(self.start)(
            **{name: (1.0 - fraction) * a + fraction * b for name, (a, b) in pairs.items()}
        )

    @property
    def parts(self) -> tuple[CrossSection, ...]:
        """The sections at both ends."""
        return self.start, self.end

    def rotate(self) -> Taper:
        """Return the section rotated by a right angle about the axis."""
        return replace(self, start=self.start.rotate(), end=self.end.rotate())

    def average_over(self, fractions: Vector) -> ElementSections:
        """Return the means over elements with ends at fractions (n + 1,) of the length."""
        points, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
        middle, half = 0.5 * (fractions[1:] + fractions[:-1]), 0.5 * np.diff(fractions)
        positions = np.clip(middle[:, None] + half[:, None] * points, 0.0, 1.0)
        sections = [[self.at(float(x)) for x in row] for row in positions]
        return ElementSections(sections, 0.5 * weights)

    @property
    def area(self) -> float:
        """Mean area [m2]."""
        return float(self.average_over(np.array([0.0, 1.0])).area[0])


@dataclass(frozen=True)
class ElementSections:
    """Means of sections over elements, each (n,).

    Parameters
    ----------
    sections : list of list
        Sections at the Gauss points of every element.
    weights : ndarray
        Weights of the Gauss points, whose sum is 1.
    """

    sections: list[list[CrossSection]]
    weights: Vector

    def _mean(self, value: Callable[[CrossSection], float]) -> Vector:
        values = [[float(value(section)) for section in row] for row in self.sections]
        return np.array(values) @ self.weights

    @property
    def area(self) -> Vector:
        """Area [m2]."""
        return self._mean(lambda section: section.area)

    @property
    def inertia_y(self) -> Vector:
        """Second moment of area int z^2 dA [m4]."""
        return self._mean(lambda section: section.inertia_y)

    @property
    def inertia_z(self) -> Vector:
        """Second moment of area int y^2 dA [m4]."""
        return self._mean(lambda section: section.inertia_z)

    @property
    def torsion_constant(self) -> Vector:
        """Torsion constant J [m4]."""
        return self._mean(lambda section: section.torsion_constant)

    def shear_correction(self, poisson_ratio: float) -> Vector:
        """Return the shear correction factor, weighted with the area [-]."""
        shear = self._mean(lambda section: section.area * section.shear_correction(poisson_ratio))
        return shear / self.area
