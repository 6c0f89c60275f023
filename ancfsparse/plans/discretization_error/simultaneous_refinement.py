"""Estimate mesh and time errors by refining both simultaneously.

The difference between two runs is about three quarters of the error of the first.  If that is close
to the tolerance, the second run is accurate enough.  Otherwise one more run, with the mesh of the
first and the steps of the second, divides the difference into parts due to mesh and steps; the
resolution selected from them is run, and confirmed by its difference from the second run.

The first run has no numerical damping, so that the vibrations removed by long damped steps are part
of the difference.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.plans.discretization_error.mesh_error import GROWTH
from ancfsparse.plans.discretization_error.richardson import ASYMPTOTIC_RANGE, MIN_ORDER, Estimate
from ancfsparse.plans.discretization_error.run_estimates import (
    RunEstimates,
    elements_of,
    is_close,
    mesh_estimates,
    mesh_orders,
    step_estimates,
)
from ancfsparse.plans.discretization_error.time_error import MAX_HALVINGS, agrees_with_undamped
from ancfsparse.plans.discretization_error.turning_points import find_swings
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.trial_runs.run_differences import (
    absolute_tolerances,
    goal_differences,
    history_differences,
)
from ancfsparse.plans.trial_runs.trial_runs import BASE_BUDGET, TRIAL_FRACTION, TrialRun, TrialRuns
from ancfsparse.scene import Beam

STEP_GROWTH = 2  # ratio of the numbers of steps; of elements too, if they are of low order
LOW_ORDER = 2
# Fraction of the order with which errors are assumed to decrease.
UNOBSERVED_FRACTION = 0.75  # for two runs
MIN_OBSERVED_FRACTION = 0.4  # for three runs
TOLERANCE_FRACTION = 0.75  # that the estimated error may reach
MAX_NEAR_EXCESS = 2.0  # over that, below which refining both again takes no more than dividing
MAX_UNOBSERVED_RATIO = 1.5  # steps extrapolated without an observed order, over those run
MAX_STEP_RATIO = 16.0  # steps extrapolated with the order of the method, over those run
ORDER_BUDGET = 0.5  # of the base budget, to observe the order of the steps
SWING_FRACTION = 0.5  # of the tolerance, above which swings count
MAX_PHASE_ERROR = 1.0  # rad
MAX_REFINEMENTS = 5  # before that
MAX_REDUCTION = 0.5  # ratio of successive differences before that
UNDAMPED_ATTEMPTS = 2  # runs without numerical damping that may fail


@dataclass(frozen=True)
class Refinement:
    """Result of simultaneous refinement.

    Attributes
    ----------
    time : RunEstimates
        Of the steps.
    mesh : RunEstimates
        Of the automatic meshes.
    combined_errors : tuple of float, or None
        Error of the last run by mesh and steps together, for every quantity [its unit], if it is
        within the tolerance; `time` and `mesh` then have half of it each.
    runs : tuple of TrialRun
        All runs.
    """

    time: RunEstimates
    mesh: RunEstimates
    combined_errors: tuple[float, ...] | None
    runs: tuple[TrialRun, ...]


def refine_together(
    trials: TrialRuns, model: Model, order: int, step_order: int
) -> Refinement | None:
    """Refine mesh and steps together until the errors of both are known or small enough.

    The orders are those of positions in the length of the elements, and of the integrator.  None if
    a run fails, or motions do not converge: then mesh and steps must be refined separately.
    """
    growth = _growth(order)
    runs: list[TrialRun] = []
    before: list[float] = []
    last = [0.0] * len(trials.goals)
    for integrator_trials, n_longest, steps in _resolutions(trials, growth, runs):
        finer = trials.with_mesh(model, n_longest)
        if _has_inner_nodes(trials, finer):
            return None  # positions on beams set the mesh, whose error decreases irregularly
        run = integrator_trials.run(finer, steps)
        if run is None:
            runs.clear()
            continue
        runs.append(run)
        if len(runs) < 2:
            continue
        one, other = runs[-2:]
        whole = history_differences(trials.goals, one, other)
        differences = goal_differences(trials.goals, one, other)
        if is_close(trials, other, whole) and resolves_vibrations(trials, other):
            ratios = [
                min(growth**p, float(STEP_GROWTH**step_order)) for p in mesh_orders(trials, order)
            ]
            errors = [_error(*each) for each in zip(differences, last, ratios, strict=True)]
            pairs = zip(errors, absolute_tolerances(trials.goals, other), strict=True)
            excess = max(error / (TOLERANCE_FRACTION * tolerance) for error, tolerance in pairs)
            result = None
            if excess <= 1.0:
                result = _combine(trials, runs, errors, order, step_order)
            elif excess > MAX_NEAR_EXCESS:
                result = _separate(trials, runs, order, step_order)
            if result is not None:
                time = result.time
                agrees = runs[0].integrator != trials.integrator or agrees_with_undamped(
                    trials, time.runs[-1].model, time.runs, time.estimates)  # fmt: skip
                return result if agrees else None
            if excess > MAX_NEAR_EXCESS:
                return None
        if before and any(b > MAX_REDUCTION * a for a, b in zip(before, whole, strict=True)):
            return None
        before, last = whole, differences
    return None


def _growth(order: int) -> float:
    """Return the ratio of the numbers of elements of successive meshes."""
    return GROWTH if order > LOW_ORDER else float(STEP_GROWTH)


def _resolutions(
    trials: TrialRuns, growth: float, runs: Sequence[TrialRun]
) -> Iterator[tuple[TrialRuns, float, int]]:
    """Yield the integrator, number of elements and number of steps of the next run.

    If two runs without numerical damping have failed, runs with it follow from the first mesh, with
    halved steps until one does not fail.
    """
    first, steps = trials.first
    undamped = _without_damping(trials)
    n_longest, failures = first, 0
    if undamped is not trials:
        for _ in range(UNDAMPED_ATTEMPTS):
            yield undamped, n_longest, steps
            n_longest, steps = growth * n_longest, STEP_GROWTH * steps
            if runs:
                break
        else:
            n_longest, steps = first, steps // STEP_GROWTH
    done = len(runs)
    while done < MAX_REFINEMENTS and failures < MAX_HALVINGS:
        yield trials, n_longest, steps
        steps *= STEP_GROWTH
        if runs:
            done, n_longest = done + 1, growth * n_longest
        else:
            failures += 1


def _error(difference: float, before: float, ratio: float) -> float:
    """Return the error of the last run from its difference to the previous one.

    Errors decrease by `ratio`, to a lower power if the differences of three runs show one.  A much
    smaller difference is one by chance, see `richardson`.
    """
    power = UNOBSERVED_FRACTION
    if before > difference * ratio ** ASYMPTOTIC_RANGE[1]:
        difference = before / ratio
    if before > 0.0 and difference > 0.0:
        observed = math.log(before / difference) / math.log(ratio)
        power = min(1.0, max(MIN_OBSERVED_FRACTION, observed))
    return difference / float(ratio**power - 1.0)


def refine_other_elements(
    trials: TrialRuns, model: Model, order: int, time: RunEstimates, reference_run: TrialRun
) -> Refinement | None:
    """Estimate the mesh error of other elements, with the time error of known ones.

    The reference run has the known elements on the finest mesh.  None if a run fails, or the two
    meshes are the same.
    """
    n_longest, steps = float(max(reference_run.model.counts.values())), reference_run.steps
    growth = _growth(order)
    if any(element.name == "string" for element in model.elements.values()):
        n_longest /= growth  # to take less work than the known elements
    coarse, fine = (trials.with_mesh(model, n) for n in (n_longest, growth * n_longest))
    if _has_inner_nodes(trials, coarse) or _has_inner_nodes(trials, fine):
        return None
    one, other = trials.run(coarse, steps), trials.run(fine, steps)
    if one is None or other is None:
        return None
    whole = history_differences(trials.goals, one, other)
    if not (is_close(trials, other, whole) and resolves_vibrations(trials, other)):
        return None
    of_mesh = mesh_estimates(trials, (one, other), order)
    errors = [m.conservative + t.at(steps) for m, t in zip(of_mesh, time.estimates, strict=True)]
    pairs = zip(errors, absolute_tolerances(trials.goals, other), strict=True)
    is_enough = all(error <= TOLERANCE_FRACTION * tolerance for error, tolerance in pairs)
    mesh = RunEstimates(of_mesh, (one, other))
    return Refinement(time, mesh, tuple(errors) if is_enough else None, (one, other))


def _has_inner_nodes(trials: TrialRuns, model: Model) -> bool:
    """Return True if positions on beams add nodes to the meshes of a model, or move them."""
    scene = trials.build(model)
    bodies = [scene.body(name) for name in model.counts]
    is_uneven = any(isinstance(body, Beam) and body.nodes is not None for body in bodies)
    return is_uneven or sum(b.n_elements for b in bodies) != sum(model.counts.values())


def _without_damping(trials: TrialRuns) -> TrialRuns:
    """Return runs by the same integrator without numerical damping, if there is one."""
    integrator = trials.integrator
    if not isinstance(integrator, GeneralizedAlpha) or integrator.rho_inf >= 1.0:
        return trials
    return trials.with_integrator(GeneralizedAlpha(1.0))


def resolves_vibrations(trials: TrialRuns, run: TrialRun) -> bool:
    """Return True if steps are short enough for the vibrations of the quantities.

    A method of order 2 delays a vibration in each step by a twelfth of the cube of its phase in the
    step.  Two runs whose phase errors exceed `MAX_PHASE_ERROR` may agree by chance.
    """
    tolerances = absolute_tolerances(trials.goals, run)
    for history, tolerance in zip(run.histories, tolerances, strict=True):
        for values in history.T:
            phase = np.pi * len(find_swings(values, SWING_FRACTION * tolerance)[0])
            if phase**3 > 12.0 * MAX_PHASE_ERROR * run.steps**2:
                return False
    return True


def _combine(
    trials: TrialRuns, runs: Sequence[TrialRun], errors: Sequence[float], order: int,
    step_order: int) -> Refinement:  # fmt: skip
    """Return two runs, the second of which is accurate enough, with undivided errors."""
    one, other = runs[-2:]
    ratio = elements_of(other) / elements_of(one)
    of_steps, of_mesh = [], []
    for error, p in zip(errors, mesh_orders(trials, order), strict=True):
        half = 0.5 * error
        of_steps.append(Estimate(other.steps, half, step_order, False, STEP_GROWTH, False))
        of_mesh.append(Estimate(elements_of(other), half, p, False, ratio, False))
    last = (one, other)
    time, mesh = RunEstimates(tuple(of_steps), last), RunEstimates(tuple(of_mesh), last)
    return Refinement(time, mesh, tuple(errors), tuple(runs))


def _separate(
    trials: TrialRuns, runs: list[TrialRun], order: int, step_order: int
) -> Refinement | None:
    """Return the errors of mesh and steps, by a run between the last two.

    Steps on the coarse mesh are halved until their order is observed, if errors must decrease by
    more than a factor that may be extrapolated without.
    """
    one, other = runs[-2:]
    tolerances = absolute_tolerances(trials.goals, other)
    halved = [one]
    for k in range(MAX_REFINEMENTS):
        run = trials.run(one.model, other.steps << k)
        if run is None:
            return None
        halved.append(run)
        of_steps = step_estimates(trials, halved, step_order)
        if any(each.is_observed and each.order <= MIN_ORDER for each in of_steps):
            return None  # motions do not converge
        pairs = zip(of_steps, tolerances, strict=True)
        steps = [each.resolution_for(0.5 * tolerance) for each, tolerance in pairs]
        ratios = [n / run.steps / _max_ratio(e) for n, e in zip(steps, of_steps, strict=True)]
        if max(ratios) <= 1.0:
            break
        planned = run.cost.work * max(steps) / run.steps
        is_expensive = (
            trials.total_work > ORDER_BUDGET * BASE_BUDGET
            and run.cost.work > TRIAL_FRACTION * planned
        )
        if is_expensive and all(each.is_observed for each in of_steps):
            break
    mesh = RunEstimates(mesh_estimates(trials, (halved[1], other), order), (halved[1], other))
    return Refinement(RunEstimates(of_steps, tuple(halved)), mesh, None, (*runs, *halved[1:]))


def _max_ratio(known: Estimate) -> float:
    """Return the ratio of steps up to which an error may be extrapolated."""
    if not known.is_observed:
        return MAX_UNOBSERVED_RATIO
    return MAX_STEP_RATIO if known.is_asymptotic else 1.0
