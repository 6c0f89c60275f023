"""Small motions about a state: mass, stiffness, damping and constraints, and factors of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results import Equilibrium
from ancfsparse.scene import Scene, check_scene
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.initial_conditions.consistent_accelerations import (
    initial_acceleration,
    load_amplitudes_at_start,
)
from ancfsparse.solve.initial_conditions.restart import check_start
from ancfsparse.solve.linearization.matrices import (
    free_submatrix,
    mass_matrix,
    symmetric_from_lower,
)
from ancfsparse.system import State, System

if TYPE_CHECKING:
    import scipy.sparse as sp

Vector = NDArray[np.float64]

# Flexibility of every constraint relative to that of the coordinates it holds: redundant
# constraints then give no zero pivot, and frequencies change by less than rounding.
FLEXIBILITY = 1e-10
# Stiffness of springs in place of constraints relative to that of the coordinates these hold.
STIFFER = 1e3


class LinearizedSystem:
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
        The solver of the equations that were factored last.
    shift : float
        Of the last factor, if `factor` made it [1/s2].
    """

    def __init__(self, system: System, state: State, amplitudes: Vector) -> None:
        self.system, self.state, self._amplitudes = system, state, amplitudes
        n, pattern = system.n_free, system.pattern
        self.mass = symmetric_from_lower(mass_matrix(system))
        self.stiffness = symmetric_from_lower(free_submatrix(system, self._matrix(0.0, 1.0)))
        self.gradients = system.constraints.jacobian(state.q)[:, :n]
        self.diagonal = system.mass_diagonal
        self.seed = self._plain = SparseSeed(pattern.indptr, pattern.indices, n)
        self.shift = 0.0
        self._scale = 1.0
        self._below: int | None = None

    @property
    def size(self) -> float:
        """Size of the squares of the highest frequencies [1/s2]; 0 where nothing is stiff."""
        return float(np.max(np.abs(self.stiffness.diagonal()) / self.diagonal))

    @property
    def stiffest(self) -> Vector:
        """Largest stiffness of each slope along any axis, of its coordinates, (n_free,) [N/m, N m].

        The rounding of stress is a share of it; a string, which has no slopes, has that of its
        positions.  Zero for all other coordinates.
        """
        n = self.system.n_free
        own, largest = np.zeros((2, self.system.n_all))
        own[:n] = np.abs(self.stiffness.diagonal())
        for kind, table in zip(self.system.kinds, self.system.places, strict=True):
            for name in kind.vectors[1:] or kind.vectors:
                places = table[:, kind.columns(name)]
                np.maximum.at(largest, places, own[places].max(axis=1, keepdims=True))
        return largest[:n]

    def _matrix(self, mass: float, stiffness: float, damping: float = 0.0) -> Vector:
        state, matrix = self.state, self.system.assembly.matrix
        args, rest = (state.q, state.lam, self._amplitudes), np.zeros_like(state.q)
        return matrix(mass, stiffness, *args, damping_factor=damping, v=rest)

    def damping(self) -> sp.csr_array:
        """Return the damping matrix C over the free coordinates [N s/m, N s, N m s]."""
        return symmetric_from_lower(free_submatrix(self.system, self._matrix(0.0, 0.0, 1.0)))

    def factor(self, shift: float) -> int | None:
        """Factor ``K - shift M`` under the constraints.

        Returns
        -------
        int or None
            How many eigenvalues are below the shift, by Sylvester's law of inertia; None if the
            matrix is singular.
        """
        if shift != self.shift:
            self._below = self._factor(-np.sign(shift), 0.0, abs(shift))
            self.shift = shift
        return self._below

    def factor_at_rate(self, rate: float) -> int | None:
        """Factor ``rate^2 M + rate C + K`` under the constraints; count its negative eigenvalues.

        C and K without what forces without a potential make unsymmetric; the rate [1/s] is
        positive.
        """
        self.shift = 0.0
        return self._factor(1.0, 1.0 / rate, rate**2)

    def factor_stiffness(self, more: Vector | None = None) -> int | None:
        """Factor K under the constraints; return how many of its eigenvalues are negative.

        `more` is added to its values on the pattern.  Rigid bodies have no stiffness of their own,
        and what equations alone hold is singular without them, so springs in their place are added,
        which do nothing where they are met.
        """
        self.shift = 0.0
        if not self.system.n_multipliers:
            return self._factor(0.0, 0.0, self.size, more)
        import scipy.sparse as sp

        self._below, self._scale = None, self.size
        added = 0.0 if more is None else symmetric_from_lower(free_submatrix(self.system, more))
        # Coordinates with hardly any are as stiff for their masses as all are on average.
        stiff = np.abs(self.stiffness.diagonal()) / self._scale
        stiff = np.maximum(stiff, self.diagonal * (np.sum(stiff) / np.sum(self.diagonal)))
        flexible, phi_q = self._flexibility(stiff), self.gradients
        springs = phi_q.T @ sp.diags_array(STIFFER / flexible) @ phi_q
        held = (self.stiffness + added) / self._scale + springs
        corner = sp.diags_array(-FLEXIBILITY * flexible)
        lower = sp.tril(sp.block_array([[held, phi_q.T], [phi_q, corner]]), format="csc")
        lower.sort_indices()
        self.seed = SparseSeed(lower.indptr, lower.indices, self.system.n_free)
        self.seed.factor(lower.data)
        negative = self.seed.negative_pivots
        return None if negative is None else negative - self.system.n_multipliers

    def _flexibility(self, stiff: Vector) -> Vector:
        """Return that of each constraint, by the stiffness of its coordinates [1/kg]."""
        flexible = self.gradients.power(2) @ (1.0 / stiff)
        flexible[flexible == 0.0] = np.max(flexible, initial=1.0 / np.max(stiff))
        return np.asarray(flexible)

    def _factor(
        self, mass: float, damping: float, scale: float, more: Vector | None = None
    ) -> int | None:
        """Factor ``mass M + damping C + (K + more) / scale`` under nearly rigid constraints."""
        system = self.system
        values = self._matrix(mass, 1.0 / scale, damping)  # [kg]
        if more is not None:
            values = values + more / scale
        n, m = system.n_free, system.n_multipliers
        if m:
            stiff = np.abs(self.stiffness.diagonal()) / scale + abs(mass) * self.diagonal
            values[system.pattern.indptr[n : n + m]] -= FLEXIBILITY * self._flexibility(stiff)
        self.seed = self._plain
        self.seed.factor(values)
        self._scale = scale
        negative = self.seed.negative_pivots
        return None if negative is None else negative - m

    def solve(self, force: Vector) -> Vector:
        """Solve the equations factored last under the constraints, nearly rigid, (n_free,)."""
        r = np.zeros(self.seed.n)
        r[: len(self.diagonal)] = np.ravel(force)
        return self.seed.solve(r)[: len(self.diagonal)] / self._scale

    def solve_with_multipliers(self, force: Vector) -> tuple[Vector, Vector]:
        """Solve likewise under rigid constraints, for the multipliers too [N]."""
        n = len(self.diagonal)
        r = np.zeros(self.seed.n)
        r[:n] = force
        solution = np.array(self.seed.solve(r))
        r[:n], r[n:] = 0.0, -(self.gradients @ solution[:n])
        solution += self.seed.solve(r)
        return solution[:n] / self._scale, solution[n:]

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


