"""Equilibrium equations: residual, tangent stiffness and its factor."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.results import RunStats
from ancfsparse.seeds import DeflatedSeed
from ancfsparse.solve.linearization.matrices import coupled_seed, omitted_coupling
from ancfsparse.solve.linearization.nonconservative_tangent import (
    NonconservativeTangent,
    solve_with_correction,
)
from ancfsparse.solve.preparation.choose_factorization import make_static_seed
from ancfsparse.solve.statics.imposed_loads import ImposedLoads
from ancfsparse.solve.statics.norms import ROUNDING_UNITS, Norms
from ancfsparse.solve.statics.penalties import Penalties
from ancfsparse.system import System
from ancfsparse.system.contributions.interface import sum_of

NO_FORCES = np.zeros(0)


class StaticState(NamedTuple):
    """Coordinates, multipliers and residuals of a state.

    Attributes
    ----------
    q : (n_all,) float
        Coordinates [m, 1].
    lam : (m,) float
        Multipliers [N].
    r : (n_free,) float
        Residual forces [N, N m].
    phi : (m,) float
        Violation of the constraints [m].
    reactions : (n_all - n_free,) float
        Forces at fixed and prescribed coordinates, without dead loads [N, N m]; empty where they
        are not needed.
    """

    q: Vector
    lam: Vector
    r: Vector
    phi: Vector
    reactions: Vector = NO_FORCES


class EquilibriumEquations(Norms):
    """Static residual and tangent of a scene over the free coordinates.

    Constraints are imposed by penalty springs and by multipliers (augmented Lagrangian), so the
    matrix is positive definite at a stable equilibrium, and its negative pivots count the unstable
    directions.

    Parameters
    ----------
    system : System
        The system at rest.
    stats : RunStats
        Counts residuals, factors and solves.
    on_factor : callable, optional
        Called at every factorisation.
    kind : str, optional
        One of `solve.preparation.choose_factorization.FACTORIZATIONS`.
    t : float, optional
        Time of the loads and drives [s].

    Attributes
    ----------
    seed : SparseSeed or DeflatedSeed
        Seed on the pattern of the matrix.
    strings : tuple of (n, 2, dim) int and (n,) float arrays, or None
        Indices of both ends of all elements without slopes, and their lengths [m].
    plain : bool
        Whether the stiffness comes from the elements alone.
    conservative : bool
        Whether all forces have a potential; moments in space have none.
    span : float
        Largest coordinate of the reference shape [m].
    stiffness_rounding : float
        Rounding of the stiffness over the mass in the reference shape [1/s2].
    imposed : ImposedLoads
        Loads and prescribed motions.
    start : StaticState
        The reference shape without loads.
    loads : float
        Norm of all loads, see `force_norm`, including the forces that prescribed motions cause if
        only the supports move.
    """

    def __init__(
        self,
        system: System,
        stats: RunStats,
        on_factor: Callable[[], object] = lambda: None,
        kind: str = "complete",
        t: float = 0.0,
    ) -> None:
        super().__init__(system)
        self.stats = stats
        self._on_factor = on_factor
        self.imposed = ImposedLoads(system, t)
        loads = system.loads
        self.plain = not (loads.moment_place or loads.followers) and system.constraints.linear
        self.conservative = system.conservative
        self._make_pattern()
        self.seed, self._modes = make_static_seed(system, self._indptr, self._indices, kind)
        self._plain = self.seed  # without the stiffness between elements
        self._ready: tuple[StaticState, Vector] | None = None
        self.strings = _string_elements(system)
        self._nonconservative = None if self.conservative else NonconservativeTangent(system)
        self._unfactored: Any = None  # part of the tangent that the factor does not contain
        self._phi_q: Any = None
        self._springs = np.zeros(system.n_multipliers)
        self._rounded: tuple[Vector, Vector] | None = None  # coordinates, and the rounding there
        self.start = self.state(system.q_ref, np.zeros(system.n_multipliers), 0.0)
        loaded = self.state(self.start.q, self.start.lam, 1.0)
        if system.n_multipliers:
            self._penalties = Penalties(system, self._gradients, loaded.r)
        self.loads = self.force_norm(loaded.r - self.start.r)
        self._load_norm = self._norm_of_loads()
        self._driven_mass = self.typical_masses(slice(system.n_all - system.prescribed.n, None))
        self._stress_at_start = self.force_norm(self.start.r)
        self.span = float(np.max(np.abs(system.q_ref)))
        diagonal = self.stiffness(self.start, 0.0)[system.pattern.indptr[: system.n_free]]
        self.stiffness_rounding = (
            ROUNDING_UNITS * EPSILON * float(np.max(diagonal / self.mass, initial=0.0))
        )
        largest = np.full(system.n_free, self.span)
        largest[self.slopes] = 1.0
        largest *= diagonal
        # Far above the rounding of forces, which is evaluated only below it.
        self._max_rounding = 64.0 * ROUNDING_UNITS * EPSILON * self.force_norm(largest)

    def omitted_coupling(self, q: Vector) -> str:
        """Return a sentence on a force whose part between points is not in the tangent."""
        return omitted_coupling(self.system, q, self.imposed.amplitudes)

    def move_to(self, t: float) -> None:
        """Set loads and prescribed motions of another time [s]; `loads` keeps its maximum."""
        self.imposed.set_time(t)
        self._ready = None
        loaded = self.state(self.start.q, self.start.lam, 1.0)
        self.loads = max(self.loads, self.force_norm(loaded.r - self.start.r))
        self._load_norm = max(self._load_norm, self._norm_of_loads())

    def force_scale(self, state: StaticState) -> float:
        """Return the norm of loads and driving forces.

        If both are zero, it is the one of the stress in the reference shape, or else `loads`.
        """
        forces = self._load_norm + self._driving_force(state)
        return forces or self._stress_at_start or self.loads

    def acceleration_scale(self, state: StaticState) -> float:
        """Return the root mean square of the acceleration by `force_scale` [m/s2]."""
        return float(self.force_scale(state) * np.sqrt(self.system.dim / self.total_mass))

    def _make_pattern(self) -> None:
        """Restrict the pattern to the coordinates, and add the coupling by springs."""
        pattern, n = self.system.pattern, self.system.n_free
        end = int(pattern.indptr[n])
        self._keep: NDArray[np.int64] | slice = slice(0, end)
        self._indptr, self._indices = pattern.indptr[: n + 1], pattern.indices[:end]
        self._keys: NDArray[np.int64] | None = None
        if not self.system.n_multipliers:
            return
        import scipy.sparse as sp

        self._keep = np.flatnonzero(self._indices < n)
        columns = np.repeat(np.arange(n), np.diff(self._indptr))[self._keep]
        entries = columns * n + self._indices[self._keep]
        # All entries that gradients may have, including those that are zero in this state.
        self._gradients = phi_q = self._jacobian(self.system.q_ref)
        phi_q.data[:] = 1.0
        reach = self.system.constraints.reach(self.system.q_ref)[:, :n]
        springs = sp.coo_array(sp.tril(reach.T @ reach))
        self._keys = np.unique(np.concatenate([entries, springs.coords[1] * n + springs.coords[0]]))
        self._own = np.searchsorted(self._keys, entries)
        self._indices = (self._keys % n).astype(np.int32)
        self._indptr = np.searchsorted(self._keys, n * np.arange(n + 1)).astype(np.int64)

    def _jacobian(self, q: Vector) -> Any:
        return self.system.constraints.jacobian(q)[:, : self.system.n_free]

    def state(self, q: Vector, lam: Vector, load: float) -> StaticState:
        """Return a state with its residuals under a load factor."""
        self.stats.residual_evaluations += 1
        q = self.imposed.move_supports(q, load)
        r, phi = self.imposed.residual(q, lam, load)
        n = self.system.n_free
        return StaticState(q, lam, r[:n], phi, r[n:] + self.imposed.dead_load(load)[n:])

    def _norm_of_loads(self) -> float:
        """Return the norm of the loads without prescribed motions."""
        r, _ = self.imposed.residual(self.start.q, self.start.lam, 1.0)
        return self.force_norm(r[: self.system.n_free] - self.start.r)

    def _driving_force(self, state: StaticState) -> float:
        """Return the norm of the forces that impose prescribed motions."""
        prescribed = self.system.prescribed
        if not prescribed:
            return 0.0
        forces = state.reactions[len(state.reactions) - prescribed.n :]
        with np.errstate(over="ignore"):
            squares = float(np.sum(forces**2 / self._driven_mass))
        if n := prescribed.n_equations:
            joints = self._jacobian(state.q)[-n:].T @ state.lam[-n:]
            squares += self.force_norm(joints) ** 2
        return math.sqrt(squares)

    def moved(self, state: StaticState, dx: Vector, dlam: Vector, load: float) -> StaticState:
        """Return the state after a correction."""
        q = state.q.copy()
        q[: len(dx)] += dx
        return self.state(q, state.lam + dlam, load)

    def stiffness(self, state: StaticState, load: float, out: Vector | None = None) -> Vector:
        """Return the values of the tangent stiffness, without penalty springs [N/m, N, N m]."""
        lam, amplitudes = state.lam, self.imposed.amplitudes_at(load)
        assembly = self.system.assembly
        return np.asarray(assembly.matrix(0.0, 1.0, state.q, lam, amplitudes, out=out))

    def stress_stiffness(self, q: Vector, out: Vector, work: Vector) -> Vector:
        """Return the geometric stiffness by the stress of the elements."""
        assembly = self.system.assembly
        no_forces = np.zeros(self.system.n_multipliers), self.imposed.amplitudes_at(0.0)
        values = np.asarray(assembly.matrix(0.0, 1.0, q, *no_forces, out=out))
        values -= assembly.material(0.0, 1.0, q, out=work)
        return values

    def _material(self, state: StaticState) -> Vector | None:
        """Return the diagonal of the material stiffness if there are rigid bodies."""
        if not self._penalties.rigid:
            return None
        values = self.system.assembly.material(0.0, 1.0, state.q)
        return np.asarray(values)[self.system.pattern.indptr[: self.system.n_free]]

    def factor(
        self, state: StaticState, values: Vector, load: float, shift: float = 0.0
    ) -> int | None:
        """Factor a stiffness with penalty springs and `shift` [1/s2] times the mass.

        Returns
        -------
        int or None
            Number of negative pivots, a lower bound if the seed is incomplete; None if the matrix
            is singular.
        """
        entries = values[self._keep]
        if self._keys is not None:
            import scipy.sparse as sp

            all_entries = np.zeros(len(self._keys))
            all_entries[self._own] = entries
            entries = all_entries
            self._phi_q = phi_q = self._jacobian(state.q)
            diagonal = entries[self._indptr[:-1]]
            self._springs = self._penalties.springs(phi_q, diagonal, self._material(state))
            added = sp.coo_array(sp.tril(phi_q.T @ sp.diags_array(self._springs) @ phi_q))
            keys = added.coords[1].astype(np.int64) * len(diagonal) + added.coords[0]
            np.add.at(entries, np.searchsorted(self._keys, keys), added.data)
        if shift > 0.0:
            entries = entries.copy()
            entries[self._indptr[:-1]] += shift * self.mass
        self.stats.factorizations += 1
        self._on_factor()
        coupling = self.system.coupling_stiffness(state.q)
        parts = [self.system.unsymmetric_stiffness(state.q)]
        if self._nonconservative is not None:
            parts.append(self._nonconservative.stiffness(state.q, self.imposed.amplitudes_at(load)))
        if isinstance(self._plain, DeflatedSeed):
            assert self._modes is not None
            self._unfactored = sum_of([*parts, coupling])
            self._plain.factor(entries, self._modes.at(state.q))
            # Only a solution shows whether the matrix is definite.
            self._ready = state, self._solution(state)
        else:
            self._unfactored, self.seed = sum_of(parts), self._plain
            if coupling is not None:
                self.seed, entries = coupled_seed(self._indptr, self._indices, entries, coupling)
            if self.seed.factor(entries) == 0:
                return 0
        self.stats.indefinite += self.seed.negative_pivots != 0
        return self.seed.negative_pivots

    def correction(self, state: StaticState) -> tuple[Vector, Vector]:
        """Return the corrections of coordinates and multipliers by the last factor."""
        if self._ready is not None and self._ready[0] is state:
            dx = self._ready[1]
        else:
            dx = self._solution(state)
        if not len(state.phi):
            return dx, state.phi
        return dx, self._springs * (state.phi + self._phi_q @ dx)

    def _solution(self, state: StaticState) -> Vector:
        """Return the correction of the coordinates by the last factor."""
        self.stats.solves += 1
        r = state.r
        if len(state.phi):
            r = r + self._phi_q.T @ (self._springs * state.phi)
        if self._unfactored is not None and self._unfactored.nnz:
            x = solve_with_correction(self.seed.solve, self._unfactored, r, np.sqrt(self.mass))
            if x is not None:
                return -x
        return -self.seed.solve(r)

    def rounding(self, state: StaticState, load: float) -> Vector:
        """Return the rounding of every residual force [N, N m]."""
        if self._rounded is None or self._rounded[0] is not state.q:
            values = self.stiffness(state, load)
            self._rounded = state.q, self.rounding_of(values, state.q, state.lam)
        return self._rounded[1]

    def is_lost_in_rounding(self) -> bool:
        """Return whether the rounding of forces exceeds the loads, at any orientation."""
        q = np.full(self.system.n_all, self.span)
        q[self.slopes] = 1.0
        rounding = self.force_norm(self.rounding_of(self.stiffness(self.start, 0.0), q))
        return rounding > self.loads + self._stress_at_start

    def negative_pivots(self, counted: int) -> int:
        """Return the number of negative pivots of the last matrix, given those counted so far.

        A matrix without a complete factor is tested with a random force, which has a component in
        every direction.
        """
        if isinstance(self.seed, DeflatedSeed) and counted == 0:
            force = np.random.default_rng(1).standard_normal(len(self.mass)) * np.sqrt(self.mass)
            self.stats.solves += 1
            self.seed.solve(force)
            return self.seed.negative_pivots
        return counted

    def noise(self, state: StaticState, load: float) -> Vector:
        """Return the displacements of the bodies by rounding of the forces [m], (n_bodies,)."""
        rounding = self.rounding(state, load)
        sign = np.random.default_rng(0).choice([-1.0, 1.0], len(rounding))
        self.stats.solves += 1
        return self.distances(self.seed.solve(sign * rounding))

    def _is_met(self, state: StaticState) -> bool:
        """Return whether the constraints are satisfied up to rounding."""
        if not len(state.phi):
            return True
        span = np.max(np.abs(state.q[self._positions]))
        sizes = span + self.system.constraints.sizes(state.q)
        return bool(np.all(np.abs(state.phi) <= ROUNDING_UNITS * EPSILON * sizes))

    def is_balanced(
        self, state: StaticState, load: float, tolerance: float, *, intermediate: bool = False
    ) -> bool:
        """Return whether the residual is below the tolerance, or below rounding.

        The tolerance is relative to loads and driving forces; in an `intermediate` load step, which
        only leads to the next one, to the larger `loads`: otherwise steps are a fourth as long.
        """
        if not self._is_met(state):
            return False
        forces = self.imposed.force_factor(load) * (self.loads if intermediate else self._load_norm)
        if not intermediate:
            forces += self._driving_force(state)
        allowed = tolerance * (forces + self._stress_at_start)
        norm = self.force_norm(state.r)
        if not np.isfinite(norm):
            return False
        if norm <= allowed or norm > self._max_rounding:
            return norm <= allowed
        excess = np.maximum(np.abs(state.r) - self.rounding(state, load), 0.0)
        return self.force_norm(excess) <= allowed


def _string_elements(system: System) -> tuple[NDArray[np.int32], Vector] | None:
    """Return the indices of both ends of all elements without slopes, and their lengths [m]."""
    bodies = [body for body in system.scene.beams if body.kind.is_string]
    if not bodies:
        return None
    ends = [system.elements(body).reshape(body.n_elements, 2, -1) for body in bodies]
    return np.concatenate(ends), np.concatenate([body.lengths for body in bodies])
