"""Consistent initial conditions, and the start of an implicit integrator."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError, SingularSceneError
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.implicit.time_integration import Start
from ancfsparse.scene.joints.distance import DistanceConstraint
from ancfsparse.solve.initial_conditions.consistent_accelerations import (
    forces_of_prescribed_rates,
    index_of_largest,
    initial_acceleration,
    initial_jerk,
    load_amplitudes_at_start,
    prescribed_values_at_start,
    range_error,
    solve_constrained,
    stiff_acceleration,
)
from ancfsparse.solve.initial_conditions.restart import continues_run
from ancfsparse.system import System
from ancfsparse.system.coordinates.numbering import velocity_scales
from ancfsparse.system.coordinates.state import ROUNDING, State

if TYPE_CHECKING:
    from ancfsparse.seeds import Seed


REGULARIZATION = 1e-10  # of the constraint block, over the smallest phi_q M^-1 phi_q^T
# The same where constraints are redundant.  Corrections change redundant multipliers by misfits
# over it: with 1e-10 those of Bricard's mechanism grew to 1e6 N, and steps of 4 ms failed or took
# 2.7 times as many corrections.  Rows of 1000 bars take as many with 1e-6 and 1e-5 as with 1e-10.
REDUNDANT_REGULARIZATION = 1e-6
N_CORRECTIONS = 2  # Newton's, to project a start on the constraints; each squares the violation
# Violations that a start from another run may have in addition to rounding: as much as a step
# allows, and far less than a new joint would cause.
RESTART_POSITION_TOLERANCE = 1e-6  # over the size of the terms of a constraint
RESTART_VELOCITY_TOLERANCE = 1e-2  # over the size of the terms of its rate
# Velocities from the rounding of positions in a step, over that tolerance.
VELOCITY_ROUNDING = 1e3 * np.finfo(float).eps / RESTART_VELOCITY_TOLERANCE


def regularize(system: System, scale: float, ratio: float | None = None) -> float:
    """Set the small negative diagonal of the constraint block, so that L D L^T always exists.

    Parameters
    ----------
    system : System
        Its assembly stores the value.
    scale : float
        Factor of the stiffness in the matrix, beta dt^2 [s2].
    ratio : float, optional
        The diagonal over the smallest phi_q M^-1 phi_q^T.

    Returns
    -------
    float
        The diagonal without its sign [1/kg]; 0 without constraints.
    """
    if not system.n_multipliers:
        return 0.0
    lam = np.zeros(system.n_multipliers)
    amplitudes = load_amplitudes_at_start(system)
    if ratio is None:
        ratio = REDUNDANT_REGULARIZATION if system.is_redundant else REGULARIZATION
    values = system.assembly.matrix(1.0, scale, system.q_ref, lam, amplitudes)
    diagonal = values[system.pattern.indptr[: system.n_free]]
    phi_q = system.constraints.jacobian(system.q_ref)[:, : system.n_free]
    value = ratio * float(np.min(phi_q.power(2) @ (1.0 / diagonal)))
    system.assembly.set_regularization(value)
    return value


def check_constraints(system: System, state: State | None = None) -> None:
    """Check that a start satisfies the constraints and their rates.

    A start from a `state` may violate them by as much as the steps of a run allow.

    Raises
    ------
    InputError
        With the most violated equation, and the violation.
    SingularSceneError
        If an equation has no free coordinate.
    """
    if not system.n_multipliers:
        return
    without_free = system.constraints.without(system.n_free)
    if without_free:
        raise SingularSceneError(
            f"the {system.constraints.labels[without_free[0]]} constrains no free coordinate: its "
            "points are already fixed; leave it out, or use a joint with more freedom, such as pin"
        )
    zero, lam = np.zeros(system.n_all), np.zeros(system.n_multipliers)
    amplitudes = load_amplitudes_at_start(system)
    _, phi = system.assembly.residual(system.q0, system.v0, zero, lam, system.dead_load, amplitudes)
    prescribed, prescribed_rates = prescribed_values_at_start(system)
    phi -= prescribed
    phi_q = system.constraints.jacobian(system.q0)
    position_tolerance, velocity_tolerance = ROUNDING, ROUNDING
    position_sizes = system.constraints.sizes(system.q0)
    velocity_sizes = np.abs(phi_q) @ velocity_scales(system.scene, system.places, system.v0)
    if state is not None:
        position_tolerance = RESTART_POSITION_TOLERANCE
        velocity_tolerance = RESTART_VELOCITY_TOLERANCE
        position_sizes += np.max(np.abs(system.q0))
        if "run" in state.memory:  # rounding of positions in every step causes velocities
            velocity_sizes += VELOCITY_ROUNDING * position_sizes / state.memory["run"]["dt"]
    rate_errors = np.zeros(system.n_multipliers)
    if system.prescribed.n_equations:
        rate_errors[-system.prescribed.n_equations :] = system.prescribed.rate_errors(system.t0)
    if system.prescribed.n:
        columns = np.abs(phi_q[:, system.n_all - system.prescribed.n :])
        rate_errors += columns @ system.prescribed.speed_errors(system.t0)
    for tolerance, values, sizes, error, reported, unit, name, hint in (
        (
            position_tolerance,
            phi,
            position_sizes,
            0.0,
            violated_lengths,
            "m",
            "positions",
            "move the start or the joint so that they agree, or take start=assemble(scene)",
        ),
        (
            velocity_tolerance,
            phi_q @ system.v0 - prescribed_rates,
            velocity_sizes,
            rate_errors,
            violated_rates,
            "m/s",
            "velocities",
            "give the body a velocity that the joint allows there",
        ),
    ):
        excess = np.abs(values) - tolerance * sizes - error
        largest = int(np.argmax(excess))
        if not excess[largest] <= 0.0:
            arm = system.constraints.arm(largest)
            size, unit = (
                abs(reported(system, values, prescribed)[largest]) / (arm or 1.0),
                unit.replace("m", "rad" if arm else "m"),
            )
            raise InputError(
                f"the initial {name} violate the {system.constraints.labels[largest]} by "
                f"{size:.3g} {unit}: {hint}"
            )


def violated_lengths(system: System, phi: Vector, prescribed: Vector) -> Vector:
    """Return the violations of all equations, of distances by their lengths, (m,) [m].

    Parameters
    ----------
    system : System
        With the constraints.
    phi : (m,) float
        Values of the equations; those of distances are ``(d^2 - l^2) / (2 l_0)`` [m].
    prescribed : (m,) float
        Their prescribed values; those of distances are ``l^2 / (2 l_0)`` [m].
    """
    out = np.array(phi)
    for row, initial, half_square in _distances(system, prescribed):
        length = np.sqrt(2.0 * initial * half_square)
        out[row] = np.sqrt(max(0.0, 2.0 * initial * (phi[row] + half_square))) - length
    return out


def violated_rates(system: System, rates: Vector, prescribed: Vector) -> Vector:
    """Return the violations of the rates, of distances by their rates, (m,) [m/s].

    Values `prescribed` as in `violated_lengths`, with which the distances agree.
    """
    out = np.array(rates)
    for row, initial, half_square in _distances(system, prescribed):
        out[row] *= np.sqrt(0.5 * initial / half_square)
    return out


def _distances(system: System, prescribed: Vector) -> list[tuple[int, float, float]]:
    """Return row, initial length l_0 and l^2 / (2 l_0) of every distance [m]."""
    joints = {id(each): each for each in system.scene.joints}
    out = []
    for row, (owner, _) in enumerate(system.constraints.source):
        joint = joints.get(owner)
        if isinstance(joint, DistanceConstraint):
            half_square = float(prescribed[row]) - system.constraints.offset[row]
            out.append((row, joint.length, half_square))
    return out


def check_energy(system: System) -> None:
    """Check that the initial energy is in the range of floating-point numbers.

    Raises
    ------
    InputError
        With the largest velocity.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        energies = system.energies(system.q0[None], system.v0[None])
    if not np.isfinite(energies).all():
        i = index_of_largest(system.v0)
        unit = "m/s" if system.unit(i) == "N" else "1/s"
        raise range_error(f"the speed of {system.describe(i)} is {system.v0[i]:.3g} {unit}")


