"""Cross-sections with formulas of their own: tubes and I-sections."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ancfsparse.checks import check_positive, set_fields
from ancfsparse.errors import InputError

SMALLEST = 1e-75  # side [m] whose fourth power, and that of its inverse, are still numbers


def check_side(what: str, value: object) -> float:
    """Return a side [m], refused if its fourth power is not among the floating-point numbers."""
    side = check_positive(what, value, "m")
    if not SMALLEST <= side <= 1.0 / SMALLEST:
        raise InputError(
            f"{what} must lie between {SMALLEST:g} and {1.0 / SMALLEST:g} m, whose fourth powers "
            f"are in the range of floating-point numbers, got {side:g} m"
        )
    return side


@dataclass(frozen=True)
class Tube:
    """A hollow circular section.

    Parameters
    ----------
    diameter : float
        Outer diameter [m].
    thickness : float
        Thickness of the wall [m], at most half the diameter.
    """

    diameter: float
    thickness: float

    def __post_init__(self) -> None:
        """Check both and keep them in double precision."""
        set_fields(
            self,
            diameter=check_side("diameter of the tube", self.diameter),
            thickness=check_side("thickness of the tube", self.thickness),
        )
        if 2.0 * self.thickness > self.diameter:
            raise InputError(
                f"the wall of the tube is {self.thickness:g} m thick, more than half its diameter "
                f"of {self.diameter:g} m: give the outer diameter, and the thickness of one wall"
            )

    @property
    def _square(self) -> float:
        """Mean of the squares of both diameters [m2]."""
        return 0.5 * (self.diameter**2 + (self.diameter - 2.0 * self.thickness) ** 2)

    @property
    def area(self) -> float:
        """Area [m2]."""
        return math.pi * self.thickness * (self.diameter - self.thickness)

    @property
    def inertia_y(self) -> float:
        """Second moment of area int z^2 dA [m4]."""
        return self.area * self._square / 8.0

    @property
    def inertia_z(self) -> float:
        """Second moment of area int y^2 dA [m4]."""
        return self.inertia_y

    @property
    def torsion_constant(self) -> float:
        """Torsion constant J, here the polar second moment [m4]."""
        return 2.0 * self.inertia_y

    def shear_correction(self, poisson_ratio: float) -> float:
        """Shear correction factor k (Cowper 1966), the same for y and z.

        Parameters
        ----------
        poisson_ratio : float
            Poisson's ratio nu of the material.

        Returns
        -------
        float
            ``6 (1 + nu) (1 + m^2)^2 / ((7 + 6 nu) (1 + m^2)^2 + (20 + 12 nu) m^2)`` with m the
            inner diameter over the outer one.
        """
        square = (1.0 - 2.0 * self.thickness / self.diameter) ** 2
        both = (1.0 + square) ** 2
        nu = poisson_ratio
        return 6.0 * (1.0 + nu) * both / ((7.0 + 6.0 * nu) * both + (20.0 + 12.0 * nu) * square)


@dataclass(frozen=True)
class IBeam:
    """A rolled or welded I-section with equal flanges, without fillets.

    Parameters
    ----------
    height : float
        Along y, both flanges included [m].
    width : float
        Of the flanges, along z [m].
    web, flange : float
        Thickness of the web and of each flange [m].
    """

    height: float
    width: float
    web: float
    flange: float

    def __post_init__(self) -> None:
        """Check the sides and keep them in double precision."""
        for name in ("height", "width", "web", "flange"):
            set_fields(self, **{name: check_side(f"{name} of the I-section", getattr(self, name))})
        if not (self.web < self.width and 2.0 * self.flange < self.height):
            raise InputError(
                f"the I-section has no room between its flanges: its web of {self.web:g} m must be "
                f"thinner than its width of {self.width:g} m, and two flanges of {self.flange:g} m "
                f"than its height of {self.height:g} m"
            )

    @property
    def area(self) -> float:
        """Area [m2]."""
        return 2.0 * self.width * self.flange + self._clear * self.web

    @property
    def _clear(self) -> float:
        """Height between the flanges [m]."""
        return self.height - 2.0 * self.flange

    @property
    def inertia_y(self) -> float:
        """Second moment of area int z^2 dA [m4]."""
        return (2.0 * self.flange * self.width**3 + self._clear * self.web**3) / 12.0

    @property
    def inertia_z(self) -> float:
        """Second moment of area int y^2 dA [m4]."""
        beside = self.width - self.web
        return (self.width * self.height**3 - beside * self._clear**3) / 12.0

    @property
    def torsion_constant(self) -> float:
        """Torsion constant J without restraint of warping [m4].

        Notes
        -----
        ``2/3 b t^3 + (h - 2 t) w^3 / 3 + 2 a D^4 - 0.42 t^4`` for thin walls: strips, what their
        joints add, and what their ends take away (El Darwish and Johnston, J. Struct. Div. ASCE 91
        (1965) 203), without fillets.
        """
        b, w, t = self.width, self.web, self.flange
        ratio = w / t
        added = -0.042 + 0.2204 * ratio - 0.0725 * ratio**2
        circle = t + 0.25 * w**2 / t
        strips = 2.0 * b * t**3 / 3.0 + self._clear * w**3 / 3.0
        return strips + 2.0 * added * circle**4 - 0.42 * t**4

    def shear_correction(self, poisson_ratio: float) -> float:
        """Shear correction factor k: the share of the web, as in engineering practice.

        Parameters
        ----------
        poisson_ratio : float
            Poisson's ratio of the material; does not change the factor.

        Returns
        -------
        float
            Area of the web over all of it; for shear along z it is on the safe side.
        """
        return self._clear * self.web / self.area
