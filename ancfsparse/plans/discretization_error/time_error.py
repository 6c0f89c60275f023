"""Error of the time steps: the same coarse mesh with half the step, until the error is known."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from ancfsparse.errors import PlanError
from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.plans.discretization_error.richardson import MIN_ORDER, Estimate
from ancfsparse.plans.discretization_error.run_estimates import (
    RunEstimates,
    max_unobserved_ratio,
    may_be_compared,
    step_estimates,
)
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.trial_runs.run_differences import (
    absolute_tolerances,
    goal_differences,
    history_differences,
)
from ancfsparse.plans.trial_runs.trial_runs import BASE_BUDGET, TrialRun, TrialRuns

MAX_HALVINGS = 14  # of the longest step
# Largest ratio of error to tolerance from which the number of steps is extrapolated.
MAX_CHEAP_RATIO = 2.0  # in the asymptotic range, while trial runs are within the base budget
MAX_ASYMPTOTIC_RATIO = 16.0  # in the asymptotic range, later, or if it was confirmed twice
MAX_OBSERVED_RATIO = 1.0  # with another observed order; the confirmation run checks it
ORDER_TOLERANCE = 0.15  # relative deviation of a ratio of differences that confirms the order
# After these, differences that do not decrease with the smallest order show a motion that is too
# irregular for an estimate.
STAGNATION_HALVINGS = 3
STAGNATION_BUDGET = 0.5  # of the base budget, spent first: steps may still be too long to converge
HASTY_FACTOR = 0.5  # of both limits, if a finer mesh may be better
# The undamped integrator conserves vibrations that long damped steps remove.  In 60 random plans
# that were met, damping changed the quantity by .03 of the tolerance or less (.1 in one); in three
# that were exceeded 1.7 to 4 times, by .2 to .5.
MAX_DAMPING_FRACTION = 0.05  # of the tolerance
MAX_DAMPING_RATIO = 0.1  # of the estimated error, where that is larger


def time_error(
    trials: TrialRuns,
    model: Model,
    order: int,
    hasty: bool = False,
    fixed_steps: int | None = None,
) -> RunEstimates:
    """Halve the step until the error of every quantity can be predicted.

    A `hasty` search stops as soon as differences decrease slowly, since a finer mesh may be better.
    Damping is not examined if a fixed number of steps is not accurate enough anyway.

    Raises
    ------
    StepError
        If no step is short enough for a complete run.
    PlanError
        If the motions do not converge as steps are halved: the motion is chaotic, or the quantity
        is not smooth.
    """
    runs: list[TrialRun] = []
    failed = trials.failed
    for halvings in range(MAX_HALVINGS + 1):
        if trials.base << halvings <= failed:
            continue
        trials.check_budget()
        run = trials.run(model, trials.base << halvings)
        if run is None:
            runs.clear()
            continue
        runs.append(run)
        if len(runs) < 2:
            continue
        estimates = step_estimates(trials, runs, order)
        if _is_enough(trials, runs, estimates, order):
            pairs = zip(estimates, absolute_tolerances(trials.goals, run), strict=True)
            is_unmet = fixed_steps and any(each.at(fixed_steps) > limit for each, limit in pairs)
            if is_unmet or agrees_with_undamped(trials, model, runs, estimates):
                return RunEstimates(estimates, tuple(runs))
        if _stagnates(trials, runs, hasty):
            break
    if trials.failure is not None and len(runs) < 2:
        raise trials.failure
    tolerances = absolute_tolerances(trials.goals, runs[-1])
    differences = history_differences(trials.goals, runs[-2], runs[-1])
    i = max(range(len(tolerances)), key=lambda i: differences[i] / tolerances[i])
    quantity = trials.goals[i].quantity
    raise PlanError(quantity.name, tolerances[i], differences[i], quantity.unit, len(runs))


def no_time_error(trials: TrialRuns, model: Model) -> RunEstimates:
    """Return the run of an equilibrium, without an error of steps."""
    run = trials.run(model, 1)
    assert run is not None  # statics has no failing steps
    return RunEstimates((Estimate(1.0, 0.0, 2.0, is_asymptotic=True),) * len(trials.goals), (run,))


def _stagnates(trials: TrialRuns, runs: Sequence[TrialRun], hasty: bool) -> bool:
    """Return True if differences have decreased too slowly in several halvings of the step."""
    factor = HASTY_FACTOR if hasty else 1.0
    budget = factor * STAGNATION_BUDGET * BASE_BUDGET
    if len(runs) < STAGNATION_HALVINGS + 2 or trials.total_work < budget:
        return False
    differences = [history_differences(trials.goals, a, b) for a, b in pairwise(runs)]
    series = zip(*differences, strict=True)
    factor /= 2.0 ** (MIN_ORDER * STAGNATION_HALVINGS)
    return any(each[-1] > factor * each[-1 - STAGNATION_HALVINGS] for each in series)


def _is_enough(
    trials: TrialRuns, runs: Sequence[TrialRun], estimates: Sequence[Estimate], order: int
) -> bool:
    """Return True if errors can be extrapolated, and complete histories converge."""
    tolerances = absolute_tolerances(trials.goals, runs[-1])
    cheap = trials.total_work < BASE_BUDGET
    last = history_differences(trials.goals, runs[-2], runs[-1])
    if not may_be_compared(trials, runs[-1], last):
        return False
    before = history_differences(trials.goals, runs[-3], runs[-2]) if len(runs) > 2 else None
    for i, (each, tolerance) in enumerate(zip(estimates, tolerances, strict=True)):
        goal = trials.goals[i]
        ratio = MAX_OBSERVED_RATIO if each.is_observed else max_unobserved_ratio(goal)
        if each.is_asymptotic:
            ratio = MAX_ASYMPTOTIC_RATIO
            if cheap and not _is_order_confirmed(trials, runs, i, order):
                ratio = MAX_CHEAP_RATIO
        if each.conservative > ratio * tolerance:
            return False
        if before is not None and last[i] > max(tolerance, 0.5 * before[i]):
            return False
    return True


def _is_order_confirmed(trials: TrialRuns, runs: Sequence[TrialRun], i: int, order: int) -> bool:
    """Return True if four runs have shown the order of the method twice, for quantity i."""
    if len(runs) < 4:
        return False
    differences = [goal_differences(trials.goals, a, b)[i] for a, b in pairwise(runs[-4:])]
    ratio = 2.0**order
    return all(
        (1.0 - ORDER_TOLERANCE) * ratio <= first / second <= (1.0 + ORDER_TOLERANCE) * ratio
        for first, second in pairwise(differences)
        if second > 0.0
    )


def agrees_with_undamped(
    trials: TrialRuns, model: Model, runs: Sequence[TrialRun], estimates: Sequence[Estimate]
) -> bool:
    """Return True if the damping of long steps has removed no relevant vibration."""
    if not isinstance(trials.integrator, GeneralizedAlpha) or trials.integrator.rho_inf >= 1.0:
        return True
    other = trials.with_integrator(GeneralizedAlpha(1.0))
    run = other.run(model, runs[-1].steps)
    trials.seconds += other.seconds
    if run is None:  # its steps are too long; the quantity is still unknown
        return True
    tolerances = absolute_tolerances(trials.goals, runs[-1])
    differences = goal_differences(trials.goals, runs[-1], run)
    return all(
        difference <= max(MAX_DAMPING_RATIO * each.error, MAX_DAMPING_FRACTION * tolerance)
        for difference, each, tolerance in zip(differences, estimates, tolerances, strict=True)
    )
