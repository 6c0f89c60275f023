"""A system as first-order equations, for integrators that are independent of mechanics."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.integrate import solve_ivp
from scipy.sparse import csc_array

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.seeds import SparseSeed
from ancfsparse.system import System

# Right-hand sides between two reports of progress.
REPORT_EVERY = 500


class FirstOrder:
    """``y' = f(t, y)`` with ``y = (q, v)`` over the free coordinates of a system.

    The force is the compiled one that the Newmark method uses, and the mass matrix is factored
    once, so that a comparison of integrators compares integrators.

    Parameters
    ----------
    system : System
        Without multipliers, under constant loads: its joints eliminate coordinates.

    Attributes
    ----------
    y0 : (2 n_free,) float
        The state at t = 0 [m, m/s].
    system : System
        The system.
    mass : SparseSeed
        The factor of its mass matrix.
    mass_values : (n_values,) float
        That matrix, on the pattern of the system.
    amplitudes : (n_amplitudes,) float
        Of its changing loads at t = 0, where they stay.
    """

    def __init__(self, system: System) -> None:
        if system.n_multipliers:
            raise InputError(
                "only a system without multipliers is an ordinary differential equation: make its "
                "joints without multipliers, as_constraint=False"
            )
        self.system = system
        self._n = n = system.n_free
        self._assembly = system.assembly
        self._force = system.assembly.force
        self._pattern = system.pattern.indices, system.pattern.indptr
        self._load = system.dead_load[:n]
        self._q = system.q0.copy()
        self.amplitudes = system.loads.amplitudes(np.zeros(1))[0]
        self._zero = np.zeros(0), self.amplitudes
        self.mass_values = system.assembly.matrix(1.0, 0.0, system.q0, *self._zero)
        self.mass = SparseSeed(system.pattern.indptr, system.pattern.indices, n)
        self.mass.factor(self.mass_values)
        self.y0 = np.concatenate([system.q0[:n], system.v0[:n]])

    def __call__(self, t: float, y: Vector) -> Vector:
        """Return y', shape (2 n_free,), with accelerations ``M^-1 (f - Q(q))``."""
        n = self._n
        self._q[:n] = y[:n]
        rate = np.empty(2 * n)
        rate[:n] = y[n:]
        rate[n:] = self.mass.solve(self._load - self._force(self._q)[:n])
        return rate

    def jacobian(self, t: float, y: Vector) -> Vector:
        """Return dy'/dy, dense (2 n_free, 2 n_free), from the generated tangent stiffness."""
        n = self._n
        self._q[:n] = y[:n]
        stiffness = self._dense(self._assembly.matrix(0.0, 1.0, self._q, *self._zero))
        jacobian = np.zeros((2 * n, 2 * n))
        jacobian[:n, n:] = np.eye(n)
        jacobian[n:, :n] = -self._inverse_mass @ stiffness
        return jacobian

    @cached_property
    def _inverse_mass(self) -> Vector:
        return np.asarray(np.linalg.inv(self._dense(self.mass_values)), dtype=np.float64)

    def _dense(self, values: Vector) -> Vector:
        """Spread the lower triangle of a symmetric matrix."""
        lower = csc_array((values, *self._pattern), shape=(self._n, self._n)).toarray()
        return np.asarray(lower + np.tril(lower, -1).T)

    def coordinates(self, y: Vector) -> Vector:
        """Return full coordinate vectors (k, n_all) for states (2 n_free, k)."""
        q = np.tile(self._q, (y.shape[1], 1))
        q[:, : self._n] = y[: self._n].T
        return q


class OutOfTimeError(Exception):
    """An integrator took longer than it was given."""


@dataclass(frozen=True)
class OdeRun:
    """The solution of an integrator."""

    q: Vector  # (k, n_all), coordinates at the output times
    seconds: float  # wall time of the integration [s]
    evaluations: int  # evaluations of the right-hand side
    counts: dict[str, int] = field(default_factory=dict)  # Jacobians and factorizations


def integrate(
    equations: FirstOrder,
    method: str,
    t: Vector,
    rtol: float,
    atol: float,
    cap: float = np.inf,
    on_time: Callable[[float], None] | None = None,
    with_jacobian: bool = False,
) -> OdeRun:
    """Run one of SciPy's integrators against the clock.

    Parameters
    ----------
    equations : FirstOrder
        The right-hand side and the start.
    method : str
        As `scipy.integrate.solve_ivp` calls it.
    t : (k,) float
        Times to report [s], from the first to the last.
    rtol, atol, cap : float
        Relative and absolute tolerance, and the wall time that it may take [s].
    on_time : callable, optional
        Called with the simulated time now and then.
    with_jacobian : bool, optional
        True to give an implicit method the Jacobian instead of differences.

    Raises
    ------
    OutOfTimeError
        When the cap is reached.
    RuntimeError
        When the integrator gives up.
    """
    evaluations = 0
    begin = time.perf_counter()

    def watched(now: float, y: Vector) -> Vector:
        nonlocal evaluations
        evaluations += 1
        if time.perf_counter() - begin > cap:
            raise OutOfTimeError(f"{method} took longer than {cap:g} s")
        if on_time is not None and evaluations % REPORT_EVERY == 0:
            on_time(now)
        return equations(now, y)

    given = {"jac": equations.jacobian} if with_jacobian else {}
    solution = solve_ivp(
        watched, (t[0], t[-1]), equations.y0, method=method, t_eval=t, rtol=rtol, atol=atol, **given
    )
    seconds = time.perf_counter() - begin
    if not solution.success:
        raise RuntimeError(f"{method} gave up: {solution.message}")
    return OdeRun(
        equations.coordinates(solution.y),
        seconds,
        evaluations,
        {"jacobians": int(solution.njev), "factorizations": int(solution.nlu)},
    )
