"""Accelerations at the start of a motion, and their rate."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.seeds import Seed


# The cube root of rounding, where a central difference is most accurate.
DIFFERENCE_RATIO = 6e-6  # motion for differences of stiff forces, over the size of the body
# The fourth root of rounding, where a second difference is most accurate.
SECOND_DIFFERENCE_RATIO = 1e-4  # motion for second differences of stiff forces, over that size
MAX_CURVATURE_CHANGE = 0.25  # with twice that motion, relative; at a kink it is a half
MAX_FRICTION_ITERATIONS = 100  # between friction and joint forces
FRICTION_TOLERANCE = 1e-12  # relative change of the multipliers


def initial_acceleration(system: System, seed: Seed, v: Vector) -> tuple[Vector, Vector]:
    """Solve ``M a + phi_q^T lam = f - Q``, ``phi_q a = -(phi_q v)_q v`` at the initial state.

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
        if system.depends_on_reactions:
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
    """Return the solution of `initial_acceleration` with friction by the forces of joints.

    A fixed-point iteration between forces and multipliers; its rate is the friction coefficient.
    """
    gradients, no_multipliers = (
        system.constraints.jacobian(system.q0),
        np.zeros(system.n_multipliers),
    )
    frictionless = _forces(system, system.q0, v, no_multipliers, 0.0)
    for _ in range(MAX_FRICTION_ITERATIONS):
        friction = _forces(system, system.q0, v, lam, 0.0) - frictionless - gradients.T @ lam
        before, (a, lam) = lam, solve_constrained(system, seed, force - friction, rate)
        if np.max(np.abs(lam - before)) <= FRICTION_TOLERANCE * np.max(np.abs(lam)):
            break
    return a, lam


def initial_jerk(
    system: System, seed: Seed, v: Vector, a: Vector, lam: Vector, dt: float
) -> Vector:
    """Return the rate of the accelerations at the start, (n_all,) [m/s3, 1/s3].

    The equations of motion and the twice differentiated constraints are differentiated once more.
    The rate of the loads is their change over the first step, since the steps contain no more of
    it: the initial rate of a load that reverses or jumps within the step would be far too large.
    All other forces are differentiated by a central difference over a relative motion of some
    millionths: over a hundredth of a long step, a stiff rotating bar would stretch by more than it
    ever does.

    Parameters
    ----------
    system, seed, v
        As for `initial_acceleration`.
    a, lam
        Results of `initial_acceleration`.
    dt : float
        Time step [s].
    """
    longest = 1e-2 * dt
    rate = _relative_rate(system, v)
    h = min(longest, DIFFERENCE_RATIO / max(rate, DIFFERENCE_RATIO / longest))
    after, before = (_forces(system, system.q0 + t * v, v + t * a, lam, 0.0) for t in (h, -h))
    force_rate = (after - before) / (2.0 * h)
    if system.loads.n_amplitudes or system.prescribed.n:
        later, now = (_forces(system, system.q0, v, lam, t) for t in (dt, 0.0))
        force_rate += (later - now) / dt
    constraint_rate = -_third_derivative_terms(system, v, a)
    if system.prescribed:
        first, last = (system.prescribed.at(system.t0 + t) for t in (0.0, dt))
        constraint_rate += prescribed_rate_terms(
            system, (last.a - first.a) / dt, (last.s_second - first.s_second) / dt
        )
    return solve_constrained(system, seed, -force_rate, constraint_rate)[0]


def stiff_acceleration(
    system: System, seed: Seed, v: Vector, stiffness: float, damping: float
) -> Vector:
    """Return the accelerations of stiff modes that follow the initial motion, (n_all,).

    A stiff bar that rotates at a rate w has the acceleration w^2 r towards its centre, though it
    begins without stress.  That is ``-S^-1 (stiffness Q''[v, v] + damping (C v)'[v])`` with the
    forces at rest, Q, and those of damping, C v; of slow modes it is a small part.  It is zero if
    forces set in at the start, as in a contact: their kinks have no curvature.

    Parameters
    ----------
    system : System
        At its initial state.
    seed : SparseSeed or IncompleteSeed
        With the factor of the matrix S of a step.
    v : (n_all,) float
        Velocities [m/s, 1/s].
    stiffness, damping : float
        Factors of both in that matrix [s2, s].
    """
    n, none = system.n_free, np.zeros(system.n_all)
    if not v.any():
        return none
    out = none.copy(), none.copy()
    time = SECOND_DIFFERENCE_RATIO / np.maximum(_relative_rate(system, v), np.finfo(float).tiny)
    lam = np.zeros(system.n_multipliers)
    with np.errstate(all="ignore"):
        for a, t in zip(out, (time, 2.0 * time), strict=True):
            states = [system.q0 + k * t * v for k in (-1.0, 0.0, 1.0)]
            before, now, after = (_forces(system, q, 0.0 * v, lam, 0.0) for q in states)
            force = stiffness / t**2 * (after - 2.0 * now + before)
            if system.damped:
                first, _, last = (_forces(system, q, v, lam, 0.0) for q in states)
                force += damping / (2.0 * t) * ((last - after) - (first - before))
            a[:n] = -seed.solve(np.append(force[:n], lam))[:n]
        size, change = (a @ system.assembly.inertia(a) for a in (out[0], out[1] - out[0]))
    return out[0] if change <= MAX_CURVATURE_CHANGE**2 * size else none


