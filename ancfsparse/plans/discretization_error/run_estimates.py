"""Estimates of the error of mesh or steps from several trial runs, by Richardson extrapolation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ancfsparse.plans.discretization_error.richardson import Estimate, estimate
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.quantities.tolerances import Goal
from ancfsparse.plans.trial_runs.run_differences import (
    absolute_tolerances,
    differences_over_time,
    goal_differences,
)
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns

SOLVER_NOISE = 1e-7  # difference by the tolerance of the solver, relative to the quantity
# The reaction of a clamp under sudden weight converged with order 4 at the end and 1 at the start.
# Orders of the largest differences, first at the end and then at the start, hid that: 3.4 times.
NEAR_FRACTION = 0.1  # of a run, before and after a time; differences near it show the order there

# Largest ratio of error to tolerance for which two runs suffice, which show no order.  Largest
# values of two runs may agree by chance: kinetic energies of 8 and 12 elements did, 1.6 times off.
MAX_UNOBSERVED_RATIO = 0.4
MAX_UNOBSERVED_PEAK_RATIO = 0.1
# Largest difference of two motions in the asymptotic range, over the size of the quantity.  Peaks
# agreed by chance in motions that differed by .125 and .14 of it: the errors were 1.5 and 1.9
# tolerances.
MAX_DIFFERENCE = 0.1


@dataclass(frozen=True)
class RunEstimates:
    """Estimates of one source of error from several trial runs.

    Attributes
    ----------
    estimates : tuple of Estimate
        For every quantity, by the number of elements or of steps.
    runs : tuple of TrialRun
        With ascending numbers of elements or of steps.
    """

    estimates: tuple[Estimate, ...]
    runs: tuple[TrialRun, ...]

    @property
    def is_asymptotic(self) -> bool:
        """True if all observed orders agree with the theoretical ones."""
        return all(each.is_asymptotic for each in self.estimates)


def max_unobserved_ratio(goal: Goal) -> float:
    """Return the largest ratio of error to tolerance for which two runs suffice."""
    is_peak = goal.quantity.at == "largest"
    return MAX_UNOBSERVED_PEAK_RATIO if is_peak else MAX_UNOBSERVED_RATIO


def is_close(trials: TrialRuns, other: TrialRun, differences: Sequence[float]) -> bool:
    """Return True if two motions are in the asymptotic range."""
    columns = zip(differences, trials.goals, other.histories, strict=True)
    return all(
        difference <= MAX_DIFFERENCE * goal.quantity.size(history)
        for difference, goal, history in columns
    )


def may_be_compared(trials: TrialRuns, other: TrialRun, differences: Sequence[float]) -> bool:
    """Return True if two motions are in the asymptotic range, or differ less than the tolerances.

    Then their peaks, and their values at the end, do not agree by chance.
    """
    tolerances = absolute_tolerances(trials.goals, other)
    pairs = zip(differences, tolerances, strict=True)
    return is_close(trials, other, differences) or all(one <= limit for one, limit in pairs)


def elements_of(trial: TrialRun) -> int:
    """Return the number of elements of the beams with automatic meshes."""
    scene = trial.run.system.scene
    return sum(scene.body(name).n_elements for name in trial.model.counts)


def mesh_orders(trials: TrialRuns, order: int) -> list[int]:
    """Return the order of every quantity in the length of the elements from that of positions."""
    return [each.quantity.order(order) for each in trials.goals]


def solver_noise(trials: TrialRuns, run: TrialRun) -> list[float]:
    """Return the difference by the tolerance of the solver in every quantity [its unit]."""
    pairs = zip(trials.goals, run.histories, strict=True)
    return [SOLVER_NOISE * goal.quantity.size(history) for goal, history in pairs]


def step_estimates(trials: TrialRuns, runs: Sequence[TrialRun], order: int) -> tuple[Estimate, ...]:
    """Estimate the error of the last of several runs on one mesh for every quantity."""
    return _extrapolate(trials, runs, [run.steps for run in runs], [order] * len(trials.goals))


def mesh_estimates(trials: TrialRuns, runs: Sequence[TrialRun], order: int) -> tuple[Estimate, ...]:
    """Estimate the error of the last of several runs with the same steps for every quantity."""
    counts = [elements_of(run) for run in runs]
    return _extrapolate(trials, runs, counts, mesh_orders(trials, order))


def _extrapolate(
    trials: TrialRuns, runs: Sequence[TrialRun], resolutions: Sequence[int], orders: Sequence[int]
) -> tuple[Estimate, ...]:
    """Estimate the error of the last run from the differences of all."""
    differences = [goal_differences(trials.goals, a, b) for a, b in pairwise(runs)]
    columns = zip(*differences, strict=True)
    near = _differences_near_last(trials, runs[-3:])
    columns = zip(columns, orders, solver_noise(trials, runs[-1]), near, strict=True)
    return tuple(estimate(resolutions, *each) for each in columns)


def _differences_near_last(trials: TrialRuns, runs: Sequence[TrialRun]) -> list[float | None]:
    """Return the differences of the first two of three runs near the largest of the last two.

    Of quantities at all saved times; None for others.
    """
    out: list[float | None] = [None] * len(trials.goals)
    for i, goal in enumerate(trials.goals if len(runs) > 2 else ()):
        first, last = (
            differences_over_time(goal, a.histories[i], b.histories[i]) for a, b in pairwise(runs)
        )
        if goal.quantity.at == "saved" and min(len(first), len(last)) > 1:
            times = np.linspace(0.0, 1.0, len(first))
            distances = np.abs(times - last.argmax() / (len(last) - 1.0))
            out[i] = float(first[distances <= NEAR_FRACTION].max())
    return out


def no_time_error(trials: TrialRuns, model: Model) -> RunEstimates:
    """Return the run of an equilibrium, without an error of steps."""
    run = trials.run(model, 1)
    assert run is not None  # statics has no failing steps
    return RunEstimates((Estimate(1.0, 0.0, 2.0, is_asymptotic=True),) * len(trials.goals), (run,))