def starting_state(
    system: System, seed: Seed, integrator: Implicit, dt: float, state: State | None = None
) -> tuple[Start, Vector]:
    """Return the start with which an integrator is of second order from its first step on.

    The pseudo-acceleration is the acceleration at the time to which the integrator shifts it.
    Where constraints are prescribed functions of time, the velocity across them is the one that
    Newmark's formulas assign to a smooth motion (`Implicit.velocity_constant`); otherwise
    multipliers would oscillate with an amplitude of first order, undamped by the trapezoidal rule.
    Vibrations that the step cannot
    resolve are filtered out of the accelerations and their rates (`low_frequency_part`): the
    formulas would use them as the mean of a whole step, and displace the end of a stiff beam under
    a sudden load by far too much.  Velocities that are damped out within the step are filtered out
    too (`undamped_velocities`).

    Parameters
    ----------
    system : System
        At its initial state ``q0``, ``v0``.
    seed : SparseSeed or IncompleteSeed
        On the pattern of the system; its factor is replaced.
    integrator : Implicit
        Its weights are used.
    dt : float
        Time step [s].
    state : State, optional
        Source of the initial state.  A state at which a run of the same scheme has ended is
        consistent; for any other, positions and velocities are projected on the constraints.

    Returns
    -------
    start : Start
        Initial state of the time loop.
    a : (n_all,) float
        The true accelerations [m/s2, 1/s2].
    """
    amplitudes = load_amplitudes_at_start(system)
    if continues_run(state, system, integrator, dt):
        b = state.a if state.b is None else state.b
        return Start(state.q, state.v, state.a, b, state.lam, amplitudes), state.a
    if state is not None and system.n_multipliers:
        project_on_constraints(system, seed)
    lam = np.zeros(system.n_multipliers)
    v = undamped_velocities(system, seed, integrator.damping_scale * dt)
    seed.factor(system.assembly.matrix(1.0, 0.0, system.q0, lam, amplitudes))
    a, lam = initial_acceleration(system, seed, system.v0)
    begin = a if v is system.v0 else initial_acceleration(system, seed, v)[0]
    jerk = None
    if integrator.shift != 0.0 or system.n_multipliers:
        jerk = initial_jerk(system, seed, v, begin, lam, dt)
        if system.n_multipliers:
            rate = (
                integrator.velocity_constant
                * dt**2
                * (system.constraints.jacobian(system.q0) @ jerk)
            )
            change, _ = solve_constrained(system, seed, np.zeros(system.n_all), rate)
            v = v + change
    scale, damping = integrator.scale * dt**2, integrator.damping_scale * dt
    if seed.factor(
        system.assembly.matrix(1.0, scale, system.q0, lam, amplitudes, damping_factor=damping, v=v)
    ):
        # The stress exceeds what the mass can balance: only a definite matrix is a filter.
        seed.factor(system.assembly.material(1.0, scale, system.q0, damping_factor=damping))
    # 1 - (1 - S^-1 M)^2: with damping, the filter alone would have an error of first order.
    factors = scale, damping
    slow = low_frequency_part(system, seed, v, factors)
    stiff = stiff_acceleration(system, seed, slow, *factors)
    once = stiff + low_frequency_part(system, seed, begin, factors)
    smooth = b = once + low_frequency_part(system, seed, begin - once, factors)
    if jerk is not None and integrator.shift != 0.0:
        # Damping makes the jerk larger than the accelerations by the rate of decay, which no step
        # limits: the filter is applied three times.
        for _ in range(3):
            jerk = low_frequency_part(system, seed, jerk)
        b = smooth + integrator.shift * dt * jerk
    return Start(system.q0, v, smooth, b, lam, amplitudes), a


