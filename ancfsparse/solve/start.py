"""Consistent start of a motion: what balances the initial state, and what an integrator needs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.march import Start
from ancfsparse.seeds import Seed
from ancfsparse.system import System
from ancfsparse.system.numbering import ROUNDING, speeds

Vector = NDArray[np.float64]

# Share of the smallest phi_q M^-1 phi_q^T by which the constraint block is made definite.
REGULARIZATION = 1e-10

# A motion over which differences of stiff forces are taken, over the size of what moves: the cube
# root of rounding, where a central difference is best.
SMALL_MOTION = 6e-6


def regularize(system: System, scale: float) -> None:
    """Give the constraint block its small negative diagonal, so that L D L^T always exists.

    Parameters
    ----------
    system : System
        Its assembly takes the value.
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
    phi_q = system.constraints.jacobian(system.q0)
    moving = speeds(system.scene, system.places, system.v0)
    for values, sizes, unit, what, advice in (
        (
            phi,
            system.constraints.sizes(system.q0),
            "m",
            "positions",
            "move the start or the joint so that they agree",
        ),
        (
            *(phi_q @ system.v0, np.abs(phi_q) @ moving, "m/s", "velocities"),
            "give the body a velocity that the joint allows there",
        ),
    ):
        over = np.abs(values) - ROUNDING * sizes
        worst = int(np.argmax(over))
        if not over[worst] <= 0.0:
            raise InputError(
                f"the initial {what} break the {system.constraints.labels[worst]} by "
                f"{abs(values[worst]):.3g} {unit}: {advice}"
            )


def starting_state(
    system: System, seed: Seed, integrator: Implicit, dt: float
) -> tuple[Start, Vector]:
    """Return the state from which an integrator is of second order from its first step on.

    The integrator's own acceleration is that at the time it looks ahead to; and where constraints
    prescribe a motion, the velocity across them is the one that Newmark's formulas give a smooth
    motion (`Implicit.velocity_constant`).  Without that, multipliers oscillate with an amplitude of
    first order, and those of the trapezoidal rule for ever.  What the accelerations hold of
    vibrations that the step cannot follow is left out (`resolved`): the formulas would take it for
    the mean of a whole step, and throw the end of a stiff beam away under a sudden load.

    Parameters
    ----------
    system : System
        At its initial state ``q0``, ``v0``.
    seed : SparseSeed or IncompleteSeed
        On the pattern of the system; it is left with a factor that is of no use later.
    integrator : Implicit
        The weights.
    dt : float
        Time step [s].

    Returns
    -------
    start : Start
        What the march goes on from.
    a : (n_all,) float
        The true accelerations [m/s2, 1/s2].
    """
    v, amplitudes = system.v0, system.loads.amplitudes(np.zeros(1))[0]
    lam = np.zeros(system.n_multipliers)
    seed.factor(system.assembly.matrix(1.0, 0.0, system.q0, lam, amplitudes))
    a, lam = initial_acceleration(system, seed)
    jerk = None
    if integrator.shift != 0.0 or system.n_multipliers:
        jerk = initial_jerk(system, seed, a, lam, 1e-2 * dt)
        if system.n_multipliers:
            rate = integrator.velocity_constant * dt**2 * (_phi_q(system) @ jerk)
            change, _ = _solve(system, seed, np.zeros(system.n_all), rate)
            v = v + change
    scale, damping = integrator.scale * dt**2, integrator.damping_scale * dt
    if seed.factor(
        system.assembly.matrix(1.0, scale, system.q0, lam, amplitudes, damping_factor=damping)
    ):
        # A stress that the mass does not carry: only a definite matrix makes a filter.
        seed.factor(system.assembly.material(1.0, scale, system.q0, damping_factor=damping))
    # 1 - (1 - S^-1 M)^2: of damping, the filter alone would make an error of first order.
    once = resolved(system, seed, a)
    smooth = b = 2.0 * once - resolved(system, seed, once)
    if jerk is not None and integrator.shift != 0.0:
        b = smooth + integrator.shift * dt * resolved(system, seed, jerk)
    return Start(system.q0, v, smooth, b, lam, amplitudes), a


def resolved(system: System, seed: Seed, rate: Vector) -> Vector:
    """Return the part of accelerations, or of their rate, that a step can follow, (n_all,).

    ``S^-1 M``, S the matrix of the step, leaves slow modes alone and takes modes of dt omega >> 1
    for what they are: stiff, and at rest but for what the start throws into them.  The part across
    constraints stays what it is.

    Parameters
    ----------
    system : System
        At its initial state.
    seed : SparseSeed or IncompleteSeed
        With the factor of the matrix of a step.
    rate : (n_all,) float
        All of it.
    """
    n = system.n_free
    force = system.assembly.inertia(rate)[:n]
    if system.n_multipliers:
        force = np.concatenate([force, _phi_q(system) @ rate])
    out = np.zeros(system.n_all)
    out[:n] = seed.solve(force)[:n]
    return out


