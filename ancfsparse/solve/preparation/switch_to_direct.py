"""Switch from an incomplete to a complete seed during a run, by operation counts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from ancfsparse.nonlinear.iteration import SWEEP_COST, Costs
from ancfsparse.seeds import Groups
from ancfsparse.seeds.complete.sparse_seed import CHOLMOD_ENTRY_BYTES
from ancfsparse.system_memory import available_memory

if TYPE_CHECKING:
    from ancfsparse.seeds import Fill, IncompleteSeed, Seed

FIRST_COMPARISON = 5  # steps before the first comparison of costs; doubled for each further one
# Complete seeds are renewed a fifth to two thirds as often as incomplete ones, at equally many
# corrections.
MIN_RENEWAL_RATIO = 0.33  # renewals of complete over those of incomplete seeds
# If a third of the corrections have a new seed, complete seeds are renewed as often: 248 and 327
# times, incomplete ones 186 and 301 times.
RENEWAL_FACTOR = 3.0  # that ratio over the renewals per correction
# An entry of a complete seed takes a third longer than one of an incomplete seed, and it must be
# ordered.
MAX_COST_RATIO = 0.6  # counted cost with the complete over that with the incomplete seed
MAX_COUNTED_FILL = 25.0  # blocks of the factor per block of the matrix


class SwitchToDirect:
    """Compare the costs of a run on incomplete seeds with those on complete ones, and switch.

    Parameters
    ----------
    groups : Groups
        Groups of unknowns of the complete factor.
    costs_of : callable
        Returns the costs of an iteration and of a seed with the operations of `Fill`.
    incomplete : IncompleteSeed
        The present seed.
    switch : callable
        Creates the complete seed and passes it to the compiled loop.
    """

    def __init__(
        self,
        groups: Groups,
        costs_of: Callable[[Seed | Fill], Costs],
        incomplete: IncompleteSeed,
        switch: Callable[[], Seed],
    ) -> None:
        self._groups, self._switch = groups, switch
        fill = groups.exact_fill(MAX_COUNTED_FILL)
        self._complete = None if fill is None else costs_of(fill)
        self._costs, self._sweep = costs_of(incomplete), SWEEP_COST * incomplete.sweep_flops
        self._counted = dict.fromkeys(("residual_evaluations", "solves", "factorizations"), 0)
        self._swept = 0

    def is_cheaper(self, counts: Mapping[str, int], inner: tuple[int, int]) -> bool:
        """Return whether the steps since the last comparison had cost less on complete seeds.

        Parameters
        ----------
        counts : mapping
            Counts of the compiled loop so far.
        inner : (int, int)
            Sweeps and products so far.
        """
        since, swept = self.since_comparison(counts, inner)
        self.continue_comparison((dict.fromkeys(since, 0), 0), counts, inner)
        if self._complete is None:
            return False
        residuals, solves, factors = (
            since[name] for name in ("residual_evaluations", "solves", "factorizations")
        )
        cost = self._costs.total(residuals, 0, factors) + self._sweep * swept
        renewals = min(1.0, max(MIN_RENEWAL_RATIO, RENEWAL_FACTOR * factors / max(solves, 1)))
        complete = self._complete.total(residuals, solves, renewals * factors)
        return complete < MAX_COST_RATIO * cost

    def since_comparison(
        self, counts: Mapping[str, int], inner: tuple[int, int]
    ) -> tuple[dict[str, int], int]:
        """Return the counts, and sweeps and products, since the last comparison."""
        since = {key: counts[key] - before for key, before in self._counted.items()}
        return since, sum(inner) - self._swept

    def continue_comparison(
        self,
        since: tuple[Mapping[str, int], int],
        counts: Mapping[str, int],
        inner: tuple[int, int],
    ) -> None:
        """Let the counts since the last comparison be those that `since_comparison` returned."""
        self._counted = {key: counts[key] - each for key, each in since[0].items()}
        self._swept = sum(inner) - since[1]

    def switch(self) -> Seed | None:
        """Return the complete seed that the run continues with; None if it does not fit."""
        free = available_memory()
        if free is not None and (
            self._groups.exact_fill(free / (CHOLMOD_ENTRY_BYTES * self._groups.nnz)) is None
        ):
            return None
        return self._switch()
