"""The Python interface of the compiled time loops; types only."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from ancfsparse.array_types import Vector


class Loop(Protocol):
    """Compiled time loop of a motion."""

    @property
    def steps(self) -> int:
        """Number of accepted steps."""

    @property
    def state(self) -> tuple[Vector, Vector, Vector, Vector]:
        """Last accepted ``(q, v, a, lam)`` as copies."""

    @property
    def memory(self) -> dict[str, Any]:
        """Memory for the next steps in addition to the state; valid after the last step."""

    @property
    def energy_gain(self) -> tuple[float, float]:
        """Energy increase, and the largest energy exchanged, at the last check [J]."""

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Continue with the memory of a loop that reached the present state."""

    def save_history(self, rows: Vector, /) -> None:
        """Write history variables of the system to rows of this table, as `advance` does states."""

    def advance(
        self,
        nonlinear: object,
        n_steps: int,
        amplitudes: Vector,
        save_every: int,
        steps_done: int,
        q_out: Vector,
        v_out: Vector,
        a_out: Vector,
        lam_out: Vector,
        /,
    ) -> tuple[int, int]:
        """Take steps; return their number and the outcome."""


class ImplicitLoop(Loop, Protocol):
    """Time loop with a nonlinear loop for the equations of a step (time_loop.pxi)."""

    @property
    def capsule(self) -> object:
        """Equations of a step, structure "ancf_equations"."""

    @property
    def unbalanced(self) -> tuple[Vector, Vector]:
        """Residual [N, N m] and constraints [m] of the last iterate."""

    @property
    def unsure_work(self) -> float:
        """Uncertainty of the work of loads that jump [J]."""

    @property
    def largest_gain(self) -> tuple[float, float, int]:
        """Largest energy increase, its reference energy [J], and its step."""

    def gained_energy(self) -> bool:
        """Return True if the energy increase was too large at any check."""

    def change_step(
        self, dt: float, integrator: object, change_b: Vector, change_v: Vector
    ) -> None:
        """Continue with another step size."""

    def move(self, start: object, before: Vector, lead: Vector, force: Vector) -> None:
        """Continue from another state."""

    def drive(self, n: int, n_equations: int, start: Vector, force: Vector) -> None:
        """Prescribe the last coordinates and equations as functions of time."""

    def withdraw(self) -> int:
        """Return the number of last steps that a failed run must discard."""

    def may_shorten(self) -> None:
        """Reject steps that would increase the energy."""

    def soften(self, softness: float) -> None:
        """Give constraints a compliance [m/N]."""

    def weigh(
        self, mass: Vector, total: float, measures: bool = True, extrapolates: bool = False, /
    ) -> None:
        """Measure corrections (and motions) in the mass norm; extrapolate accelerations."""

    def set_threads(self, threads: int) -> None:
        """Set the number of threads for passes over vectors."""

    def prepare(self, amplitudes: Vector) -> None:
        """Set the loads of the next step and its predictor."""

    def residual(self) -> Vector:
        """Return the scaled residual at the present iterate."""

    def correct(self, s: Vector) -> None:
        """Add a correction to the present iterate."""

    def matrix(self) -> Vector:
        """Return the values of the scaled iteration matrix."""

    def material(self) -> Vector:
        """Return the values of its definite part."""


class NewmarkLoop(ImplicitLoop, Protocol):
    """Time loop of Newmark's family, whose step size can change (_newmark_family.pyx)."""

    @property
    def jerk(self) -> Vector:
        """Rate of the accelerations over the last accepted steps."""

    @property
    def refused_gain(self) -> tuple[float, float]:
        """As `energy_gain`, for the last solution rejected by it [J]."""

    def follow_jerk(self) -> None:
        """Keep the mean rate of the accelerations, which changes of the step size need."""

    def jump(self, change_a: Vector, amplitudes: Vector) -> None:
        """Continue after a jump of the loads."""


class ExplicitLoop(Loop, Protocol):
    """Explicit time loop, which only solves for accelerations (_explicit.pyx)."""

    @property
    def finite(self) -> bool:
        """True if the acceleration at the start is finite."""

    def move(self, q: Vector, v: Vector, a: Vector, lam: Vector, memory: Mapping[str, Any]) -> None:
        """Return to a state, with its memory."""

    def refresh(self) -> None:
        """Recompute the acceleration of the present state."""

    def accelerations_of(
        self, q: Vector, v: Vector, inputs: Vector, a_out: Vector, lam_out: Vector
    ) -> None:
        """Compute accelerations and multipliers of states between steps from their forces."""