def initial_acceleration(system: System, seed: Seed) -> tuple[Vector, Vector]:
    """Solve ``M a + phi_q^T lam = f - Q``, ``phi_q a = -(phi_q v)_q v`` at the initial state.

    Parameters
    ----------
    system : System
        At its initial state ``q0``, ``v0``.
    seed : SparseSeed or IncompleteSeed
        With the factor of the mass matrix.

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
        force = -_forces(system, system.q0, system.v0, np.zeros(system.n_multipliers), 0.0)
        rate = -system.constraints.curvature(system.v0)
        a, lam = _solve(system, seed, force, rate)
    if np.isfinite(a).all() and np.isfinite(lam).all():
        return a, lam
    if np.isfinite(rate).all():
        i = _worst(force)
        raise _out_of_range(f"the force at {system.describe(i)} is {force[i]:.3g} {system.unit(i)}")
    i = _worst(rate)
    label = system.constraints.labels[i]
    raise _out_of_range(f"the {label} would need an acceleration of {rate[i]} m/s2")


def check_energy(system: System) -> None:
    """Refuse a start whose energy leaves the range of floating-point numbers.

    Raises
    ------
    InputError
        With the largest velocity.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        energies = system.energies(system.q0[None], system.v0[None])
    if not np.isfinite(energies).all():
        i = _worst(system.v0)
        unit = "m/s" if system.unit(i) == "N" else "1/s"
        raise _out_of_range(f"{system.describe(i)} moves by {system.v0[i]:.3g} {unit}")


def _out_of_range(where: str) -> InputError:
    return InputError(
        f"the motion leaves the range of floating-point numbers at its start, where {where}: check "
        "the units of loads, velocities and stiffness, which are SI"
    )


def _worst(values: Vector) -> int:
    """Return the place of what is not a number, or else of the largest."""
    return int(np.argmax(np.nan_to_num(np.abs(values), nan=np.inf)))


def initial_jerk(system: System, seed: Seed, a: Vector, lam: Vector, reach: float) -> Vector:
    """Return the rate of the accelerations at the start, (n_all,) [m/s3, 1/s3].

    The equations of motion and the twice differentiated constraints are differentiated once more:
    by a one-sided difference for loads, which may not be defined before the start, and by a central
    one over a motion of some millionths for everything else.  Stiff forces need that: over a
    hundredth of a long step a bar that turns stretches by more than it ever will.

    Parameters
    ----------
    system, seed, a, lam
        As `initial_acceleration` takes and gives them.
    reach : float
        Time between the points of the difference for loads, and the longest for forces [s].
    """
    near = min(reach, SMALL_MOTION / max(_rate(system), SMALL_MOTION / reach))
    ahead, behind = (
        _forces(system, system.q0 + t * system.v0, system.v0 + t * a, lam, 0.0)
        for t in (near, -near)
    )
    rate = (ahead - behind) / (2.0 * near)
    if system.loads.amplitudes(np.zeros(1)).size:
        for t, weight in ((0.0, -1.5), (reach, 2.0), (2.0 * reach, -0.5)):
            rate += weight / reach * _forces(system, system.q0, system.v0, lam, t)
    return _solve(system, seed, -rate, -_bending(system, a))[0]


def _bending(system: System, a: Vector) -> Vector:
    """Return ``3 v.phi_qq.a`` at the start, what moves constraints are bent by, (m,) [m/s3].

    By polarization of the curvature, which is quadratic; over a time in which the accelerations
    make velocities like the initial ones, or the smaller would be lost beside the larger.
    """
    v, inertia, curvature = system.v0, system.assembly.inertia, system.constraints.curvature
    moving, pushed = float(v @ inertia(v)), float(a @ inertia(a))
    if moving == 0.0 or pushed == 0.0:
        return np.zeros(system.n_multipliers)
    time = math.sqrt(moving / pushed)
    return np.asarray(0.75 / time * (curvature(v + time * a) - curvature(v - time * a)))


def _rate(system: System) -> float:
    """Return how fast the scene moves by its own size, or a slope by its own length [1/s]."""
    places = np.concatenate([each[:, : system.dim].ravel() for each in system.places])
    slopes = np.ones(system.n_all, dtype=bool)
    slopes[places] = False
    speed, size = (np.max(np.abs(x[places])) for x in (system.v0, system.q0))
    return float(max(speed / size, np.max(np.abs(system.v0[slopes]), initial=0.0)))


def _forces(system: System, q: Vector, v: Vector, lam: Vector, t: float) -> Vector:
    """Return what must balance M a: internal and constraint forces less the loads, (n_all,) [N]."""
    amplitudes = system.loads.amplitudes(np.array([t]))[0]
    rest = np.zeros(system.n_all)
    return np.asarray(system.assembly.residual(q, v, rest, lam, system.dead_load, amplitudes)[0])


def _phi_q(system: System) -> Any:
    return system.constraints.jacobian(system.q0)


def _solve(system: System, seed: Seed, force: Vector, rate: Vector) -> tuple[Vector, Vector]:
    """Solve ``M x + phi_q^T mu = force``, ``phi_q x = rate``; refined, since the factor is near."""
    n, m = system.n_free, system.n_multipliers
    x, mu = np.zeros(system.n_all), np.zeros(m)
    if not m:
        x[:n] = seed.solve(force[:n])
        return x, mu
    phi_q = _phi_q(system)
    for _ in range(3):
        top = force - system.assembly.inertia(x) - phi_q.T @ mu
        correction = seed.solve(np.concatenate([top[:n], rate - phi_q @ x]))
        x[:n] += correction[:n]
        mu += correction[n:]
    return x, mu
