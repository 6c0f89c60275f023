"""Consistent start of a motion: what balances the initial state, and what an integrator needs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, SingularSceneError
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.implicit.time_integration import Start
from ancfsparse.seeds import Seed
from ancfsparse.solve.initial_conditions.consistent_accelerations import (
    constraint_gradients,
    forces_of_prescribed_rates,
    index_of_largest,
    initial_acceleration,
    initial_jerk,
    load_amplitudes_at_start,
    prescribed_values_at_start,
    range_error,
    solve_constrained,
)
from ancfsparse.solve.initial_conditions.restart import continues_run
from ancfsparse.system import System
from ancfsparse.system.coordinates.numbering import ROUNDING, speeds
from ancfsparse.system.coordinates.state import State

Vector = NDArray[np.float64]

# Share of the smallest phi_q M^-1 phi_q^T by which the constraint block is made definite.
REGULARIZATION = 1e-10


# Newton's corrections that put a start on the constraints, each of which squares what it is off.
N_CORRECTIONS = 2

# What a start from another run may be off from the constraints beside what rounds, of positions and
# of velocities: as much as a step leaves, and far less than where a joint is new.
RESTART_POSITION_TOLERANCE, RESTART_VELOCITY_TOLERANCE = 1e-6, 1e-2
# What such velocities may be off by that share of: rounding of places in a step, over its length.
VELOCITY_ROUNDING = 1e3 * np.finfo(float).eps / RESTART_VELOCITY_TOLERANCE


def regularize(system: System, scale: float, share: float = REGULARIZATION) -> float:
    """Give the constraint block its small negative diagonal, so that L D L^T always exists.

    Parameters
    ----------
    system : System
        Its assembly takes the value.
    scale : float
        Factor of the stiffness in the matrix, beta dt^2 [s2].
    share : float, optional
        Its share of the smallest phi_q M^-1 phi_q^T.

    Returns
    -------
    float
        The diagonal without its sign [1/kg].
    """
    if not system.n_multipliers:
        return 0.0
    lam = np.zeros(system.n_multipliers)
    amplitudes = load_amplitudes_at_start(system)
    values = system.assembly.matrix(1.0, scale, system.q_ref, lam, amplitudes)
    diagonal = values[system.pattern.indptr[: system.n_free]]
    phi_q = system.constraints.jacobian(system.q_ref)[:, : system.n_free]
    value = share * float(np.min(phi_q.power(2) @ (1.0 / diagonal)))
    system.assembly.set_regularization(value)
    return value


def check_constraints(system: System, state: State | None = None) -> None:
    """Refuse a start that violates the constraints or their rates.

    That from a `state` may do so by as much as the steps of a run leave.

    Raises
    ------
    InputError
        With the worst equation and by how much.
    SingularSceneError
        If an equation is between coordinates that are all held.
    """
    if not system.n_multipliers:
        return
    idle = system.constraints.without(system.n_free)
    if idle:
        raise SingularSceneError(
            f"the {system.constraints.labels[idle[0]]} holds nothing that can move: its points are "
            "held already, leave it out or take a joint that holds less, such as pin"
        )
    rest, lam = np.zeros(system.n_all), np.zeros(system.n_multipliers)
    amplitudes = load_amplitudes_at_start(system)
    _, phi = system.assembly.residual(system.q0, system.v0, rest, lam, system.dead_load, amplitudes)
    followed, rates = prescribed_values_at_start(system)
    phi -= followed
    phi_q = system.constraints.jacobian(system.q0)
    moving = speeds(system.scene, system.places, system.v0)
    of_places, of_speeds = ROUNDING, ROUNDING
    sizes_of_places = system.constraints.sizes(system.q0)
    sizes_of_speeds = np.abs(phi_q) @ moving
    if state is not None:
        of_places, of_speeds = RESTART_POSITION_TOLERANCE, RESTART_VELOCITY_TOLERANCE
        sizes_of_places += np.max(np.abs(system.q0))
        if "run" in state.memory:  # places that are rounded in every step make speeds
            sizes_of_speeds += VELOCITY_ROUNDING * sizes_of_places / state.memory["run"]["dt"]
    unsure = np.zeros(system.n_multipliers)
    if system.prescribed.n_equations:
        unsure[-system.prescribed.n_equations :] = system.prescribed.rate_errors(system.t0)
    if system.prescribed.n:
        driven = np.abs(phi_q[:, system.n_all - system.prescribed.n :])
        unsure += driven @ system.prescribed.speed_errors(system.t0)
    for share, values, sizes, room, unit, what, advice in (
        (
            of_places,
            phi,
            sizes_of_places,
            0.0,
            "m",
            "positions",
            "move the start or the joint so that they agree",
        ),
        (
            of_speeds,
            *(phi_q @ system.v0 - rates, sizes_of_speeds, unsure, "m/s", "velocities"),
            "give the body a velocity that the joint allows there",
        ),
    ):
        over = np.abs(values) - share * sizes - room
        worst = int(np.argmax(over))
        if not over[worst] <= 0.0:
            arm = system.constraints.arm(worst)
            off, unit = abs(values[worst]) / (arm or 1.0), unit.replace("m", "rad" if arm else "m")
            raise InputError(
                f"the initial {what} break the {system.constraints.labels[worst]} by "
                f"{off:.3g} {unit}: {advice}"
            )


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
        i = index_of_largest(system.v0)
        unit = "m/s" if system.unit(i) == "N" else "1/s"
        raise range_error(f"{system.describe(i)} moves by {system.v0[i]:.3g} {unit}")


def starting_state(
    system: System, seed: Seed, integrator: Implicit, dt: float, state: State | None = None
) -> tuple[Start, Vector]:
    """Return the state from which an integrator is of second order from its first step on.

    The integrator's own acceleration is that at the time it looks ahead to; and where constraints
    prescribe a motion, the velocity across them is the one that Newmark's formulas give a smooth
    motion (`Implicit.velocity_constant`).  Without that, multipliers oscillate with an amplitude of
    first order, and those of the trapezoidal rule for ever.  Vibrations that the step cannot
    resolve are filtered out of the accelerations and their rates (`low_frequency_part`): the
    formulas would use them as the mean of a whole step, and displace the end of a stiff beam under
    a sudden load by far too much.  Velocities that are damped out within the step are filtered out
    too (`undamped_velocities`).

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
    state : State, optional
        What the initial state was taken from.  One that a run of the same scheme has come to is
        consistent already; of another one, positions and velocities are put on the constraints.

    Returns
    -------
    start : Start
        What the march goes on from.
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
            rate = integrator.velocity_constant * dt**2 * (constraint_gradients(system) @ jerk)
            change, _ = solve_constrained(system, seed, np.zeros(system.n_all), rate)
            v = v + change
    scale, damping = integrator.scale * dt**2, integrator.damping_scale * dt
    if seed.factor(
        system.assembly.matrix(1.0, scale, system.q0, lam, amplitudes, damping_factor=damping, v=v)
    ):
        # A stress that the mass does not carry: only a definite matrix makes a filter.
        seed.factor(system.assembly.material(1.0, scale, system.q0, damping_factor=damping))
    # 1 - (1 - S^-1 M)^2: of damping, the filter alone would make an error of first order.
    once = low_frequency_part(system, seed, begin, (scale, damping))
    smooth = b = 2.0 * once - low_frequency_part(system, seed, once, (scale, damping))
    if jerk is not None and integrator.shift != 0.0:
        # Damping makes the rate larger than accelerations by its own rate, which no step limits:
        # the filter, cubed, leaves little of it beside what is left of the accelerations.
        for _ in range(3):
            jerk = low_frequency_part(system, seed, jerk)
        b = smooth + integrator.shift * dt * jerk
    return Start(system.q0, v, smooth, b, lam, amplitudes), a


