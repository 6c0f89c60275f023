"""Estimates of the error of mesh or steps from several trial runs, by Richardson extrapolation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from ancfsparse.plans.discretization_error.richardson import Estimate, estimate
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.trial_runs.run_differences import (
    absolute_tolerances,
    goal_differences,
)
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns

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
    columns = zip(zip(*differences, strict=True), orders, strict=True)
    return tuple(estimate(resolutions, *each) for each in columns)


def no_time_error(trials: TrialRuns, model: Model) -> RunEstimates:
    """Return the run of an equilibrium, without an error of steps."""
    run = trials.run(model, 1)
    assert run is not None  # statics has no failing steps
    return RunEstimates((Estimate(1.0, 0.0, 2.0, is_asymptotic=True),) * len(trials.goals), (run,))
