"""The interface of the compiled assembly in Python."""

from __future__ import annotations

from typing import Protocol

from ancfsparse.array_types import Vector


class CompiledAssembly(Protocol):
    """The equations of motion as a sum of contributions (_assembly.pyx).

    Vectors have shape (n_all,), multipliers (m,), amplitudes (n_amplitudes,); units are those of
    the coordinates they belong to.
    """

    memory: Vector

    @property
    def contributions(self) -> tuple[object, ...]:
        """The compiled contributions."""

    @property
    def capsule(self) -> object:
        """Pointer "ancf_system" for time loops."""

    @property
    def threads(self) -> int:
        """Number of threads."""

    @property
    def damped(self) -> bool:
        """True if forces depend on velocities."""

    @property
    def mass(self) -> Vector:
        """Values of the mass matrix on the pattern."""

    def set_regularization(self, value: float) -> None:
        """Set the negative diagonal of the constraint block."""

    def use_couplings(self, used: bool) -> None:
        """Set whether matrices of compiled callers contain the blocks of touching elements."""

    def set_threads(self, threads: int) -> None:
        """Set the number of threads."""

    def check(self) -> None:
        """Raise the error of a user force, if any."""

    def forget(self) -> None:
        """Reset the errors of user forces."""

    def residual(
        self, q: Vector, v: Vector, a: Vector, lam: Vector, dead_load: Vector, amplitudes: Vector
    ) -> tuple[Vector, Vector]:
        """Return residual and constraints."""

    def residual_between(
        self,
        q0: Vector,
        q1: Vector,
        v: Vector,
        a: Vector,
        lam: Vector,
        dead_load: Vector,
        amplitudes: Vector,
    ) -> tuple[Vector, Vector]:
        """Return the residual with discrete gradients, and constraints."""

    def matrix(
        self,
        mass_factor: float,
        stiffness_factor: float,
        q: Vector,
        lam: Vector,
        amplitudes: Vector,
        *,
        damping_factor: float = 0.0,
        v: Vector | None = None,
        out: Vector | None = None,
    ) -> Vector:
        """Return values on the pattern of the matrix of a step."""

    def material(
        self,
        mass_factor: float,
        stiffness_factor: float,
        q: Vector,
        *,
        damping_factor: float = 0.0,
        out: Vector | None = None,
    ) -> Vector:
        """Return values of its definite part, without geometric stiffness."""

    @property
    def tunes(self) -> bool:
        """True if energies depend on amplitudes."""

    def load_work(
        self,
        q0: Vector,
        amplitudes0: Vector,
        q1: Vector,
        amplitudes1: Vector,
        *,
        v0: Vector | None = None,
        v1: Vector | None = None,
    ) -> float:
        """Return the work of time-dependent loads between two states [J]."""

    @property
    def n_history(self) -> int:
        """Number of history variables that are saved with each state."""

    @property
    def history(self) -> Vector:
        """History variables that are saved with each state, a copy."""

    def set_step(self, dt: float, /) -> None:
        """Set the time since the last accepted state [s], 0 outside of a step."""

    def begin(self, q: Vector) -> None:
        """Set the internal variables for a state at rest, without history."""

    def accept(self, q: Vector) -> None:
        """Update the internal variables to accepted coordinates."""

    def load_reach(self, q0: Vector, q1: Vector, amplitudes: Vector) -> float:
        """Return an upper bound of the work of the loads between two states [J]."""

    def force(self, q: Vector) -> Vector:
        """Return the elastic forces."""

    def inertia(self, a: Vector) -> Vector:
        """Return mass times acceleration."""

    def damping(self, q: Vector, v: Vector) -> Vector:
        """Return the forces of damping."""

    def strain_energy(self, q: Vector, amplitudes: Vector | None = None) -> float:
        """Return the strain energy [J], by default with the last amplitudes."""
