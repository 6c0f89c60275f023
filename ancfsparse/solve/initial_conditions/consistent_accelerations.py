"""Accelerations at the start of a motion, and their rate."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.seeds import Seed
from ancfsparse.system import System

Vector = NDArray[np.float64]

# A motion over which differences of stiff forces are taken, over the size of what moves: the cube
# root of rounding, where a central difference is best.
DIFFERENCE_RATIO = 6e-6
# Turns between friction and the forces of joints at the start, at most, and when they have settled.
MAX_FRICTION_ITERATIONS, FRICTION_TOLERANCE = 100, 1e-12


def initial_acceleration(system: System, seed: Seed, v: Vector) -> tuple[Vector, Vector]:
    """Solve ``M a + phi_q^T lam = f - Q``, ``phi_q a = -(phi_q v)_q v`` at the initial places.

    Parameters
    ----------
    system : System
        At its initial state.
    seed : SparseSeed or IncompleteSeed
        With the factor of the mass matrix.
    v : (n_all,) float
        Velocities [m/s, 1/s].

    Returns
    -------
    a : (n_all,) float
        Accelerations [m/s2, 1/s2], zero at fixed coordinates.
    lam : (m,) float
        Multipliers [N].

    Raises
    ------
    InputError
        If they leave the range of floating-point numbers.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        force = -_forces(system, system.q0, v, np.zeros(system.n_multipliers), 0.0)
        rate = -system.constraints.curvature(system.q0, v)
        if system.prescribed:
            now = system.prescribed.at(system.t0)
            rate += prescribed_rate_terms(system, now.a, now.s_second)
        a, lam = solve_constrained(system, seed, force, rate)
        if system.reacts:
            a, lam = _with_friction(system, seed, v, force, rate, lam)
        if system.prescribed.n:
            a[-system.prescribed.n :] = now.a
    if np.isfinite(a).all() and np.isfinite(lam).all():
        return a, lam
    if np.isfinite(rate).all():
        i = index_of_largest(force)
        raise range_error(f"the force at {system.describe(i)} is {force[i]:.3g} {system.unit(i)}")
    i = index_of_largest(rate)
    label = system.constraints.labels[i]
    raise range_error(f"the {label} would need an acceleration of {rate[i]} m/s2")


def _with_friction(
    system: System, seed: Seed, v: Vector, force: Vector, rate: Vector, lam: Vector
) -> tuple[Vector, Vector]:
    """Return what `initial_acceleration` does, with friction by forces of joints.

    Forces and multipliers are found in turn; each turn changes less by the coefficient of friction.
    """
    gradients, none = system.constraints.jacobian(system.q0), np.zeros(system.n_multipliers)
    bare = _forces(system, system.q0, v, none, 0.0)
    for _ in range(MAX_FRICTION_ITERATIONS):
        friction = _forces(system, system.q0, v, lam, 0.0) - bare - gradients.T @ lam
        before, (a, lam) = lam, solve_constrained(system, seed, force - friction, rate)
        if np.max(np.abs(lam - before)) <= FRICTION_TOLERANCE * np.max(np.abs(lam)):
            break
    return a, lam


def initial_jerk(
    system: System, seed: Seed, v: Vector, a: Vector, lam: Vector, dt: float
) -> Vector:
    """Return the rate of the accelerations at the start, (n_all,) [m/s3, 1/s3].

    The equations of motion and the twice differentiated constraints are differentiated once more.
    The rate of the loads is their change in the first step, which is all that the steps contain of
    them: one that turns, or jumps, within the step has another rate at the start, by which it would
    throw the body away.  All other forces are differentiated by a central difference over a motion
    of some millionths: over a hundredth of a long step a stiff bar that turns stretches by more
    than it ever will.

    Parameters
    ----------
    system, seed, v
        As `initial_acceleration` takes them.
    a, lam
        As it returns them.
    dt : float
        Time step [s].
    """
    reach = 1e-2 * dt
    near = min(reach, DIFFERENCE_RATIO / max(_relative_rate(system, v), DIFFERENCE_RATIO / reach))
    ahead, behind = (_forces(system, system.q0 + t * v, v + t * a, lam, 0.0) for t in (near, -near))
    rate = (ahead - behind) / (2.0 * near)
    if system.loads.n_amplitudes or system.prescribed.n:
        later, now = (_forces(system, system.q0, v, lam, t) for t in (dt, 0.0))
        rate += (later - now) / dt
    bent = -_third_derivative_terms(system, v, a)
    if system.prescribed:
        first, last = (system.prescribed.at(system.t0 + t) for t in (0.0, dt))
        bent += prescribed_rate_terms(
            system, (last.a - first.a) / dt, (last.s_second - first.s_second) / dt
        )
    return solve_constrained(system, seed, -rate, bent)[0]


