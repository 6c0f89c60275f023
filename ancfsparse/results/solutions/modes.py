"""Natural frequencies and mode shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.results.solutions.mode_shapes import ModeShapes


@dataclass(frozen=True, eq=False, repr=False)
class Modes(ModeShapes):
    """Small vibrations of a scene about a state, in ascending order of their eigenvalues.

    Parameters
    ----------
    system, about, shapes
        As in `ModeShapes`.
    eigenvalues : ndarray, shape (n,)
        Squares of the angular frequencies [1/s2]: negative for unstable modes, and 0
        within rounding errors for free rigid-body motions.
    damping_rates : ndarray, shape (n,)
        ``x.C x`` with the damping matrix C [1/s].
    rounding : ndarray, shape (n,)
        Bound on the rounding error of each eigenvalue [1/s2].
    effective_masses : ndarray, shape (n, dim)
        Effective mass of each mode along each axis [kg]; the sum over all modes is at most the
        mass of the scene.
    """

    eigenvalues: Vector
    damping_rates: Vector
    rounding: Vector
    effective_masses: Vector

    def __repr__(self) -> str:
        """Summarise the modes in one line."""
        unstable = int(np.count_nonzero(self.eigenvalues < 0.0))
        return (
            f"Modes: {len(self)} modes, {self._first(self.frequencies)} Hz"
            + f", unstable ({unstable} growing)" * (unstable > 0)
        )

    @property
    def frequencies(self) -> Vector:
        """Natural frequencies without damping, (n,) [Hz]; 0 for rigid and for growing motions."""
        return np.asarray(np.sqrt(np.maximum(self.eigenvalues, 0.0)) / (2.0 * np.pi))

    @property
    def growth(self) -> Vector:
        """Growth rates of motions from an unstable state, (n,) [1/s], without damping."""
        return np.asarray(np.sqrt(np.maximum(-self.eigenvalues, 0.0)))

    @property
    def stable(self) -> bool:
        """True if no small motion grows."""
        return not (self.eigenvalues < 0.0).any()

    @property
    def damping(self) -> Vector:
        """Damping ratios, (n,) [-], to first order in the damping; NaN without a frequency.

        Exact if the damping matrix is a combination of mass and stiffness matrix, such as Rayleigh
        damping about the stress-free shape.
        """
        omega = 2.0 * np.pi * self.frequencies
        ratio = np.full(len(omega), np.nan)
        np.divide(self.damping_rates, 2.0 * omega, out=ratio, where=omega > 0.0)
        return ratio

    def _name(self, mode: int) -> str:
        return f"mode {mode % len(self)}, {self.frequencies[mode]:.4g} Hz"