def project_on_constraints(system: System, seed: Seed) -> None:
    """Correct initial positions and velocities that violate the constraints.

    The corrections are along ``M^-1 phi_q^T``, as those of an impulse of the joints.

    Parameters
    ----------
    system : System
        Its ``q0`` and ``v0`` are replaced.
    seed : SparseSeed or IncompleteSeed
        On the pattern of the system; afterwards it holds the factor of the mass matrix.
    """
    zero, lam, loads = (
        np.zeros(system.n_all),
        np.zeros(system.n_multipliers),
        load_amplitudes_at_start(system),
    )
    seed.factor(system.assembly.matrix(1.0, 0.0, system.q0, lam, loads))
    prescribed, prescribed_rates = prescribed_values_at_start(system)
    for _ in range(N_CORRECTIONS):
        phi = system.assembly.residual(system.q0, zero, zero, lam, system.dead_load, loads)[1]
        system.q0 = system.q0 + solve_constrained(system, seed, zero, prescribed - phi)[0]
    violation = prescribed_rates - system.constraints.jacobian(system.q0) @ system.v0
    system.v0 = system.v0 + solve_constrained(system, seed, zero, violation)[0]


def undamped_velocities(system: System, seed: Seed, scale: float) -> Vector:
    """Return the part of the initial velocities that is not damped out in a step, (n_all,) [m/s].

    ``1 - (1 - D)^3``, ``D = (M + scale C)^-1 M`` with the damping C: of third order if the step
    resolves the decay.  If damping removes a velocity at once, Newmark's formulas would use its
    mean over the step, half of it, and stretch a stiff body by far more than it moves.  Rigid
    motions and velocities across constraints remain.

    Parameters
    ----------
    system : System
        At its initial state.
    seed : SparseSeed or IncompleteSeed
        On the pattern of the system; afterwards it holds the factor of this matrix.
    scale : float
        Change of a velocity over the change of the acceleration [s].
    """
    if not system.damped or not system.v0.any():
        return system.v0
    lam, amplitudes = np.zeros(system.n_multipliers), load_amplitudes_at_start(system)
    seed.factor(
        system.assembly.matrix(
            1.0, 0.0, system.q0, lam, amplitudes, damping_factor=scale, v=system.v0
        )
    )
    v = removed = system.v0
    for _ in range(3):
        removed = removed - low_frequency_part(system, seed, removed, (0.0, scale))
    return v - removed


