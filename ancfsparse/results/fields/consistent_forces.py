"""Multipliers and accelerations that satisfy the equations of motion with prescribed motions."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.seeds import SparseSeed
from ancfsparse.system.coordinates.constraint_terms import Gradients
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.system import System

N_REFINEMENTS = 6  # solutions with one factor; each gains the digits that regularization costs
MAX_REFINEMENTS = 100  # with friction by joint forces, which each solution changes
REFINEMENT_TOLERANCE = 1e-12  # change of the multipliers by the last solution, over the largest
VELOCITY_TOLERANCE = 1e-6  # relative change by the last solution; regularization loses a part of it
# Of the constraint block, over phi_q M^-1 phi_q^T.  Redundant multipliers change by the error of
# saved accelerations over it: with 1e-10 by 7e3 N in a driven Bricard mechanism, with 1e-6 by 1 N.
REGULARIZATION = 1e-6


def recover_forces(system: System, states: StateHistory) -> StateHistory:
    """Return states whose velocities and accelerations satisfy prescribed ones, and multipliers.

    Implicit steps satisfy constraints in position.  Their accelerations across them differ from
    prescribed ones: after a jump of the third derivative by an amount of first order.  Velocities
    across them differ by the error of the iteration over the step, which adds up without numerical
    dissipation.  So velocities are projected onto ``phi_q v = s'``, and the equations of motion are
    solved with ``phi_q a = s'' - (phi_q v)_q v`` for all forces at the saved times.

    Parameters
    ----------
    system : System
        The moving system.
    states : StateHistory
        Its states.
    """
    v, a, lam = (np.array(table) for table in (states.v, states.a, states.lam))
    first, first_equation = (
        system.n_all - system.prescribed.n,
        system.n_multipliers - system.prescribed.n_equations,
    )
    solver = _ConstrainedSolver(system)
    amplitudes = system.loads.amplitudes(states.t)
    motion = system.prescribed.history(states.t)
    a[:, first:] = motion.a
    for k, q in enumerate(states.q):
        system.set_history(states.internal[k])
        solver.factor(q, lam[k], amplitudes[k])
        rate = np.zeros(system.n_multipliers)
        rate[first_equation:] = motion.s_rate[k]
        solver.project(v[k], rate)
        rate = -system.constraints.curvature(q, v[k])
        rate[first_equation:] += motion.s_second[k]
        solver.solve_motion(q, v[k], a[k], lam[k], rate, amplitudes[k])
    return states._replace(v=v, a=a, lam=lam)


class _ConstrainedSolver:
    """Solve with ``M`` and ``phi_q`` of one state after the other."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
        self._diagonal = np.asarray(system.pattern.indptr[:-1])
        self._factored = np.empty(0)
        self._phi_q: Gradients

    def factor(self, q: Vector, lam: Vector, amplitudes: Vector) -> None:
        """Factor the matrix of a state, if it differs from that of the last."""
        system, n, diagonal = self._system, self._system.n_free, self._diagonal
        self._phi_q = phi_q = system.constraints.gradients(q)
        values = np.array(system.assembly.matrix(1.0, 0.0, q, lam, amplitudes))
        flexible = np.zeros(system.n_all)
        flexible[:n] = 1.0 / values[diagonal[:n]]
        squares = phi_q.values**2 * flexible[phi_q.columns]
        values[diagonal[n:]] = -REGULARIZATION * self._sum_by_row(squares)
        if not np.array_equal(values, self._factored):
            self._seed.factor(values)
            self._factored = values

    def _times_gradients(self, x: Vector) -> Vector:
        return self._sum_by_row(self._phi_q.values * x[self._phi_q.columns])

    def _sum_by_row(self, entries: Vector) -> Vector:
        sums = np.bincount(self._phi_q.rows, entries, minlength=self._system.n_multipliers)
        return np.asarray(sums, dtype=np.float64)

    def project(self, v: Vector, rate: Vector) -> None:
        """Change velocities in place until ``phi_q v = rate``, least in the norm of the mass."""
        n = self._system.n_free
        for _ in range(N_REFINEMENTS):
            change = self._seed.solve(
                np.concatenate([np.zeros(n), rate - self._times_gradients(v)])
            )[:n]
            v[:n] += change
            if np.max(np.abs(change), initial=0.0) <= VELOCITY_TOLERANCE * np.max(np.abs(v)):
                break

    def solve_motion(
        self, q: Vector, v: Vector, a: Vector, lam: Vector, rate: Vector, amplitudes: Vector
    ) -> None:
        """Change accelerations and multipliers in place until the residual vanishes."""
        system, n = self._system, self._system.n_free
        state = q, v, a, lam, system.dead_load, amplitudes
        n_refinements = MAX_REFINEMENTS if system.depends_on_reactions else N_REFINEMENTS
        for _ in range(n_refinements):
            force = -system.assembly.residual(*state)[0][:n]
            change = self._seed.solve(np.concatenate([force, rate - self._times_gradients(a)]))
            a[:n] += change[:n]
            lam += change[n:]
            largest = np.max(np.abs(lam), initial=0.0)
            if np.max(np.abs(change[n:]), initial=0.0) <= REFINEMENT_TOLERANCE * largest:
                break
