"""Initial states with an infinite force, as of a bent shape at a pin, which transmits no moment.

On every mesh the force is finite and grows with the number of elements, and long steps pass over
the shock, so agreement of trial runs is no proof.  The force at t = 0 is therefore compared on
finer meshes.

Histories are inaccurate in the first steps after a shock, such as a sudden weight: velocities less
so in shorter steps, forces in steps of any length.  Times that trial runs have in common are many
steps apart, so the first steps are repeated with half the length; forces also on a finer mesh.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ancfsparse.errors import PlanError
from ancfsparse.integrators import Implicit
from ancfsparse.plans.discretization_error.error_model import ErrorModel
from ancfsparse.plans.discretization_error.richardson import MIN_ORDER
from ancfsparse.plans.discretization_error.run_estimates import elements_of
from ancfsparse.plans.quantities.tolerances import Goal
from ancfsparse.plans.trial_runs.run_differences import absolute_tolerances, goal_differences
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns
from ancfsparse.solve import simulate
from ancfsparse.solve.motion.arguments import DEFAULT_INTEGRATOR

REFINEMENTS = (4, 16)  # elements over those of the finest trial run
MIN_GROWTH_POWER = 0.25  # power of the number of elements with which a force has no limit
# The support of a pendulum that falls with its weight had the largest error, 1.9 times the
# tolerance, in the first step, .8 times in the second and less in all others.
FIRST_STEPS = 4
# Of forces at t = 0 in the length of the elements: at a clamp, after a sudden force elsewhere, one
# of .8 tolerances on 14 elements was 1.4 off.
INITIAL_ORDER = 1.0
MAX_REFINEMENTS = 4  # of steps and meshes too coarse for the tolerance in the first steps alone


def check_initial_force(trials: TrialRuns, reference_run: TrialRun) -> None:
    """Refuse a force over time, or its largest value, that has no limit at t = 0.

    The reference run has the selected elements, on the finest mesh.

    Raises
    ------
    PlanError
        If the force grows with the number of elements by more than its tolerance.  Moments of
        straight beams at rest are rounding, which grows, too.
    """
    counts = reference_run.model.counts
    at_rest = trials.t_end is None or trials.start is not None
    if at_rest or isinstance(trials.integrator, SolutionMethod) or not counts:
        return
    n_elements = elements_of(reference_run)
    coarser = next((run for run in trials.done.values() if run is not None
                    and run.model.elements == reference_run.model.elements
                    and elements_of(run) < n_elements), None)  # fmt: skip
    for i, goal in enumerate(trials.goals):
        quantity = goal.quantity
        if quantity.at == "end" or quantity.has_limit_at_start:
            continue
        if coarser is not None:
            forces = _initial_force(coarser, i), _initial_force(reference_run, i)
            if _power(forces, (elements_of(coarser), n_elements)) < MIN_GROWTH_POWER:
                continue
        _compare_finer_meshes(trials, reference_run, i)


def add_initial_error(trials: TrialRuns, error_model: ErrorModel) -> ErrorModel:
    """Return the error model with at least the errors of histories in the first steps.

    Where these exceed the tolerance, shorter steps are selected, and for forces finer meshes, if
    they reduce them.
    """
    is_method = isinstance(trials.integrator, SolutionMethod)
    if trials.t_end is None or is_method or not any(map(_is_history_of_rates, trials.goals)):
        return error_model
    selected = error_model.optimum()
    out: ErrorModel | None = None
    known: dict[bool, float] = {}  # largest ratio to the tolerance, by mesh and by steps
    for _ in range(MAX_REFINEMENTS):
        parts = _initial_errors(trials, error_model, *selected)
        if parts is None:
            break
        error = _with_errors(error_model, selected, list(map(sum, zip(*parts, strict=True))))
        out = out or error
        if error is error_model or error.optimal_excess <= 1.0:
            return error
        excesses = [_excess(part, error_model.tolerances) for part in parts]
        is_mesh = excesses[1] > excesses[0]
        if not is_mesh and error_model.fixed_steps is not None:
            break
        if excesses[is_mesh] > 2.0**-MIN_ORDER * known.get(is_mesh, math.inf):
            break
        known[is_mesh] = excesses[is_mesh]
        n_longest, steps = selected
        selected = (2.0 * n_longest, steps) if is_mesh else (n_longest, 2 * steps)
    return out or error_model


def _excess(errors: Sequence[float], tolerances: Sequence[float]) -> float:
    return max(error / tolerance for error, tolerance in zip(errors, tolerances, strict=True))


def _initial_errors(
    trials: TrialRuns, error_model: ErrorModel, n_longest: float, steps: int
) -> tuple[list[float], list[float]] | None:
    """Return the errors of all quantities in the first steps, by steps and by mesh [their unit].

    None if these steps fail.
    """
    assert trials.t_end is not None
    t_end = FIRST_STEPS * trials.t_end / steps
    is_implicit = isinstance(trials.integrator, Implicit)
    # Explicit steps would be unstable on finer meshes.
    integrator = trials.integrator if is_implicit else DEFAULT_INTEGRATOR
    first = replace(trials.with_integrator(integrator), t_end=t_end, base=FIRST_STEPS)
    model = trials.with_mesh(error_model.model, n_longest)
    one, other = (first.run(model, ratio * FIRST_STEPS) for ratio in (1, 2))
    if one is None or other is None:
        return None
    by_steps = _scaled_differences(trials.goals, one, other, first.step_order)
    by_mesh = [0.0] * len(by_steps)
    if model.counts and any(map(_is_history_of_forces, trials.goals)):
        finer = first.run(trials.with_mesh(error_model.model, 2.0 * n_longest), FIRST_STEPS)
        if finer is not None:
            by_mesh = _scaled_differences(trials.goals, one, finer, INITIAL_ORDER)
    return by_steps, by_mesh


def _with_errors(
    error_model: ErrorModel, selected: tuple[float, int], errors: Sequence[float]
) -> ErrorModel:
    """Return the error model with a resolution selected, and errors added that it lacks there.

    It is returned unchanged if it lacks none.
    """
    if selected != error_model.optimum():
        error_model = replace(error_model, selected=selected, combined_errors=None)
    predicted = (
        each.get("time", each.get("mesh and steps", 0.0)) for each in error_model.errors(*selected)
    )
    missing = [max(0.0, x - y) for x, y in zip(errors, predicted, strict=True)]
    if not any(missing):
        return error_model
    pairs = zip(error_model.time.estimates, missing, strict=True)
    steps = selected[1]
    times = tuple(replace(each, resolution=steps, error=each.at(steps) + x) for each, x in pairs)
    combined = error_model.combined_errors
    if combined is not None:
        combined = tuple(map(sum, zip(combined, missing, strict=True)))
    time = replace(error_model.time, estimates=times)
    return replace(error_model, time=time, combined_errors=combined, selected=selected)


def _scaled_differences(
    goals: Sequence[Goal], one: TrialRun, other: TrialRun, order: float
) -> list[float]:
    """Return the errors of histories of rates in a run, from one with twice the resolution."""
    factor = 1.0 + 1.0 / (2.0**order - 1.0)
    differences = zip(goals, goal_differences(goals, one, other), strict=True)
    return [factor * _is_history_of_rates(goal) * difference for goal, difference in differences]


def _is_history_of_forces(goal: Goal) -> bool:
    return goal.quantity.at == "saved" and not goal.quantity.has_limit_at_start


def _is_history_of_rates(goal: Goal) -> bool:
    """Return True if a quantity may be inaccurate in the first steps: a rate or a force.

    Errors of positions, angles and energies there were .07 of the tolerance or less in 30 plans.
    """
    return goal.quantity.at == "saved" and goal.quantity.is_like_rates


def _initial_force(run: TrialRun, i: int) -> float:
    return float(np.linalg.norm(run.histories[i][0]))


def _power(forces: tuple[float, float], elements: tuple[int, int]) -> float:
    """Return the power of the number of elements with which a force grows."""
    less, more = forces
    if less <= 0.0 or more <= 0.0:
        return 0.0
    return math.log(more / less) / math.log(elements[1] / elements[0])


def _compare_finer_meshes(trials: TrialRuns, reference_run: TrialRun, i: int) -> None:
    """Compare the initial states on finer meshes."""
    n_longest = max(reference_run.model.counts.values())
    assert trials.t_end is not None
    dt = trials.t_end / (reference_run.steps * REFINEMENTS[-1])
    quantity, forces = trials.goals[i].quantity, [_initial_force(reference_run, i)]
    elements = [elements_of(reference_run)]
    for factor in REFINEMENTS:
        scene = trials.build(trials.with_mesh(reference_run.model, factor * n_longest))
        run = simulate(scene, dt, dt, integrator=DEFAULT_INTEGRATOR)  # stable on every mesh
        forces.append(float(np.linalg.norm(quantity.in_scene(scene).history(run)[0])))
        elements.append(sum(scene.body(name).n_elements for name in reference_run.model.counts))
    pairs = (pairwise(each) for each in (forces, elements))
    powers = [_power(*each) for each in zip(*pairs, strict=True)]
    tolerance = absolute_tolerances(trials.goals, reference_run)[i]
    if min(powers) >= MIN_GROWTH_POWER and forces[-1] - forces[0] > tolerance:
        raise PlanError(
            quantity.name, tolerance, forces[-1] - forces[-2], quantity.unit, len(forces), 0.0
        )
