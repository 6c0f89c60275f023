"""What runs cost by counts, so that methods can be compared without a clock."""

from __future__ import annotations

from dataclasses import dataclass

from ancfsparse.integrators import Implicit
from ancfsparse.results import RunStats
from ancfsparse.seeds import Seed
from ancfsparse.solve.stepping.implicit_setup import iteration_costs
from ancfsparse.system import System


@dataclass(frozen=True)
class CostModel:
    """Modelled costs in the unit of `Costs`.

    Attributes
    ----------
    residual, solve, factor : float
        Of an evaluation of the residual, of a solution, and of a new factor with its matrix.
    """

    residual: float
    solve: float
    factor: float

    @classmethod
    def of(cls, system: System, integrator: Implicit, seed: Seed) -> CostModel:
        """Return the prices of implicit runs with a seed."""
        weighed = iteration_costs(system, integrator, seed, None)
        solve = 0.5 * seed.solve_flops
        return cls(weighed.iteration - solve, solve, weighed.seed)

    def of_run(self, stats: RunStats) -> float:
        """Return what a run with error estimates, each a solution, has cost."""
        solves = stats.solves + stats.steps + stats.rejected_steps
        return (
            self.residual * stats.residual_evaluations
            + self.solve * solves
            + self.factor * stats.factorizations
        )
