"""The interface of a contribution to the equations of motion.

The interface of its compiled part for time loops is in abi/system_abi.h.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sized
from functools import reduce
from operator import add
from typing import Any, Protocol

import numpy as np

from ancfsparse.array_types import Indices, Integers, Vector
from ancfsparse.system.assembly.sparsity_pattern import Pattern

MIN_LENGTH = 1e-6  # smallest part of a motion that is taken


class Compiled(Protocol):
    """The compiled part of a contribution."""

    @property
    def capsule(self) -> object:
        """Pointer "ancf_contribution" for the assembly."""


class Contribution(ABC):
    """A term of the equations of motion.

    Attributes
    ----------
    conservative : bool
        True if its forces at rest have a potential, so that its stiffness is symmetric.
    is_explicit_in_time : bool
        True if the time dependence of its forces is known in the reference shape.
    is_load : bool
        True for loads and springs, which are ignored in the assembly of joints.
    is_contact : bool
        True if bodies press on each other or on obstacles only where they touch.
    is_between_beams : bool
        True if it is the contact of beams with each other.
    sticks : bool
        True if it has friction that sticks, which depends on the motion before.
    depends_on_reactions : bool
        True if its forces depend on multipliers of other equations, as friction does.
    separates : bool
        True if bodies that begin inside each other are moved apart.
    """

    conservative = True
    is_explicit_in_time = True
    is_load = False
    is_contact = False
    is_between_beams = False
    sticks = False
    depends_on_reactions = False
    separates = False

    def cliques(self) -> list[Indices]:
        """Return tables of unknowns; those of a row are coupled in the matrix."""
        return []

    @abstractmethod
    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled contribution, for the pattern of the matrix."""

    def coupled_pairs(self) -> list[tuple[Any, Indices]]:
        """Return the compiled lists of touching elements, and the unknowns of each element."""
        return []

    def operations(self) -> int:
        """Return the operations of its forces in the present state, zero if negligible."""
        return 0

    @property
    def gyroscopic(self) -> Any:
        """The skew-symmetric gyroscopic matrix, sparse (n_free, n_free) [kg/s], or None."""
        return None

    def potential(self, q: Vector) -> Vector | float:
        """Return the part of its energy that is not strain energy, (k,) [J], q (k, n)."""
        return 0.0

    def contact_energy(self, q: Vector) -> Vector | float:
        """Return the potential of its contact, (k,) [J], q (k, n)."""
        return 0.0

    def forces_on_elements(
        self, q: Vector, v: Vector, history: Vector | None
    ) -> Iterable[tuple[Indices, Vector, Vector]]:
        """Return elements (p,), normal forces and friction (p, dim) [N] of its contact in a state.

        Elements are numbered among those of all its bodies, and may occur several times.
        """
        return ()

    def tension(self, rope: Any, q: Vector, v: Vector, amplitudes: Vector) -> Vector | None:
        """Return the tension of a rope in states, (k,) [N], or None if it is not one of its own."""
        return None

    def contact_losses(self, history: Vector) -> Vector | float:
        """Return energies that its contact has exchanged from the start of a run on, (k, 3) [J].

        They are the work of turning obstacles, and losses to friction and to damped impacts.

        Parameters
        ----------
        history : (k, h) float
            History variables of the system in states of the run.
        """
        return 0.0

    def deepest_point(self, q: Vector) -> tuple[float, float, str, str]:
        """Return the largest penetration of its contact and the radius there [m], and both names.

        These are the contact, as in messages, and the place.
        """
        return 0.0, 1.0, "", ""

    def forget_deepest(self) -> None:  # noqa: B027
        """Discard the penetrations of earlier states."""

    def start_warnings(self, q: Vector) -> list[Warning]:
        """Return warnings of a motion that begins at given coordinates (n_all,)."""
        return []

    def run_warnings(self, t: Vector, q: Any) -> list[Warning]:
        """Return warnings of the last motion, with its saved times (k,) [s] and states (k, n)."""
        return []

    def rest_warnings(self, q: Vector, when: Callable[[int], str]) -> list[Warning]:
        """Return warnings of equilibria (k, n_all); `when` names the time or load of the k-th."""
        return []

    def admits(self, q0: Vector, q1: Vector) -> bool:
        """Return whether no bodies pass through each other in a straight motion to a state."""
        return True

    def admits_correction(self, q0: Vector, q1: Vector) -> bool:
        """Return whether a correction of an equilibrium may move bodies straight to a state."""
        return self.admits(q0, q1)

    def begin_equilibria(self, q: Vector) -> None:  # noqa: B027
        """Let forces with a history begin at coordinates from which equilibria are sought."""

    def approach_equilibrium(self, dt: float) -> None:  # noqa: B027
        """Set the time between the last equilibrium and the next one [s]."""

    def accept_equilibrium(self, q: Vector) -> None:  # noqa: B027
        """Update the history to an equilibrium."""

    def end_equilibria(self) -> None:  # noqa: B027
        """Keep the history as it is."""

    def unsymmetric_stiffness(self, q: Vector) -> Any:
        """Return the part of its stiffness in equilibria that its matrix leaves out, or None.

        Sparse, (n_all, n_all).
        """
        return None

    def coupling_stiffness(self, q: Vector) -> Any:
        """Return the stiffness between elements that its matrix has no entries for, or None.

        Sparse and symmetric, (n_all, n_all).
        """
        return None

    def material_coupling(self, q: Vector) -> Any:
        """Return its part that is semidefinite together with the material part of its matrix."""
        return None

    def set_sticking(self, is_sticking: bool) -> None:  # noqa: B027
        """Let its matrix contain the stiffness of friction that sticks, or only in steps."""

    def power(self, q: Vector, v: Vector, amplitudes: Vector) -> Vector | float:
        """Return the power of its loads, shape (k,) [W].

        Parameters
        ----------
        q, v : (k, n_all) float
            States.
        amplitudes : (k, n_amplitudes) float
            Amplitudes in these states.
        """
        return 0.0

    def unilateral_forces(
        self, q: Vector, v: Vector, amplitudes: Vector
    ) -> list[tuple[str, Vector]]:
        """Return names with units, and values (k,), of forces that can be inactive.

        These are stops, ropes and user forces, on which a motion that does not reach them has no
        information.
        """
        return []

    def check_step(self, dt: float, phase: float) -> None:  # noqa: B027
        """Refuse a fixed step dt [s] that is too long for its law.

        The phase is the product of a step and a frequency up to which the integrator is stable.
        """

    def longest_step(self, phase: float) -> float:
        """Return the longest step that `check_step` admits [s]."""
        return math.inf

    def resolving_step(self, keeps_energy: bool = False) -> tuple[float, str]:
        """Return the longest step that resolves its impacts [s], and its name.

        With longer steps all motions have the same wrong impacts, and do not differ by them.  The
        step is infinite without impacts, and without friction and restitution if an integrator
        conserves the energy of impacts with any step (`keeps_energy`).
        """
        return math.inf, ""

    def dissipation(self, q: Vector, v: Vector, lam: Vector) -> Vector | float:
        """Return the power dissipated by forces that depend on multipliers (k, m), (k,) [W]."""
        return 0.0

    def resisted_motions(self, q: Vector) -> Any:
        """Return the motions that it resists in equilibria, as rows of a sparse (k, n_all).

        Each is the gradient of a length [1].  None if there are none, and for elements.
        """
        return None

    def omitted_coupling(self, q: Vector, amplitudes: Vector) -> str:
        """Return a sentence if its matrix leaves out how points affect each other, else none."""
        return ""

    def divide(self, n_free: int, n_all: int, threads: int) -> bool:
        """Divide its work among threads; return True if it is divided."""
        return False


def sum_of(matrices: Iterable[Any]) -> Any:
    """Return the sum of all matrices that are not None, or None."""
    present = [each for each in matrices if each is not None]
    return reduce(add, present) if present else None


def limit_length(
    terms: Iterable[Contribution], q: Vector, dq: Vector, length: float = 1.0
) -> float:
    """Return the part of a correction, halved until no bodies pass through each other, or 0."""
    for each in terms:
        while not each.admits_correction(q, q + length * dq):
            length *= 0.5
            if length < MIN_LENGTH:
                return 0.0
    return length


def offsets_of(tables: Iterable[Sized]) -> Integers:
    """Return the index of the first entry of each table in all of them joined, and the end."""
    return np.cumsum([0, *(len(each) for each in tables)], dtype=np.int32)


def matrix_unknowns(places: Integers, n_free: int) -> Integers:
    """Convert indices in q, in place, to unknowns of the matrix; fixed ones are -1."""
    places[places >= n_free] = -1
    return places
