"""Error of interpolation between the saved states of methods whose states are exact in time."""

from __future__ import annotations

import math

from ancfsparse.array_types import Vector
from ancfsparse.plans.discretization_error.richardson import Estimate
from ancfsparse.plans.discretization_error.run_estimates import RunEstimates
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.quantities.tolerances import Goal
from ancfsparse.plans.trial_runs.run_differences import absolute_tolerances, goal_differences
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.plans.trial_runs.trial_runs import BASE_BUDGET, TrialRun, TrialRuns

MAX_HALVINGS = 10  # of the intervals between saved states of the first trial run
MAX_WORK = 2.0  # of these trial runs, over the base budget
LOAD_ORDER = 2  # of interpolation of loads, and of equilibria, which is linear


def sampling_error(trials: TrialRuns, model: Model) -> RunEstimates:
    """Halve the intervals between saved states until the interpolation error is known.

    Interpolation is linear between equilibria, cubic between states of vibrations.  Loads may be
    interpolated linearly as well, which the last two runs show.  Quantities at the end only need no
    other states.

    Raises
    ------
    StepError
        If a run fails.
    """
    method = trials.integrator
    assert isinstance(method, SolutionMethod)
    runs: list[TrialRun] = []
    for _ in range(MAX_HALVINGS + 1):
        run = trials.run(model, method.min_intervals << len(runs))
        if run is None:
            assert trials.failure is not None
            raise trials.failure
        runs.append(run)
        if method.order > LOAD_ORDER and len(runs) < 2:
            continue
        by_loads = [0.0] * len(trials.goals)
        if len(runs) > 1:
            by_loads = goal_differences(trials.goals, *runs[-2:])
        estimates = [
            _estimate(goal, history, run.steps, method.order, each / (2.0**LOAD_ORDER - 1.0))
            for goal, history, each in zip(trials.goals, run.histories, by_loads, strict=True)
        ]
        pairs = zip(estimates, absolute_tolerances(trials.goals, run), strict=True)
        enough = all(each.error <= tolerance for each, tolerance in pairs)
        # Where an equilibrium ceases to exist, states jump.
        if enough or trials.total_work > MAX_WORK * BASE_BUDGET or run.run.stats.recoveries:
            break
    return RunEstimates(tuple(estimates), tuple(runs))


def _estimate(goal: Goal, history: Vector, steps: int, order: int, by_loads: float) -> Estimate:
    """Estimate the interpolation error of a quantity."""
    fine = 0.0 if goal.quantity.at == "end" else _deviation(goal, history, order)
    coarse = _deviation(goal, history[::2], order)
    # Kinks leave order 1.
    observed = min(max(math.log2(coarse / fine), 1.0), float(order)) if 0.0 < fine < coarse else 1.0
    error = fine / 2.0**observed
    if by_loads > error:
        return Estimate(steps, by_loads, float(LOAD_ORDER), is_asymptotic=True)
    return Estimate(steps, error, observed, is_asymptotic=True)


def _deviation(goal: Goal, history: Vector, order: int) -> float:
    """Return the largest deviation of every other state from interpolation of its neighbours."""
    nodes, middle = history[::2], history[1::2]
    if order == LOAD_ORDER:
        interpolated = 0.5 * (nodes[:-1] + nodes[1:])
    else:
        inner = 9.0 * (nodes[1:-2] + nodes[2:-1])
        interpolated, middle = (inner - nodes[:-3] - nodes[3:]) / 16.0, middle[1:-1]
    return goal.quantity.largest_difference(interpolated, middle)
