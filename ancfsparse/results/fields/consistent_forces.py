"""Multipliers and accelerations of equations of motion that have a prescribed acceleration."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.seeds import SparseSeed
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.system import System

if TYPE_CHECKING:
    import scipy.sparse as sp

N_REFINEMENTS = 3  # solutions with one factor; each gains the digits that regularization costs
MAX_REFINEMENTS = 100  # with friction by joint forces, which each solution changes
REFINEMENT_TOLERANCE = 1e-12  # change of the multipliers by the last solution, over the largest
# Of the constraint block, over phi_q M^-1 phi_q^T.  Redundant multipliers change by the error of
# saved accelerations over it: with 1e-10 by 7e3 N in a driven Bricard mechanism, with 1e-6 by 1 N.
REGULARIZATION = 1e-6


def recover_forces(system: System, states: StateHistory, saves_means: bool) -> StateHistory:
    """Return states with accelerations that satisfy prescribed ones, and their multipliers.

    Implicit steps satisfy constraints in position, so their accelerations across them differ from
    prescribed ones: after a jump of the third derivative by an amount of first order.  Here
    ``phi_q a = s'' - (phi_q v)_q v`` holds at the saved coordinates and velocities, which are of
    second order, and the multipliers balance the change of ``M a``.

    Parameters
    ----------
    system : System
        The moving system.
    states : StateHistory
        Its states.
    saves_means : bool
        True if accelerations and multipliers are means over the step before.  Then they are
        replaced by the solution for all forces at the saved times.
    """
    a, lam = np.array(states.a), np.array(states.lam)
    first, first_equation = (
        system.n_all - system.prescribed.n,
        system.n_multipliers - system.prescribed.n_equations,
    )
    solver = _ConstrainedSolver(system)
    amplitudes = system.loads.amplitudes(states.t)
    motion = system.prescribed.history(states.t)
    a[:, first:] = motion.a
    for k, (q, v) in enumerate(zip(states.q, states.v, strict=True)):
        rate = -system.constraints.curvature(q, v)
        rate[first_equation:] += motion.s_second[k]
        solver.correct(q, v, a[k], lam[k], rate, amplitudes[k], keeps_residual=not saves_means)
    return StateHistory(states.q, states.v, a, lam, states.t)


class _ConstrainedSolver:
    """Solve ``M a + phi_q^T lam = f``, ``phi_q a = rate`` for one state after the other."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
        self._diagonal = np.asarray(system.pattern.indptr[:-1])
        self._factored = np.empty(0)

    def correct(
        self,
        q: Vector,
        v: Vector,
        a: Vector,
        lam: Vector,
        rate: Vector,
        amplitudes: Vector,
        keeps_residual: bool,
    ) -> None:
        """Correct accelerations and multipliers of a state in place."""
        system, n = self._system, self._system.n_free
        phi_q = system.constraints.jacobian(q)
        self._factor(q, lam, amplitudes, phi_q[:, :n])
        state = q, v, a, lam, system.dead_load, amplitudes
        retained = system.assembly.residual(*state)[0][:n] if keeps_residual else np.zeros(n)
        n_refinements = MAX_REFINEMENTS if system.depends_on_reactions else N_REFINEMENTS
        for _ in range(n_refinements):
            force = retained - system.assembly.residual(*state)[0][:n]
            change = self._seed.solve(np.concatenate([force, rate - phi_q @ a]))
            a[:n] += change[:n]
            lam += change[n:]
            largest = np.max(np.abs(lam), initial=0.0)
            if np.max(np.abs(change[n:]), initial=0.0) <= REFINEMENT_TOLERANCE * largest:
                break

    def _factor(self, q: Vector, lam: Vector, amplitudes: Vector, phi_q: sp.csr_array) -> None:
        """Factor the matrix of a state, if it differs from that of the last."""
        system, n, diagonal = self._system, self._system.n_free, self._diagonal
        values = np.array(system.assembly.matrix(1.0, 0.0, q, lam, amplitudes))
        values[diagonal[n:]] = -REGULARIZATION * (phi_q.power(2) @ (1.0 / values[diagonal[:n]]))
        if not np.array_equal(values, self._factored):
            self._seed.factor(values)
            self._factored = values
