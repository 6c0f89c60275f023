"""Costs of runs by operation counts, for comparison of methods without a clock."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ancfsparse.integrators import Implicit
from ancfsparse.results import RunStats
from ancfsparse.solve.stepping.implicit_setup import iteration_costs
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.seeds import Seed


@dataclass(frozen=True)
class CostModel:
    """Costs of the parts of an implicit run, in the unit of `Costs`.

    Attributes
    ----------
    residual, solve, factor : float
        Cost of a residual, of a solution, and of a new factor with its matrix.
    """

    residual: float
    solve: float
    factor: float

    @classmethod
    def of(cls, system: System, integrator: Implicit, seed: Seed) -> CostModel:
        """Return the costs of implicit runs with a seed."""
        costs = iteration_costs(system, integrator, seed, None)
        solve = 0.5 * seed.solve_flops
        return cls(costs.iteration - solve, solve, costs.seed)

    def of_run(self, stats: RunStats) -> float:
        """Return the cost of a run with error estimates, each of which takes a solution."""
        solves = stats.solves + stats.steps + stats.rejected_steps
        return (
            self.residual * stats.residual_evaluations
            + self.solve * solves
            + self.factor * stats.factorizations
        )
