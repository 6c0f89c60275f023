"""The Python interface of the compiled nonlinear loop and its inverses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Tolerance:
    """When a step counts as converged.

    Attributes
    ----------
    by_correction : bool
        Measure the residual by its length (default), or the largest entry of the residual (the
        paper's way).
    force, constraint : float
        Bounds on the entries of the scaled residual: beta dt^2 times newtons, and metres.
    correction : float
        Bound on the length of what is left after a correction [m].
    noise : float
        Corrections shorter than this are rounding [m].
    share, work : float
        Bounds on what is left over the first correction of the step, and over the way that the step
        moves the scene [-].
    floor : float
        Rounding of the residual [m]: no bound is below it.
    sure : bool
        Whether what is left is always looked at, and not foreseen by the contraction.
    """

    by_correction: bool
    force: float
    constraint: float
    correction: float
    noise: float
    share: float = math.inf
    work: float = math.inf
    floor: float = 0.0
    sure: bool = False


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
