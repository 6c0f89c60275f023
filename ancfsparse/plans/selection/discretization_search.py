"""Trial runs of one model, until its errors can be predicted for every mesh and step."""

from __future__ import annotations

from dataclasses import replace

from ancfsparse.errors import PlanError, StepError
from ancfsparse.plans.discretization_error.error_model import ErrorModel
from ancfsparse.plans.discretization_error.low_regularity import refine_to_bounds
from ancfsparse.plans.discretization_error.mesh_error import (
    COARSEST_COUNT,
    GROWTH,
    error_of_given_meshes,
    mesh_error,
)
from ancfsparse.plans.discretization_error.mesh_grading import grade_meshes
from ancfsparse.plans.discretization_error.run_estimates import RunEstimates
from ancfsparse.plans.discretization_error.sampling_error import sampling_error
from ancfsparse.plans.discretization_error.simultaneous_refinement import (
    refine_other_elements,
    refine_together,
)
from ancfsparse.plans.discretization_error.time_error import no_time_error, time_error
from ancfsparse.plans.models.model import Model, coarse_count, convergence_order, open_bodies
from ancfsparse.plans.trial_runs.cost_model import fit_cost_model
from ancfsparse.plans.trial_runs.run_differences import absolute_tolerances
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.plans.trial_runs.trial_runs import BASE_BUDGET, TRIAL_FRACTION, TrialRun, TrialRuns
from ancfsparse.scene import Scene

MAX_COARSE_RATIO = 4.0  # refinement of the coarsest mesh if steps do not converge on it
MAX_STEP_EXCESS = 3.0  # error of the steps over the tolerance, where meshes are compared
MIN_GRADING_GAIN = 1.5  # elements of a uniform mesh over those of a graded one
MIN_WORK_SAVED = 2e6  # residuals of one coordinate, a few times the set-up of two trial runs
GRADING_RUNS = 4.0  # trial runs that lead to graded meshes, each with the work of the last


def search(
    trials: TrialRuns,
    model: Model,
    finer: Scene | None,
    fixed_steps: int | None,
    near: ErrorModel | None = None,
) -> ErrorModel:
    """Run trials of one model until its errors can be predicted.

    Parameters
    ----------
    trials : TrialRuns
        Runs.
    model : Model
        The elements of all beams with automatic elements.
    finer : Scene or None
        The scene with every specified mesh halved; None if all meshes are automatic.
    fixed_steps : int or None
        Number of steps if the step was specified.
    near : ErrorModel, optional
        Error model of other elements, with about the same error of the steps.

    Raises
    ------
    StepError
        If no step is short enough.
    PlanError
        If the motions do not converge.
    """
    order = _order(trials.scene, model)
    if _is_open(trials, model, finer, fixed_steps):
        result = _refine_together(trials, model, order, near)
        if result is not None:
            return result
    try:
        return refine_separately(trials, model, finer, fixed_steps)
    except PlanError as failure:
        has_no_steps = trials.t_end is None or isinstance(trials.integrator, SolutionMethod)
        if has_no_steps or failure.steps is not None:
            raise
        return refine_to_bounds(trials, model, finer, fixed_steps, order, failure)


def refine_separately(
    trials: TrialRuns, model: Model, finer: Scene | None, fixed_steps: int | None
) -> ErrorModel:
    """Refine first the steps, then the mesh, until their orders are observed; see `search`.

    If a run on a finer mesh fails, both are refined again with shorter steps than failed.
    """
    while True:
        failed = trials.failed
        try:
            return _refine_once(trials, model, finer, fixed_steps)
        except StepError:
            if trials.failed <= failed:
                raise


def _refine_once(
    trials: TrialRuns, model: Model, finer: Scene | None, fixed_steps: int | None
) -> ErrorModel:
    order = _order(trials.scene, model)
    n_longest, coarse, time = _coarse_time_error(trials, model, fixed_steps)
    steps = _steps_for_meshes(trials, time)

    def is_affordable(last: TrialRun) -> bool:
        """Return True if a finer run costs little compared with the planned run."""
        planned = last.cost.work * time.runs[-1].steps / steps
        return trials.total_work < max(BASE_BUDGET, TRIAL_FRACTION * planned)

    given = (0.0,) * len(trials.goals)

    def build_error_model(mesh: RunEstimates | None) -> ErrorModel:
        last = mesh.runs[-1] if mesh else time.runs[-1]
        graded = model if mesh is None else replace(model, gradings=last.model.gradings)
        tolerances = tuple(absolute_tolerances(trials.goals, last))
        cost = fit_cost_model(trials.costs)
        base = trials.base if trials.t_end is not None else 1
        return ErrorModel(
            graded, time, mesh, given, tolerances, cost, fixed_steps, base=base, order=order
        )

    def grade(mesh: RunEstimates, done: bool) -> Model | None:
        """Return graded meshes if two runs with them, in place of the next one, reduce the work."""
        last = mesh.runs[-1]
        gradings, gain = grade_meshes(trials.scene, last)
        if gain < MIN_GRADING_GAIN:
            return None
        planned = build_error_model(mesh)
        work = planned.optimal_work
        more = 1.0 + 1.0 / GROWTH - (0.0 if done else GROWTH)
        saved = work * (1.0 - 1.0 / gain) - more * last.cost.work
        pays = saved > (MIN_WORK_SAVED if done else 0.0)
        return replace(last.model, gradings=gradings) if pays else None

    if finer is not None:
        given = tuple(error_of_given_meshes(trials, finer, coarse, steps, order))
    if not coarse.counts:
        return build_error_model(None)
    return build_error_model(
        mesh_error(trials, coarse, n_longest, steps, order, is_affordable, grade)
    )


