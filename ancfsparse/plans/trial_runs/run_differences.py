"""Differences of requested quantities between trial runs, and their tolerances."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.plans.quantities.tolerances import Goal
from ancfsparse.plans.trial_runs.trial_runs import TrialRun


def absolute_tolerances(goals: Sequence[Goal], trial: TrialRun) -> list[float]:
    """Return the absolute tolerance of every quantity, by its size in a run [its unit].

    Raises
    ------
    InputError
        If a quantity with a relative error is zero or does not change, but by rounding.
    """
    out = [each.tolerance(h) for each, h in zip(goals, trial.histories, strict=True)]
    for each, tolerance in zip(goals, out, strict=True):
        each.check_change(tolerance, trial.run)
    return out


def goal_difference(goal: Goal, one: Vector, other: Vector) -> float:
    """Return the largest difference of two histories at the requested times [unit]."""
    quantity = goal.quantity
    return quantity.largest_difference(*map(quantity.select, _at_common_times(one, other)))


def differences_over_time(goal: Goal, one: Vector, other: Vector) -> Vector:
    """Return the magnitude of the difference of two histories at all common times, (k,) [unit]."""
    common = _at_common_times(one, other)
    return np.asarray(np.linalg.norm(goal.quantity.difference(*common), axis=1))


def goal_differences(goals: Sequence[Goal], one: TrialRun, other: TrialRun) -> list[float]:
    """Return the largest difference of every quantity at the requested times [its unit]."""
    histories = zip(goals, one.histories, other.histories, strict=True)
    return [goal_difference(*each) for each in histories]


def history_differences(goals: Sequence[Goal], one: TrialRun, other: TrialRun) -> list[float]:
    """Return the largest difference of every quantity at any saved time [its unit]."""
    histories = zip(goals, one.histories, other.histories, strict=True)
    return [goal.quantity.largest_difference(*_at_common_times(*pair)) for goal, *pair in histories]


def _at_common_times(one: Vector, other: Vector) -> tuple[Vector, Vector]:
    """Return two histories at their common times."""
    intervals = [len(each) - 1 for each in (one, other)]
    both = max(1, math.gcd(*intervals))
    strides = [max(1, each // both) for each in intervals]
    return one[:: strides[0]], other[:: strides[1]]
