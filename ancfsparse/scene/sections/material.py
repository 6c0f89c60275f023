"""Linear elastic materials with damping."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

from ancfsparse.checks import check_finite, check_positive, set_fields
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value


@dataclass(frozen=True)
class Material:
    """A linear elastic isotropic material, with optional internal damping.

    Parameters
    ----------
    youngs_modulus : float
        Young's modulus E [Pa], positive.
    density : float
        Mass per volume [kg/m3], positive.
    poisson_ratio : float, optional
        Poisson's ratio, greater than -1 and less than 0.5.  Cables do not use it.
    axial_damping : float, optional
        Retardation time of stretching [s], also of the section of a beam, in the Kelvin-Voigt law
        sigma = E (eps + tau eps').  A vibration of angular frequency omega has the damping ratio
        tau omega / 2.
    bending_damping : float, optional
        Retardation time of bending and, in a thick beam, of shear and torsion [s].
    rayleigh : (float, float), optional
        Rayleigh's alpha [1/s] and beta [s]: a force -alpha M v proportional to the velocity in
        space, and beta as a retardation time of every strain.  The damping ratio is
        alpha / (2 omega) + beta omega / 2.

    Notes
    -----
    The force beta K v would also damp rigid rotation, because K contains the stresses; acting on
    the strains it is the same for small vibrations about the stress-free shape and does not damp
    rotation.  The retardation times add up.
    """

    youngs_modulus: float
    density: float
    poisson_ratio: float = 0.3
    _: KW_ONLY
    axial_damping: float = 0.0
    bending_damping: float = 0.0
    rayleigh: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        """Check the numbers and store them in double precision."""
        nu = check_finite("poisson_ratio", self.poisson_ratio)
        if not -1.0 < nu < 0.5:
            raise InputError(
                f"poisson_ratio must be greater than -1 and less than 0.5, got {nu:.6g}: "
                + (
                    "an incompressible material would be infinitely stiff here, try 0.49"
                    if nu >= 0.5
                    else "below, a material would give way without end in shear; metals have 0.3"
                )
            )
        if not isinstance(self.rayleigh, tuple) or len(self.rayleigh) != 2:
            raise InputError(
                f"rayleigh must be a pair (alpha in 1/s, beta in s), got "
                f"{format_value(self.rayleigh)}: try rayleigh=(0.0, 1e-3)"
            )
        alpha, beta = self.rayleigh
        set_fields(
            self,
            youngs_modulus=check_positive("youngs_modulus", self.youngs_modulus, "Pa"),
            density=check_positive("density", self.density, "kg/m3"),
            poisson_ratio=nu,
            axial_damping=_check_damping("axial_damping", self.axial_damping, "s"),
            bending_damping=_check_damping("bending_damping", self.bending_damping, "s"),
            rayleigh=(
                _check_damping("alpha of rayleigh", alpha, "1/s"),
                _check_damping("beta of rayleigh", beta, "s"),
            ),
        )

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G = E / (2 (1 + nu)) [Pa]."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def lame_modulus(self) -> float:
        """Lame's first parameter, 2 G nu / (1 - 2 nu) [Pa]."""
        return 2.0 * self.shear_modulus * self.poisson_ratio / (1.0 - 2.0 * self.poisson_ratio)

    @property
    def axial_retardation(self) -> float:
        """Retardation time of stretching [s], including Rayleigh's beta."""
        return self.axial_damping + self.rayleigh[1]

    @property
    def bending_retardation(self) -> float:
        """Retardation time of bending, shear and torsion [s], including Rayleigh's beta."""
        return self.bending_damping + self.rayleigh[1]


def _check_damping(what: str, value: object, unit: str) -> float:
    """Return a damping, refused if it would supply energy instead of dissipating it."""
    number = check_finite(what, value, unit)
    if number < 0.0:
        raise InputError(
            f"{what} must not be negative, got {number:.6g} {unit}: it would feed energy into the "
            "motion; leave it out for none"
        )
    return number
