"""The Python interface of the compiled nonlinear loop and its inverses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector


@dataclass(frozen=True)
class Tolerance:
    """Convergence criterion of a step.

    Attributes
    ----------
    by_correction : bool
        Whether the norm of the correction is measured (default), or the largest entry of the
        residual, as in the paper.
    force, constraint : float
        Bounds on the entries of the scaled residual: beta dt^2 times newtons, and metres.
    correction : float
        Bound on the norm of the remaining error after a correction [m].
    noise : float
        Corrections shorter than this are rounding errors [m].
    share, work : float
        Bounds on the remaining error, relative to the first correction of the step, and to the
        displacement in the step [-].
    floor : float
        Rounding error of the residual [m], a lower limit of all bounds.
    sure : bool
        Whether the remaining error is always computed, not predicted from the contraction.
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
    """An approximate inverse that is updated by secant pairs."""

    @property
    def capsule(self) -> object:
        """Structure "ancf_inverse" for the loop."""


class OwnInverse(Inverse, Protocol):
    """An inverse that is not the rotation of another one."""

    def set_guard(self, weight: Vector, smallest_y: float, largest_ratio: float) -> None:
        """Set the criteria for rejecting pairs."""

    def set_threads(self, threads: int) -> None:
        """Set the number of threads."""


class DenseInverse(OwnInverse, Protocol):
    """A dense inverse."""

    matrix: NDArray[np.float64]


class NonlinearLoop(Protocol):
    """Solves the equations of step after step (_iteration.pyx)."""

    step: int
    yields: bool
    halves: bool
    newton: bool
    rate: float
    measured: float
    memory: Vector

    @property
    def capsule(self) -> object:
        """Structure "ancf_nonlinear" for the time loop."""

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of iterations, residuals, factorizations and recoveries."""

    @property
    def seconds(self) -> dict[str, float]:
        """Time of each part [s]; empty if not measured."""

    @property
    def events(self) -> list[tuple[int, int, int, float]]:
        """Recovered steps: number, attempt, previous outcome, contraction."""

    @property
    def contraction(self) -> float:
        """Ratio of residuals after and before the last correction."""

    @property
    def max_iterations(self) -> int:
        """Maximum number of corrections in a step."""

    def take_events(self) -> list[tuple[int, int, int, float]]:
        """Return the events and clear the list."""

    def set_costs(self, cost_iteration: float, cost_seed: float) -> None:
        """Set new costs of an iteration and of a new seed."""

    def take_seed(
        self, seed: object, inverse: Inverse, rounds: bool, cost_iteration: float, cost_seed: float
    ) -> None:
        """Continue with another seed."""

    def set_threads(self, threads: int) -> None:
        """Set the number of threads."""

    def set_tolerance(self, tolerance: Tolerance) -> None:
        """Set the bounds of the next steps."""

    def mark_seeded(self) -> None:
        """Mark the inverse as that of the present iterate."""

    def mark_stale(self) -> None:
        """Renew the seed in the next step."""

    def solve(self) -> int:
        """Solve the equations of one step; return the outcome."""
