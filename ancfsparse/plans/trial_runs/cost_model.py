"""What a run costs: counts of pilot runs, scaled to its steps and its mesh, times measured time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from ancfsparse.results import RunStats

# Work of one residual, one solution and one factor with its matrix, for each coordinate: ratios of
# operations on chains (docs/theory.md).
RESIDUAL, SOLVE, FACTOR = 1.0, 1.2, 16.0
# What a step costs beside its coordinates, in coordinates: calls, tests, a saved state.
BESIDE = 20.0


@dataclass(frozen=True)
class Counted:
    """Counts of one run.

    Attributes
    ----------
    steps, coordinates : int
        Steps, and free coordinates.
    work : float
        Weighed counts for each step and coordinate.
    march, setup : float
        Measured times of march and set-up [s].
    """

    steps: int
    coordinates: int
    work: float
    march: float
    setup: float

    @property
    def amount(self) -> float:
        """All work, in that of a residual of one coordinate."""
        return self.steps * self.work * (self.coordinates + BESIDE)


def counted(stats: RunStats, steps: int, coordinates: int) -> Counted:
    """Return the counts of a run over a number of steps."""
    work = (
        RESIDUAL * max(stats.residual_evaluations, stats.steps)
        + SOLVE * stats.solves
        + FACTOR * stats.factorizations
    )
    return Counted(
        steps, coordinates, work / steps, stats.march_seconds, stats.seconds.get("set-up", 0.0)
    )


@dataclass(frozen=True)
class CostModel:
    """Costs by steps and coordinates.

    Attributes
    ----------
    runs : tuple of Counted
        Pilot runs with ascending numbers of steps.
    """

    runs: tuple[Counted, ...]

    @property
    def unit(self) -> float:
        """Time of a residual of one coordinate [s]: the least measured, the least disturbed."""
        return min(run.march / run.amount for run in self.runs)

    def work(self, steps: float) -> float:
        """Return the work for each step and coordinate at a number of steps.

        Longer steps take more iterations; between pilots the logarithms are interpolated.
        """
        runs = self.runs
        if steps <= runs[0].steps:
            return runs[0].work
        for one, other in pairwise(runs):
            if steps <= other.steps:
                share = math.log(steps / one.steps) / math.log(other.steps / one.steps)
                return float(one.work * (other.work / one.work) ** share)
        return runs[-1].work

    def amount(self, steps: float, coordinates: float) -> float:
        """Return the work of a run."""
        return steps * self.work(steps) * (coordinates + BESIDE)

    def seconds(self, steps: float, coordinates: float) -> float:
        """Return march and set-up together [s]."""
        last = max(self.runs, key=lambda run: run.coordinates)
        setup = min(run.setup for run in self.runs) * max(1.0, coordinates / last.coordinates)
        return setup + self.unit * self.amount(steps, coordinates)


def model(runs: Sequence[Counted]) -> CostModel:
    """Return a cost model: one run for each number of steps, that of the largest mesh."""
    best: dict[int, Counted] = {}
    for run in runs:
        if run.steps not in best or run.coordinates > best[run.steps].coordinates:
            best[run.steps] = run
    return CostModel(tuple(best[steps] for steps in sorted(best)))
