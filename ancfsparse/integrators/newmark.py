"""Newmark's method for index-3 equations (section 3.1 of the paper)."""

from __future__ import annotations

from dataclasses import dataclass

from ancfsparse.errors import InputError, check_finite


@dataclass(frozen=True)
class Newmark:
    """Newmark's formulas with ``gamma = 1/2 + alpha`` and ``beta = (gamma + 1/2)^2 / 4`` (eq. 4).

    Parameters
    ----------
    alpha : float, optional
        Numerical damping, 0 to 1.  Zero is the trapezoidal rule, second order; above zero the
        scheme damps high frequencies and is first order.
    """

    alpha: float = 0.0

    def __post_init__(self) -> None:
        """Check the damping."""
        if not 0.0 <= check_finite("alpha", self.alpha) <= 1.0:
            raise InputError(
                f"Newmark's alpha must be between 0 (no damping) and 1, got {self.alpha:g}: "
                "0.05 is a common damping"
            )

    @property
    def gamma(self) -> float:
        """Weight of the new acceleration in the velocity."""
        return 0.5 + self.alpha

    @property
    def beta(self) -> float:
        """Weight of the new acceleration in the position."""
        return 0.25 * (self.gamma + 0.5) ** 2
