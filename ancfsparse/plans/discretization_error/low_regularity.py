"""Error bounds for quantities that converge slowly, for example after load jumps.

After a jump, motions contain waves of all lengths, which only short steps and fine meshes resolve.
A peak may converge long before the history does, both with a low order and irregularly.  Mesh and
steps are therefore refined together, and four motions must show convergence: the error is bounded
by their differences, of which the last may be small by chance, and by an order of at most 1. Peaks
of motions that are not in the asymptotic range can agree by chance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import PlanError
from ancfsparse.plans.discretization_error.error_model import ErrorModel
from ancfsparse.plans.discretization_error.initial_singularity import check_initial_force
from ancfsparse.plans.discretization_error.mesh_error import (
    COARSEST_COUNT,
    GROWTH,
    error_of_given_meshes,
)
from ancfsparse.plans.discretization_error.richardson import MIN_ORDER, Estimate
from ancfsparse.plans.discretization_error.run_estimates import (
    RunEstimates,
    elements_of,
    may_be_compared,
)
from ancfsparse.plans.discretization_error.turning_points import find_swings
from ancfsparse.plans.models.model import Model, coarse_count
from ancfsparse.plans.trial_runs.cost_model import fit_cost_model
from ancfsparse.plans.trial_runs.run_differences import (
    absolute_tolerances,
    goal_differences,
    history_differences,
)
from ancfsparse.plans.trial_runs.trial_runs import BASE_BUDGET, TrialRun, TrialRuns
from ancfsparse.scene import Scene

FIRST_STEP_RATIO = 4  # steps of the first motion over the smallest number of steps
STEP_GROWTH = 2  # ratio of the numbers of steps of successive motions
MAX_ORDER = 1.0  # in the steps, that a bound relies on
TARGET_ORDER = 2  # by which the cost of reaching the tolerance is predicted
N_MOTIONS = 4  # of which a bound is made
MAX_MOTIONS = 12
MAX_COST = 40.0  # of a motion, over the base budget
TOLERANCE_FRACTION = 0.75  # that a bound may reach
MIN_SWINGS = 10  # of a vibration
MIN_STATES_PER_SWING = 3.0  # saved states that determine its period


def refine_to_bounds(
    trials: TrialRuns,
    model: Model,
    finer: Scene | None,
    fixed_steps: int | None,
    order: int,
    failure: PlanError,
) -> ErrorModel:
    """Refine mesh and steps together until bounds of all errors are within the tolerances.

    Arguments as in `search`, with the order of positions and the failure of the other estimates.

    Raises
    ------
    PlanError
        If bounds do not reach the tolerances, or would take too much work.
    """
    if fixed_steps is not None:
        raise failure
    n_longest = coarse_count(trials.scene, COARSEST_COUNT)
    steps = FIRST_STEP_RATIO * trials.base
    runs: list[TrialRun] = []
    differences: list[list[float]] = []
    is_checked = False
    for _ in range(MAX_MOTIONS):
        run = trials.run(trials.with_mesh(model, n_longest), steps)
        n_longest, steps = GROWTH * n_longest, STEP_GROWTH * steps
        if run is None:
            runs.clear()
            differences.clear()
            continue
        runs.append(run)
        if len(runs) > 1:
            differences.append(goal_differences(trials.goals, *runs[-2:]))
        if len(runs) < N_MOTIONS:
            continue
        tolerances = absolute_tolerances(trials.goals, run)
        last = zip(*differences[1 - N_MOTIONS :], strict=True)
        orders, errors = zip(*map(bound, last), strict=True)
        pairs = zip(errors, tolerances, strict=True)
        excess = max(error / (TOLERANCE_FRACTION * tolerance) for error, tolerance in pairs)
        of_histories = history_differences(trials.goals, *runs[-2:])
        if excess <= 1.0:
            if may_be_compared(trials, run, of_histories):
                return _error_model(trials, runs, tolerances, orders, errors, finer, order)
            if not is_checked:
                check_initial_force(trials, run)
            is_checked = True
        # Logarithms, because a tolerance may be beyond the reach of any number of runs.
        refinements = math.log(max(excess, 1.0)) / math.log(STEP_GROWTH**TARGET_ORDER)
        budget = math.log(MAX_COST * BASE_BUDGET / run.cost.work)
        if refinements * math.log(GROWTH * STEP_GROWTH) > budget:
            break
    if len(runs) < N_MOTIONS:
        raise failure
    raise _failure(trials, runs, tolerances, errors if excess > 1.0 else of_histories)


def bound(differences: Sequence[float]) -> tuple[float, float]:
    """Return the order shown by three differences of four motions, and a bound of the error.

    A difference may be small by chance, so the previous one counts as well, reduced by the ratio
    expected since; if the differences do not decrease, the largest of all three counts.
    """
    first, second, third = differences
    observed = math.inf if third == 0.0 else 0.0
    if first > 0.0 and third > 0.0:
        observed = math.log(first / third) / (2.0 * math.log(STEP_GROWTH))
    order = min(max(observed, MIN_ORDER), MAX_ORDER)
    ratio = STEP_GROWTH**order
    largest = max(third, second / ratio) if observed >= MIN_ORDER else max(differences)
    return order, largest / (ratio - 1.0)


def _error_model(
    trials: TrialRuns,
    runs: Sequence[TrialRun],
    tolerances: Sequence[float],
    orders: Sequence[float],
    errors: Sequence[float],
    finer: Scene | None,
    order: int,
) -> ErrorModel:
    """Return the error model with the last run selected."""
    one, last = runs[-2:]
    has_mesh = bool(last.model.counts)
    of_steps, of_mesh = [], []
    for p, error in zip(orders, errors, strict=True):
        part = 0.5 * error if has_mesh else error
        of_steps.append(Estimate(last.steps, part, p, False, STEP_GROWTH))
        of_mesh.append(Estimate(max(1, elements_of(last)), part, p, False, GROWTH))
    given = (0.0,) * len(tolerances)
    if finer is not None:
        given = tuple(error_of_given_meshes(trials, finer, last.model, last.steps, order))
    counts = max(last.model.counts.values(), default=1)
    return ErrorModel(
        last.model,
        RunEstimates(tuple(of_steps), (one, last)),
        RunEstimates(tuple(of_mesh), (one, last)) if has_mesh else None,
        given,
        tuple(tolerances),
        fit_cost_model([run.cost for run in runs]),
        None,
        selected=(float(counts), last.steps),
        base=trials.base,
        combined_errors=tuple(errors) if finer is None else None,
        order=order,
        is_bound=True,
    )


def _failure(
    trials: TrialRuns,
    runs: Sequence[TrialRun],
    tolerances: Sequence[float],
    errors: Sequence[float],
) -> PlanError:
    """Return the failure for the quantity with the largest error, and the time of that error."""
    i = max(range(len(tolerances)), key=lambda k: errors[k] / tolerances[k])
    quantity = trials.goals[i].quantity
    one, last = (np.asarray(run.histories[i]) for run in runs[-2:])
    step = math.gcd(len(one) - 1, len(last) - 1)
    common = (each[:: max(1, (len(each) - 1) // step)] for each in (one, last))
    differences = np.linalg.norm(quantity.difference(*common), axis=1)
    assert trials.t_end is not None
    t = trials.t_end * float(differences.argmax()) / max(1, len(differences) - 1)
    left = float(differences.max())
    causes = _vibration(last, runs[-1].steps, trials.t_end, tolerances[i], quantity.unit)
    return PlanError(quantity.name, tolerances[i], left, quantity.unit, len(runs), t, causes)


def _vibration(
    history: Vector, steps: int, t_end: float, tolerance: float, unit: str
) -> tuple[str, ...]:
    """Describe the vibration of a quantity in the last motion; empty without one."""
    swings = (find_swings(values, tolerance) for values in history.reshape(len(history), -1).T)
    rows, sizes = max(swings, key=lambda each: len(each[0]))
    if len(rows) < MIN_SWINGS:
        return ()
    states = float(np.median(np.diff(rows)))
    period = 2.0 * t_end * states / (len(history) - 1)
    length = (
        f"about {period:.2g} s, {period * steps / t_end:.2g} steps"
        if states >= MIN_STATES_PER_SWING
        else f"{period:.2g} s or less"
    )
    return (
        f"In the last motion it vibrates by up to {sizes.max():.3g} {unit}".rstrip()
        + f" with periods of {length}: axial_damping and bending_damping of the material damp "
        "vibrations",
    )
