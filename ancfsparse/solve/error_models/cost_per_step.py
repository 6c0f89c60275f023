"""Detect whether shorter steps would be cheaper because each needs fewer iterations."""

from __future__ import annotations

import math

from ancfsparse.nonlinear.iteration import Costs

MIN_STEPS = 8  # steps of a comparison
# Iterations whose cost steps must exceed to be shortened.  Without, a beam that a moment spins up
# took steps twice as long with half as many again residuals and factors, at 7 times the error.
MIN_HARD_COST = 5.5
N_HELD_STEPS = 128  # steps for which shortened steps do not grow, or are not tried again


class StepCostMonitor:
    """Compares the cost of steps before and after they were shortened.

    Parameters
    ----------
    costs : Costs
        Costs of a residual, a solution and a factor.
    ratio : float
        Ratio of a step to a shortened one.
    """

    def __init__(self, costs: Costs, ratio: float) -> None:
        self._factor, self._ratio = costs.factor, ratio
        self._hard = MIN_HARD_COST * costs.iteration
        self._steps, self._total = 0, 0.0  # at the last comparison
        self._longer = math.inf  # cost of each of the longer steps
        self._failed = 0.0  # cost of shorter steps that were not cheaper
        self._until, self._rest = 0, 0  # steps until growth is allowed, and until that is forgotten

    def may_grow(self, steps: int) -> bool:
        """Return whether steps may grow after a number of them."""
        return steps >= self._until

    def too_large(self, steps: int, total: float) -> bool:
        """Return whether the next steps should be shorter, by the total cost of all steps."""
        if steps - self._steps < MIN_STEPS:
            return False
        cost = (total - self._total) / (steps - self._steps)
        self._steps, self._total = steps, total
        if self._longer < cost:
            self._failed, self._until, self._rest = cost, 0, steps + N_HELD_STEPS
        elif steps >= self._rest:
            self._failed = 0.0
        self._longer = math.inf
        if cost < max(self._hard, self._ratio * self._failed):
            return False
        self._longer, self._until = cost, steps + N_HELD_STEPS
        self._total += self._factor  # for the change of the step
        return True
