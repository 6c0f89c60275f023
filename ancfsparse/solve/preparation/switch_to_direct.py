"""From an incomplete seed to the complete one during a run, where the counts show that it pays."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ancfsparse.nonlinear.iteration import Costs
from ancfsparse.seeds import Fill, Groups, IncompleteSeed, Seed
from ancfsparse.seeds.complete.sparse_seed import BLOCK_ENTRY
from ancfsparse.system_memory import available_memory

# Steps after which costs are compared for the first time; then after twice as many, and so on.
FIRST_LOOK = 5
# Complete seeds are renewed a fifth to two thirds as often as incomplete ones, at as many
# corrections.
RARER = 0.33
# Where a third of the corrections have a seed of their own, complete ones are renewed
# as often: 248 and 327 times where incomplete ones are 186 and 301 times.
OFTEN = 3.0
# By what factor the complete seed must be cheaper as counted: its entries take a third longer than
# those of an incomplete one, and it has to be ordered.
MARGIN = 0.6
# Blocks of the complete factor for each of the matrix beyond which its costs are not looked at.
MOST_FILL = 25.0


class WayBack:
    """Whether a run on incomplete seeds should go on with complete ones, and how.

    Parameters
    ----------
    groups : Groups
        Of what the complete factor would be made.
    costs_of : callable
        Gives the costs of an iteration and of a seed that has the operations of `Fill`.
    incomplete : IncompleteSeed
        What the run is on.
    take : callable
        Makes the complete seed and lets the compiled loop go on with it.
    """

    def __init__(
        self,
        groups: Groups,
        costs_of: Callable[[Seed | Fill], Costs],
        incomplete: IncompleteSeed,
        take: Callable[[], Seed],
    ) -> None:
        self._groups, self._take = groups, take
        fill = groups.exact_fill(MOST_FILL)
        self._exact = None if fill is None else costs_of(fill)
        self._solve = 0.0 if fill is None else 0.5 * fill.solve_flops
        self._costs, self._sweep = costs_of(incomplete), 0.5 * incomplete.sweep_flops
        self._residual = self._costs.iteration - 0.5 * incomplete.solve_flops
        self._seen = dict.fromkeys(("residual_evaluations", "solves", "factorizations"), 0)
        self._swept = 0

    def pays(self, counts: Mapping[str, int], inner: tuple[int, int]) -> bool:
        """Whether the steps since the last look would have been cheaper on complete seeds.

        Parameters
        ----------
        counts : mapping
            Of the compiled loop so far.
        inner : (int, int)
            Sweeps and products so far.
        """
        since = {key: counts[key] - seen for key, seen in self._seen.items()}
        swept = sum(inner) - self._swept
        self._seen, self._swept = {key: counts[key] for key in since}, sum(inner)
        if self._exact is None:
            return False
        residual = self._residual * since["residual_evaluations"]
        cost = residual + self._sweep * swept
        cost += self._costs.seed * since["factorizations"]
        exact = residual + self._solve * since["solves"]
        rarer = min(1.0, max(RARER, OFTEN * since["factorizations"] / max(since["solves"], 1)))
        exact += rarer * self._exact.seed * since["factorizations"]
        return exact < MARGIN * cost

    def take(self) -> Seed | None:
        """Return the complete seed that the run goes on with; None where it does not fit."""
        free = available_memory()
        if free is not None and (
            self._groups.exact_fill(free / (BLOCK_ENTRY * self._groups.nnz)) is None
        ):
            return None
        return self._take()
