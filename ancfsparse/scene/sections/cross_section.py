"""The base classes of sections, the table of their subclasses, and principal axes.

A section lies in its own y-z plane; the axis of the beam is x.  In a planar scene y is in the plane
and z points out of it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_positive, set_fields
from ancfsparse.errors import InputError

MIN_SIDE = 1e-75  # [m], whose fourth power, and that of its inverse, are floating-point numbers
MAX_PRODUCT_MOMENT = 1e-9  # over the polar moment, attributed to rounding

# Classes of sections, by their names in files and messages.
SECTION_TYPES: dict[str, type[AnySection]] = {}


def power(x: float, n: int) -> float:
    """Return x^n by products, which round alike in all units that differ by powers of two.

    The function `pow` of the C library does not.
    """
    return math.prod([x] * n)


class AnySection:
    """The section of a beam; properties of one shape alone belong to its class.

    Attributes
    ----------
    is_uniform : bool
        Whether it is the same all along a beam.
    can_taper : bool
        Whether two of its kind may be the ends of a `Taper`.
    radius : float or None
        Radius of a round section [m].
    """

    is_uniform: ClassVar[bool] = True
    can_taper: ClassVar[bool] = False
    radius: float | None = None

    def __init_subclass__(cls, is_shape: bool = True) -> None:
        """Enter a shape in the table of sections."""
        if is_shape:
            SECTION_TYPES[cls.__name__] = cls

    if TYPE_CHECKING:

        @property
        def area(self) -> float:
            """Area, or its mean along the beam [m2]."""

        @property
        def inertia_y(self) -> float:
            """Second moment of area int z^2 dA about the centroid, for bending about y [m4]."""

        @property
        def inertia_z(self) -> float:
            """Second moment of area int y^2 dA about the centroid, for bending about z [m4]."""

        @property
        def torsion_constant(self) -> float:
            """Saint-Venant's torsion constant J [m4]."""

        def shear_correction(self, poisson_ratio: float) -> float:
            """Return the shear correction factor k of a uniform section [-]."""

    @property
    def parts(self) -> tuple[CrossSection, ...]:
        """The uniform sections that define it."""
        raise NotImplementedError

    @property
    def frame_angle(self) -> float:
        """Angle from y, towards z, to the axis e_y of the beam, a principal axis [rad]."""
        return 0.0

    def average_over(self, fractions: Vector) -> Any:
        """Return the section, or its means over elements with ends at fractions of the length."""
        return self

    def rotate(self) -> Any:
        """Return the section rotated by a right angle about the axis.

        Raises
        ------
        InputError
            If it has no such form.
        """
        raise InputError(f"a {type(self).__name__} cannot be rotated: give it with other sides")


class CrossSection(AnySection, is_shape=False):
    """A cross-section that does not change along a beam.

    Attributes
    ----------
    noun : str
        Its name in messages.
    sides : tuple of str
        Fields that are lengths [m], checked when it is made.
    """

    noun: ClassVar[str] = "section"
    sides: ClassVar[tuple[str, ...]] = ()
    can_taper = True
    shear_factor: float

    @property
    def parts(self) -> tuple[CrossSection, ...]:
        """The section itself."""
        return (self,)

    @property
    def frame_angle(self) -> float:
        """Angle from y, towards z, to the nearest principal axis [rad]."""
        return principal_axes(self)[0]

    def __post_init__(self) -> None:
        """Check the sides and store them in double precision."""
        for name in self.sides:
            side = check_side(f"{name} of the {self.noun}", getattr(self, name))
            set_fields(self, **{name: side})

    def shear_correction(self, poisson_ratio: float) -> float:
        """Return the shear correction factor k, the same for y and z [-].

        Parameters
        ----------
        poisson_ratio : float
            Poisson's ratio nu of the material; does not change a factor that was given.
        """
        return self.shear_factor


def check_side(what: str, value: object) -> float:
    """Return a length [m] whose fourth power is in the range of floating-point numbers.

    Raises
    ------
    InputError
        If it is not such a number.
    """
    side = check_positive(what, value, "m")
    if not MIN_SIDE <= side <= 1.0 / MIN_SIDE:
        raise InputError(
            f"{what} must lie between {MIN_SIDE:g} and {1.0 / MIN_SIDE:g} m, whose fourth powers "
            f"are in the range of floating-point numbers, got {side:g} m"
        )
    return side


def list_section_types(*, can_taper: bool = False) -> str:
    """Return the names of all sections for a message, or of those that may taper."""
    *names, last = [
        name for name, kind in sorted(SECTION_TYPES.items()) if kind.can_taper or not can_taper
    ]
    return f"{', '.join(names)} or {last}"


def principal_axes(section: Any) -> tuple[float, float, float]:
    """Return the angle from y, towards z, to the nearest principal axis, and both moments.

    Parameters
    ----------
    section : CrossSection or ElementSections
        The section.

    Returns
    -------
    angle : float
        From -pi/4 to pi/4 [rad].
    inertia_y, inertia_z : float
        For bending about the principal axes nearest to y and to z [m4].
    """
    inertia_y, inertia_z = section.inertia_y, section.inertia_z
    product = getattr(section, "inertia_yz", 0.0)
    if not product or abs(product) <= MAX_PRODUCT_MOMENT * (inertia_y + inertia_z):
        return 0.0, inertia_y, inertia_z
    mean, difference = 0.5 * (inertia_y + inertia_z), inertia_z - inertia_y
    sign = math.copysign(1.0, difference)
    half = sign * math.hypot(0.5 * difference, product)
    angle = 0.5 * math.atan2(sign * product, 0.5 * abs(difference))
    return angle, mean - half, mean + half
