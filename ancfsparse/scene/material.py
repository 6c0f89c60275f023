"""What a beam is made of."""

from __future__ import annotations

from dataclasses import dataclass

from ancfsparse.errors import InputError, check_finite, check_positive


@dataclass(frozen=True)
class Material:
    """A linear elastic isotropic material.

    Parameters
    ----------
    youngs_modulus : float
        Young's modulus E [Pa], positive.
    density : float
        Mass per volume [kg/m3], positive.
    poisson_ratio : float, optional
        Poisson's ratio, greater than -1 and less than 0.5.  Cables do not use it.
    """

    youngs_modulus: float
    density: float
    poisson_ratio: float = 0.3

    def __post_init__(self) -> None:
        """Check every number."""
        check_positive("Young's modulus", self.youngs_modulus, "Pa")
        check_positive("density", self.density, "kg/m3")
        nu = check_finite("Poisson's ratio", self.poisson_ratio)
        if not -1.0 < nu < 0.5:
            raise InputError(
                f"Poisson's ratio must be greater than -1 and less than 0.5, got {nu:.6g}: "
                "an incompressible material would be infinitely stiff here, try 0.49"
            )

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G = E / (2 (1 + nu)) [Pa]."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def lame_modulus(self) -> float:
        """Lame's first parameter, 2 G nu / (1 - 2 nu) [Pa]."""
        return 2.0 * self.shear_modulus * self.poisson_ratio / (1.0 - 2.0 * self.poisson_ratio)