def _third_derivative_terms(system: System, v: Vector, a: Vector) -> Vector:
    """Return ``3 v.phi_qq.a`` at the start, what moves constraints are bent by, (m,) [m/s3].

    By polarization of the curvature, which is quadratic; over a time in which the accelerations
    make velocities like the initial ones, or the smaller would be lost beside the larger.  To it
    comes the third derivative of equations that are not quadratic.
    """
    inertia, bent = system.assembly.inertia, system.constraints.curvature
    curvature = partial(bent, system.q0)
    third = np.zeros(system.n_multipliers)
    if system.constraints.measures and v.any():
        near = DIFFERENCE_RATIO / _relative_rate(system, v)
        third = (bent(system.q0 + near * v, v) - bent(system.q0 - near * v, v)) / (2.0 * near)
    if not v.any() or not a.any():
        return third
    # Powers of two keep squares in the range of numbers and change no digit.
    speed, push = (math.ldexp(1.0, math.frexp(np.max(np.abs(x)))[1]) for x in (v, a))
    moving = float(v / speed @ inertia(v / speed))
    pushed = float(a / push @ inertia(a / push))
    if moving == 0.0 or pushed == 0.0:
        return third
    time = math.sqrt(moving / pushed) * (speed / push)
    return third + 0.75 / time * (curvature(v + time * a) - curvature(v - time * a))


def _relative_rate(system: System, v: Vector) -> float:
    """Return how fast the scene moves by its own size, or a slope by its own length [1/s]."""
    places = system.positions
    slopes = np.ones(system.n_all, dtype=bool)
    slopes[places] = False
    speed, size = (np.max(np.abs(x[places])) for x in (v, system.q0))
    size = max(size, *(body.shortest for body in system.scene.bodies))
    return float(max(speed / size, np.max(np.abs(v[slopes]), initial=0.0)))


def load_amplitudes_at_start(system: System, later: float = 0.0) -> Vector:
    """Return the amplitudes of the loads at the start, or so much later [s]."""
    return np.asarray(system.loads.amplitudes(np.array([system.t0 + later]))[0])


def _forces(system: System, q: Vector, v: Vector, lam: Vector, later: float) -> Vector:
    """Return what must balance M a: internal and constraint forces less the loads, (n_all,) [N].

    Among the former is the inertia of what is prescribed.
    """
    amplitudes = load_amplitudes_at_start(system, later)
    rest = np.zeros(system.n_all)
    if system.prescribed.n:
        rest[-system.prescribed.n :] = system.prescribed.at(system.t0 + later).a
    return np.asarray(system.assembly.residual(q, v, rest, lam, system.dead_load, amplitudes)[0])


def prescribed_rate_terms(system: System, driven: Vector, followed: Vector) -> Vector:
    """Return what is left of rates for the free coordinates, by equation, (m,).

    Parameters
    ----------
    system : System
        At its initial state.
    driven : (n,) float
        Rates of the driven coordinates.
    followed : (n_equations,) float
        Rates that the led equations are to have.
    """
    rates = np.zeros(system.n_all)
    rates[system.n_all - len(driven) :] = driven
    out = np.asarray(-(constraint_gradients(system) @ rates))
    out[system.n_multipliers - len(followed) :] += followed
    return out


def forces_of_prescribed_rates(
    system: System, driven: Vector, stiffness: float, damping: float
) -> Vector:
    """Return the forces of stiffness and damping against rates of driven coordinates, (n_all,).

    Parameters
    ----------
    system : System
        At its initial state.
    driven : (n_all,) float
        The rates, zero but for driven coordinates.
    stiffness, damping : float
        Factors of both.
    """
    out = np.zeros(system.n_all)
    if damping and system.damped:
        out += damping * system.assembly.damping(system.q0, driven)
    if stiffness:
        shortest = min(body.shortest for body in system.scene.bodies)
        small = DIFFERENCE_RATIO * shortest / float(np.max(np.abs(driven)))
        force = system.assembly.force
        ahead, behind = (force(system.q0 + sign * small * driven) for sign in (1.0, -1.0))
        out += stiffness / (2.0 * small) * (ahead - behind)
    return out


def prescribed_values_at_start(system: System) -> tuple[Vector, Vector]:
    """Return what the equations are to have at the start, and its rate, (m,) [m, m/s]."""
    values, rates = np.zeros(system.n_multipliers), np.zeros(system.n_multipliers)
    if system.prescribed.n_equations:
        now = system.prescribed.at(system.t0)
        values[-len(now.s) :], rates[-len(now.s) :] = now.s, now.s_rate
    return values, rates


def constraint_gradients(system: System) -> Any:
    """Return phi_q at the start, a sparse matrix (m, n_all)."""
    return system.constraints.jacobian(system.q0)


def solve_constrained(
    system: System, seed: Seed, force: Vector, rate: Vector
) -> tuple[Vector, Vector]:
    """Solve ``M x + phi_q^T mu = force``, ``phi_q x = rate``; refined, since the factor is near."""
    n, m = system.n_free, system.n_multipliers
    x, mu = np.zeros(system.n_all), np.zeros(m)
    if not m:
        x[:n] = seed.solve(force[:n])
        return x, mu
    phi_q = constraint_gradients(system)
    for _ in range(3):
        top = force - system.assembly.inertia(x) - phi_q.T @ mu
        correction = seed.solve(np.concatenate([top[:n], rate - phi_q @ x]))
        x[:n] += correction[:n]
        mu += correction[n:]
    return x, mu


def range_error(where: str) -> InputError:
    """Return the error for a start whose numbers are too large somewhere."""
    return InputError(
        f"the motion leaves the range of floating-point numbers at its start, where {where}: check "
        "the units of loads, velocities and stiffness, which are SI"
    )


def index_of_largest(values: Vector) -> int:
    """Return the place of what is not a number, or else of the largest."""
    return int(np.argmax(np.nan_to_num(np.abs(values), nan=np.inf)))
