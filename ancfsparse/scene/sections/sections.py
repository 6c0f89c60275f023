"""Cross-sections: from a shape, or from measured numbers, to what a beam needs.

The section lies in its own y-z plane, the beam's axis is x.  In a planar scene y is in the plane
and z points out of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_finite, check_positive, set_fields
from ancfsparse.errors import InputError
from ancfsparse.scene.sections.material import Material
from ancfsparse.scene.sections.polygon import PRINCIPAL, Polygon
from ancfsparse.scene.sections.profiles import IBeam, Tube, check_side

POINTS = 3  # Gauss points of an element with a section that changes
ZETA_5 = 1.0369277551433699  # Riemann's zeta(5) = 1 + 1/2^5 + 1/3^5 + ...


@dataclass(frozen=True)
class Rectangle:
    """A solid rectangular section.

    Parameters
    ----------
    width : float
        Side along z, across the plane of a planar scene [m].
    height : float
        Side along y, in the plane of a planar scene [m].
    """

    width: float
    height: float

    def __post_init__(self) -> None:
        """Check both sides and keep them in double precision."""
        set_fields(
            self,
            width=check_side("width of the rectangle", self.width),
            height=check_side("height of the rectangle", self.height),
        )

    @property
    def area(self) -> float:
        """Area [m2]."""
        return self.width * self.height

    @property
    def inertia_y(self) -> float:
        """Second moment of area int z^2 dA, for bending about y [m4]."""
        return self.height * self.width**3 / 12.0

    @property
    def inertia_z(self) -> float:
        """Second moment of area int y^2 dA, for bending about z [m4]."""
        return self.width * self.height**3 / 12.0

    @property
    def torsion_constant(self) -> float:
        """Saint-Venant's torsion constant J [m4]; 0.140577 b^4 for a square.

        Notes
        -----
        Saint-Venant's series (Timoshenko and Goodier, Theory of Elasticity, article 109) is
        ``a b^3 (1/3 - 64 b / (pi^5 a) sum tanh(n pi a / 2 b) / n^5)`` over odd n, with a >= b.
        The part of the sum with tanh replaced by 1 is 31/32 zeta(5); what remains falls off
        like exp(-n pi a / b), so six terms give every digit.
        """
        a, b = max(self.width, self.height), min(self.width, self.height)
        tail = 0.0
        for n in range(1, 12, 2):
            decay = math.exp(-n * math.pi * a / b)
            tail += 2.0 * decay / (1.0 + decay) / n**5
        series = 31.0 / 32.0 * ZETA_5 - tail
        return a * b**3 * (1.0 / 3.0 - 64.0 * b / (math.pi**5 * a) * series)

    def shear_correction(self, poisson_ratio: float) -> float:
        """Shear correction factor k (Cowper 1966), the same for y and z.

        Parameters
        ----------
        poisson_ratio : float
            Poisson's ratio nu of the material.

        Returns
        -------
        float
            ``10 (1 + nu) / (12 + 11 nu)``.
        """
        return 10.0 * (1.0 + poisson_ratio) / (12.0 + 11.0 * poisson_ratio)


@dataclass(frozen=True)
class Circle:
    """A solid circular section.

    Parameters
    ----------
    diameter : float
        Diameter [m].
    """

    diameter: float

    def __post_init__(self) -> None:
        """Check the diameter and keep it in double precision."""
        set_fields(self, diameter=check_side("diameter of the circle", self.diameter))

    @property
    def area(self) -> float:
        """Area [m2]."""
        return math.pi * self.diameter**2 / 4.0

    @property
    def inertia_y(self) -> float:
        """Second moment of area int z^2 dA [m4]."""
        return math.pi * self.diameter**4 / 64.0

    @property
    def inertia_z(self) -> float:
        """Second moment of area int y^2 dA [m4]."""
        return math.pi * self.diameter**4 / 64.0

    @property
    def torsion_constant(self) -> float:
        """Torsion constant J, here the polar second moment [m4]."""
        return math.pi * self.diameter**4 / 32.0

    def shear_correction(self, poisson_ratio: float) -> float:
        """Shear correction factor k (Cowper 1966), the same for y and z.

        Parameters
        ----------
        poisson_ratio : float
            Poisson's ratio nu of the material.

        Returns
        -------
        float
            ``6 (1 + nu) / (7 + 6 nu)``.
        """
        return 6.0 * (1.0 + poisson_ratio) / (7.0 + 6.0 * poisson_ratio)


@dataclass(frozen=True)
class Section:
    """A section known by its numbers: measured, tabulated, or computed elsewhere.

    Parameters
    ----------
    area : float
        Area [m2].
    inertia_y : float
        Second moment of area int z^2 dA, for bending about y [m4].
    inertia_z : float
        Second moment of area int y^2 dA, for bending about z and in a planar scene [m4].
    torsion_constant : float
        Torsion constant J [m4].
    shear_factor : float, optional
        Shear correction factor k, the same for y and z.  The default 5/6 is the value of a
        rectangle at Poisson's ratio 0.
    inertia_yz : float, optional
        Product moment of area int y z dA [m4], of thick beams in space.
    """

    area: float
    inertia_y: float
    inertia_z: float
    torsion_constant: float
    shear_factor: float = 5.0 / 6.0
    inertia_yz: float = 0.0

    def __post_init__(self) -> None:
        """Check every number and keep it in double precision."""
        product = check_finite("inertia_yz of the section", self.inertia_yz, "m4")
        set_fields(
            self,
            area=check_positive("area of the section", self.area, "m2"),
            inertia_y=check_positive("inertia_y of the section", self.inertia_y, "m4"),
            inertia_z=check_positive("inertia_z of the section", self.inertia_z, "m4"),
            torsion_constant=check_positive(
                "torsion_constant of the section", self.torsion_constant, "m4"
            ),
            shear_factor=check_positive("shear_factor of the section", self.shear_factor),
            inertia_yz=product,
        )
        if not abs(product) < math.sqrt(self.inertia_y) * math.sqrt(self.inertia_z):
            raise InputError(
                f"inertia_yz of the section, {product:.6g} m4, must be smaller than the root of "
                f"inertia_y times inertia_z, {self.inertia_y:.6g} and {self.inertia_z:.6g} m4"
            )

    def shear_correction(self, poisson_ratio: float) -> float:
        """Shear correction factor k, as it was given.

        Parameters
        ----------
        poisson_ratio : float
            Poisson's ratio of the material; does not change the factor.

        Returns
        -------
        float
            The factor.
        """
        return self.shear_factor


@dataclass(frozen=True)
class Taper:
    """A section that changes evenly along a beam.

    Its sides, or numbers, are those of `start` at the start of the beam and those of `end` at its
    end, and linear between.  An element has the means over its length: in statics the error falls
    with the square of the element length, and the mass is exact.

    Parameters
    ----------
    start, end : Rectangle, Circle, Tube, IBeam or Section
        Two sections of one kind.
    """

    start: Rectangle | Circle | Tube | IBeam | Section
    end: Rectangle | Circle | Tube | IBeam | Section

    def __post_init__(self) -> None:
        """Check that both are of one kind."""
        known = (Rectangle, Circle, Tube, IBeam, Section)
        if not isinstance(self.start, known) or type(self.start) is not type(self.end):
            raise InputError(
                "a Taper needs two sections of one kind, both Rectangle, Circle, Tube, IBeam or "
                f"Section, got {type(self.start).__name__} and {type(self.end).__name__}"
            )

    def at(self, share: float) -> Rectangle | Circle | Tube | IBeam | Section:
        """Return the section at a share of the length, from 0 to 1."""
        pairs = {name: (value, getattr(self.end, name)) for name, value in vars(self.start).items()}
        return type(self.start)(**{k: (1.0 - share) * a + share * b for k, (a, b) in pairs.items()})

    def over(self, shares: NDArray[np.float64]) -> Means:
        """Return the means over elements, whose ends are at shares (n + 1,) of the length."""
        points, weights = np.polynomial.legendre.leggauss(POINTS)
        middle, half = 0.5 * (shares[1:] + shares[:-1]), 0.5 * np.diff(shares)
        places = np.clip(middle[:, None] + half[:, None] * points, 0.0, 1.0)
        sections = [[self.at(float(x)) for x in row] for row in places]
        return Means(sections, 0.5 * weights)

    @property
    def area(self) -> float:
        """Mean area [m2]."""
        return float(self.over(np.array([0.0, 1.0])).area[0])


@dataclass(frozen=True)
class Means:
    """Means of sections over elements, each (n,).

    Parameters
    ----------
    sections : list of list
        Sections at the points of every element.
    weights : ndarray
        Shares of the points.
    """

    sections: list[list[Rectangle | Circle | Tube | IBeam | Section]]
    weights: NDArray[np.float64]

    def _mean(self, of: Callable[[Any], float]) -> NDArray[np.float64]:
        return np.array([[of(each) for each in row] for row in self.sections]) @ self.weights

    @property
    def area(self) -> NDArray[np.float64]:
        """Area [m2]."""
        return self._mean(lambda each: float(each.area))

    @property
    def inertia_y(self) -> NDArray[np.float64]:
        """Second moment of area int z^2 dA [m4]."""
        return self._mean(lambda each: float(each.inertia_y))

    @property
    def inertia_z(self) -> NDArray[np.float64]:
        """Second moment of area int y^2 dA [m4]."""
        return self._mean(lambda each: float(each.inertia_z))

    @property
    def torsion_constant(self) -> NDArray[np.float64]:
        """Torsion constant J [m4]."""
        return self._mean(lambda each: float(each.torsion_constant))

    def shear_correction(self, poisson_ratio: float) -> NDArray[np.float64]:
        """Shear correction factor, weighed with the area."""
        shear = self._mean(lambda each: float(each.area * each.shear_correction(poisson_ratio)))
        return shear / self.area


AnySection = Rectangle | Circle | Tube | IBeam | Polygon | Section | Taper


def principal_axes(section: Any) -> tuple[float, float, float]:
    """Return the angle from y, towards z, to the principal axis nearest to it, and both moments.

    Returns
    -------
    angle : float
        From -pi/4 to pi/4 [rad].
    inertia_y, inertia_z : float
        For bending about the principal axes nearest to y and to z [m4].
    """
    about_y, about_z = section.inertia_y, section.inertia_z
    product = getattr(section, "inertia_yz", 0.0)
    if not product or abs(product) <= PRINCIPAL * (about_y + about_z):
        return 0.0, about_y, about_z
    apart = math.copysign(1.0, about_z - about_y)
    half = apart * math.hypot(0.5 * (about_z - about_y), product)
    angle = 0.5 * math.atan2(apart * product, 0.5 * abs(about_z - about_y))
    return angle, 0.5 * (about_y + about_z) - half, 0.5 * (about_y + about_z) + half


def parameters_of(section: Any, material: Material) -> dict[str, dict[str, Any]]:
    """Give the parameters of elements of a section, or of its means, by what damps them.

    ``"stretching"``, of the axis and the section, by `Material.axial_damping`; ``"turning"``, of
    sections beside each other, by `Material.bending_damping`; ``"masses"`` by Rayleigh's alpha;
    ``"ratios"`` by nothing.  Units are those of `ElasticBody.stiffnesses`.
    """
    modulus, shear_modulus = material.youngs_modulus, material.shear_modulus
    _, about_y, about_z = principal_axes(section)
    shear_stiffness = (
        section.shear_correction(material.poisson_ratio) * shear_modulus * section.area
    )
    return {
        "stretching": {
            "axial_stiffness": modulus * section.area,
            "lame_area": material.lame_modulus * section.area,
            "shear_modulus_area": shear_modulus * section.area,
            "youngs_modulus_area": modulus * section.area,
        },
        "turning": {
            "bending_stiffness": modulus * about_z,
            "shear_stiffness_y": shear_stiffness,
            "shear_stiffness_z": shear_stiffness,
            "torsion_stiffness": shear_modulus * section.torsion_constant,
            "bending_stiffness_y": modulus * about_y,
            "bending_stiffness_z": modulus * about_z,
        },
        "masses": {
            "mass_per_length": material.density * section.area,
            "inertia_y": material.density * about_z,
            "inertia_z": material.density * about_y,
        },
        "ratios": {"poisson_ratio": material.poisson_ratio},
    }
