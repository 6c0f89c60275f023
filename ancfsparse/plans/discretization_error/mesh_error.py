"""Error of the mesh: the same steps with more elements, until the error is known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ancfsparse.errors import StepError
from ancfsparse.plans.discretization_error.mesh_grading import MIN_GRADING_GAIN, grade_meshes
from ancfsparse.plans.discretization_error.residual_correction import (
    corrections,
    estimate_from_corrections,
)
from ancfsparse.plans.discretization_error.richardson import Estimate
from ancfsparse.plans.discretization_error.run_estimates import (
    RunEstimates,
    elements_of,
    mesh_estimates,
    mesh_orders,
)
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.trial_runs.run_differences import absolute_tolerances, goal_differences
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns
from ancfsparse.scene import Scene

# On four elements the motion of the paper's pendulum is so irregular that steps do not converge.
COARSEST_COUNT = 8.0  # elements on the longest beam of the coarsest mesh
GROWTH = 1.5  # ratio of the numbers of elements of successive meshes
MAX_MESHES = 12
MAX_GROWTH = 3.0  # ratio for equilibria, whose next mesh may be the last


def mesh_error(
    trials: TrialRuns,
    model: Model,
    n_longest: float,
    steps: int,
    order: int,
    is_affordable: Callable[[TrialRun], bool],
) -> RunEstimates:
    """Refine the mesh until the error of every quantity can be predicted.

    Parameters
    ----------
    trials, model
        Runs, and the elements.
    n_longest : float
        Elements on the longest beam of the coarsest mesh.
    steps : int
        Number of steps, for which the motions on all meshes have about the same error.
    order : int
        Order of positions in the length of the elements.
    is_affordable : callable
        Returns True if a finer mesh than that of a run may be tried.

    Raises
    ------
    StepError
        If a run on a finer mesh needs shorter steps.
    """
    runs: list[TrialRun] = []
    while True:
        run = _run(trials, trials.with_mesh(model, n_longest), steps)
        if not runs or elements_of(run) > elements_of(runs[-1]):
            runs.append(run)
        n_longest *= GROWTH
        estimates = _estimate(trials, runs, order)
        if estimates is None:
            continue
        result = RunEstimates(estimates, tuple(runs))
        if _is_enough(trials, runs, estimates) or len(runs) == MAX_MESHES:
            return result
        if len(runs) > 2 and not is_affordable(run):
            return result
        growth = _count(trials, result) / elements_of(run)
        gradings, gain = grade_meshes(trials.scene, run)
        if len(runs) > 1 and not model.gradings and gain > max(MIN_GRADING_GAIN, 2.0 / growth):
            model, n_longest, runs = replace(model, gradings=gradings), n_longest / GROWTH**2, []
        elif trials.t_end is None and corrections(trials, run) is not None:
            # The next run may be the last.
            n_longest = max(n_longest, min(growth, MAX_GROWTH) * n_longest / GROWTH)


def _count(trials: TrialRuns, result: RunEstimates) -> float:
    """Return the predicted number of elements that meets the tolerances."""
    tolerances = absolute_tolerances(trials.goals, result.runs[-1])
    pairs = zip(result.estimates, tolerances, strict=True)
    return max(each.resolution_for(tolerance) for each, tolerance in pairs)


def _run(trials: TrialRuns, model: Model, steps: int) -> TrialRun:
    run = trials.run(model, steps)
    if run is None:
        assert trials.failure is not None
        raise trials.failure
    return run


def _estimate(
    trials: TrialRuns, runs: Sequence[TrialRun], order: int
) -> tuple[Estimate, ...] | None:
    """Estimate the error of the last mesh for every quantity; None if there are too few.

    Differences of meshes are the last resort: with nodes at given positions, parts of two meshes
    may be the same, whereas corrections halve every element.
    """
    if trials.t_end is None:
        known = (corrected_estimates(trials, some, order) for some in (runs[-2:], runs[-1:]))
        estimates = next((each for each in known if each is not None), None)
        if estimates is not None:
            return estimates
    return mesh_estimates(trials, runs, order) if len(runs) > 1 else None


def corrected_estimates(
    trials: TrialRuns, runs: Sequence[TrialRun], order: int
) -> tuple[Estimate, ...] | None:
    """Estimate the error of the last of one or two meshes of an equilibrium by corrections.

    None if a correction gives no estimate.
    """
    known = [each for each in (corrections(trials, run) for run in runs) if each is not None]
    if len(known) < len(runs):
        return None
    counts = [elements_of(run) for run in runs]
    columns = zip(zip(*known, strict=True), mesh_orders(trials, order), strict=True)
    return tuple(estimate_from_corrections(counts, *each) for each in columns)


def error_of_given_meshes(
    trials: TrialRuns, finer: Scene, model: Model, steps: int, order: int
) -> list[float]:
    """Estimate the error of meshes specified by the user, for every quantity [its unit].

    By one run of a `finer` scene, which has two elements for every specified one.
    """
    other = TrialRuns(
        finer,
        trials.t_end,
        trials.goals,
        trials.integrator,
        trials.base,
        trials.start,
        run_costs=trials.run_costs,
    )
    coarse = _run(trials, model, steps)
    try:
        fine = _run(other, model, steps)
    except StepError:
        trials.done["meshes given", steps] = None  # these steps are too long for the finer scene
        raise
    trials.seconds += other.seconds
    differences = goal_differences(trials.goals, coarse, fine)
    # The difference is e(n) - e(2 n) = e(n) (1 - 2^-p).
    return [
        d / (1.0 - 2.0**-p) for d, p in zip(differences, mesh_orders(trials, order), strict=True)
    ]


def _is_enough(trials: TrialRuns, runs: Sequence[TrialRun], estimates: Sequence[Estimate]) -> bool:
    """Return True if errors are within the tolerances, or can be extrapolated to them."""
    pairs = zip(estimates, absolute_tolerances(trials.goals, runs[-1]), strict=True)
    return all(each.conservative <= tolerance for each, tolerance in pairs)
