"""Small motions about a state: mass, stiffness, damping and constraints, and factors of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.stability import mass_matrix, on_free, whole
from ancfsparse.system import State, System

if TYPE_CHECKING:
    import scipy.sparse as sp

Vector = NDArray[np.float64]

# Flexibility of every constraint relative to that of the coordinates it holds: redundant
# constraints then give no zero pivot, and frequencies change by less than rounding.
FLEXIBILITY = 1e-10


class Pencil:
    """The equations ``M x'' + K x + Phi_q^T mu = 0``, ``Phi_q x = 0`` of small motions.

    Parameters
    ----------
    system : System
        What moves; its constraint block is not regularized.
    state : State
        Its coordinates, and its multipliers, whose forces rotate with the motion.
    amplitudes : (n_amplitudes,) float
        Amplitudes of the loads there.

    Attributes
    ----------
    mass, stiffness : (n_free, n_free) sparse
        M [kg, kg m2] and K, with the stiffness of stress, loads and multipliers [N/m, N, N m].
    gradients : (m, n_free) sparse
        Phi_q [1, m].
    diagonal : (n_free,) float
        Diagonal of M, positive also where equations alone give a coordinate its mass [kg, kg m2].
    seed : SparseSeed
        The solver of the shifted equations.
    shift : float
        Of the last factor [1/s2].
    """

    def __init__(self, system: System, state: State, amplitudes: Vector) -> None:
        self.system, self.state, self._amplitudes = system, state, amplitudes
        n, pattern = system.n_free, system.pattern
        self.mass = whole(mass_matrix(system))
        self.stiffness = whole(on_free(system, self._matrix(0.0, 1.0)))
        self.gradients = system.constraints.jacobian(state.q)[:, :n]
        self.diagonal = system.mass_diagonal
        self.seed = SparseSeed(pattern.indptr, pattern.indices, n)
        self.shift = 0.0
        self._below: int | None = None

    @property
    def size(self) -> float:
        """Size of the squares of the highest frequencies [1/s2]; 0 where nothing is stiff."""
        return float(np.max(np.abs(self.stiffness.diagonal()) / self.diagonal))

    def _matrix(self, mass: float, stiffness: float, damping: float = 0.0) -> Vector:
        state, matrix = self.state, self.system.assembly.matrix
        args, rest = (state.q, state.lam, self._amplitudes), np.zeros_like(state.q)
        return matrix(mass, stiffness, *args, damping_factor=damping, v=rest)

    def damping(self) -> sp.csr_array:
        """Return the damping matrix C over the free coordinates [N s/m, N s, N m s]."""
        return whole(on_free(self.system, self._matrix(0.0, 0.0, 1.0)))

    def factor(self, shift: float) -> int | None:
        """Factor ``K - shift M`` under the constraints.

        Returns
        -------
        int or None
            How many eigenvalues are below the shift, by Sylvester's law of inertia; None if the
            matrix is singular.
        """
        if shift == self.shift:
            return self._below
        system, self.shift = self.system, shift
        values = self._matrix(-np.sign(shift), 1.0 / abs(shift))  # [kg]
        n, m = system.n_free, system.n_multipliers
        if m:
            stiff = np.abs(self.stiffness.diagonal()) / abs(shift) + self.diagonal
            flexible = self.gradients.power(2) @ (1.0 / stiff)
            flexible[flexible == 0.0] = np.max(flexible, initial=1.0 / np.max(stiff))
            values[system.pattern.indptr[n : n + m]] -= FLEXIBILITY * flexible
        self.seed.factor(values)
        negative = self.seed.negative_pivots
        self._below = None if negative is None else negative - m
        return self._below

    def solve(self, force: Vector) -> Vector:
        """Return ``(K - shift M)^-1 force`` under the constraints, nearly rigid, (n_free,)."""
        r = np.zeros(self.seed.n)
        r[: len(self.diagonal)] = np.ravel(force)
        return self.seed.solve(r)[: len(self.diagonal)] / abs(self.shift)

    def solve_all(self, forces: Vector) -> Vector:
        """Solve for several forces, columns (n_free, k), under rigid constraints."""
        n = len(self.diagonal)
        out = np.stack([self.solve(force) for force in forces.T], axis=1)
        if self.gradients.shape[0]:
            for x in out.T:
                r = np.zeros(self.seed.n)
                r[n:] = -(self.gradients @ x)
                x += self.seed.solve(r)[:n]
        return out
