"""Damped and unstable modes of a scene about a state."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.results.solutions.mode_shapes import ModeShapes, check_amplitude
from ancfsparse.system.coordinates.state import State


@dataclass(frozen=True, eq=False, repr=False)
class ComplexModes(ModeShapes):
    """Small motions ``x exp(w t)`` about a state, in ascending order of |w|.

    Parameters
    ----------
    system, about, shapes
        As in `ModeShapes`.
    eigenvalues : ndarray of complex, shape (n,)
        The w [1/s]; of each conjugate pair the one with positive imaginary part.
    rounding : ndarray, shape (n,)
        Bound on the error of each eigenvalue by rounding of the matrices [1/s].  Errors are larger
        if two eigenvalues nearly coincide, as at the onset of flutter.
    """

    eigenvalues: NDArray[np.complex128]
    rounding: Vector

    def __repr__(self) -> str:
        """Summarise the modes in one line."""
        unstable = int(np.count_nonzero(self._growing))
        return (
            f"ComplexModes: {len(self)} modes, {self._first(self.frequencies)} Hz"
            + f", unstable ({unstable} growing)" * (unstable > 0)
        )

    @property
    def frequencies(self) -> Vector:
        """Frequencies of the damped vibrations, (n,) [Hz]; 0 without oscillation."""
        return np.asarray(self.eigenvalues.imag / (2.0 * np.pi))

    @property
    def growth(self) -> Vector:
        """Growth rates, (n,) [1/s], negative for decaying motions."""
        return np.asarray(self.eigenvalues.real)

    @property
    def damping(self) -> Vector:
        """Damping ratios ``-Re w / |w|``, (n,) [-]: 1 without oscillation; NaN for w = 0."""
        size = np.abs(self.eigenvalues)
        ratio = np.full(len(size), np.nan)
        np.divide(-self.eigenvalues.real, size, out=ratio, where=size > 0.0)
        return ratio

    @property
    def stable(self) -> bool:
        """True if none of these motions grows beyond rounding errors."""
        return not self._growing.any()

    @property
    def _growing(self) -> NDArray[np.bool_]:
        return np.asarray(self.eigenvalues.real > self.rounding)

    def moving(self, mode: int, amplitude: float) -> State:
        """Return a state of the motion in one mode, with its velocities; parameters as in `state`.

        ``simulate(scene, ..., start=modes.moving(0, 1e-3))`` continues it.
        """
        unit = check_amplitude(amplitude) * self._unit(mode)
        rate = self.eigenvalues[mode]
        moved = replace(self.about, q=self.about.q + unit.real, v=(rate * unit).real)
        return replace(moved, a=(rate**2 * unit).real, b=None, memory={})

    def _name(self, mode: int) -> str:
        """Return the number, the frequency and the damping ratio."""
        frequency, ratio = self.frequencies[mode], self.damping[mode]
        return f"mode {mode % len(self)}, {frequency:.4g} Hz, damping {ratio:.3g}"