def scene_of(of: object, at: object = None) -> Scene:
    """Return the scene of what modes are asked of, checked.

    Raises
    ------
    InputError
        If it is neither a scene nor an equilibrium, or an equilibrium with another state.
    """
    if not isinstance(of, (Scene, Equilibrium)):
        advice = "; give its scene too: modes(scene, n, at=state)" * isinstance(of, State)
        raise InputError(
            f"modes are those of a scene or an equilibrium, got {format_value(of)}{advice}"
        )
    if isinstance(of, Equilibrium) and at is not None:
        raise InputError("an equilibrium is a state already: give its scene with at, or no at")
    scene = of.system.scene if isinstance(of, Equilibrium) else of
    check_scene(scene)
    return scene


def linearize(of: Scene | Equilibrium, at: State | Equilibrium | None) -> LinearizedSystem:
    """Linearise the scene about a state."""
    if isinstance(of, Equilibrium):
        assert isinstance(of.system, System)
        time = np.array([of.state.t])
        return LinearizedSystem(of.system, of.state, of.system.loads.amplitudes(time)[0])
    state = check_start(at, "at")
    system = System(of, state)
    lam = np.zeros(system.n_multipliers)
    if state is None:
        if system.gyroscopic is not None:
            raise InputError(
                "the stress-free shape is no equilibrium in a rotating frame: give the "
                "equilibrium, solve_static(scene)"
            )
        rest = np.zeros(system.n_all)
        here = system.state(system.t0, system.q_ref, rest, rest, lam)
        return LinearizedSystem(system, here, np.zeros(system.loads.n_amplitudes))
    if system.n_multipliers:
        seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
        seed.factor(
            system.assembly.matrix(1.0, 0.0, system.q0, lam, load_amplitudes_at_start(system))
        )
        lam = initial_acceleration(system, seed, system.v0)[1]
    here = system.state(system.t0, system.q0, system.v0, None, lam)
    return LinearizedSystem(system, here, load_amplitudes_at_start(system))
