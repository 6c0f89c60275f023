"""The Python interface of the compiled contact between beams; types only."""

from __future__ import annotations

from typing import Protocol

from ancfsparse.array_types import Integers, Vector
from ancfsparse.system.contributions.interface import Compiled


class CompiledBeamContact(Compiled, Protocol):
    """A contact of beams as a contribution (_beam_contacts.pyx)."""

    renewals: int
    is_sticking: bool
    coupled_pairs: Integers
    deepest: tuple[float, tuple[int, int], tuple[float, float]]

    def forget_deepest(self) -> None:
        """Discard the penetrations of earlier states."""

    def divide(self, threads: int, /) -> None:
        """Distribute the pairs among threads."""

    def begin_equilibria(self, q: Vector, /) -> None:
        """Let bristles be deflected by displacements from coordinates on."""

    def accept_equilibrium(self, q: Vector, /) -> None:
        """Update the deflections of bristles to an equilibrium."""

    def end_equilibria(self) -> None:
        """Let bristles keep their deflections."""

    def bristles(self, q: Vector, /) -> tuple[Integers, Vector, Vector, Vector]:
        """Return elements, nodal weights and two derivatives of bristles outside of steps."""

    def energy(self, q: Vector, /) -> float:
        """Return the potential of the pressures [J]."""

    def touches(
        self, q: Vector, v: Vector | None = None, /
    ) -> tuple[Integers, Vector, Vector, Vector]:
        """Return elements, positions in them, forces and penetrations of points in contact.

        Forces have the damping of a restitution if velocities are given.
        """

    def friction(self, q: Vector, v: Vector, history: Vector, /) -> Vector:
        """Return friction on these points, (k, dim) [N]; bristles need their history variables."""

    def pairs(self, q: Vector, /) -> Integers:
        """Return the pairs of elements that may touch, (k, 2)."""

    def admits(self, q0: Vector, q1: Vector, /) -> bool:
        """Return whether no axes pass through each other between two states."""
