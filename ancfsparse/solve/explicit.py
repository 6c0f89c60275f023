"""Explicit motion: what is refused before it starts, and how it is watched while it lasts."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, Instability
from ancfsparse.integrators.explicit import Explicit, make_explicit
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Trajectory
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.blocks import BlockInverse
from ancfsparse.solve.stability import check_free, fastest_vibration, start_load
from ancfsparse.solve.start import initial_acceleration
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Up to so many operations of a product for each one of a sweep the dense blocks are faster:
# measured on cables of 3 to 60 elements, where they meet at 5.
DENSE_AHEAD = 4.0

# Share of the kinetic and elastic energy that may come from nowhere before a run is stopped, and of
# the potential energy, whose rounding shows while nothing moves yet.
STRAY, ROUNDING = 0.1, 1e-9

# Excess of the step over its limit that the estimate of the limit may cause.
UNCERTAIN = 1e-3


class ExplicitMarch:
    """The compiled loop, looked after: steps come in chunks, and a chunk that diverged is undone.

    Parameters
    ----------
    system : System
        At its initial state.
    dt : float
        Time step [s].
    integrator : CentralDifference or RungeKuttaNystrom
        The method.
    loop : compiled loop
        At the initial state.
    """

    def __init__(self, system: System, dt: float, integrator: Explicit, loop: Any) -> None:
        self._system, self._dt, self._integrator, self._loop = system, dt, integrator, loop
        self._constant = system.loads.n_amplitudes == 0
        self._start = self._energy(system.q0, system.v0)[0] if self._constant else 0.0
        self._steps = 0
        self._trouble = ""

    @property
    def state(self) -> tuple[Vector, ...]:
        """Last accepted ``(q, v, a, lam)`` as copies."""
        state: tuple[Vector, ...] = self._loop.state
        return state

    @property
    def counts(self) -> dict[str, int]:
        """Counts under the names of the nonlinear loop; nothing is iterated."""
        forces = self._steps * self._integrator.tableau.forces
        names = (
            *("iterations", "last_corrections", "indefinite", "skipped_pairs"),
            *("recoveries_reseed", "recoveries_newton"),
        )
        done = {"residual_evaluations": forces, "solves": forces, "factorizations": 1}
        return dict.fromkeys(names, 0) | done

    @property
    def seconds(self) -> dict[str, float]:
        """Time by part: it is not split."""
        return {}

    def advance(
        self,
        _nonlinear: object,
        n_steps: int,
        amplitudes: Vector,
        save_every: int,
        steps_done: int,
        q_out: Vector,
        v_out: Vector,
        a_out: Vector,
        _lam_out: Vector,
    ) -> tuple[int, Outcome]:
        """Take steps; return how many and the outcome: all of them and success, or none.

        Parameters
        ----------
        n_steps, save_every, steps_done : int
            As in the compiled loop.
        amplitudes : (n_steps * forces per step, n_amplitudes) float
            Loads at the times of the stages.
        q_out, v_out, a_out : float arrays
            Where saved states go.
        """
        q, v, a, _ = self._loop.state
        taken = self._loop.advance(n_steps, amplitudes, save_every, steps_done, q_out, v_out, a_out)
        self._steps += taken
        outcome = Outcome.CONVERGED
        if taken < n_steps:
            outcome, self._trouble = Outcome.NOT_FINITE, "the numbers left the range of doubles"
        elif self._strayed(amplitudes[-1]):
            outcome = Outcome.DIVERGED
        if outcome != Outcome.CONVERGED:
            self._loop.restore(q, v, a)
            return 0, outcome
        return taken, outcome

    def failure(self, step: int, path: Trajectory) -> Instability:
        """Say what happened, after `advance` has put the last good state back.

        Parameters
        ----------
        step : int
            Number of the first step that is not to be trusted.
        path : Trajectory
            The states before it.
        """
        q, _, a, _ = self.state
        amplitudes = self._system.loads.amplitudes(np.array([self._dt * (step - 1)]))[0]
        limit = self._integrator.tableau.interval / fastest_vibration(self._system, q, amplitudes)
        force = self._system.assembly.inertia(a)[: self._system.n_free]
        worst = int(np.argmax(np.abs(force)))
        reason = (
            f"{self._trouble}; beams that are stretched vibrate faster, and the stable step, which "
            f"is {limit:.4g} s at t = {self._dt * (step - 1):.6g} s, shrinks with them"
        )
        where = self._system.describe(worst)
        return Instability(reason, self._dt * step, step, self._dt, force[worst], where, path)

    def _strayed(self, amplitudes: Vector) -> bool:
        """Whether the present state cannot be a stable solution.

        Under constant loads the energy tells.  Work of changing loads is not known here; then the
        fastest vibration of the present state tells, since a motion that grows without bound
        stretches the beams.
        """
        q, v, _, _ = self._loop.state
        if self._constant:
            total, moving, potential = self._energy(q, v)
            gain = total - self._start
            if gain <= STRAY * moving + ROUNDING * abs(potential):
                return False
            self._trouble = f"{gain:.3g} J of energy came from nowhere"
            return True
        omega = fastest_vibration(self._system, q, amplitudes)
        if self._dt * omega <= (1.0 + UNCERTAIN) * self._integrator.tableau.interval:
            return False
        self._trouble = f"the fastest vibration has grown to {omega:.4g} rad/s"
        return True

    def _energy(self, q: Vector, v: Vector) -> tuple[float, float, float]:
        """Return all energy, its kinetic and elastic part, and the potential of the loads [J]."""
        kinetic, elastic, _ = self._system.energies(q[None], v[None])
        moving, potential = float(kinetic[0] + elastic[0]), -float(q @ self._system.dead_load)
        return moving + potential, moving, potential


def prepare_explicit(
    system: System,
    dt: float,
    n_steps: int,
    integrator: Explicit,
    solver: object,
    tolerance: object,
) -> tuple[ExplicitMarch, SparseSeed | BlockInverse, str]:
    """Return the march, the inverse of the mass matrix, and a sentence on both.

    Raises
    ------
    InputError
        If there are multipliers, a solver or a tolerance is asked for, or the step is too long.
    """
    for what, value, default in (("solver", solver, "auto"), ("tolerance", tolerance, "default")):
        if value != default:
            raise InputError(
                f"{integrator!r} solves no equations, so {what}={value!r} means nothing: leave it "
                "out, or take an implicit integrator such as Newmark()"
            )
    check_free(system, integrator)
    seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
    omega = fastest_vibration(system, system.q0, start_load(system))
    limit = integrator.tableau.interval / omega
    if dt > limit:
        t_end = n_steps * dt
        enough = float(t_end / np.ceil(t_end / limit))
        raise InputError(
            f"dt = {dt:g} s is above the stable step of {integrator!r}, which is {limit:.4g} s for "
            f"this scene because its fastest vibration has {omega:.4g} rad/s: take "
            f"dt = {enough!r} s ({t_end / enough:.0f} steps) or less, or an implicit integrator "
            "such as Newmark()"
        )
    a, _ = initial_acceleration(system, seed)
    blocks = BlockInverse(system.pattern.indptr, system.pattern.indices, system.assembly.mass)
    dense = blocks.solve_flops <= DENSE_AHEAD * seed.solve_flops
    mass = blocks if dense else seed
    why = (
        f"{integrator!r}: {integrator.tableau.forces} evaluations of the forces per step, "
        f"dt = {dt / limit:.3g} of the stable step {limit:.4g} s (fastest vibration "
        f"{omega:.4g} rad/s); mass matrix "
        f"{'inverted in dense blocks' if dense else 'factored once'}"
    )
    return (
        ExplicitMarch(system, dt, integrator, make_explicit(system, dt, integrator, a, mass)),
        mass,
        why,
    )
