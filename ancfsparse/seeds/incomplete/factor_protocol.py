"""The Python interface of the compiled incomplete factor; types only."""

from __future__ import annotations

from typing import Protocol

from ancfsparse.array_types import Vector
from ancfsparse.seeds.incomplete.constraint_border import Border
from ancfsparse.seeds.incomplete.sliding_modes import SlidingModes
from ancfsparse.seeds.interface.protocols import Factor


class IncompleteFactor(Factor, Protocol):
    """Incomplete block factorization with conjugate gradients (_ic.pyx).

    Attributes
    ----------
    use : int
        Whether the modes of a deflation space are used, from one factor to the next.
    """

    use: int

    @property
    def sweeps(self) -> int:
        """Number of sweeps for compiled callers."""

    @property
    def products(self) -> int:
        """Number of products with the matrix for compiled callers."""

    @property
    def sizes(self) -> Vector:
        """Scaling factors (m,) that make equations comparable with unit residuals."""

    def take_modes(self, modes: SlidingModes) -> None:
        """Use a deflation space as well."""

    def take_border(self, border: Border) -> None:
        """Solve for multipliers as well."""

    def set_threads(self, threads: int) -> None:
        """Set the number of threads, at most two of which are used."""

    def mend(self, values: Vector) -> bool:
        """Factor with a larger diagonal; return True if that was possible."""

    def sweep(self, r: Vector) -> Vector:
        """Return the product of one sweep with r (n,)."""

    def solve_to(self, r: Vector, ratio: float, max_iterations: int) -> tuple[Vector, int]:
        """Return a solution with the ratio of its residual to r, and its number of iterations."""
