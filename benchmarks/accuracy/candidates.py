"""Integrators and solvers of this package that run against the clock.

A new integrator is one line in `INTEGRATORS`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ancfsparse.errors import EnergyIncreaseError, InstabilityError, StepError
from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.solve import simulate, stable_step
from benchmarks.accuracy.models import MODELS, OUTPUTS, meets_outputs, step_up_to
from benchmarks.accuracy.timed_runs import FailedError, Sample, Task
from benchmarks.common import methods
from benchmarks.common.methods import chosen
from benchmarks.common.timing import OURS

# Every one a whole part of half a second, so that output times are met.
DTS = (2e-2, 1e-2, 4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4, 6.25e-5, 3.125e-5)

SOLVERS = chosen(methods.SOLVERS, "Davidon", "BFGS", "modified Newton", "Newton")
"""Solvers of the equations of an implicit step."""


@dataclass(frozen=True)
class Integrator:
    """A row of the table.

    Attributes
    ----------
    name : str
        For tables and charts, and for the table of `methods`.
    dts : tuple of float
        Time steps [s], largest first; those that do not meet the output times are omitted.
    stable_fractions : tuple of float
        In the place of `dts`, for an explicit method: parts of its longest stable step.
    solvers : tuple of str
        Keys of `SOLVERS`; empty for an explicit method, which has no equations to solve.
    colour : str
        Its colour in charts.
    scheme : Implicit or Explicit, optional
        One that is not in the table.
    """

    name: str
    dts: tuple[float, ...] = DTS
    solvers: tuple[str, ...] = tuple(SOLVERS)
    colour: str = "#0072b2"
    stable_fractions: tuple[float, ...] = ()
    scheme: Implicit | Explicit | None = None

    @property
    def integrator(self) -> Implicit | Explicit:
        """The integrator of the package."""
        return methods.INTEGRATORS[self.name] if self.scheme is None else self.scheme

    def steps(self, model: str, elements: int, t_end: float) -> list[float]:
        """Return the steps to run on a mesh [s], all of which meet the output times."""
        integrator = self.integrator if self.stable_fractions else None
        if isinstance(integrator, Explicit):
            limit = stable_step(MODELS[model].problem(elements).scene, integrator)
            return [step_up_to(fraction * limit, t_end) for fraction in self.stable_fractions]
        return [dt for dt in self.dts if meets_outputs(dt, t_end)]


FAST_SOLVERS = ("BFGS", "modified Newton")

# The first is refused, and stays on the chart.
STABLE_FRACTIONS = (1.05, 0.98, 0.7, 0.5, 0.35, 0.25)

INTEGRATORS = (
    Integrator("Newmark(0)"),
    Integrator("Newmark(0.05)", solvers=FAST_SOLVERS, colour="#56b4e9"),
    Integrator("HHT(0.05)", solvers=FAST_SOLVERS, colour="#5c4fc4"),
    Integrator("GeneralizedAlpha(0.9)", solvers=FAST_SOLVERS, colour="#000000"),
    Integrator("CentralDifference", (), (), "#b22222", STABLE_FRACTIONS),
    Integrator("RungeKuttaNystrom(4)", (), (), "#6b8e23", STABLE_FRACTIONS),
    Integrator("RungeKuttaNystrom(8)", (), (), "#2f4f4f", STABLE_FRACTIONS[:3]),
)
"""Integrators of the study; adding one is one line."""


def candidates(
    model: str,
    elements: int,
    t_end: float,
    integrators: Sequence[Integrator] = INTEGRATORS,
    solvers: Sequence[str] = tuple(SOLVERS),
) -> list[Task]:
    """Return a task for every integrator, every step and every solver."""
    return [
        task(model, elements, t_end, integrator, dt, solver)
        for integrator in integrators
        for solver in ([s for s in solvers if s in integrator.solvers] or [""])
        for dt in integrator.steps(model, elements, t_end)
    ]


def task(
    model: str,
    elements: int,
    t_end: float,
    row: Integrator,
    dt: float,
    solver: str,
    tolerance: str | float = "default",
) -> Task:
    """Return one run of this package, timed by its compiled time loop alone."""
    scene, rod = MODELS[model].problem(elements)

    def run() -> Sample:
        scheme = row.integrator
        if isinstance(scheme, Explicit) and dt > (limit := stable_step(scene, scheme)):
            raise FailedError(f"above the stable step, {limit:.2g} s")
        try:
            path = simulate(
                scene,
                t_end,
                dt,
                integrator=scheme,
                solver=SOLVERS.get(solver, "auto"),
                tolerance=tolerance,
                save_every=round(t_end / OUTPUTS / dt),
                save_nodes=[rod.end],
            )
        except InstabilityError as failure:
            raise FailedError(f"unstable at t = {failure.time:.2g} s") from failure
        except EnergyIncreaseError as failure:
            raise FailedError(f"gained energy at t = {failure.time:.2g} s") from failure
        except StepError as failure:
            raise FailedError(f"no convergence at t = {failure.time:.2g} s") from failure
        stats = path.stats
        counts = {
            "steps": stats.steps,
            "residuals": stats.residual_evaluations,
            "iterations": stats.iterations,
            "factorizations": stats.factorizations,
            "solves": stats.solves,
        }
        return Sample(stats.march_seconds, path.position(rod.end)[1:], counts)

    return Task(OURS, row.name, solver, model, elements, "dt", dt, run)
