"""Set-up of explicit runs: checks of the scene, mass inverse, stable step, and instability."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError, InstabilityError, Parameter
from ancfsparse.integrators.explicit.explicit_methods import Explicit, make_explicit
from ancfsparse.integrators.interface.time_grid import divides, plain
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.dense.block_inverse import BlockInverse
from ancfsparse.solve.initial_conditions.consistent_accelerations import (
    initial_acceleration,
    load_amplitudes_at_start,
)
from ancfsparse.solve.initial_conditions.consistent_state import project_on_constraints
from ancfsparse.solve.initial_conditions.prescribed_start import inputs_at
from ancfsparse.solve.initial_conditions.restart import (
    continues_run,
    restore_contributions,
    restore_state,
)
from ancfsparse.solve.linearization.matrices import (
    constraint_magnitudes,
    highest_frequency,
    initial_multipliers,
    mass_matrix,
    mass_seed,
    needs_saddle_point_factor,
    saddle_seed,
)
from ancfsparse.solve.stepping.energy_rounding import estimate_energy_rounding
from ancfsparse.system import System
from ancfsparse.system.coordinates.state import State

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import ExplicitLoop, Loop

# On cables of 3 to 60 elements both take equally long at a ratio of 5.
MAX_BLOCK_COST_RATIO = 4.0  # operations of dense blocks over those of a sweep
MAX_BLOCK_COORDINATES = 10_000  # beyond which finding blocks would take too much memory

SUGGESTED_INTEGRATOR = Parameter("integrator", "GeneralizedAlpha(0.9)", separator="")
"""The implicit integrator that messages suggest."""


def check_explicit_scene(system: System, integrator: Explicit) -> None:
    """Check that an explicit integrator can handle constraints and damping of a scene."""
    if any(term.is_sliding for _, _, term in system.constraints.measures):
        raise InputError(
            "{integrator!r} cannot follow points that slide along beams: take an implicit "
            "integrator such as {implicit}",
            integrator=integrator,
            implicit=SUGGESTED_INTEGRATOR,
        )
    if any(term.sticks for term in system.contributions):
        raise InputError(
            "{integrator!r} cannot follow contacts that stick: give them a slip_speed, or take an "
            "implicit integrator such as {implicit}",
            integrator=integrator,
            implicit=SUGGESTED_INTEGRATOR,
        )
    if system.depends_on_reactions:
        raise InputError(
            "{integrator!r} cannot follow friction by the forces of joints: take an implicit "
            "integrator such as {implicit}, or friction of a given size",
            integrator=integrator,
            implicit=SUGGESTED_INTEGRATOR,
        )
    if system.n_multipliers and not integrator.holds:
        raise InputError(
            "{integrator!r} cannot satisfy constraints by multipliers, and the {first} needs them: "
            "hold and connect beams at their nodes, with as_constraint=False, or take "
            "CentralDifference(), DormandPrince() or an implicit integrator such as {implicit}",
            integrator=integrator,
            first=system.constraints.labels[0],
            implicit=SUGGESTED_INTEGRATOR,
        )
    if system.damped and not integrator.takes_velocities:
        raise InputError(
            "{integrator!r} takes forces that depend on positions and time, and the damping of "
            "this scene depends on velocities: take DormandPrince() or an implicit integrator such "
            "as {implicit}",
            integrator=integrator,
            implicit=SUGGESTED_INTEGRATOR,
        )


def check_no_equations_options(
    integrator: Explicit,
    solver: object,
    tolerance: object,
    max_halvings: int = 0,
    factorization: str = "auto",
) -> None:
    """Check that no option of equation solvers is set."""
    for name, value, default in (
        ("solver", solver, "auto"),
        ("tolerance", tolerance, "default"),
        ("max_halvings", max_halvings, 0),
        ("factorization", factorization, "auto"),
    ):
        if value != default:
            raise InputError(
                "{integrator!r} solves no equations, so {given} does not apply: leave it out, or "
                "take an implicit integrator such as {implicit}",
                integrator=integrator,
                given=Parameter(name, repr(value), "="),
                implicit=SUGGESTED_INTEGRATOR,
            )


def prepare_explicit(
    system: System,
    dt: float,
    n_steps: int,
    integrator: Explicit,
    max_energy_gain: float,
    start: State | None = None,
) -> tuple[ExplicitLoop, SparseSeed | BlockInverse, str]:
    """Return the compiled time loop, the inverse of the mass matrix, and a description of both.

    Raises
    ------
    InputError
        If the integrator cannot handle the scene, or the step is too long.
    """
    check_explicit_scene(system, integrator)
    seed, saddle, lam = mass_seed(system), None, None
    if needs_saddle_point_factor(system, integrator):
        saddle = saddle_seed(system)
        if start is not None and not continues_run(start, system, integrator, dt):
            project_on_constraints(system, saddle)
        lam = initial_multipliers(system, saddle)
    omega = highest_frequency(system, seed, system.q0, load_amplitudes_at_start(system), lam)
    limit = integrator.tableau.interval / omega
    if dt > limit:
        t_end = n_steps * dt
        steps = float(np.ceil(t_end / limit))
        enough = plain(t_end / steps, lambda x: x <= limit and divides(t_end, x))
        raise InputError(
            "{dt} is above the stable step of {integrator!r}, which is {limit:.4g} s for this "
            "scene because its fastest vibration has {omega:.4g} rad/s: take {enough} "
            "({steps:.0f} steps) or less, or an implicit integrator such as {implicit}",
            dt=Parameter("dt", f"{dt:g} s"),
            integrator=integrator,
            limit=limit,
            omega=omega,
            enough=Parameter("dt", f"{enough} s"),
            steps=steps,
            implicit=SUGGESTED_INTEGRATOR,
        )
    if not system.n_multipliers:
        initial_acceleration(system, seed, system.v0)  # checks the range of numbers
    mass = cheapest_mass_inverse(system, seed) if saddle is None else saddle
    rounding = estimate_energy_rounding(system, system.stiffness_diagonal(system.q0), dt)
    state = (system.q0, system.v0, inputs_at(system, np.array([system.t0]), rates=True)[0])
    sizes = None if saddle is None else constraint_magnitudes(system)
    time_loop = make_explicit(
        system, dt, integrator, *state, mass, max_energy_gain, *rounding, sizes
    )
    if restore_contributions(start, system):
        time_loop.refresh()
    check_multipliers(system, time_loop, integrator)
    if continues_run(start, system, integrator, dt):
        restore_state(start, system, time_loop)
    why = (
        f"{integrator!r}: forces evaluated {integrator.tableau.forces} times per step, dt is "
        f"{dt / limit:.3g} of the stable step {limit:.4g} s (fastest vibration {omega:.4g} rad/s), "
        f"{_describe_mass(system, seed, mass)}"
    )
    return time_loop, mass, why


def restart_explicit(
    system: System,
    t: float,
    dt: float,
    integrator: Explicit,
    mass: SparseSeed | BlockInverse,
    max_energy_gain: float,
    state: tuple[Vector, Vector],
    before: Loop,
    work: float,
) -> ExplicitLoop:
    """Return a loop that continues another one after a part of the motion between them.

    Parameters
    ----------
    t : float
        Time of the state [s].
    state : tuple of (n_all,) float
        Its coordinates and velocities.
    before : Loop
        The loop before that part.
    work : float
        Change of the energy in that part [J].
    """
    inputs, memory = inputs_at(system, np.array([t]), rates=True)[0], before.memory
    contributions = system.assembly.memory  # which a new loop resets
    rounding = estimate_energy_rounding(system, system.stiffness_diagonal(system.q0), dt)
    sizes = constraint_magnitudes(system)
    loop = make_explicit(
        system, dt, integrator, *state, inputs, mass, max_energy_gain, *rounding, sizes
    )
    if len(contributions):
        system.assembly.memory = contributions
        loop.refresh()
    if len(inputs):  # loads and drives have done work, which is not known in any other way
        memory["watch"]["work"] += work
    loop.recall(memory | {"amplitudes0": np.append(inputs, 0.0)})
    return loop


def _describe_mass(system: System, seed: SparseSeed, mass: SparseSeed | BlockInverse) -> str:
    """Describe the solution for accelerations."""
    if mass.n > system.n_free:
        often = "once" if system.constraints.linear else "at each of them"
        return f"mass matrix with constraints factored {often}, steps projected on them"
    return f"mass matrix {'factored once' if mass is seed else 'inverted in dense blocks'}"


def check_multipliers(system: System, time_loop: ExplicitLoop, integrator: Explicit) -> None:
    """Check that the multipliers at the start could be found."""
    if not (time_loop.finite and np.isfinite(time_loop.state[2]).all()):
        raise InputError(
            "{integrator!r} finds no multipliers at the start: the forces there leave the range "
            "of numbers, or the {last} repeats another constraint; leave that out, or take an "
            "implicit integrator such as {implicit}",
            integrator=integrator,
            last=system.constraints.labels[-1],
            implicit=SUGGESTED_INTEGRATOR,
        )


def cheapest_mass_inverse(system: System, seed: SparseSeed) -> SparseSeed | BlockInverse:
    """Return the inverse of the mass matrix, in dense blocks if they are faster than a sweep."""
    if system.n_free > MAX_BLOCK_COORDINATES:
        return seed
    mass = mass_matrix(system)
    blocks = BlockInverse(mass.indptr, mass.indices, mass.data)
    return blocks if blocks.solve_flops <= MAX_BLOCK_COST_RATIO * seed.solve_flops else seed


def count_forces(stats: RunStats, integrator: Explicit) -> None:
    """Count the operations of the steps."""
    stats.residual_evaluations = stats.solves = stats.steps * integrator.tableau.forces
    stats.factorizations = 1


def instability_error(
    system: System,
    time_loop: Loop,
    mass: SparseSeed | BlockInverse,
    integrator: Explicit,
    outcome: Outcome,
    step: int,
    now: float,
    dt: float,
    path: Trajectory | None = None,
) -> InstabilityError:
    """Return the error of a run that has become unstable.

    Parameters
    ----------
    mass : SparseSeed or BlockInverse
        Inverse of the mass matrix, perhaps with constraints.
    outcome : Outcome
        ``GAINED_ENERGY``, ``NOT_FINITE`` or ``DIVERGED``.
    step : int
        Number of the last step.
    now : float
        Time after it [s].
    path : Trajectory, optional
        The states so far.
    """
    gain, _ = time_loop.energy_gain
    if outcome == Outcome.DIVERGED:
        reason = f"the constraints cannot be met by step {step + 1}: they rotate too far in it"
    elif outcome == Outcome.NOT_FINITE:
        reason = f"step {step + 1} leaves the range of numbers"
    else:
        load = system.loads.amplitudes(np.array([now]))[0]
        q, _, _, lam = time_loop.state
        mass = mass_seed(system) if mass.n > system.n_free else mass
        limit = integrator.tableau.interval / highest_frequency(system, mass, q, load, lam)
        reason = (
            f"the motion has gained {gain:.3g} J without work of a load; the stable step, which "
            f"stretching shortens, is now {limit:.3g} s"
        )
    return InstabilityError(reason, now, step, dt, gain, "the whole scene", path)
