"""What the compiled time loops give to Python; types alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Table = NDArray[np.float64]


class Loop(Protocol):
    """A motion that a compiled loop moves on."""

    @property
    def steps(self) -> int:
        """Steps accepted so far."""

    @property
    def state(self) -> tuple[Vector, Vector, Vector, Vector]:
        """Last accepted ``(q, v, a, lam)`` as copies."""

    @property
    def memory(self) -> dict[str, Any]:
        """What the next steps depend on beside the state."""

    @property
    def energy_gain(self) -> tuple[float, float]:
        """Energy above what was given, and the largest energy exchanged, at the last look [J]."""

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on with the memory of a loop that came to the present state."""

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
        """Most energy above what was given, what it is compared with [J], and after which step."""

    def gained_energy(self) -> bool:
        """Whether the energy was ever too far above what was given."""

    def change_step(
        self, dt: float, integrator: object, change_b: Vector, change_v: Vector
    ) -> None:
        """Go on with another step."""

    def drive(self, n: int, n_equations: int, start: Vector, force: Vector) -> None:
        """Let the last coordinates and the last equations follow functions of time."""

    def may_shorten(self) -> None:
        """Let steps that would gain energy be refused."""

    def weigh(self, mass: Vector, total: float) -> None:
        """Measure motions and corrections by mass."""

    def set_threads(self, threads: int) -> None:
        """Set the number of threads for passes over vectors."""

    def prepare(self, amplitudes: Table) -> None:
        """Set the loads of the next step and put its predictor in place."""

    def residual(self) -> Vector:
        """Return the scaled residual at the present iterate."""

    def correct(self, s: Vector) -> None:
        """Add a correction to the present iterate."""

    def matrix(self) -> Vector:
        """Return the values of the scaled iteration matrix."""

    def material(self) -> Vector:
        """Return those of its definite neighbour."""


class ControlledLoop(ImplicitLoop, Protocol):
    """Newmark's family, whose steps may be controlled by their error (_march.pyx)."""

    @property
    def step_error(self) -> float:
        """Estimated error of the last step that was looked at [m]."""

    @property
    def jerk(self) -> Vector:
        """Rate of the accelerations over the last accepted steps."""

    @property
    def refused_gain(self) -> tuple[float, float]:
        """As `energy_gain`, of the last solution that was refused for it [J]."""

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
        """Go on after a jump of the loads."""


class ExplicitLoop(Loop, Protocol):
    """Steps that solve no equations but for accelerations (_explicit.pyx)."""

    @property
    def finite(self) -> bool:
        """Whether there is an acceleration at the start."""

    def refresh(self) -> None:
        """Set the acceleration of the present state again."""
