"""Forces at rest, their derivative and its factor: what statics solves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.results import RunStats
from ancfsparse.seeds import DeflatedSeed
from ancfsparse.solve.linearization.nonconservative_tangent import (
    NonconservativeTangent,
    solve_with_correction,
)
from ancfsparse.solve.preparation.choose_factorization import make_static_seed
from ancfsparse.solve.statics.norms import ROUNDING, Norms
from ancfsparse.solve.statics.penalties import Penalties
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Share of the loads over which the motion of drives is taken as linear.
SMALL_LOAD = 1e-6


class StaticState(NamedTuple):
    """Coordinates and multipliers with what is unbalanced there.

    Attributes
    ----------
    q : (n_all,) float
        Coordinates [m, 1].
    lam : (m,) float
        Multipliers [N].
    r : (n_free,) float
        Unbalanced forces [N, N m].
    phi : (m,) float
        Violation of the constraints [m].
    """

    q: Vector
    lam: Vector
    r: Vector
    phi: Vector


class EquilibriumEquations(Norms):
    """The equations of rest of a scene, on the free coordinates alone.

    Constraints are held by springs and by multipliers that learn what the springs take (augmented
    Lagrangian), so the matrix is definite where the equilibrium is stable, and its negative pivots
    count the directions in which it is not.

    Parameters
    ----------
    system : System
        What is at rest.
    stats : RunStats
        Counts residuals, factors and solves.
    on_factor : callable, optional
        Called at every factorisation.
    kind : str, optional
        One of `solve.preparation.choose_factorization.SEEDS`.
    t : float, optional
        Time of the loads and drives [s].

    Attributes
    ----------
    seed : SparseSeed or DeflatedSeed
        Ordered for the matrix.
    strings : tuple of (n, 2, dim) int and (n,) float arrays, or None
        Places of both ends of all elements without slopes, and their lengths [m].
    plain : bool
        Whether the stiffness comes from the elements alone.
    conservative : bool
        Whether all forces have a potential, as moments in space have none.
    span : float
        Largest coordinate of the reference shape [m].
    forces_first : bool
        Whether drives only move when all forces are there, and not with them: a cable that sags is
        slackened more easily than a straight one.
    start : State
        The reference shape without loads.
    loads : float
        Size of all loads, see `size_of_forces`.
    acceleration : float
        Root mean square of the acceleration by `pushes` [m/s2].
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
        self._amplitudes = system.loads.amplitudes(np.array([t]))[0]
        self._grows = system.loads.growing
        self._dead = system.dead_load
        self._set_drives(t)
        self.forces_first = False
        self._rest = np.zeros(system.n_all)
        loads = system.loads
        self.plain = not (loads.moment_place or loads.followers) and system.constraints.linear
        self.conservative = system.conservative
        self._make_pattern()
        self.seed, self._modes = make_static_seed(system, self._indptr, self._indices, kind)
        self._ready: tuple[StaticState, Vector] | None = None
        self.strings = _strings(system)
        self._unsymmetric = None if self.conservative else NonconservativeTangent(system)
        self._beside: Any = None
        self._phi_q: Any = None
        self._springs = np.zeros(system.n_multipliers)
        self._rounded: tuple[Vector, Vector] | None = None  # coordinates, and the rounding there
        self.start = self.state(system.q_ref, np.zeros(system.n_multipliers), 0.0)
        pushed = self.state(self.start.q, self.start.lam, 1.0)
        if system.n_multipliers:
            self._penalties = Penalties(system, self._gradients, pushed.r)
        self.loads = self.size_of_forces(pushed.r - self.start.r)
        self._stress_at_start = self.size_of_forces(self.start.r)
        self.acceleration = self.pushes * (system.dim / self.whole_mass) ** 0.5
        self.span = float(np.max(np.abs(system.q_ref)))
        largest = np.full(system.n_free, self.span)
        largest[self.slopes] = 1.0
        largest *= self.stiffness(self.start, 0.0)[system.pattern.indptr[: system.n_free]]
        # Far above the rounding of forces, which only then need be looked at one by one.
        self._most_rounding = 64.0 * ROUNDING * EPSILON * self.size_of_forces(largest)

    def move_to(self, t: float) -> None:
        """Take loads and drives at another time [s]; the loads count by their largest size."""
        self._amplitudes = self.system.loads.amplitudes(np.array([t]))[0]
        self._set_drives(t)
        self._ready = None
        pushed = self.state(self.start.q, self.start.lam, 1.0)
        self.loads = max(self.loads, self.size_of_forces(pushed.r - self.start.r))
        self.acceleration = self.pushes * (self.system.dim / self.whole_mass) ** 0.5

    @property
    def pushes(self) -> float:
        """Size of all loads, or without any of the forces that stress the reference shape."""
        return self.loads or self._stress_at_start

    def _set_drives(self, t: float) -> None:
        """Let drives begin in the reference shape; with the loads they come to where they are."""
        system, prescribed = self.system, self.system.prescribed
        first, led = system.n_all - prescribed.n, system.n_multipliers - prescribed.n_equations
        self._still, self._held = system.q_ref[first:], np.zeros(0)
        self._driven, self._followed = np.zeros(prescribed.n), np.zeros(0)
        if not prescribed:
            return
        now = prescribed.at(t)
        none, lam = np.zeros(system.n_all), np.zeros(system.n_multipliers)
        args = (none, none, lam, self._dead, self._amplitudes)
        self._held = np.asarray(system.assembly.residual(system.q_ref, *args)[1])[led:]
        self._driven, self._followed = now.q - self._still, now.s - self._held

    @property
    def places(self) -> Vector:
        """Where joints hold coordinates, and where drives have led them under all loads."""
        system = self.system
        fixed = system.q_ref[system.n_free : system.n_all - len(self._driven)]
        return np.append(fixed, self._still + self._driven)

    def _make_pattern(self) -> None:
        """Take the coordinates out of the pattern of the system, and add what springs couple."""
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
        own = columns * n + self._indices[self._keep]
        # Which entries there may be, also where those of this state cancel.
        self._gradients = phi_q = self._jacobian(self.system.q_ref)
        phi_q.data[:] = 1.0
        reach = self.system.constraints.reach(self.system.q_ref)[:, :n]
        springs = sp.coo_array(sp.tril(reach.T @ reach))
        self._keys = np.unique(np.concatenate([own, springs.coords[1] * n + springs.coords[0]]))
        self._own = np.searchsorted(self._keys, own)
        self._indices = (self._keys % n).astype(np.int32)
        self._indptr = np.searchsorted(self._keys, n * np.arange(n + 1)).astype(np.int64)

    def _jacobian(self, q: Vector) -> Any:
        return self.system.constraints.jacobian(q)[:, : self.system.n_free]

    def state(self, q: Vector, lam: Vector, load: float) -> StaticState:
        """Return a state with what is unbalanced under a share of the loads."""
        self.stats.residual_evaluations += 1
        if self._driven.any():
            q = np.array(q)
            q[len(q) - len(self._driven) :] = self._still + self._way(load) * self._driven
        forces = self._share(load) * self._dead, self._amplitudes_at(load)
        r, phi = self.system.assembly.residual(q, self._rest, self._rest, lam, *forces)
        followed = self._held + self._way(load) * self._followed
        phi[len(phi) - len(followed) :] -= followed
        return StaticState(q, lam, np.asarray(r)[: self.system.n_free], np.asarray(phi))

    def _share(self, load: float) -> float:
        """Return the share of the forces where the load has come so far."""
        return min(1.0, 2.0 * load) if self.forces_first else load

    def _way(self, load: float) -> float:
        """Return the share of their way that drives have gone by then."""
        return max(0.0, 2.0 * load - 1.0) if self.forces_first else load

    def _amplitudes_at(self, load: float) -> Vector:
        """Return the amplitudes under a share of the loads."""
        return np.asarray(np.where(self._grows, self._share(load), 1.0) * self._amplitudes)

    @property
    def driven(self) -> bool:
        """Whether anything is moved by drives."""
        return bool(self._driven.any() or self._followed.any())

    @property
    def small_load(self) -> float:
        """A share of the loads in which unbalanced forces are linear: any without drives."""
        return SMALL_LOAD if self.driven else 1.0

    def moved(self, state: StaticState, dx: Vector, dlam: Vector, load: float) -> StaticState:
        """Return the state after a correction."""
        q = state.q.copy()
        q[: len(dx)] += dx
        return self.state(q, state.lam + dlam, load)

    def stiffness(self, state: StaticState, load: float, out: Vector | None = None) -> Vector:
        """Return the values of the tangent stiffness, without springs [N/m, N, N m]."""
        lam, amplitudes = state.lam, self._amplitudes_at(load)
        assembly = self.system.assembly
        return np.asarray(assembly.matrix(0.0, 1.0, state.q, lam, amplitudes, out=out))

    def stress_stiffness(self, q: Vector, out: Vector, work: Vector) -> Vector:
        """Return the part of the stiffness that the stress of the elements makes."""
        assembly = self.system.assembly
        rest = np.zeros(self.system.n_multipliers), self._amplitudes_at(0.0)
        values = np.asarray(assembly.matrix(0.0, 1.0, q, *rest, out=out))
        values -= assembly.material(0.0, 1.0, q, out=work)
        return values

    def _material(self, state: StaticState) -> Vector | None:
        """Return the diagonal of the stiffness without stress and multipliers, for rigid bodies."""
        if not self._penalties.rigid:
            return None
        values = self.system.assembly.material(0.0, 1.0, state.q)
        return np.asarray(values)[self.system.pattern.indptr[: self.system.n_free]]

    def factor(
        self, state: StaticState, values: Vector, load: float, shift: float = 0.0
    ) -> int | None:
        """Factor a stiffness with springs and, on the diagonal, `shift` [1/s2] times the mass.

        Returns
        -------
        int or None
            Number of negative pivots, of a seed that is incomplete at least so many; None if it is
            singular.
        """
        kept = values[self._keep]
        if self._keys is not None:
            import scipy.sparse as sp

            own, kept = kept, np.zeros(len(self._keys))
            kept[self._own] = own
            self._phi_q = phi_q = self._jacobian(state.q)
            diagonal = kept[self._indptr[:-1]]
            self._springs = self._penalties.springs(phi_q, diagonal, self._material(state))
            added = sp.coo_array(sp.tril(phi_q.T @ sp.diags_array(self._springs) @ phi_q))
            keys = added.coords[1].astype(np.int64) * len(diagonal) + added.coords[0]
            np.add.at(kept, np.searchsorted(self._keys, keys), added.data)
        if shift > 0.0:
            kept = kept.copy()
            kept[self._indptr[:-1]] += shift * self.mass
        self.stats.factorizations += 1
        self._on_factor()
        if self._unsymmetric is not None:
            self._beside = self._unsymmetric.stiffness(state.q, self._amplitudes_at(load))
        if isinstance(self.seed, DeflatedSeed):
            assert self._modes is not None
            self.seed.factor(kept, self._modes.at(state.q))
            # Only a solution finds out whether the matrix is definite.
            self._ready = state, self._solution(state)
        elif self.seed.factor(kept) == 0:
            return 0
        self.stats.indefinite += self.seed.negative_pivots != 0
        return self.seed.negative_pivots

    def correction(self, state: StaticState) -> tuple[Vector, Vector]:
        """Return what the last factor takes for the error of coordinates and multipliers."""
        if self._ready is not None and self._ready[0] is state:
            dx = self._ready[1]
        else:
            dx = self._solution(state)
        if not len(state.phi):
            return dx, state.phi
        return dx, self._springs * (state.phi + self._phi_q @ dx)

    def _solution(self, state: StaticState) -> Vector:
        """Return what the last factor takes for the error of the coordinates."""
        self.stats.solves += 1
        r = state.r
        if len(state.phi):
            r = r + self._phi_q.T @ (self._springs * state.phi)
        if self._beside is not None and self._beside.nnz:
            x = solve_with_correction(self.seed.solve, self._beside, r, np.sqrt(self.mass))
            if x is not None:
                return -x
        return -self.seed.solve(r)

    def rounding(self, state: StaticState, load: float) -> Vector:
        """Return the rounding of every unbalanced force [N, N m]."""
        if self._rounded is None or self._rounded[0] is not state.q:
            values = self.stiffness(state, load)
            self._rounded = state.q, self.rounding_of(values, state.q, state.lam)
        return self._rounded[1]

    def lost_in_rounding(self) -> bool:
        """Whether forces may round by more than the loads, however the scene is turned."""
        q = np.full(self.system.n_all, self.span)
        q[self.slopes] = 1.0
        rounding = self.size_of_forces(self.rounding_of(self.stiffness(self.start, 0.0), q))
        return rounding > self.loads + self._stress_at_start

    def negative_pivots(self, counted: int) -> int:
        """Return the number of negative pivots that were counted, of the last matrix.

        One that is not factored exactly is tried with a random force beside, which has a share of
        every direction.
        """
        if isinstance(self.seed, DeflatedSeed) and counted == 0:
            force = np.random.default_rng(1).standard_normal(len(self.mass)) * np.sqrt(self.mass)
            self.stats.solves += 1
            self.seed.solve(force)
            return self.seed.negative_pivots
        return counted

    def noise(self, state: StaticState, load: float) -> Vector:
        """Return how far rounding of the forces moves the bodies, by the last factor [m]."""
        rounding = self.rounding(state, load)
        sign = np.random.default_rng(0).choice([-1.0, 1.0], len(rounding))
        self.stats.solves += 1
        return self.distances(self.seed.solve(sign * rounding))

    def _is_met(self, state: StaticState) -> bool:
        """Whether rounding is all that violates the constraints."""
        if not len(state.phi):
            return True
        span = np.max(np.abs(state.q[self._positions]))
        sizes = span + self.system.constraints.sizes(state.q)
        return bool(np.all(np.abs(state.phi) <= ROUNDING * EPSILON * sizes))

    def is_balanced(self, state: StaticState, load: float, tolerance: float) -> bool:
        """Whether what is unbalanced is a small share of the loads, or rounding."""
        if not self._is_met(state):
            return False
        allowed = tolerance * (self._share(load) * self.loads + self._stress_at_start)
        left = self.size_of_forces(state.r)
        if left <= allowed or left > self._most_rounding:
            return left <= allowed
        excess = np.maximum(np.abs(state.r) - self.rounding(state, load), 0.0)
        return self.size_of_forces(excess) <= allowed


def _strings(system: System) -> tuple[NDArray[np.int32], Vector] | None:
    """Return the places of both ends of all elements without slopes, and their lengths [m]."""
    bodies = [body for body in system.scene.beams if body.kind.is_string]
    if not bodies:
        return None
    ends = [system.elements(body).reshape(body.n_elements, 2, -1) for body in bodies]
    return np.concatenate(ends), np.concatenate([body.lengths for body in bodies])