def low_frequency_part(
    system: System, seed: Seed, rate: Vector, factors: tuple[float, float] = (0.0, 0.0)
) -> Vector:
    """Return the part of accelerations, or of their rate, that a step can resolve, (n_all,).

    ``S^-1 M`` with the matrix S of the step keeps slow modes, and removes stiff ones of
    dt omega >> 1, which are nearly at rest.  The part across constraints does not change.

    Parameters
    ----------
    system : System
        At its initial state.
    seed : SparseSeed or IncompleteSeed
        With the factor of the matrix of a step.
    rate : (n_all,) float
        Accelerations or their rates.
    factors : (float, float), optional
        Factors of stiffness [s2] and damping [s] in that matrix, if coordinates are prescribed:
        these keep their rates, and stiffly connected coordinates follow.
    """
    n, driven = system.n_free, system.n_all - system.prescribed.n
    free = rate
    if driven < system.n_all:
        free = rate.copy()
        free[driven:] = 0.0
    force = system.assembly.inertia(free)[:n]
    if rate[driven:].any():
        force -= forces_of_prescribed_rates(system, rate - free, *factors)[:n]
    if system.n_multipliers:
        force = np.concatenate([force, system.constraints.jacobian(system.q0) @ free])
    out = np.zeros(system.n_all)
    out[:n] = seed.solve(force)[:n]
    out[driven:] = rate[driven:]
    return out
