"""Rectangles, circles, tubes, I-sections, and sections given by numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self

from ancfsparse.checks import check_finite, check_positive, set_fields
from ancfsparse.errors import InputError
from ancfsparse.scene.sections.cross_section import CrossSection, power

ZETA_5 = 1.0369277551433699  # Riemann's zeta(5) = 1 + 1/2^5 + 1/3^5 + ...


@dataclass(frozen=True)
class Rectangle(CrossSection):
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
    noun = "rectangle"
    sides = ("width", "height")

    @property
    def area(self) -> float:
        """Area [m2]."""
        return self.width * self.height

    @property
    def inertia_y(self) -> float:
        """Second moment of area int z^2 dA, for bending about y [m4]."""
        return self.height * power(self.width, 3) / 12.0

    @property
    def inertia_z(self) -> float:
        """Second moment of area int y^2 dA, for bending about z [m4]."""
        return self.width * power(self.height, 3) / 12.0

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
        return a * power(b, 3) * (1.0 / 3.0 - 64.0 * b / (math.pi**5 * a) * series)

    def rotate(self) -> Rectangle:
        """Return the section rotated by a right angle about the axis."""
        return Rectangle(width=self.height, height=self.width)

    def shear_correction(self, poisson_ratio: float) -> float:
        """Return ``10 (1 + nu) / (12 + 11 nu)`` (Cowper 1966) [-]."""
        return 10.0 * (1.0 + poisson_ratio) / (12.0 + 11.0 * poisson_ratio)


class _Round(CrossSection, is_shape=False):
    """The properties that all round sections have in common."""

    diameter: float

    @property
    def radius(self) -> float:  # type: ignore[override]
        """Outer radius [m]."""
        return 0.5 * self.diameter

    def rotate(self) -> Self:
        """Return the section itself."""
        return self

    @property
    def inertia_z(self) -> float:
        """Second moment of area int y^2 dA [m4]."""
        return self.inertia_y

    @property
    def torsion_constant(self) -> float:
        """Torsion constant J, here the polar second moment [m4]."""
        return 2.0 * self.inertia_y


@dataclass(frozen=True)
class Circle(_Round):
    """A solid circular section.

    Parameters
    ----------
    diameter : float
        Diameter [m].
    """

    diameter: float
    noun = "circle"
    sides = ("diameter",)

    @property
    def area(self) -> float:
        """Area [m2]."""
        return math.pi * power(self.diameter, 2) / 4.0

    @property
    def inertia_y(self) -> float:
        """Second moment of area int z^2 dA [m4]."""
        return math.pi * power(self.diameter, 4) / 64.0

    def shear_correction(self, poisson_ratio: float) -> float:
        """Return ``6 (1 + nu) / (7 + 6 nu)`` (Cowper 1966) [-]."""
        return 6.0 * (1.0 + poisson_ratio) / (7.0 + 6.0 * poisson_ratio)


@dataclass(frozen=True)
class Tube(_Round):
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
    noun = "tube"
    sides = ("diameter", "thickness")

    def __post_init__(self) -> None:
        """Check both lengths and store them in double precision."""
        super().__post_init__()
        if 2.0 * self.thickness > self.diameter:
            raise InputError(
                f"the wall of the tube is {self.thickness:g} m thick, more than half its diameter "
                f"of {self.diameter:g} m: give the outer diameter, and the thickness of one wall"
            )

    @property
    def _mean_square_diameter(self) -> float:
        """Mean of the squares of both diameters [m2]."""
        return 0.5 * (power(self.diameter, 2) + power(self.diameter - 2.0 * self.thickness, 2))

    @property
    def area(self) -> float:
        """Area [m2]."""
        return math.pi * self.thickness * (self.diameter - self.thickness)

    @property
    def inertia_y(self) -> float:
        """Second moment of area int z^2 dA [m4]."""
        return self.area * self._mean_square_diameter / 8.0

    def shear_correction(self, poisson_ratio: float) -> float:
        """Return the factor of Cowper (1966) [-].

        It is ``6 (1 + nu) (1 + m^2)^2 / ((7 + 6 nu) (1 + m^2)^2 + (20 + 12 nu) m^2)`` with m the
        inner diameter over the outer one.
        """
        square = (1.0 - 2.0 * self.thickness / self.diameter) ** 2
        both = (1.0 + square) ** 2
        nu = poisson_ratio
        return 6.0 * (1.0 + nu) * both / ((7.0 + 6.0 * nu) * both + (20.0 + 12.0 * nu) * square)


@dataclass(frozen=True, kw_only=True)
class IBeam(CrossSection):
    """A rolled or welded I-section with equal flanges, without fillets.

    Parameters
    ----------
    width : float
        Width of the flanges, along z [m].
    height : float
        Height along y, both flanges included [m].
    web, flange : float
        Thickness of the web and of each flange [m].
    """

    width: float
    height: float
    web: float
    flange: float
    noun = "I-section"
    sides = ("width", "height", "web", "flange")

    def __post_init__(self) -> None:
        """Check the lengths and store them in double precision."""
        super().__post_init__()
        if not (self.web < self.width and 2.0 * self.flange < self.height):
            raise InputError(
                f"the I-section has no room between its flanges: its web of {self.web:g} m must be "
                f"thinner than its width of {self.width:g} m, and two flanges of {self.flange:g} m "
                f"than its height of {self.height:g} m"
            )

    @property
    def area(self) -> float:
        """Area [m2]."""
        return 2.0 * self.width * self.flange + self._clear_height * self.web

    @property
    def _clear_height(self) -> float:
        """Height between the flanges [m]."""
        return self.height - 2.0 * self.flange

    @property
    def inertia_y(self) -> float:
        """Second moment of area int z^2 dA [m4]."""
        return (
            2.0 * self.flange * power(self.width, 3) + self._clear_height * power(self.web, 3)
        ) / 12.0

    @property
    def inertia_z(self) -> float:
        """Second moment of area int y^2 dA [m4]."""
        gap = self.width - self.web
        return (self.width * power(self.height, 3) - gap * power(self._clear_height, 3)) / 12.0

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
        circle = t + 0.25 * w * w / t
        strips = 2.0 * b * power(t, 3) / 3.0 + self._clear_height * power(w, 3) / 3.0
        return strips + 2.0 * added * power(circle, 4) - 0.42 * power(t, 4)

    def shear_correction(self, poisson_ratio: float) -> float:
        """Return the fraction of the area in the web, as in engineering practice [-].

        For shear along z it is on the safe side.
        """
        return self._clear_height * self.web / self.area


@dataclass(frozen=True)
class Section(CrossSection):
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
        """Check the numbers and store them in double precision."""
        product = check_finite("inertia_yz of the section", self.inertia_yz, "m4")
        units = {"area": "m2", "shear_factor": ""}
        for name in ("area", "inertia_y", "inertia_z", "torsion_constant", "shear_factor"):
            unit = units.get(name, "m4")
            value = check_positive(f"{name} of the section", getattr(self, name), unit)
            set_fields(self, **{name: value})
        set_fields(self, inertia_yz=product)
        if not abs(product) < math.sqrt(self.inertia_y) * math.sqrt(self.inertia_z):
            raise InputError(
                f"inertia_yz of the section, {product:.6g} m4, must be smaller than the root of "
                f"inertia_y times inertia_z, {self.inertia_y:.6g} and {self.inertia_z:.6g} m4"
            )

    def rotate(self) -> Section:
        """Return the section rotated by a right angle about the axis."""
        return replace(
            self,
            inertia_y=self.inertia_z,
            inertia_z=self.inertia_y,
            inertia_yz=-self.inertia_yz,
        )
