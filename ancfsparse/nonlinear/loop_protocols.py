"""The Python interface of the compiled nonlinear loop and its inverses; types only."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ancfsparse.nonlinear.iteration import Tolerance

Vector = NDArray[np.float64]


class Inverse(Protocol):
    """An approximate inverse that learns from corrections."""

    @property
    def capsule(self) -> object:
        """What the loop calls, "ancf_inverse"."""


class OwnInverse(Inverse, Protocol):
    """One that is complete, and not a rotation of another with the body."""

    def set_guard(self, weight: Vector, smallest_y: float, largest_ratio: float) -> None:
        """Set which pairs are refused."""

    def set_threads(self, threads: int) -> None:
        """Set the number of threads."""


class DenseInverse(OwnInverse, Protocol):
    """One that is a matrix."""

    matrix: NDArray[np.float64]


class NonlinearLoop(Protocol):
    """Solves the equations of step after step (_iteration.pyx)."""

    step: int
    yields: bool
    halves: bool
    rate: float
    measured: float

    @property
    def capsule(self) -> object:
        """What the time loop calls, "ancf_nonlinear"."""

    @property
    def counts(self) -> dict[str, int]:
        """Iterations, residuals, factors and recoveries so far."""

    @property
    def seconds(self) -> dict[str, float]:
        """Time of each part [s]; empty where it is not taken."""

    @property
    def events(self) -> list[tuple[int, int, int, float]]:
        """Steps that were recovered: number, rung, outcome before, contraction."""

    @property
    def contraction(self) -> float:
        """Factor by which the last correction changed the residual."""

    @property
    def max_iterations(self) -> int:
        """Corrections allowed in a step."""

    def take_events(self) -> list[tuple[int, int, int, float]]:
        """Return the events so far, and forget them."""

    def take_seed(
        self, seed: object, inverse: Inverse, rounds: bool, cost_iteration: float, cost_seed: float
    ) -> None:
        """Continue with another seed."""

    def set_threads(self, threads: int) -> None:
        """Set the number of threads."""

    def set_tolerance(self, tolerance: Tolerance) -> None:
        """Set the bounds of the next steps."""

    def mark_seeded(self) -> None:
        """Treat the inverse as that of the present iterate."""

    def mark_stale(self) -> None:
        """Renew the seed in the next step."""

    def solve(self) -> int:
        """Solve the equations of one step; return the outcome."""