def _third_derivative_terms(system: System, v: Vector, a: Vector) -> Vector:
    """Return ``3 v.phi_qq.a`` and the third derivative ``phi_qqq v v v`` at the start, (m,) [m/s3].

    The first by polarization of the curvature, which is quadratic, over a time in which the
    accelerations cause velocities comparable with the initial ones, to avoid cancellation.
    """
    inertia, curvature_at = system.assembly.inertia, system.constraints.curvature
    curvature = partial(curvature_at, system.q0)
    third = np.zeros(system.n_multipliers)
    if system.constraints.measures and v.any():
        h = DIFFERENCE_RATIO / _relative_rate(system, v)
        third = curvature_at(system.q0 + h * v, v) - curvature_at(system.q0 - h * v, v)
        third /= 2.0 * h
    if not v.any() or not a.any():
        return third
    # Powers of two keep squares in the range of floating-point numbers without rounding.
    v_scale, a_scale = (math.ldexp(1.0, math.frexp(np.max(np.abs(x)))[1]) for x in (v, a))
    v_square = float(v / v_scale @ inertia(v / v_scale))
    a_square = float(a / a_scale @ inertia(a / a_scale))
    if v_square == 0.0 or a_square == 0.0:
        return third
    time = math.sqrt(v_square / a_square) * (v_scale / a_scale)
    return third + 0.75 / time * (curvature(v + time * a) - curvature(v - time * a))


def _relative_rate(system: System, v: Vector) -> float:
    """Return the speed over the size of the scene, or the rate of a unit slope if larger [1/s]."""
    positions = system.positions
    slopes = np.ones(system.n_all, dtype=bool)
    slopes[positions] = False
    speed, size = (np.max(np.abs(x[positions])) for x in (v, system.q0))
    size = max(size, *(body.shortest for body in system.scene.bodies))
    return float(max(speed / size, np.max(np.abs(v[slopes]), initial=0.0)))


def load_amplitudes_at_start(system: System, later: float = 0.0) -> Vector:
    """Return the amplitudes of the loads at the start, or a time later [s]."""
    return np.asarray(system.loads.amplitudes(np.array([system.t0 + later]))[0])


def _forces(system: System, q: Vector, v: Vector, lam: Vector, later: float) -> Vector:
    """Return internal and constraint forces less the loads, which balance M a, (n_all,) [N].

    They include the inertia of prescribed coordinates.
    """
    amplitudes = load_amplitudes_at_start(system, later)
    a = np.zeros(system.n_all)
    if system.prescribed.n:
        a[-system.prescribed.n :] = system.prescribed.at(system.t0 + later).a
    return np.asarray(system.assembly.residual(q, v, a, lam, system.dead_load, amplitudes)[0])


def prescribed_rate_terms(system: System, coordinates: Vector, values: Vector) -> Vector:
    """Return the rates of the constraints less the part of prescribed coordinates, (m,).

    Parameters
    ----------
    system : System
        At its initial state.
    coordinates : (n,) float
        Rates of the prescribed coordinates.
    values : (n_equations,) float
        Prescribed rates of the equations.
    """
    rates = np.zeros(system.n_all)
    rates[system.n_all - len(coordinates) :] = coordinates
    out = np.asarray(-(system.constraints.jacobian(system.q0) @ rates))
    out[system.n_multipliers - len(values) :] += values
    return out


def forces_of_prescribed_rates(
    system: System, rates: Vector, stiffness: float, damping: float
) -> Vector:
    """Return the forces of stiffness and damping against prescribed rates, (n_all,).

    Parameters
    ----------
    system : System
        At its initial state.
    rates : (n_all,) float
        Rates, zero except at prescribed coordinates.
    stiffness, damping : float
        Factors of both.
    """
    out = np.zeros(system.n_all)
    if damping and system.damped:
        out += damping * system.assembly.damping(system.q0, rates)
    if stiffness:
        shortest = min(body.shortest for body in system.scene.bodies)
        h = DIFFERENCE_RATIO * shortest / float(np.max(np.abs(rates)))
        force = system.assembly.force
        after, before = (force(system.q0 + sign * h * rates) for sign in (1.0, -1.0))
        out += stiffness / (2.0 * h) * (after - before)
    return out


def prescribed_values_at_start(system: System) -> tuple[Vector, Vector]:
    """Return the prescribed values of the constraints at the start, and rates, (m,) [m, m/s]."""
    values, rates = np.zeros(system.n_multipliers), np.zeros(system.n_multipliers)
    if system.prescribed.n_equations:
        now = system.prescribed.at(system.t0)
        values[-len(now.s) :], rates[-len(now.s) :] = now.s, now.s_rate
    return values, rates


def solve_constrained(
    system: System, seed: Seed, force: Vector, rate: Vector
) -> tuple[Vector, Vector]:
    """Solve ``M x + phi_q^T mu = force``, ``phi_q x = rate``, with refinement of the solution."""
    n, m = system.n_free, system.n_multipliers
    x, mu = np.zeros(system.n_all), np.zeros(m)
    if not m:
        x[:n] = seed.solve(force[:n])
        return x, mu
    phi_q = system.constraints.jacobian(system.q0)
    for _ in range(3):
        top = force - system.assembly.inertia(x) - phi_q.T @ mu
        correction = seed.solve(np.concatenate([top[:n], rate - phi_q @ x]))
        x[:n] += correction[:n]
        mu += correction[n:]
    return x, mu


def range_error(where: str) -> InputError:
    """Return the error for a start outside the range of floating-point numbers."""
    return InputError(
        f"the motion leaves the range of floating-point numbers at its start, where {where}: check "
        "the units of loads, velocities and stiffness, which are SI"
    )


def index_of_largest(values: Vector) -> int:
    """Return the index of the first value that is not a number, or else of the largest."""
    return int(np.argmax(np.nan_to_num(np.abs(values), nan=np.inf)))
