"""Detect whether shorter steps would be cheaper because each needs fewer iterations."""

from __future__ import annotations

import math

from ancfsparse.results import RunStats
from ancfsparse.solve.error_models.cost_model import CostModel

MIN_STEPS = 8  # steps of a comparison
MIN_HARD_COST = 5.5  # residuals with their solutions; only steps above this cost are shortened
# Shorter steps are more accurate by the square of their ratio, so they need not be as cheap for the
# same time.
MIN_COST_RATIO = 1.05  # cost of a longer step over that of a shorter one
N_HELD_STEPS = 128  # steps for which shortened steps do not grow, or are not tried again


class StepCostMonitor:
    """Compares the cost of steps before and after they were shortened.

    Parameters
    ----------
    cost_model : CostModel
        Costs of a residual, a solution and a factor.
    ratio : float
        Ratio of a step to a shortened one.
    """

    def __init__(self, cost_model: CostModel, ratio: float) -> None:
        self._cost_model, self._ratio = cost_model, ratio
        self._hard = MIN_HARD_COST * (cost_model.residual + cost_model.solve)
        self._steps, self._total = 0, 0.0  # at the last comparison
        self._longer = math.inf  # cost of each of the longer steps
        self._failed = 0.0  # cost of shorter steps that were not cheaper
        self._until, self._rest = 0, 0  # steps until growth is allowed, and until that is forgotten

    def may_grow(self, steps: int) -> bool:
        """Return whether steps may grow after a number of them."""
        return steps >= self._until

    def too_large(self, stats: RunStats) -> bool:
        """Return whether the next steps should be shorter."""
        steps, total = stats.steps, self._cost_model.of_run(stats)
        if steps - self._steps < MIN_STEPS:
            return False
        cost = (total - self._total) / (steps - self._steps)
        self._steps, self._total = steps, total
        if self._longer < MIN_COST_RATIO * cost:
            self._failed, self._until, self._rest = cost, 0, steps + N_HELD_STEPS
        elif steps >= self._rest:
            self._failed = 0.0
        self._longer = math.inf
        if cost < max(self._hard, self._ratio * self._failed):
            return False
        self._longer, self._until = cost, steps + N_HELD_STEPS
        self._total += self._cost_model.factor  # for the change of the step
        return True
