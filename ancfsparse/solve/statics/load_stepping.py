"""Load stepping, with relaxation where it fails."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import EquilibriumError, InputError
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.solve.statics.newton_and_relaxation import (
    NotFoundError,
    StaticResult,
    check_passage,
    relax,
    solve_newton,
)

INTERMEDIATE_TOLERANCE = 1e-3  # residual over the loads in intermediate load steps
MIN_CAREFUL_STEPS = 10  # load steps after the full load has failed or led to instability
MIN_STEP = 1.0 / 4096.0  # such a step, of the load
MIN_STABLE_STEP = 1.0 / 640.0  # the same while equilibria are stable
MAX_EASY_FACTORS = 6  # factors of a load step after which the next one is doubled
ROUNDING_HINT = (
    "Take fewer elements: their forces round by as much as the loads, because elements that are "
    "short compared with the scene are stiff."
)


def find_equilibrium(
    equations: EquilibriumEquations, load_steps: int, tolerance: float
) -> StaticResult:
    """Find an equilibrium by large load steps, by relaxation, or by short load steps.

    An unstable equilibrium found by large steps is returned if there is no other.

    Parameters
    ----------
    equations : EquilibriumEquations
        The equations with their seed.
    load_steps : int
        Number of large steps.
    tolerance : float
        Largest residual over the loads [-].

    Raises
    ------
    EquilibriumError
        With the largest residual force.
    """
    start, stats = equations.start, equations.stats
    unstable: StaticResult | None = None
    try:
        unstable = _follow_load(equations, start, load_steps, tolerance)
        if unstable.negative == 0 or not equations.conservative:
            return unstable
    except NotFoundError as failure:
        if equations.is_lost_in_rounding():
            raise equilibrium_error(equations, failure, failure.reason, ROUNDING_HINT) from None
        if equations.conservative:
            try:
                return _relax_fully_loaded(equations, start, tolerance)
            except NotFoundError:
                pass
    steps, load_steps = stats.steps, max(MIN_CAREFUL_STEPS, load_steps)
    last, reached = NotFoundError("", start, 1.0), 0.0
    for forces_first in (False, True)[: 1 + equations.imposed.is_driven]:
        stats.steps, equations.imposed.forces_first = 0, forces_first
        try:
            return _follow_load(equations, start, load_steps, tolerance, patient=True)
        except NotFoundError as failed:
            state, reached = failed.state, failed.reached
        try:
            return _relax_fully_loaded(equations, state, tolerance, patient=True)
        except NotFoundError as failed:
            last = failed
    if unstable is None:
        reason = f"{last.reason}; load steps reached {100 * reached:.3g} %"
        raise equilibrium_error(equations, last, reason)
    stats.steps = steps
    return unstable


def find_equilibrium_near(
    equations: EquilibriumEquations, q: Vector, load_steps: int, tolerance: float
) -> StaticResult:
    """Find the equilibrium under the full load next to given coordinates, stable if possible.

    If there is none, the load grows from the reference shape as in `find_equilibrium`, and bodies
    must be on the same sides of each other in the equilibrium found.

    Parameters
    ----------
    equations : EquilibriumEquations
        The equations with their seed.
    q : (n_all,) float
        Initial coordinates.
    load_steps : int
        Number of large steps from the reference shape.
    tolerance : float
        Largest residual over the loads [-].

    Raises
    ------
    EquilibriumError
        With the largest residual force.
    """
    state = equations.state(q, equations.start.lam, 1.0)
    try:
        check_passage(equations, q, state, 1.0)
        result = solve_newton(equations, state, 1.0, tolerance)
        equations.stats.steps += 1
        if result.negative == 0 or not equations.conservative:
            return result
        return _relax_fully_loaded(equations, state, tolerance)
    except NotFoundError:
        result = find_equilibrium(equations, load_steps, tolerance)
    try:
        check_passage(equations, q, result.state, 1.0)
    except NotFoundError as failure:
        raise equilibrium_error(equations, failure, failure.reason) from None
    return result


def _relax_fully_loaded(
    equations: EquilibriumEquations,
    state: StaticState,
    tolerance: float,
    *,
    patient: bool = False,
) -> StaticResult:
    """Relax under the full load, which counts as one more load step."""
    start = equations.state(state.q, state.lam, 1.0)
    check_passage(equations, state.q, start, 1.0)
    result = relax(equations, start, 1.0, tolerance, patient=patient)
    equations.stats.steps += 1
    return result


def _follow_load(
    equations: EquilibriumEquations,
    state: StaticState,
    load_steps: int,
    tolerance: float,
    *,
    patient: bool = False,
) -> StaticResult:
    """Apply the load in steps.

    With `patient`, a step that fails or leads to an unstable equilibrium is halved until it is very
    short, and doubled again after an easy one.
    """
    done, step, stable = 0.0, 1.0 / load_steps, patient and equations.conservative
    result = StaticResult(state, 0, 0.0)
    while done < 1.0:
        target = min(1.0, done + step)
        if 1.0 - target < 1e-9:
            target = 1.0
        start = equations.state(result.state.q, result.state.lam, target)
        factors = equations.stats.factorizations
        definite = stable and step > MIN_STABLE_STEP
        bound = tolerance if target == 1.0 else max(tolerance, INTERMEDIATE_TOLERANCE)
        try:
            check_passage(equations, result.state.q, start, target)
            new = solve_newton(
                equations,
                start,
                target,
                bound,
                extrapolate=not patient,
                definite=definite,
                intermediate=target < 1.0,
            )
        except NotFoundError as failure:
            if patient and step > MIN_STEP:
                step *= 0.5
                continue
            raise NotFoundError(failure.reason, result.state, target, done) from None
        result, done, stable = new, target, stable and new.negative == 0
        equations.stats.steps += 1
        if equations.stats.factorizations - factors <= MAX_EASY_FACTORS:
            step = min(2.0 * step, 1.0 / load_steps)
    return result


def equilibrium_error(
    equations: EquilibriumEquations, last: NotFoundError, reason: str, *advice: str
) -> EquilibriumError:
    """Return the error with the largest residual force of the last state."""
    system = equations.system
    r = equations.state(last.state.q, last.state.lam, last.load).r
    largest = int(np.argmax(np.abs(np.nan_to_num(r, nan=np.inf))))
    where, unit = system.describe(largest), system.unit(largest)
    omitted = equations.omitted_coupling(equations.start.q)
    if omitted:
        advice = (f"{omitted[0].upper()}{omitted[1:]}.",)
    elif not equations.is_lost_in_rounding():
        advice = _contact_advice(equations, last.state.q) or advice
    return EquilibriumError(reason, last.load, abs(float(r[largest])), where, unit, *advice)


def _contact_advice(equations: EquilibriumEquations, q: Vector) -> tuple[str, ...]:
    """Return a sentence on the deepest contact of a state, if there are contacts."""
    terms = [term for term in equations.system.contributions if term.is_contact]
    try:
        points = [term.deepest_point(q) for term in terms]
    except InputError:  # there are too many pairs of elements in this state
        points = []
    if not points:
        return ()
    _, _, what, where = max(points, key=lambda each: each[0] / each[1])
    at = f", at {where}" * bool(where)
    return (
        f"Corrections must not let bodies pass through each other: see {what}{at}. "
        "Take a motion with damping that comes to rest, as with GeneralizedAlpha(0.), a start near "
        "the equilibrium, or more tension in straight cables.",
    )
