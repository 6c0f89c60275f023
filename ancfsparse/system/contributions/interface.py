"""What the system asks of everything that adds to its equations of motion, in Python.

What the time loop asks of the compiled part is in abi/system_abi.h.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.system.assembly.sparsity_pattern import Pattern, Unknowns

Vector = NDArray[np.float64]
Places = NDArray[np.int32]


class Compiled(Protocol):
    """The compiled part of a contribution."""

    @property
    def capsule(self) -> object:
        """What the assembly calls, "ancf_contribution"."""


class Contribution(ABC):
    """Something that adds to the equations of motion.

    Attributes
    ----------
    conservative : bool
        Whether its forces at rest have a potential, so that its stiffness is symmetric.
    is_explicit_in_time : bool
        Whether a change of its forces with time is known from the reference shape.
    is_load : bool
        Whether it is a load or a spring, which counts for nothing where a scene is assembled.
    depends_on_reactions : bool
        Whether its forces depend on multipliers otherwise than by the equations of these.
    """

    conservative = True
    is_explicit_in_time = True
    is_load = False
    depends_on_reactions = False

    def cliques(self) -> list[Unknowns]:
        """Return which unknowns meet in its part of the matrix: all those of a row of a table."""
        return []

    @abstractmethod
    def compile(self, pattern: Pattern) -> Compiled:
        """Return an object with a ``capsule`` "ancf_contribution", once the pattern is known."""

    @property
    def gyroscopic(self) -> Any:
        """The skew-symmetric matrix of its forces by velocities, sparse (n_free, n_free) [kg/s].

        None where there is none.
        """
        return None

    def potential(self, q: Vector) -> Vector | float:
        """Return what the energy of its compiled part is but strain energy, (k,) [J], q (k, n)."""
        return 0.0

    def power(self, q: Vector, v: Vector, amplitudes: Vector) -> Vector | float:
        """Return the power of its loads, shape (k,) [W].

        Parameters
        ----------
        q, v : (k, n_all) float
            States.
        amplitudes : (k, n_amplitudes) float
            What the functions of time give there.
        """
        return 0.0

    def unilateral_forces(
        self, q: Vector, v: Vector, amplitudes: Vector
    ) -> list[tuple[str, Vector]]:
        """Return what begins to push somewhere on the way: its name with its unit, and (k,) values.

        Stops, ropes and functions of the motion, of which a motion that does not reach them shows
        nothing.
        """
        return []

    def dissipation(self, q: Vector, v: Vector, lam: Vector) -> Vector | float:
        """Return the power that its forces by multipliers take, (k,) [W], lam (k, m)."""
        return 0.0

    def resisted_motions(self, q: Vector) -> Any:
        """Return the motions that it resists in static scenes, as rows of a sparse (k, n_all).

        Each is the gradient of a length [1].  None where it holds nothing, and for elements, which
        resist strain alone.
        """
        return None

    def divide(self, n_free: int, n_all: int, threads: int) -> bool:
        """Share its work among threads; return whether it has enough of it."""
        return False


def matrix_unknowns(places: Places, n_free: int) -> Places:
    """Turn places in q, in place, into numbers of unknowns in the matrix; -1 for the fixed ones."""
    places[places >= n_free] = -1
    return places