def project_on_constraints(system: System, seed: Seed) -> None:
    """Correct the initial positions and velocities by what they are off from the constraints.

    Along ``M^-1 phi_q^T``, which is what an impulse of the joints does.

    Parameters
    ----------
    system : System
        Its ``q0`` and ``v0`` are replaced.
    seed : SparseSeed or IncompleteSeed
        On the pattern of the system; it is left with the factor of the mass matrix.
    """
    none, lam, loads = (
        np.zeros(system.n_all),
        np.zeros(system.n_multipliers),
        load_amplitudes_at_start(system),
    )
    seed.factor(system.assembly.matrix(1.0, 0.0, system.q0, lam, loads))
    followed, rates = prescribed_values_at_start(system)
    for _ in range(N_CORRECTIONS):
        phi = system.assembly.residual(system.q0, none, none, lam, system.dead_load, loads)[1]
        system.q0 = system.q0 + solve_constrained(system, seed, none, followed - phi)[0]
    off = rates - constraint_gradients(system) @ system.v0
    system.v0 = system.v0 + solve_constrained(system, seed, none, off)[0]


def undamped_velocities(system: System, seed: Seed, scale: float) -> Vector:
    """Return the part of the initial velocities that damping leaves within a step, (n_all,) [m/s].

    ``1 - (1 - D)^3``, ``D = (M + scale C)^-1 M`` with the damping C: of third order where the step
    follows the decay.  Where damping takes a velocity at once, Newmark's formulas would go on with
    its mean over the step, half of it, and stretch a stiff body by far more than it moves.  Rigid
    motions and what joints ask for stay.

    Parameters
    ----------
    system : System
        At its initial state.
    seed : SparseSeed or IncompleteSeed
        On the pattern of the system; it is left with a factor of this matrix.
    scale : float
        What a unit of new acceleration changes a velocity by [s].
    """
    if not system.damped or not system.v0.any():
        return system.v0
    lam, amplitudes = np.zeros(system.n_multipliers), load_amplitudes_at_start(system)
    seed.factor(
        system.assembly.matrix(
            1.0, 0.0, system.q0, lam, amplitudes, damping_factor=scale, v=system.v0
        )
    )
    v = left = system.v0
    for _ in range(3):
        left = left - low_frequency_part(system, seed, left, (0.0, scale))
    return v - left


def low_frequency_part(
    system: System, seed: Seed, rate: Vector, factors: tuple[float, float] = (0.0, 0.0)
) -> Vector:
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
    factors : (float, float), optional
        Of stiffness [s2] and damping [s] in that matrix, where there are drives: what they
        prescribe stays, and what is stiff goes along.
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
        force = np.concatenate([force, constraint_gradients(system) @ free])
    out = np.zeros(system.n_all)
    out[:n] = seed.solve(force)[:n]
    out[driven:] = rate[driven:]
    return out