def _is_open(trials: TrialRuns, model: Model, finer: Scene | None, fixed_steps: int | None) -> bool:
    """Return True if both mesh and steps of a motion can be refined."""
    counts = trials.with_mesh(model, COARSEST_COUNT).counts
    has_steps = trials.t_end is not None and not isinstance(trials.integrator, SolutionMethod)
    return has_steps and bool(counts) and finer is None and fixed_steps is None


def _refine_together(
    trials: TrialRuns, model: Model, order: int, near: ErrorModel | None
) -> ErrorModel | None:
    """Refine mesh and steps together; None if that gives no error model."""
    assert not isinstance(trials.integrator, SolutionMethod)
    result = None
    if near is not None and near.reference_run.model.counts:
        result = refine_other_elements(trials, model, order, near.time, near.reference_run)
    if result is None:
        result = refine_together(trials, model, order, trials.step_order)
    if result is None:
        return None
    last = result.mesh.runs[-1]
    selected = None
    if result.combined_errors is not None:
        selected = float(max(last.model.counts.values())), last.steps
    error_model = ErrorModel(
        model,
        result.time,
        result.mesh,
        (0.0,) * len(trials.goals),
        tuple(absolute_tolerances(trials.goals, last)),
        fit_cost_model([run.cost for run in result.runs]),
        None,
        selected=selected,
        base=trials.base,
        combined_errors=result.combined_errors,
        is_simultaneous=True,
    )
    return None if selected is None and _pays_to_grade(trials, error_model) else error_model


def _pays_to_grade(trials: TrialRuns, error_model: ErrorModel) -> bool:
    """Return True if graded meshes save more work than the trial runs that lead to them."""
    last = error_model.reference_run
    _, gain = grade_meshes(trials.scene, last)
    saved = error_model.optimal_work * (1.0 - 1.0 / gain)
    return gain >= MIN_GRADING_GAIN and saved > MIN_WORK_SAVED + GRADING_RUNS * last.cost.work


def _coarse_time_error(
    trials: TrialRuns, model: Model, fixed_steps: int | None
) -> tuple[float, Model, RunEstimates]:
    """Return the coarsest mesh on which steps converge, and the error of the steps there."""
    n_longest = first = coarse_count(trials.scene, COARSEST_COUNT)
    coarse = trials.with_mesh(model, n_longest)
    if trials.t_end is None:
        return n_longest, coarse, no_time_error(trials, coarse)
    if isinstance(trials.integrator, SolutionMethod):
        return n_longest, coarse, sampling_error(trials, coarse)
    order = trials.step_order
    while True:
        coarse = trials.with_mesh(model, n_longest)
        is_last = not coarse.counts or n_longest >= first * MAX_COARSE_RATIO
        try:
            return n_longest, coarse, time_error(trials, coarse, order, not is_last, fixed_steps)
        except PlanError:
            if is_last:
                raise
        n_longest *= 2.0


def _steps_for_meshes(trials: TrialRuns, time: RunEstimates) -> int:
    """Return the smallest number of steps accurate enough for a comparison of meshes."""
    tolerances = absolute_tolerances(trials.goals, time.runs[-1])
    for run in time.runs[:-1]:
        pairs = zip(time.estimates, tolerances, strict=True)
        if all(each.at(run.steps) <= MAX_STEP_EXCESS * tolerance for each, tolerance in pairs):
            return run.steps
    return time.runs[-1].steps


def _order(scene: Scene, model: Model) -> int:
    """Return the lowest order of all elements."""
    automatic = {beam.name for beam in open_bodies(scene) if "element" in beam.automatic}
    orders = [element.order for element in model.elements.values()]
    orders += [
        convergence_order(body.element if not body.kind.package else None)
        for body in scene.beams
        if body.name not in automatic
    ]
    return min(orders, default=4)
