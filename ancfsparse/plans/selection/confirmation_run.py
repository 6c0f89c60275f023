"""Confirmation run: the selected mesh and step, run if that is short.

Its difference from the previous runs must agree with their error estimates.  If it is larger,
errors decrease more slowly than estimated, and mesh and step are selected again.  The confirmed run
is the result of the plan.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ancfsparse.plans.discretization_error.error_model import (
    ASYMPTOTIC_FRACTION,
    OBSERVED_FRACTION,
    ErrorModel,
    scaled,
)
from ancfsparse.plans.discretization_error.mesh_error import corrected_estimates
from ancfsparse.plans.discretization_error.richardson import Estimate
from ancfsparse.plans.discretization_error.run_estimates import elements_of
from ancfsparse.plans.selection.discretization_search import refine_separately
from ancfsparse.plans.trial_runs.run_differences import absolute_tolerances, goal_differences
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.plans.trial_runs.trial_runs import BASE_BUDGET, TRIAL_FRACTION, TrialRun, TrialRuns

MAX_SELECTIONS = 4  # of mesh and step
MAX_COST = 2.0  # of a confirmation run, over the base budget
# Work of a confirmation run over that of all trial runs before it.  For a slack line whose errors
# hardly decrease with the step, the selected step was so short that the run cost four times as much
# as the trial runs, and no plan resulted.
MAX_SPENT_RATIO = 2.0
MAX_WORK_RATIO = 3.0  # of a new selection to the previous one; above, more trial runs are made
AGREEMENT_FACTOR = 1.25  # by which a difference may exceed the estimate
AGREEMENT_FRACTION = 0.1  # of the tolerance, which is negligible in a difference
# Of 144 elements and 18, the difference agrees with any order of convergence: a slope angle was .33
# rad off, and .02 rad predicted.
NEAR_RATIO = 3.0  # of elements, or of steps, of two runs whose difference shows the error
MIN_ORDER_FRACTION = 0.5  # of the estimated orders, to which they may be corrected


def confirm_selection(trials: TrialRuns, error_model: ErrorModel) -> ErrorModel:
    """Run the selected mesh and step if that is short, and correct the estimates by the result.

    The error model is returned unchanged if a run is long.
    """
    if error_model.selected is not None:
        if error_model.excess(*error_model.selected) <= 1.0:
            return error_model
        error_model = replace(error_model, selected=None)  # modelling errors leave less
    known = _find_sufficient(trials, error_model)
    if known is not None:
        run = trials.run(trials.with_mesh(error_model.model, known[0]), known[1])
        assert run is not None  # it was one of the trial runs
        error_model = _correct_by_near_run(trials, error_model, error_model.time.runs[-1], run)
        if error_model.excess(*known) <= 1.0:
            return replace(error_model, selected=known)
    reference_run = error_model.reference_run
    confirmed = replace(error_model, safety_factor=ASYMPTOTIC_FRACTION)
    # A run from which errors were estimated does not confirm the estimates.
    is_known = confirmed.optimum() == (longest_count(reference_run), reference_run.steps)
    error_model = replace(
        confirmed, safety_factor=error_model.error_fraction if is_known else ASYMPTOTIC_FRACTION
    )
    for _ in range(MAX_SELECTIONS):
        selected = error_model.optimum()
        spent = sum(each.work for each in trials.run_costs)
        tried = _affordable(error_model, reference_run, selected, MAX_SPENT_RATIO * spent)
        if tried is None:
            break
        run = trials.run(trials.with_mesh(error_model.model, tried[0]), tried[1])
        if run is None:
            break
        before = error_model = replace(  # the size of a quantity may depend on mesh and steps
            error_model, tolerances=tuple(absolute_tolerances(trials.goals, run))
        )
        error_model = _corrected_by_residual(
            trials, error_model, reference_run, run
        ) or _corrected_by_difference(
            error_model, reference_run, tried, goal_differences(trials.goals, reference_run, run)
        )
        if error_model.excess(*tried) <= 1.0:
            error_model = _correct_by_near_run(trials, error_model, reference_run, run)
        if error_model.excess(*tried) <= 1.0:
            return replace(error_model, selected=tried)
        limit = MAX_WORK_RATIO * before.work(*selected)
        if error_model.is_simultaneous and error_model.optimal_work > limit:
            longer = refine_separately(trials, error_model.model, None, None)
            return confirm_selection(trials, longer.with_effects(error_model.effects))
        if error_model is before and tried != selected:  # estimates hold for the selection too
            return error_model
        reference_run, error_model = run, _extended(error_model, run)
        if tried == error_model.optimum():  # no better resolution can be reached
            break
    return replace(error_model, safety_factor=OBSERVED_FRACTION)


def _extended(error_model: ErrorModel, run: TrialRun) -> ErrorModel:
    """Return the error model with a run on a finer mesh, from which errors are extrapolated."""
    mesh = error_model.mesh
    if mesh is None or elements_of(run) <= elements_of(mesh.runs[-1]):
        return error_model
    return replace(error_model, mesh=replace(mesh, runs=(*mesh.runs, run)))


def _corrected_by_residual(
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


def _correct_by_near_run(
    trials: TrialRuns, error_model: ErrorModel, reference_run: TrialRun, run: TrialRun
) -> ErrorModel:
    """Return the error model with estimates that agree with a run of half the mesh and steps.

    The error of a reference run that is far from the run hides whether errors still decrease there.
    """
    counts = longest_count(reference_run), longest_count(run)
    is_near = counts[1] <= NEAR_RATIO * counts[0] and run.steps <= NEAR_RATIO * reference_run.steps
    if is_near or trials.t_end is None or isinstance(trials.integrator, SolutionMethod):
        return error_model
    steps = run.steps if error_model.fixed_steps else (run.steps + 1) // 2
    model = trials.with_mesh(error_model.model, max(1.0, round(counts[1] / 2)))
    near = trials.run(model, steps)
    if near is None:
        return error_model
    differences = goal_differences(trials.goals, near, run)
    return _corrected_by_difference(error_model, near, (counts[1], run.steps), differences)


def _affordable(
    error_model: ErrorModel, reference_run: TrialRun, selected: tuple[float, int], max_work: float
) -> tuple[float, int] | None:
    """Return the selected resolution, or a coarser one at a fraction of its cost; None if none.

    Its work is at most `max_work`, unless that is below the base budget.
    """
    work = error_model.work(*selected)
    budget = max(MAX_COST * BASE_BUDGET, min(TRIAL_FRACTION * work, max_work))
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

    def fraction(run: TrialRun) -> float:
        is_reference = run is error_model.reference_run
        return error_model.error_fraction if is_reference else OBSERVED_FRACTION

    sufficient = [
        (error_model.work(longest_count(each), n), (longest_count(each), n))
        for each in meshes
        for n in steps
        if (run := trials.find(each.model, n)) is not None
        and error_model.excess(longest_count(each), n) <= fraction(run)
        and _differs_little(trials, error_model, run)
    ]
    return min(sufficient)[1] if sufficient else None


def _differs_little(trials: TrialRuns, error_model: ErrorModel, run: TrialRun) -> bool:
    """Return True if a run differs from the reference run by less than the tolerances."""
    differences = goal_differences(trials.goals, run, error_model.reference_run)
    return all(d <= x for d, x in zip(differences, error_model.tolerances, strict=True))


def longest_count(run: TrialRun) -> float:
    """Return the number of elements on the longest automatic beam."""
    return float(max(run.model.counts.values(), default=1))


def _corrected_by_difference(
    error_model: ErrorModel,
    reference_run: TrialRun,
    resolution: tuple[float, int],
    differences: Sequence[float],
) -> ErrorModel:
    """Return the error model with estimates that agree with measured differences."""
    times, meshes, agrees = list(error_model.time.estimates), [], True
    if error_model.mesh is not None:
        meshes = list(error_model.mesh.estimates)
    for i, difference in enumerate(differences):
        parts = [(times[i], float(reference_run.steps), float(resolution[1]))]
        if meshes:
            counts = (longest_count(reference_run), resolution[0])
            here, there = (n * error_model.density for n in counts)
            parts.append((meshes[i], here, there))
        negligible = AGREEMENT_FRACTION * error_model.tolerances[i]
        if difference <= AGREEMENT_FACTOR * _difference(parts, 1.0) + negligible:
            continue
        agrees = False
        low, high = MIN_ORDER_FRACTION, 1.0
        while high - low > 0.01:
            middle = 0.5 * (low + high)
            is_below = _difference(parts, middle) < difference
            low, high = (low, middle) if is_below else (middle, high)
        expected = _difference(parts, low)
        new = [each.with_order(low * each.order) for each, _, _ in parts]
        if expected > 0.0:
            factor = max(1.0, difference / expected)
            new = [replace(each, error=factor * each.error) for each in new]
        else:  # no difference at all was expected
            new = [replace(each, error=each.error + difference) for each in new]
        times[i] = new[0]
        if meshes:
            meshes[i] = new[1]
    if agrees:
        return error_model
    mesh = error_model.mesh
    return replace(
        error_model,
        time=replace(error_model.time, estimates=tuple(times)),
        mesh=None if mesh is None else replace(mesh, estimates=tuple(meshes)),
    )


def _difference(parts: Sequence[tuple[Estimate, float, float]], order_fraction: float) -> float:
    """Return the expected difference of two solutions for a fraction of the estimated orders."""
    reduced = ((each.with_order(order_fraction * each.order), a, b) for each, a, b in parts)
    return sum(abs(each.at(a) - each.at(b)) for each, a, b in reduced)
