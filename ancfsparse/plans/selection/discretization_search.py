"""Trial runs of one model, until its errors can be predicted for every mesh and step.

Where both the step and a mesh are open they are refined together.  For equilibria, methods without
steps and given steps, the error of the steps is estimated on a coarse mesh, and the mesh alone is
refined.
"""

from __future__ import annotations

from dataclasses import replace

from ancfsparse.errors import PlanError, StepError
from ancfsparse.kernels.catalog import convergence_order
from ancfsparse.plans.discretization_error.error_model import ErrorModel
from ancfsparse.plans.discretization_error.mesh_error import (
    COARSEST_COUNT,
    error_of_given_meshes,
    mesh_error,
)
from ancfsparse.plans.discretization_error.refinement import (
    refine_other_elements,
    refine_steps,
    refine_together,
)
from ancfsparse.plans.discretization_error.run_estimates import RunEstimates, no_time_error
from ancfsparse.plans.discretization_error.run_series import STEP_GROWTH, Refinement
from ancfsparse.plans.discretization_error.sampling_error import sampling_error
from ancfsparse.plans.models.model import Model, coarse_count, open_bodies
from ancfsparse.plans.trial_runs.cost_model import fit_cost_model
from ancfsparse.plans.trial_runs.run_differences import absolute_tolerances
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.plans.trial_runs.trial_runs import BASE_BUDGET, TRIAL_FRACTION, TrialRun, TrialRuns
from ancfsparse.scene import Scene


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
    while True:
        failed = trials.failed
        try:
            return _search(trials, model, finer, fixed_steps, near)
        except StepError:
            if trials.failed <= failed or not trials.costs:  # shorter steps would not help
                raise


def _search(
    trials: TrialRuns,
    model: Model,
    finer: Scene | None,
    fixed_steps: int | None,
    near: ErrorModel | None,
) -> ErrorModel:
    order = _order(trials.scene, model)
    n_longest = coarse_count(trials.scene, COARSEST_COUNT)
    coarse = trials.with_mesh(model, n_longest)
    has_steps = trials.t_end is not None and not isinstance(trials.integrator, SolutionMethod)
    is_together = has_steps and fixed_steps is None
    if is_together:
        refinement = _refine_like(trials, model, order, near) or refine_together(
            trials, model, order
        )
    else:
        refinement = Refinement(_error_on_coarse_mesh(trials, coarse, fixed_steps), None)
    time = refinement.time
    steps = time.runs[-1].steps
    given = (0.0,) * len(trials.goals)
    if finer is not None:
        last = time.runs[-1]
        where = (last.model, last.steps) if refinement.combined_errors else (coarse, steps)
        given = tuple(error_of_given_meshes(trials, finer, *where, order))

    def build_error_model(mesh: RunEstimates | None) -> ErrorModel:
        last = mesh.runs[-1] if mesh else time.runs[-1]
        graded = model if mesh is None else replace(model, gradings=last.model.gradings)
        is_selected = refinement.combined_errors is not None
        longest = float(max(last.model.counts.values(), default=1))
        return ErrorModel(
            graded,
            time,
            mesh,
            given,
            tuple(absolute_tolerances(trials.goals, last)),
            fit_cost_model(trials.costs),
            fixed_steps,
            base=trials.base if trials.t_end is not None else 1,
            order=order,
            selected=(longest, last.steps) if is_selected else None,
            combined_errors=refinement.combined_errors if finer is None else None,
            is_bound=refinement.is_bound,
        )

    def is_affordable(last: TrialRun) -> bool:
        """Return True if a finer run costs little compared with the planned run."""
        return trials.total_work < max(BASE_BUDGET, TRIAL_FRACTION * last.cost.work)

    if refinement.mesh is not None or not coarse.counts:
        return build_error_model(refinement.mesh)
    return build_error_model(mesh_error(trials, coarse, n_longest, steps, order, is_affordable))


def _refine_like(
    trials: TrialRuns, model: Model, order: int, near: ErrorModel | None
) -> Refinement | None:
    """Return the errors with the time error of other elements; None if there are none."""
    if near is None or not near.reference_run.model.counts:
        return None
    return refine_other_elements(trials, model, order, near.time, near.reference_run)


def _error_on_coarse_mesh(
    trials: TrialRuns, coarse: Model, fixed_steps: int | None
) -> RunEstimates:
    """Return the error of given steps or saved states on a coarse mesh; none of an equilibrium."""
    if trials.t_end is None:
        return no_time_error(trials, coarse)
    if isinstance(trials.integrator, SolutionMethod):
        return sampling_error(trials, coarse)
    assert fixed_steps is not None
    steps = fixed_steps
    while steps <= trials.failed:
        steps *= STEP_GROWTH
    first = trials.run(coarse, steps)
    time = None if first is None else refine_steps(trials, [first])
    if time is not None:
        return time
    if trials.failure is not None:
        raise trials.failure
    quantity, tolerance = trials.goals[0].quantity, 0.0
    raise PlanError(quantity.name, tolerance, 0.0, quantity.unit, len(trials.done))


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
