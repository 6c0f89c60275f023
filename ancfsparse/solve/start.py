"""Consistent start of a motion: what balances the initial state, and what an integrator needs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.march import Start
from ancfsparse.seeds import SparseSeed
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Share of the smallest phi_q M^-1 phi_q^T by which the constraint block is made definite.
REGULARIZATION = 1e-10


def regularize(system: System, scale: float) -> None:
    """Give the constraint block its small negative diagonal, so that L D L^T always exists.

    Parameters
    ----------
    system : System
        Its assembly is told the value.
    scale : float
        Factor of the stiffness in the matrix, beta dt^2 [s2].
    """
    if not system.n_multipliers:
        return
    lam = np.zeros(system.n_multipliers)
    amplitudes = system.loads.amplitudes(np.zeros(1))[0]
    values = system.assembly.matrix(1.0, scale, system.q0, lam, amplitudes)
    diagonal = values[system.pattern.indptr[: system.n_free]]
    phi_q = system.constraints.jacobian(system.q0)[:, : system.n_free]
    system.assembly.set_regularization(REGULARIZATION * np.min(phi_q.power(2) @ (1.0 / diagonal)))


def check_constraints(system: System) -> None:
    """Refuse a start that violates the constraints or their rates.

    Raises
    ------
    InputError
        With the worst equation and by how much.
    """
    if not system.n_multipliers:
        return
    rest, lam = np.zeros(system.n_all), np.zeros(system.n_multipliers)
    amplitudes = system.loads.amplitudes(np.zeros(1))[0]
    _, phi = system.assembly.residual(system.q0, system.v0, rest, lam, system.dead_load, amplitudes)
    rate = system.constraints.jacobian(system.q0) @ system.v0
    for values, unit, what in ((phi, "m", "positions"), (rate, "m/s", "velocities")):
        worst = int(np.argmax(np.abs(values)))
        size = 1e-9 * max(1.0, float(np.max(np.abs(system.q0))), float(np.max(np.abs(system.v0))))
        if abs(values[worst]) > size:
            raise InputError(
                f"the initial {what} break the {system.constraints.labels[worst]} by "
                f"{values[worst]:.3g} {unit}: move the start or the joint so that they agree"
            )


def starting_state(system: System, seed: SparseSeed, integrator: Implicit, dt: float) -> Start:
    """Return the state from which an integrator is of second order from its first step on.

    The integrator's own acceleration is that at the time it looks ahead to; and where constraints
    prescribe a motion, the velocity across them is the one that Newmark's formulas give a smooth
    motion (`Implicit.velocity_constant`).  Without that, multipliers oscillate with an amplitude of
    first order, and those of the trapezoidal rule for ever.

    Parameters
    ----------
    system : System
        At its initial state ``q0``, ``v0``.
    seed : SparseSeed
        On the pattern of the system; it is left with a factor that is of no use later.
    integrator : Implicit
        The weights.
    dt : float
        Time step [s].
    """
    v, amplitudes = system.v0, system.loads.amplitudes(np.zeros(1))[0]
    lam = np.zeros(system.n_multipliers)
    seed.factor(system.assembly.matrix(1.0, 0.0, system.q0, lam, amplitudes))
    a, lam = initial_acceleration(system, seed)
    b = a
    if integrator.shift != 0.0 or system.n_multipliers:
        jerk = initial_jerk(system, seed, a, lam, 1e-2 * dt)
        if system.n_multipliers:
            rate = integrator.velocity_constant * dt**2 * (_phi_q(system) @ jerk)
            change, _ = _solve(system, seed, np.zeros(system.n_all), rate)
            v = v + change
        if integrator.shift != 0.0:
            scale = integrator.scale * dt**2
            seed.factor(system.assembly.matrix(1.0, scale, system.q0, lam, amplitudes))
            b = a + integrator.shift * dt * resolved(system, seed, jerk)
    return Start(system.q0, v, a, b, lam, amplitudes)


def resolved(system: System, seed: SparseSeed, rate: Vector) -> Vector:
    """Return the part of a rate of accelerations that a step can follow, (n_all,) [m/s3, 1/s3].

    ``S^-1 M``, S the matrix of the step, leaves slow modes alone and takes modes of dt omega >> 1
    for what they are: stiff, and at rest but for what the start throws into them.  The part across
    constraints stays what it is.

    Parameters
    ----------
    system : System
        At its initial state.
    seed : SparseSeed
        With the factor of the matrix of a step.
    rate : (n_all,) float
        All of it.
    """
    n = system.n_free
    force = np.concatenate([system.assembly.inertia(rate)[:n], _phi_q(system) @ rate])
    out = np.zeros(system.n_all)
    out[:n] = seed.solve(force)[:n]
    return out


def initial_acceleration(system: System, seed: SparseSeed) -> tuple[Vector, Vector]:
    """Solve ``M a + phi_q^T lam = f - Q``, ``phi_q a = -(phi_q v)_q v`` at the initial state.

    Parameters
    ----------
    system : System
        At its initial state ``q0``, ``v0``.
    seed : SparseSeed
        With the factor of the mass matrix.

    Returns
    -------
    a : (n_all,) float
        Accelerations [m/s2, 1/s2], zero at fixed coordinates.
    lam : (m,) float
        Multipliers [N].
    """
    force = -_forces(system, system.q0, system.v0, np.zeros(system.n_multipliers), 0.0)
    return _solve(system, seed, force, -system.constraints.curvature(system.v0))


def initial_jerk(system: System, seed: SparseSeed, a: Vector, lam: Vector, reach: float) -> Vector:
    """Return the rate of the accelerations at the start, (n_all,) [m/s3, 1/s3].

    The equations of motion and the twice differentiated constraints are differentiated once more,
    the forces by a one-sided difference, since loads may not be defined before the start.

    Parameters
    ----------
    system, seed, a, lam
        As `initial_acceleration` takes and gives them.
    reach : float
        Time between the points of the difference [s].
    """
    forces = [
        _forces(system, system.q0 + t * system.v0 + 0.5 * t**2 * a, system.v0 + t * a, lam, t)
        for t in (0.0, reach, 2.0 * reach)
    ]
    rate = (-3.0 * forces[0] + 4.0 * forces[1] - forces[2]) / (2.0 * reach)
    # Quadratic constraints: 0 = phi_q jerk + 3 v.phi_qq.a, the last by polarization.
    curvature = system.constraints.curvature
    bent = 0.75 * (curvature(system.v0 + a) - curvature(system.v0 - a))
    return _solve(system, seed, -rate, -bent)[0]


def _forces(system: System, q: Vector, v: Vector, lam: Vector, t: float) -> Vector:
    """Return what must balance M a: internal and constraint forces less the loads, (n_all,) [N]."""
    amplitudes = system.loads.amplitudes(np.array([t]))[0]
    rest = np.zeros(system.n_all)
    return np.asarray(system.assembly.residual(q, v, rest, lam, system.dead_load, amplitudes)[0])


def _phi_q(system: System) -> Any:
    return system.constraints.jacobian(system.q0)


def _solve(system: System, seed: SparseSeed, force: Vector, rate: Vector) -> tuple[Vector, Vector]:
    """Solve ``M x + phi_q^T mu = force``, ``phi_q x = rate``; refined, since the factor is near."""
    n, m = system.n_free, system.n_multipliers
    x, mu, phi_q = np.zeros(system.n_all), np.zeros(m), _phi_q(system)
    for _ in range(3 if m else 1):
        top = force - system.assembly.inertia(x) - phi_q.T @ mu
        correction = seed.solve(np.concatenate([top[:n], rate - phi_q @ x]))
        x[:n] += correction[:n]
        mu += correction[n:]
    return x, mu
