"""The Python interface of the compiled time loops; types only."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Table = NDArray[np.float64]


class Loop(Protocol):
    """A motion that a compiled loop advances."""

    @property
    def steps(self) -> int:
        """Steps accepted so far."""

    @property
    def state(self) -> tuple[Vector, Vector, Vector, Vector]:
        """Last accepted ``(q, v, a, lam)`` as copies."""

    @property
    def memory(self) -> dict[str, Any]:
        """What the next steps depend on in addition to the state; valid after the last step."""

    @property
    def energy_gain(self) -> tuple[float, float]:
        """Energy gain, and the largest energy exchanged, at the last check [J]."""

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Continue with the memory of a loop that reached the present state."""

    def advance(
        self,
        nonlinear: object,
        n_steps: int,
        amplitudes: Table,
        save_every: int,
        steps_done: int,
        q_out: Table,
        v_out: Table,
        a_out: Table,
        lam_out: Table,
        /,
    ) -> tuple[int, int]:
        """Take steps; return how many were taken, and the outcome."""


class ImplicitLoop(Loop, Protocol):
    """Steps whose equations a nonlinear loop solves (loop.pxi)."""

    @property
    def capsule(self) -> object:
        """The equations of a step, "ancf_equations"."""

    @property
    def unbalanced(self) -> tuple[Vector, Vector]:
        """Residual [N, N m] and constraints [m] of the last iterate."""

    @property
    def unsure_work(self) -> float:
        """Work that jumps of loads may have done, beyond what was counted [J]."""

    @property
    def largest_gain(self) -> tuple[float, float, int]:
        """Largest energy gain, what it is compared with [J], and after which step."""

    def gained_energy(self) -> bool:
        """Whether the energy gain was ever too large."""

    def change_step(
        self, dt: float, integrator: object, change_b: Vector, change_v: Vector
    ) -> None:
        """Continue with another step size."""

    def drive(self, n: int, n_equations: int, start: Vector, force: Vector) -> None:
        """Let the last coordinates and the last equations follow functions of time."""

    def withdraw(self) -> int:
        """Return how many of the last steps a failed run must not keep."""

    def may_shorten(self) -> None:
        """Reject steps that would gain energy."""

    def soften(self, softness: float) -> None:
        """Let multipliers violate their equations by a share of themselves."""

    def weigh(
        self, mass: Vector, total: float, measures: bool = True, extrapolates: bool = False, /
    ) -> None:
        """Measure motions, where asked, and corrections by mass; extrapolate accelerations."""

    def set_threads(self, threads: int) -> None:
        """Set the number of threads for passes over vectors."""

    def prepare(self, amplitudes: Table) -> None:
        """Set the loads of the next step and its predictor."""

    def residual(self) -> Vector:
        """Return the scaled residual at the present iterate."""

    def correct(self, s: Vector) -> None:
        """Add a correction to the present iterate."""

    def matrix(self) -> Vector:
        """Return the values of the scaled iteration matrix."""

    def material(self) -> Vector:
        """Return those of its definite part."""


class ControlledLoop(ImplicitLoop, Protocol):
    """Newmark's family, whose steps may be controlled by their error (_march.pyx)."""

    @property
    def step_error(self) -> float:
        """Estimated error of the last step that was checked [m]."""

    @property
    def jerk(self) -> Vector:
        """Rate of the accelerations over the last accepted steps."""

    @property
    def refused_gain(self) -> tuple[float, float]:
        """As `energy_gain`, of the last solution that was rejected for it [J]."""

    def control(
        self,
        seed: object,
        weight: Vector,
        constant: float,
        limit: float,
        easy: float,
        patience: int,
    ) -> None:
        """Estimate the error of every step; stop before one above a limit, or after easy ones."""

    def jump(self, change_a: Vector, amplitudes: Vector) -> None:
        """Continue after a jump of the loads."""


class ExplicitLoop(Loop, Protocol):
    """Steps that solve no equations but for accelerations (_explicit.pyx)."""

    @property
    def finite(self) -> bool:
        """Whether there is an acceleration at the start."""

    def refresh(self) -> None:
        """Set the acceleration of the present state again."""

    def accelerations_of(
        self, q: Vector, v: Vector, inputs: Vector, a_out: Vector, lam_out: Vector
    ) -> None:
        """Set accelerations and multipliers of states between steps, by the forces there."""
