"""Cost of a run: operation counts of trial runs, scaled in steps and mesh, times measured time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from ancfsparse.nonlinear.iteration import Costs
from ancfsparse.results import RunStats

# Work per coordinate, relative to a residual: operation counts on chains (docs/theory.md).
COORDINATE_COSTS = Costs(residual=1.0, solve=1.2, factor=16.0)
STEP_OVERHEAD = 20.0  # coordinates; work of calls, checks and a saved state in each step


@dataclass(frozen=True)
class RunCost:
    """Operation counts of one run.

    Attributes
    ----------
    steps, coordinates : int
        Steps, and unconstrained coordinates.
    unit_work : float
        Weighted counts per step and coordinate.
    march, setup : float
        Measured times of time integration and set-up [s].
    """

    steps: int
    coordinates: int
    unit_work: float
    march: float
    setup: float

    @property
    def work(self) -> float:
        """Work of the run, relative to a residual of one coordinate."""
        return self.steps * self.unit_work * (self.coordinates + STEP_OVERHEAD)


def cost_of_run(stats: RunStats, steps: int, coordinates: int) -> RunCost:
    """Return the cost of a run with a number of steps."""
    residuals = max(stats.residual_evaluations, stats.steps)
    work = COORDINATE_COSTS.total(residuals, stats.solves, stats.factorizations)
    return RunCost(
        steps, coordinates, work / steps, stats.march_seconds, stats.seconds.get("set-up", 0.0)
    )


@dataclass(frozen=True)
class CostModel:
    """Cost as a function of steps and coordinates.

    Attributes
    ----------
    runs : tuple of RunCost
        Trial runs with ascending numbers of steps.
    """

    runs: tuple[RunCost, ...]

    @property
    def unit(self) -> float:
        """Time of a residual of one coordinate [s]: the least measured, the least disturbed."""
        return min(run.march / run.work for run in self.runs)

    def unit_work(self, steps: float) -> float:
        """Return the work per step and coordinate for a number of steps.

        Longer steps take more iterations; between trial runs logarithms are interpolated.
        """
        runs = self.runs
        if steps <= runs[0].steps:
            return runs[0].unit_work
        for one, other in pairwise(runs):
            if steps <= other.steps:
                x = math.log(steps / one.steps) / math.log(other.steps / one.steps)
                return float(one.unit_work * (other.unit_work / one.unit_work) ** x)
        return runs[-1].unit_work

    def work(self, steps: float, coordinates: float) -> float:
        """Return the work of a run, relative to a residual of one coordinate."""
        return steps * self.unit_work(steps) * (coordinates + STEP_OVERHEAD)

    def seconds(self, steps: float, coordinates: float) -> float:
        """Return the time of integration and set-up [s]."""
        last = max(self.runs, key=lambda run: run.coordinates)
        setup = min(run.setup for run in self.runs) * max(1.0, coordinates / last.coordinates)
        return setup + self.unit * self.work(steps, coordinates)


def fit_cost_model(runs: Sequence[RunCost]) -> CostModel:
    """Return a cost model from the run on the largest mesh for each number of steps."""
    best: dict[int, RunCost] = {}
    for run in runs:
        if run.steps not in best or run.coordinates > best[run.steps].coordinates:
            best[run.steps] = run
    return CostModel(tuple(best[steps] for steps in sorted(best)))
