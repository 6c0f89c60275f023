"""Estimates of the error of mesh or steps from several trial runs, by Richardson extrapolation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from ancfsparse.plans.discretization_error.richardson import Estimate, estimate
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns, goal_differences

SOLVER_NOISE = 1e-7  # difference by the tolerance of the solver, relative to the quantity


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
    """Estimate the error of the last run from the differences of the last three."""
    differences = [goal_differences(trials.goals, a, b) for a, b in pairwise(runs[-3:])]
    noises = solver_noise(trials, runs[-1])
    columns = zip(zip(*differences, strict=True), orders, noises, strict=True)
    return tuple(estimate(resolutions[-3:], *each) for each in columns)
