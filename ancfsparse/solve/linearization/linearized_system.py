"""Linearized equations about a state: M, C, K, constraint gradients, and their factors."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results import Equilibrium
from ancfsparse.scene import Scene, check_scene
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.initial_conditions.consistent_accelerations import (
    initial_acceleration,
    load_amplitudes_at_start,
)
from ancfsparse.solve.initial_conditions.restart import check_start, restore_contributions
from ancfsparse.solve.linearization.matrices import (
    check_coupling,
    coupled_seed,
    free_submatrix,
    mass_matrix,
    symmetric_from_lower,
)
from ancfsparse.solve.linearization.nonconservative_tangent import NonconservativeTangent
from ancfsparse.solve.preparation.memory_estimate import (
    NO_MEMORY,
    check_factor_fits,
    estimate_memory,
    within_memory,
)
from ancfsparse.system import State, System

if TYPE_CHECKING:
    import scipy.sparse as sp


# With it redundant constraints cause no zero pivot, and frequencies change by less than rounding.
RELATIVE_FLEXIBILITY = 1e-10  # of a constraint, relative to the coordinates in it
RELATIVE_PENALTY = 1e3  # stiffness of penalty springs, relative to the coordinates in a constraint


class LinearizedSystem:
    """The equations ``M x'' + K x + Phi_q^T mu = 0``, ``Phi_q x = 0`` of small motions.

    Parameters
    ----------
    system : System
        The system; its constraint block is not regularized.
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
        Diagonal of M, positive also at coordinates whose only mass is in equations [kg, kg m2].
    seed : SparseSeed
        The factor of the last matrix.
    shift : float
        Shift of the last factor by `factor` [1/s2].

    Raises
    ------
    InputError
        If a force depends on the motion of other points and is not `coupled`.
    """

    def __init__(self, system: System, state: State, amplitudes: Vector) -> None:
        self.system, self.state, self._amplitudes = system, state, amplitudes
        check_coupling(system, state.q, amplitudes)
        n, pattern = system.n_free, system.pattern
        self.mass = symmetric_from_lower(mass_matrix(system))
        self.stiffness = symmetric_from_lower(free_submatrix(system, self._matrix(0.0, 1.0)))
        with system.sticking_friction():
            self._coupling = system.coupling_stiffness(state.q)
        if self._coupling is not None:
            self.stiffness = self.stiffness + self._coupling
        self.gradients = system.constraints.jacobian(state.q)[:, :n]
        self.diagonal = system.mass_diagonal
        self.seed = self._plain = SparseSeed(pattern.indptr, pattern.indices, n)
        self.shift = 0.0
        self._scale = 1.0
        self._below: int | None = None

    @property
    def size(self) -> float:
        """Order of the squares of the highest frequencies [1/s2]; 0 without stiffness."""
        return float(np.max(np.abs(self.stiffness.diagonal()) / self.diagonal))

    @property
    def stiffest(self) -> Vector:
        """Largest stiffness of each slope along any axis, at its coordinates, (n_free,) [N/m, N m].

        The rounding of stress is proportional to it; for strings, which have no slopes, to that of
        their positions.  Zero at all other coordinates.
        """
        n = self.system.n_free
        diagonal, largest = np.zeros((2, self.system.n_all))
        diagonal[:n] = np.abs(self.stiffness.diagonal())
        for kind, table in zip(self.system.kinds, self.system.places, strict=True):
            for name in kind.vectors[1:] or kind.vectors:
                indices = table[:, kind.columns(name)]
                np.maximum.at(largest, indices, diagonal[indices].max(axis=1, keepdims=True))
        return largest[:n]

    def _matrix(self, mass: float, stiffness: float, damping: float = 0.0) -> Vector:
        state, matrix = self.state, self.system.assembly.matrix
        args, zero = (state.q, state.lam, self._amplitudes), np.zeros_like(state.q)
        with self.system.sticking_friction():
            return matrix(mass, stiffness, *args, damping_factor=damping, v=zero)

    def damping(self) -> sp.csr_array:
        """Return the damping matrix C over the free coordinates [N s/m, N s, N m s]."""
        return symmetric_from_lower(free_submatrix(self.system, self._matrix(0.0, 0.0, 1.0)))

    def is_unsymmetric(self, rate: float) -> bool:
        """Return whether K, or C at a rate [1/s], leaves out a part of nonconservative forces."""
        tangent, state = NonconservativeTangent(self.system), (self.state.q, self._amplitudes)
        return bool(tangent.stiffness(*state).nnz or tangent.damping(*state, rate or 1.0).nnz)

    def factor(self, shift: float) -> int | None:
        """Factor ``K - shift M`` under the constraints.

        Returns
        -------
        int or None
            Number of eigenvalues below the shift, by Sylvester's law of inertia; None if the matrix
            is singular.
        """
        if shift != self.shift:
            self._below = self._factor(-np.sign(shift), 0.0, abs(shift))
            self.shift = shift
        return self._below

    def factor_at_rate(self, rate: float) -> int | None:
        """Factor ``rate^2 M + rate C + K`` under the constraints; count its negative eigenvalues.

        Unsymmetric parts of C and K, by nonconservative forces, are left out; the rate [1/s] must
        be positive.
        """
        self.shift = 0.0
        return self._factor(1.0, 1.0 / rate, rate**2)

    def factor_stiffness(self, addition: Vector | None = None) -> int | None:
        """Factor K under the constraints; return the number of its negative eigenvalues.

        `addition` is added to its values on the pattern.  The stiffness of rigid bodies is in the
        constraints alone, so penalty springs are added, whose forces vanish where these hold.
        """
        self.shift = 0.0
        if not self.system.n_multipliers:
            return self._factor(0.0, 0.0, self.size, addition)
        import scipy.sparse as sp

        self._below, self._scale = None, self.size
        added = 0.0
        if addition is not None:
            added = symmetric_from_lower(free_submatrix(self.system, addition))
        # Coordinates with hardly any stiffness get the mean ratio of stiffness to mass.
        stiff = np.abs(self.stiffness.diagonal()) / self._scale
        stiff = np.maximum(stiff, self.diagonal * (np.sum(stiff) / np.sum(self.diagonal)))
        flexible, phi_q = self._flexibility(stiff), self.gradients
        springs = phi_q.T @ sp.diags_array(RELATIVE_PENALTY / flexible) @ phi_q
        block = (self.stiffness + added) / self._scale + springs
        corner = sp.diags_array(-RELATIVE_FLEXIBILITY * flexible)
        lower = sp.tril(sp.block_array([[block, phi_q.T], [phi_q, corner]]), format="csc")
        lower.sort_indices()
        self.seed = SparseSeed(lower.indptr, lower.indices, self.system.n_free)
        self.seed.factor(lower.data)
        negative = self.seed.negative_pivots
        return None if negative is None else negative - self.system.n_multipliers

    def _flexibility(self, stiff: Vector) -> Vector:
        """Return the flexibility of the coordinates in each constraint, (m,) [1/kg]."""
        flexible = self.gradients.power(2) @ (1.0 / stiff)
        flexible[flexible == 0.0] = np.max(flexible, initial=1.0 / np.max(stiff))
        return np.asarray(flexible)

    def _factor(
        self, mass: float, damping: float, scale: float, addition: Vector | None = None
    ) -> int | None:
        """Factor ``mass M + damping C + (K + addition) / scale`` with nearly rigid constraints."""
        system = self.system
        values = self._matrix(mass, 1.0 / scale, damping)  # [kg]
        if addition is not None:
            values = values + addition / scale
        n, m = system.n_free, system.n_multipliers
        if m:
            stiff = np.abs(self.stiffness.diagonal()) / scale + abs(mass) * self.diagonal
            values[system.pattern.indptr[n : n + m]] -= RELATIVE_FLEXIBILITY * self._flexibility(
                stiff
            )
        self.seed = self._plain
        if self._coupling is not None:
            indptr, indices = system.pattern.indptr, system.pattern.indices
            self.seed, values = coupled_seed(indptr, indices, values, self._coupling / scale, n)
        self.seed.factor(values)
        self._scale = scale
        negative = self.seed.negative_pivots
        return None if negative is None else negative - m

    def solve(self, force: Vector) -> Vector:
        """Solve with the last factor, whose constraints are slightly flexible, (n_free,)."""
        r = np.zeros(self.seed.n)
        r[: len(self.diagonal)] = np.ravel(force)
        return self.seed.solve(r)[: len(self.diagonal)] / self._scale

    def solve_with_multipliers(self, force: Vector) -> tuple[Vector, Vector]:
        """Solve with rigid constraints, for the multipliers too [N]."""
        n = len(self.diagonal)
        r = np.zeros(self.seed.n)
        r[:n] = force
        solution = np.array(self.seed.solve(r))
        r[:n], r[n:] = 0.0, -(self.gradients @ solution[:n])
        solution += self.seed.solve(r)
        return solution[:n] / self._scale, solution[n:]

    def solve_all(self, forces: Vector) -> Vector:
        """Solve for several forces, columns (n_free, k), with rigid constraints."""
        n = len(self.diagonal)
        out = np.stack([self.solve(force) for force in forces.T], axis=1)
        if self.gradients.shape[0]:
            for x in out.T:
                r = np.zeros(self.seed.n)
                r[n:] = -(self.gradients @ x)
                x += self.seed.solve(r)[:n]
        return out


@contextmanager
def linearized_in_memory(
    of: object, at: object, n_matrices: int, n_vectors: int
) -> Iterator[LinearizedSystem]:
    """Check the arguments of `modes` and similar functions, and linearize within the memory.

    Parameters
    ----------
    of, at
        As in `modes`.
    n_matrices : int
        Arrays on the pattern that are needed.
    n_vectors : int
        Vectors over all unknowns that are needed.

    Raises
    ------
    InputError
        If an argument is invalid, or matrices, vectors and the factor cannot fit in memory.
    """
    if not isinstance(of, (Scene, Equilibrium)):
        hint = "; give its scene too: modes(scene, n, at=state)" * isinstance(of, State)
        raise InputError(
            f"modes are those of a scene or an equilibrium, got {format_value(of)}{hint}"
        )
    if isinstance(of, Equilibrium) and at is not None:
        raise InputError("an equilibrium is a state already: give its scene with at, or no at")
    scene = of.system.scene if isinstance(of, Equilibrium) else of
    check_scene(scene)
    with within_memory(estimate_memory(scene, matrices=n_matrices)):
        linearized = _linearize(of, at)
        vectors = replace(NO_MEMORY, vectors=8.0 * n_vectors * linearized.seed.n)
        check_factor_fits(vectors, linearized.seed)
        yield linearized


def _linearize(of: Scene | Equilibrium, at: object) -> LinearizedSystem:
    """Return the linearized equations of a scene about a state."""
    if isinstance(of, Equilibrium):
        assert isinstance(of.system, System)
        time = np.array([of.state.t])
        return LinearizedSystem(of.system, of.state, of.system.loads.amplitudes(time)[0])
    state = check_start(at, "at")
    system = System(of, state)
    restore_contributions(state, system)
    lam = np.zeros(system.n_multipliers)
    if state is None:
        if system.gyroscopic is not None:
            raise InputError(
                "the stress-free shape is no equilibrium in a rotating frame: give the "
                "equilibrium, solve_static(scene)"
            )
        zero = np.zeros(system.n_all)
        about = system.state(system.t0, system.q_ref, zero, zero, lam)
        return LinearizedSystem(system, about, np.zeros(system.loads.n_amplitudes))
    if system.n_multipliers:
        seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
        seed.factor(
            system.assembly.matrix(1.0, 0.0, system.q0, lam, load_amplitudes_at_start(system))
        )
        lam = initial_acceleration(system, seed, system.v0)[1]
    about = system.state(system.t0, system.q0, system.v0, None, lam)
    return LinearizedSystem(system, about, load_amplitudes_at_start(system))
