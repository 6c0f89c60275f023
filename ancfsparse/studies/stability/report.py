"""The stability map as text, CSV, JSON and charts."""

from __future__ import annotations

from ancfsparse.studies.common.study import Study
from ancfsparse.studies.stability.cells import OUTCOMES
from ancfsparse.studies.stability.charts import integrator_chart, solver_chart
from ancfsparse.studies.stability.findings import findings, integrator_table, solver_table
from ancfsparse.studies.stability.run import Stability, stability


def heading(result: Stability) -> str:
    """Count the outcomes."""
    counts = [f"{sum(r.outcome == kind for r in result.runs)} {kind}" for kind in OUTCOMES]
    return f"{len(result.runs)} runs: {', '.join(counts)}"


STUDY = Study(
    "stability",
    run=stability,
    heading=heading,
    tables=lambda result: [integrator_table(result), solver_table(result)],
    rows=lambda result: [run.record() for run in result.runs],
    record=Stability.record,
    findings=findings,
    charts={"stability": integrator_chart, "stability-solvers": solver_chart},
    regions={
        "stability": integrator_table,
        "stability-solvers": lambda result: "\n".join(solver_table(result).markdown()),
    },
)
