"""The Python interface of the compiled incomplete factor; types only."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.seeds.incomplete.constraint_border import Border
from ancfsparse.seeds.incomplete.sliding_modes import SlidingModes
from ancfsparse.seeds.interface.protocols import Factor

Vector = NDArray[np.float64]


class IncompleteFactor(Factor, Protocol):
    """Blocks without fill, and conjugate gradients (_ic.pyx)."""

    @property
    def sweeps(self) -> int:
        """Sweeps for compiled callers so far."""

    @property
    def products(self) -> int:
        """Products with the matrix for compiled callers so far."""

    @property
    def sizes(self) -> Vector:
        """Factor (m,) by which each equation is comparable with residuals of one."""

    def take_modes(self, modes: SlidingModes) -> None:
        """Use a coarse space too."""

    def take_border(self, border: Border) -> None:
        """Solve for multipliers too."""

    def set_threads(self, threads: int) -> None:
        """Set the number of threads, of which two find work."""

    def mend(self, values: Vector) -> bool:
        """Factor with a larger diagonal; return whether that was possible."""

    def sweep(self, r: Vector) -> Vector:
        """Return the product of one sweep with r (n,)."""

    def solve_to(self, r: Vector, share: float, most: int) -> tuple[Vector, int]:
        """Return a solution that leaves a share of r, and its number of rounds."""
