"""Equilibria of scenes with free rigid motions: pendulums, ropes, carriages."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.solve.linearization.rigid_body_modes import describe_free_motions
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.solve.statics.load_stepping import equilibrium_error
from ancfsparse.solve.statics.newton_and_relaxation import (
    NotFoundError,
    StaticResult,
    check_passage,
    relax,
)
from ancfsparse.system.rigid_motion.rigid_parts import find_rigid_parts

MAX_STEP_RATIO = 0.1  # displacement in a step over the size of the scene
PERTURBATION_RATIO = 1e-3  # perturbation of an unstable equilibrium over the size of the scene
BALANCED_RATIO = 1e-2  # residual over the loads below which a scene is near an unstable equilibrium
N_FILTERS = 4  # inverse iterations for the motion with the least stiffness


def find_free_equilibrium(
    equations: EquilibriumEquations, q: Vector, tolerance: float, free: list[str]
) -> StaticResult:
    """Relax a scene with free rigid motions to its equilibrium.

    The stiffness without loads is singular, so the load cannot grow from zero: the scene relaxes
    under the full load, see `newton_and_relaxation.relax`.

    Parameters
    ----------
    equations : EquilibriumEquations
        The equations.
    q : (n_all,) float
        Initial coordinates.
    tolerance : float
        Largest residual over the loads [-].
    free : list of str
        The free motions.

    If no stable equilibrium is found, an unstable one is returned.

    Raises
    ------
    SingularSceneError
        If the loads do not restrain them either.
    EquilibriumError
        If prescribed motions would let bodies pass through each other.
    """
    state = equations.state(q, equations.start.lam, 1.0)
    if not equations.force_scale(state) > 0.0:
        raise describe_free_motions(free, "no load restrains them")
    try:
        check_passage(equations, q, state, 1.0)
    except NotFoundError as failure:
        raise equilibrium_error(equations, failure, failure.reason) from None
    if _has_unopposed_force(equations, state):
        raise describe_free_motions(free, "loads move the scene as a whole")
    equations.stats.steps += 1
    farthest = MAX_STEP_RATIO * _scene_size(equations, q)
    try:
        return relax(equations, state, 1.0, tolerance, farthest=farthest)
    except NotFoundError as failure:
        last = equations.state(failure.state.q, failure.state.lam, 1.0)
    try:
        if equations.force_norm(last.r) < BALANCED_RATIO * equations.force_scale(last):
            return relax(
                equations, perturb_unstable(equations, last), 1.0, tolerance, farthest=farthest
            )
    except NotFoundError:
        pass
    if equations.is_balanced(last, 1.0, tolerance):
        return _unstable_equilibrium(equations, last)
    raise describe_free_motions(free, "the scene does not come to rest under its loads")


def _unstable_equilibrium(equations: EquilibriumEquations, state: StaticState) -> StaticResult:
    """Return an equilibrium with its unstable directions."""
    values, shift = equations.stiffness(state, 1.0), equations.stiffness_rounding
    negative = equations.factor(state, values, 1.0, shift)
    return StaticResult(state, negative or 1, float(equations.noise(state, 1.0).max()))


def _has_unopposed_force(equations: EquilibriumEquations, state: StaticState) -> bool:
    """Return whether the force on the whole scene along one of the axes has no reaction.

    Forces that are functions of the motion, contacts, stops and ropes may react in a place that the
    scene has not reached.
    """
    system = equations.system
    at = state.q[None], np.zeros((1, system.n_all)), equations.imposed.amplitudes[None]
    if any(
        not term.is_explicit_in_time or term.unilateral_forces(*at) for term in system.contributions
    ):
        return False
    for column in np.concatenate(system.vectors("r")).T:
        x = np.zeros(system.n_all)
        x[column] = 1.0
        terms = [term.resisted_motions(state.q) for term in system.contributions]
        rows = [system.constraints.jacobian(state.q), *(row for row in terms if row is not None)]
        if x[system.n_free :].any() or any((row @ x).any() for row in rows):
            continue
        force = x[: system.n_free] @ state.r
        if abs(force) > 1e-6 * np.abs(x[: system.n_free] * state.r).sum():
            return True
    return False


def _scene_size(equations: EquilibriumEquations, q: Vector) -> float:
    """Return the size of the scene [m]."""
    positions = np.concatenate([q[indices] for indices in equations.system.vectors("r")])
    sizes = [part.size for part in find_rigid_parts(equations.system)]
    return max(float(np.ptp(positions, axis=0).max()), *sizes)


def perturb_unstable(equations: EquilibriumEquations, state: StaticState) -> StaticState:
    """Return a state near an unstable one, displaced in the directions of least stiffness.

    Parameters
    ----------
    equations : EquilibriumEquations
        The equations.
    state : StaticState
        An equilibrium, or nearly one.

    Raises
    ------
    NotFoundError
        If no mass on the diagonal makes the stiffness definite, or bodies are in between.
    """
    distance = PERTURBATION_RATIO * _scene_size(equations, state.q)
    values, shift = equations.stiffness(state, 1.0), equations.acceleration_scale(state) / distance
    while equations.factor(state, values, 1.0, shift) != 0:
        shift *= 4.0
        if not np.isfinite(shift):
            raise NotFoundError("the stiffness is singular", state, 1.0)
    x = np.random.default_rng(2).standard_normal(len(equations.mass)) / np.sqrt(equations.mass)
    for _ in range(N_FILTERS):
        x = equations.seed.solve(equations.mass * x)
        x *= distance / equations.distance(x)
    perturbed = equations.moved(state, x, 0.0 * state.lam, 1.0)
    check_passage(equations, state.q, perturbed, 1.0)
    return perturbed
