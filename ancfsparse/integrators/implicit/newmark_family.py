"""Newmark's method, HHT and generalised-alpha for index-3 equations (section 3.1 of the paper).

All three advance with Newmark's formulas and an acceleration-like variable ``b``,

    q1 = q0 + dt v0 + dt^2 ((1/2 - beta) b0 + beta b1),   v1 = v0 + dt ((1 - gamma) b0 + gamma b1),
    (1 - alpha_m) b1 + alpha_m b0 = (1 - alpha_f) a1 + alpha_f a0,

where the true accelerations ``a`` and the multipliers satisfy the equations of motion at the end
of the step, so one evaluation of the forces serves it whatever the weights are (Arnold and Bruels
2007).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

from ancfsparse.checks import check_finite
from ancfsparse.errors import InputError
from ancfsparse.integrators.interface.integrator import Integrator


class Implicit(Integrator):
    """Implicit integrator of the family; see the module for the meaning of the weights.

    Attributes
    ----------
    residual_kernels, matrix_kernels : mapping of str to int
        Numbers of calls of each kernel for a residual and a matrix of a step.
    """

    loop = "march"
    residual_kernels: ClassVar[Mapping[str, int]] = MappingProxyType({"residual": 1})
    matrix_kernels: ClassVar[Mapping[str, int]] = MappingProxyType({"tangent": 1})

    alpha_m: float
    alpha_f: float

    def without_damping(self) -> Implicit:
        """Return the scheme without numerical damping; itself if it has none, or is of order 1."""
        return self

    @property
    def shift(self) -> float:
        """Time by which ``b`` precedes the true acceleration, in steps: b ~ a(t + shift dt)."""
        return self.alpha_m - self.alpha_f

    @property
    def gamma(self) -> float:
        """Weight of the new ``b`` in the velocity."""
        return 0.5 - self.shift

    @property
    def beta(self) -> float:
        """Weight of the new ``b`` in the position."""
        return 0.25 * (self.gamma + 0.5) ** 2

    @property
    def mass_ratio(self) -> float:
        """Factor of the mass matrix in the iteration matrix, in addition to 1 / (beta dt^2)."""
        return (1.0 - self.alpha_m) / (1.0 - self.alpha_f)

    @property
    def scale(self) -> float:
        """Change of a coordinate per unit of true acceleration, over dt^2."""
        return self.beta / self.mass_ratio

    @property
    def damping_scale(self) -> float:
        """Change of a velocity per unit of true acceleration, over dt."""
        return self.gamma / self.mass_ratio

    @property
    def velocity_constant(self) -> float:
        """Constant c of the velocity ``q' + c dt^2 q'''`` of a smooth motion in this scheme.

        If a constraint prescribes the position, Newmark's formulas hold to third order only for
        this velocity: c = 1/6 - beta + (gamma - 1/2) / 2, which is -(1/12 + shift^2 / 4).
        """
        return 1.0 / 6.0 - self.beta + 0.5 * (self.gamma - 0.5)

    @property
    def jump_share(self) -> float:
        """Uncertainty of the energy after a jump of a load, over the jump times the displacement.

        In a slow vibration the energy differs from the work of the trapezoidal rule by the
        displacement in a step times ``(1/2 - alpha_f) (a - b)``, where ``a - b`` is initially
        ``(alpha_f - alpha_m) / (1 - alpha_m)`` of the jump.  For larger dt omega it is up to four
        times as large.  With Newmark's alpha it is alpha of the jump in that step alone: stiffness
        only takes energy.
        """
        lag = (self.alpha_f - self.alpha_m) / (1.0 - self.alpha_m)
        return 4.0 * abs((0.5 - self.alpha_f) * lag) + abs(self._first_order)

    @property
    def first_jump(self) -> float:
        """Part of the change of a load in the first step that counts as a jump.

        The start knows the rate of the load, so in a slow vibration ``a - b`` is zero.  The energy
        then differs by the change of the load times ``shift^2 / 4`` times the step times the change
        of velocity; from rest the latter two are twice the displacement.  Newmark's alpha makes
        the same of a rate as of a jump.
        """
        if self.jump_share == 0.0:
            return 1.0
        return (0.5 * self.shift**2 + abs(self._first_order)) / self.jump_share

    @property
    def _first_order(self) -> float:
        """Weight of the change of ``b`` in the energy: zero for schemes of second order."""
        return self.gamma - 0.5 + self.shift


@dataclass(frozen=True)
class Newmark(Implicit):
    """Newmark's formulas with ``gamma = 1/2 + alpha`` and ``beta = (gamma + 1/2)^2 / 4`` (eq. 4).

    Parameters
    ----------
    alpha : float, optional
        Numerical damping, 0 to 1.  Zero is the trapezoidal rule, second order; above zero the
        scheme damps high frequencies and is first order: `HHT` damps and stays second order.
    """

    alpha: float = 0.0

    alpha_m = 0.0
    alpha_f = 0.0

    def __post_init__(self) -> None:
        """Check the damping."""
        object.__setattr__(self, "alpha", check_finite("alpha", self.alpha))
        if not 0.0 <= self.alpha <= 1.0:
            raise InputError(
                f"Newmark's alpha must be between 0 (no damping) and 1, got {self.alpha:g}: "
                "0.05 is a common damping"
            )

    @property
    def order(self) -> int:
        """Power of the step in the error."""
        return 2 if self.alpha == 0.0 else 1

    @property
    def gamma(self) -> float:
        """Weight of the new acceleration in the velocity."""
        return 0.5 + self.alpha


@dataclass(frozen=True)
class HHT(Implicit):
    """The method of Hilber, Hughes and Taylor (1977): second order with numerical damping.

    Parameters
    ----------
    alpha : float, optional
        Weight of the old forces in the equations of motion, 0 (trapezoidal rule) to 1/3 (most
        damping).
    """

    alpha: float = 0.05

    alpha_m = 0.0

    def __post_init__(self) -> None:
        """Check the damping."""
        object.__setattr__(self, "alpha", check_finite("alpha", self.alpha))
        if not 0.0 <= self.alpha <= 1.0 / 3.0:
            raise InputError(
                f"HHT's alpha must be between 0 (no damping) and 1/3, got {self.alpha:g}: "
                "0.05 is a common damping"
            )

    @property
    def alpha_f(self) -> float:  # type: ignore[override]
        """Weight of the old forces."""
        return self.alpha

    def without_damping(self) -> HHT:
        """Return the scheme without numerical damping."""
        return HHT(0.0)


@dataclass(frozen=True)
class GeneralizedAlpha(Implicit):
    """The method of Chung and Hulbert (1993): second order, with damping of high frequencies.

    Parameters
    ----------
    rho_inf : float, optional
        Spectral radius at infinite frequency, 0 to 1: 1 preserves high frequencies, 0 removes them
        in one step, with the least damping of low frequencies.
    """

    rho_inf: float = 0.9

    def __post_init__(self) -> None:
        """Check the radius."""
        object.__setattr__(self, "rho_inf", check_finite("rho_inf", self.rho_inf))
        if not 0.0 <= self.rho_inf <= 1.0:
            raise InputError(
                f"rho_inf must be between 0 (most damping) and 1 (none), got {self.rho_inf:g}: "
                "0.8 to 0.9 is common"
            )

    def without_damping(self) -> GeneralizedAlpha:
        """Return the scheme without numerical damping."""
        return GeneralizedAlpha(1.0)

    @property
    def alpha_m(self) -> float:  # type: ignore[override]
        """Weight of the old ``b``."""
        return (2.0 * self.rho_inf - 1.0) / (self.rho_inf + 1.0)

    @property
    def alpha_f(self) -> float:  # type: ignore[override]
        """Weight of the old true acceleration."""
        return self.rho_inf / (self.rho_inf + 1.0)
