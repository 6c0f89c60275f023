"""Whether steps cost so much that shorter ones are cheaper, which only shorter ones can show."""

from __future__ import annotations

import math

from ancfsparse.results import RunStats
from ancfsparse.solve.error_models.cost_model import CostModel

# Steps that are looked at together, at least.
FEWEST = 8
# Residuals with their solution; steps that cost more may cost less when they are shorter.
HARD = 5.5
# How much less each of the shorter ones must cost.  They are more accurate by the square of their
# ratio, so they need not be as cheap for the same time.
CHEAPER = 1.05
# For so many steps shorter ones do not grow, or are not tried again where they did not pay.
HOLD = 128


class StepCostMonitor:
    """Compares what steps cost before and after they were made shorter.

    Parameters
    ----------
    price : Price
        Of an evaluation, a solution, a factor.
    ratio : float
        By which steps are made shorter.
    """

    def __init__(self, price: CostModel, ratio: float) -> None:
        self._price, self._ratio = price, ratio
        self._hard = HARD * (price.residual + price.solve)
        self._steps, self._spent = 0, 0.0  # at the last look
        self._longer = math.inf  # what each of the longer steps did cost
        self._vain = 0.0  # the cost of shorter ones that were not cheaper
        self._until, self._rest = 0, 0  # steps up to which they do not grow, and that cost counts

    def may_grow(self, steps: int) -> bool:
        """Whether steps may be longer after so many of them."""
        return steps >= self._until

    def too_large(self, stats: RunStats) -> bool:
        """Whether the last steps shall be made shorter."""
        steps, spent = stats.steps, self._price.of_run(stats)
        if steps - self._steps < FEWEST:
            return False
        each = (spent - self._spent) / (steps - self._steps)
        self._steps, self._spent = steps, spent
        if self._longer < CHEAPER * each:
            self._vain, self._until, self._rest = each, 0, steps + HOLD
        elif steps >= self._rest:
            self._vain = 0.0
        self._longer = math.inf
        if each < max(self._hard, self._ratio * self._vain):
            return False
        self._longer, self._until = each, steps + HOLD
        self._spent += self._price.factor  # that the change asks for
        return True
