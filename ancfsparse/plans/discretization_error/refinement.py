"""Refine mesh and steps together until the error of the last trial run is known.

Each run has half the step of the previous one and, where meshes are automatic, more elements.  If
the last run is accurate enough (see `run_series`) it is selected.  If its error is far larger than
the tolerance but decreases regularly, steps alone are refined on the coarser of the last two
meshes, which divides the error into parts of mesh and steps that are extrapolated.

The first run has no numerical damping, so that the vibrations removed by long damped steps are part
of the first difference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ancfsparse.plans.discretization_error.error_model import SAFETY_FRACTION
from ancfsparse.plans.discretization_error.mesh_error import GROWTH
from ancfsparse.plans.discretization_error.mesh_grading import MIN_GRADING_GAIN, grade_meshes
from ancfsparse.plans.discretization_error.richardson import MIN_ORDER
from ancfsparse.plans.discretization_error.run_estimates import (
    RunEstimates,
    elements_of,
    is_close,
    mesh_estimates,
    step_estimates,
)
from ancfsparse.plans.discretization_error.run_series import (
    LOW_ORDER,
    N_BOUND,
    STEP_GROWTH,
    Refinement,
    RunSeries,
)
from ancfsparse.plans.discretization_error.vibrations import resolves_vibrations
from ancfsparse.plans.models.model import Model, element_lengths
from ancfsparse.plans.trial_runs.run_differences import (
    absolute_tolerances,
    goal_differences,
    history_differences,
)
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns

MAX_UNOBSERVED_RATIO = 1.5  # steps extrapolated without an observed order, over those run
MAX_REFINEMENTS = 13
SMALL_GROWTH = 1.1  # ratio of numbers of elements, until those of every part of a beam grow
SHORT_RATIO = 0.5  # of lengths of elements, below which the errors of the longest ones dominate
NEGLIGIBLE_FRACTION = 0.03  # of the difference of two meshes, for the error of steps
MAX_HALVINGS = 5  # of the steps alone
# The undamped integrator conserves vibrations that long damped steps remove.  In 60 random plans
# that were met, damping changed the quantity by .03 of the tolerance or less (.1 in one); in three
# that were exceeded 1.7 to 4 times, by .2 to .5.
MAX_DAMPING_FRACTION = 0.05  # of the tolerance


def refine_together(trials: TrialRuns, model: Model, order: int) -> Refinement:
    """Refine mesh and steps together until the errors of both are known or small enough.

    The order is that of positions in the length of the elements.

    Raises
    ------
    StepError
        If no step is short enough for a complete run.
    PlanError
        If the errors do not decrease to the tolerances within the budget: the motion is chaotic, or
        the quantity is not smooth.
    """
    runs: list[TrialRun] = []
    series: RunSeries | None = None
    growth = GROWTH if order > LOW_ORDER else float(STEP_GROWTH)
    n_longest, steps = trials.first
    mesh = trials.with_mesh(model, n_longest)
    while steps <= trials.failed:
        steps *= STEP_GROWTH
    source, step_growth = trials.without_damping(), STEP_GROWTH
    for _ in range(MAX_REFINEMENTS):
        trials.check_budget()
        run, source = source.run(mesh, steps), trials
        if run is None:  # only the step is halved
            runs.clear()
            steps *= step_growth
            continue
        runs.append(run)
        if len(runs) > 1:
            series = RunSeries(trials, runs[-N_BOUND:], order)
            if series.is_known and series.excess <= 1.0:
                if step_growth == 1 and not _is_step_error_within(trials, run, series.margins):
                    step_growth = STEP_GROWTH  # their error exceeds the rest of the tolerance
                    del runs[:-1]
                elif agrees_with_undamped(trials, runs):
                    return series.combine()
            elif series.may_be_divided:
                divided = _divide(trials, series, order)
                if divided is not None:
                    return divided
            if not series.is_decreasing and series.predicted_work > trials.budget:
                break
        is_long = len(runs) >= N_BOUND and step_growth > 1 and bool(mesh.counts)
        differences = history_differences(trials.goals, *runs[-2:]) if is_long else ()
        negligible = [NEGLIGIBLE_FRACTION * each for each in differences]
        if is_long and _is_step_error_within(trials, run, negligible):
            step_growth = 1
            del runs[:-1]  # their differences contain errors of steps
            gradings, gain = grade_meshes(trials.scene, run)
            if gain >= MIN_GRADING_GAIN:
                n_longest /= growth**2
                mesh = trials.with_mesh(replace(model, gradings=gradings), n_longest)
                runs.clear()
                continue
        steps *= step_growth
        mesh, n_longest = _refine_mesh(trials, mesh, n_longest, growth)
    if series is None:
        assert trials.failure is not None
        raise trials.failure
    raise series.failure()


def _refine_mesh(
    trials: TrialRuns, mesh: Model, n_longest: float, growth: float
) -> tuple[Model, float]:
    """Return a mesh with shorter elements, and those on the longest beam; the same if given.

    Where elements are as long in two meshes, their difference shows no error: beyond a section with
    a moment to .4 % two elements were left, and the error was 1.4 tolerances.
    """
    coarse, finer = element_lengths(trials.scene, mesh), mesh
    lengths = coarse
    while ((lengths >= coarse) & (lengths > SHORT_RATIO * lengths.max(initial=0.0))).any():
        n_longest *= growth
        finer, growth = trials.with_mesh(mesh, n_longest), SMALL_GROWTH
        lengths = element_lengths(trials.scene, finer)
    return finer, n_longest


def _is_step_error_within(trials: TrialRuns, run: TrialRun, limits: Sequence[float]) -> bool:
    """Return True if the error of the steps of a run is within limits, by half as many steps.

    Resonances move with the mesh, which is refined alone while the difference of meshes dominates.
    """
    other = trials.run(run.model, run.steps // STEP_GROWTH)
    if other is None:
        return False
    differences = history_differences(trials.goals, other, run)
    factor = STEP_GROWTH**trials.step_order - 1.0
    pairs = zip(differences, limits, strict=True)
    return all(difference <= factor * limit for difference, limit in pairs)


def agrees_with_undamped(trials: TrialRuns, runs: Sequence[TrialRun]) -> bool:
    """Return True if the damping of long steps has removed no relevant vibration.

    The first run shows it if it has no damping; otherwise the last one is repeated without.
    """
    undamped, last = trials.without_damping(), runs[-1]
    if undamped is trials or runs[0].integrator == undamped.integrator:
        return True
    run = undamped.run(last.model, last.steps)
    if run is None:  # its steps are too long; the quantity is still unknown
        return True
    differences = goal_differences(trials.goals, last, run)
    pairs = zip(differences, absolute_tolerances(trials.goals, last), strict=True)
    return all(difference <= MAX_DAMPING_FRACTION * tolerance for difference, tolerance in pairs)


def _divide(trials: TrialRuns, series: RunSeries, order: int) -> Refinement | None:
    """Return the errors of mesh and steps, by runs on the coarser of the last two meshes.

    None if a run fails, or the motions there do not converge.
    """
    one, other = series.runs[-2:]
    if not other.model.counts:
        time = refine_steps(trials, series.runs)
        return None if time is None else Refinement(time, None)
    time = refine_steps(trials, [one])
    if time is None:
        return None
    pair = time.runs[1], other
    return Refinement(time, RunEstimates(mesh_estimates(trials, pair, order), pair))


def refine_steps(trials: TrialRuns, first: Sequence[TrialRun]) -> RunEstimates | None:
    """Halve the step on one mesh until the error of the steps can be extrapolated.

    None if a run fails, or the motions do not converge.
    """
    runs = list(first)
    while True:
        trials.check_budget()
        if len(runs) > 1:
            estimates = step_estimates(trials, runs, trials.step_order)
            if any(each.is_observed and each.order <= MIN_ORDER for each in estimates):
                return None
            result = RunEstimates(estimates, tuple(runs))
            if _may_extrapolate(trials, result) or len(runs) > MAX_HALVINGS + 1:
                return result
        run = trials.run(runs[-1].model, STEP_GROWTH * runs[-1].steps)
        if run is None:
            return None
        runs.append(run)


def _may_extrapolate(trials: TrialRuns, time: RunEstimates) -> bool:
    """Return True if the steps for half of the tolerances follow from known errors."""
    last = time.runs[-1]
    pairs = zip(time.estimates, absolute_tolerances(trials.goals, last), strict=True)
    return all(
        each.is_asymptotic
        or each.resolution_for(0.5 * tolerance)
        <= last.steps * (1.0 if each.is_observed else MAX_UNOBSERVED_RATIO)
        for each, tolerance in pairs
    )


def refine_other_elements(
    trials: TrialRuns, model: Model, order: int, time: RunEstimates, reference_run: TrialRun
) -> Refinement | None:
    """Estimate the mesh error of other elements, with the time error of known ones.

    The reference run has the known elements on the finest mesh.  None if a run fails, or the two
    meshes are the same.
    """
    n_longest, steps = float(max(reference_run.model.counts.values())), reference_run.steps
    growth = GROWTH if order > LOW_ORDER else float(STEP_GROWTH)
    # To take less work than the known elements.
    if model.gradings:
        n_longest /= growth**2
    elif any(element.name == "string" for element in model.elements.values()):
        n_longest /= growth
    runs = [trials.run(trials.with_mesh(model, n), steps) for n in (n_longest, growth * n_longest)]
    one, other = runs
    if one is None or other is None or elements_of(one) == elements_of(other):
        return None
    differences = history_differences(trials.goals, one, other)
    tolerances = absolute_tolerances(trials.goals, other)
    if not (is_close(trials, other, differences) and resolves_vibrations(other, tolerances)):
        return None
    of_mesh = mesh_estimates(trials, (one, other), order)
    errors = [m.conservative + t.at(steps) for m, t in zip(of_mesh, time.estimates, strict=True)]
    pairs = zip(errors, tolerances, strict=True)
    is_enough = all(error <= SAFETY_FRACTION * tolerance for error, tolerance in pairs)
    mesh = RunEstimates(of_mesh, (one, other))
    return Refinement(time, mesh, tuple(errors) if is_enough else None)
