"""Confirmation run: the selected mesh and step, run if that is short.

Its difference from the previous runs must agree with their error estimates.  If it is larger,
errors decrease more slowly than estimated, and mesh and step are selected again.  The confirmed run
is the result of the plan.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ancfsparse.errors import InputError, PlanError, StepError
from ancfsparse.plans.discretization_error.error_model import (
    SAFETY_FRACTION,
    ErrorModel,
    scaled,
)
from ancfsparse.plans.discretization_error.mesh_error import GROWTH, corrected_estimates
from ancfsparse.plans.discretization_error.mesh_grading import MIN_GRADING_GAIN, grade_meshes
from ancfsparse.plans.discretization_error.richardson import MIN_ORDER, Estimate
from ancfsparse.plans.discretization_error.run_estimates import RunEstimates, elements_of
from ancfsparse.plans.selection.discretization_search import search
from ancfsparse.plans.trial_runs.run_differences import absolute_tolerances, goal_differences
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.plans.trial_runs.trial_runs import BASE_BUDGET, TRIAL_FRACTION, TrialRun, TrialRuns

MAX_SELECTIONS = 8  # of mesh and step
MAX_COST = 2.0  # of a confirmation run, over the base budget
# A mesh shows no order: next to a force it was 1.5, which took 1.01 times the tolerance.
OWN_FRACTION = 0.5  # of the tolerance, for the run from which an error was estimated without order
AGREEMENT_FACTOR = 1.25  # by which a difference may exceed the estimate
AGREEMENT_FRACTION = 0.1  # of the tolerance, which is negligible in a difference
# A position changed more between 3700 and 4100 steps than their errors differ: an order of a half
# followed, and 16 tolerances were predicted where the error was .1.
MIN_RATIO = 1.25  # of elements, or of steps, of two runs whose difference corrects an order
# Of 144 elements and 18, the difference agrees with any order of convergence: a slope angle was .33
# rad off, and .02 rad predicted.
MAX_REFINEMENT = 3.0  # of elements, or of steps, of two runs whose difference shows the error


def confirm_selection(trials: TrialRuns, error_model: ErrorModel) -> ErrorModel:
    """Run the selected mesh and step if that is short, and correct the estimates by the result.

    The error model is returned unchanged if a run is long.
    """
    if error_model.selected is not None:
        if error_model.excess(*error_model.selected) <= 1.0:
            return error_model
        # Modelling errors leave less.
        error_model = replace(error_model, selected=None, combined_errors=None)
    known = _find_sufficient(trials, error_model)
    if known is not None:
        return replace(error_model, selected=known)
    reference_run = error_model.reference_run
    for _ in range(MAX_SELECTIONS):
        graded = _grade(trials, error_model, reference_run)
        if graded is not None:
            return confirm_selection(trials, graded)
        selected = _near(trials, reference_run, error_model.optimum())
        tried = _affordable(error_model, reference_run, selected)
        if tried is None:
            break
        if tried == resolution(reference_run) and error_model.excess(*tried) > _limit(
            error_model, reference_run
        ):
            tried = GROWTH * tried[0], tried[1]
        run = trials.run(trials.with_mesh(error_model.model, tried[0]), tried[1])
        if run is None:
            break
        before = error_model = replace(  # the size of a quantity may depend on mesh and steps
            error_model, tolerances=tuple(absolute_tolerances(trials.goals, run))
        )
        error_model = _correct_by_residual(
            trials, error_model, reference_run, run
        ) or _correct_by_difference(trials, error_model, reference_run, run)
        if error_model.excess(*tried) <= 1.0:
            return replace(error_model, selected=tried)
        if error_model is before and tried != selected:  # estimates hold for the selection too
            return error_model
        reference_run, error_model = run, _extended(error_model, run)
        if tried == error_model.optimum():  # no better resolution can be reached
            break
    return error_model


def _extended(error_model: ErrorModel, run: TrialRun) -> ErrorModel:
    """Return the error model with a run on a finer mesh, from which errors are extrapolated."""
    mesh = error_model.mesh
    if mesh is None or elements_of(run) <= elements_of(mesh.runs[-1]):
        return error_model
    return replace(error_model, mesh=replace(mesh, runs=(*mesh.runs, run)))


def _correct_by_residual(
    trials: TrialRuns, error_model: ErrorModel, reference_run: TrialRun, run: TrialRun
) -> ErrorModel | None:
    """Return the error model of an equilibrium with residual corrections; None if they fail."""
    if trials.t_end is not None or error_model.mesh is None:
        return None
    is_other_mesh = elements_of(reference_run) != elements_of(run)
    runs = (reference_run, run) if is_other_mesh else (run,)
    estimates = corrected_estimates(trials, runs, error_model.order)
    if estimates is None:
        return None
    return replace(error_model, mesh=replace(error_model.mesh, estimates=estimates))


def _grade(
    trials: TrialRuns, error_model: ErrorModel, reference_run: TrialRun
) -> ErrorModel | None:
    """Return the error model of graded meshes, if they save more work than two runs on them."""
    if error_model.mesh is None or error_model.model.gradings or trials.t_end is None:
        return None
    gradings, gain = grade_meshes(trials.scene, reference_run)
    saved = error_model.optimal_work * (1.0 - 1.0 / gain)
    if gain < MIN_GRADING_GAIN or saved < reference_run.cost.work:
        return None
    model = replace(error_model.model, gradings=gradings)
    try:
        graded = search(trials, model, None, error_model.fixed_steps, error_model)
    except (InputError, StepError, PlanError):
        return None
    given = error_model.given_mesh_errors
    return replace(graded, given_mesh_errors=given, effects=error_model.effects)


def _near(
    trials: TrialRuns, reference_run: TrialRun, selected: tuple[float, int]
) -> tuple[float, int]:
    """Return the selected resolution, or one between whose difference shows the error."""
    if trials.t_end is None or isinstance(trials.integrator, SolutionMethod):
        return selected
    n_longest, steps = selected
    n_longest = min(n_longest, math.floor(MAX_REFINEMENT * longest_count(reference_run)))
    return n_longest, min(steps, round(MAX_REFINEMENT * reference_run.steps))


def _affordable(
    error_model: ErrorModel, reference_run: TrialRun, selected: tuple[float, int]
) -> tuple[float, int] | None:
    """Return the selected resolution, or a coarser one at a fraction of its cost; None if none."""
    budget = max(MAX_COST * BASE_BUDGET, TRIAL_FRACTION * error_model.work(*selected))
    tried = selected
    known = error_model.excess(longest_count(reference_run), reference_run.steps)
    while error_model.work(*tried) > budget:
        tried = scaled(error_model, *tried, 2.0)
        if error_model.excess(*tried) >= known:
            return None
    return tried


def _find_sufficient(trials: TrialRuns, error_model: ErrorModel) -> tuple[float, int] | None:
    """Return mesh and steps of the cheapest trial run within the tolerances; None if none."""
    time = error_model.time.runs
    mesh = error_model.mesh.runs if error_model.mesh is not None else ()
    meshes = {id(run.model): run for run in (*time[:1], *mesh)}.values()
    steps = {run.steps for run in time if error_model.fixed_steps in (None, run.steps)}

    sufficient = [
        (error_model.work(longest_count(each), n), (longest_count(each), n))
        for each in meshes
        for n in steps
        if (run := trials.find(each.model, n)) is not None
        and error_model.excess(longest_count(each), n) <= _limit(error_model, run)
        and _differs_little(trials, error_model, run)
    ]
    return min(sufficient)[1] if sufficient else None


def _limit(error_model: ErrorModel, run: TrialRun) -> float:
    """Return the fraction of the tolerances up to which a trial run meets them."""
    is_own = run is error_model.reference_run and not error_model.is_observed
    return OWN_FRACTION if is_own else SAFETY_FRACTION


def _differs_little(trials: TrialRuns, error_model: ErrorModel, run: TrialRun) -> bool:
    """Return True if a run differs from the reference run by less than the tolerances."""
    differences = goal_differences(trials.goals, run, error_model.reference_run)
    return all(d <= x for d, x in zip(differences, error_model.tolerances, strict=True))


def resolution(run: TrialRun) -> tuple[float, int]:
    """Return the number of elements on the longest automatic beam, and of steps."""
    return longest_count(run), run.steps


def longest_count(run: TrialRun) -> float:
    """Return the number of elements on the longest automatic beam."""
    return float(max(run.model.counts.values(), default=1))


def _correct_by_difference(
    trials: TrialRuns, error_model: ErrorModel, reference_run: TrialRun, run: TrialRun
) -> ErrorModel:
    """Return the error model with estimates that agree with the difference of two runs.

    If it is larger, and the runs differ in mesh and steps, one run with the mesh of the first and
    the steps of the second divides it.
    """
    goals, mesh, time = trials.goals, error_model.mesh, error_model.time
    counts = longest_count(reference_run), longest_count(run)
    steps = float(reference_run.steps), float(run.steps)
    by_mesh = by_steps = goal_differences(goals, reference_run, run)
    if mesh is not None and counts[0] != counts[1] and steps[0] != steps[1]:
        expected = (
            _change(one, *steps) + _change(other, *(n * error_model.density for n in counts))
            for one, other in zip(time.estimates, mesh.estimates, strict=True)
        )
        columns = zip(by_mesh, expected, error_model.tolerances, strict=True)
        if all(_agrees(*each) for each in columns):
            return error_model
        between = trials.run(reference_run.model, run.steps)
        if between is not None:
            by_steps = goal_differences(goals, reference_run, between)
            by_mesh = goal_differences(goals, between, run)
    new_time, new_mesh = _correct(time, steps, by_steps, error_model.tolerances), mesh
    if mesh is not None:
        elements = counts[0] * error_model.density, counts[1] * error_model.density
        new_mesh = _correct(mesh, elements, by_mesh, error_model.tolerances)
    if new_time is time and new_mesh is mesh:
        return error_model
    return replace(error_model, time=new_time, mesh=new_mesh)


def _correct(
    known: RunEstimates,
    resolutions: tuple[float, float],
    differences: Sequence[float],
    tolerances: Sequence[float],
) -> RunEstimates:
    """Return estimates of one source of error that agree with differences of two resolutions.

    The order is reduced, as far as it may be extrapolated; then the error is increased.
    """
    if resolutions[0] == resolutions[1]:
        return known
    is_near = max(resolutions) < MIN_RATIO * min(resolutions)
    out = list(known.estimates)
    columns = zip(known.estimates, differences, tolerances, strict=True)
    for i, (each, difference, tolerance) in enumerate(columns):
        if _agrees(difference, _change(each, *resolutions), tolerance):
            continue
        low, high = each.order if is_near else min(MIN_ORDER, each.order), each.order
        while high - low > 0.01 * each.order:
            middle = 0.5 * (low + high)
            is_below = _change(each.with_order(middle), *resolutions) < difference
            low, high = (low, middle) if is_below else (middle, high)
        new = each.with_order(low)
        expected = _change(new, *resolutions)
        if expected > 0.0:
            out[i] = replace(new, error=max(1.0, difference / expected) * new.error)
        else:  # no difference at all was expected
            out[i] = replace(new, error=new.error + difference)
    return known if out == list(known.estimates) else replace(known, estimates=tuple(out))


def _agrees(difference: float, expected: float, tolerance: float) -> bool:
    """Return True if a difference is not larger than expected, or negligible."""
    return difference <= AGREEMENT_FACTOR * expected + AGREEMENT_FRACTION * tolerance


def _change(known: Estimate, one: float, other: float) -> float:
    """Return the expected difference of two resolutions."""
    return abs(known.at(one) - known.at(other))
