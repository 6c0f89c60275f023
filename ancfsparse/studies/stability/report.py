"""The stability map as text, CSV, JSON and charts."""

from __future__ import annotations

from ancfsparse.studies.common.study import Study
from ancfsparse.studies.stability.cells import OUTCOMES
from ancfsparse.studies.stability.charts import integrator_chart, solver_chart
from ancfsparse.studies.stability.findings import findings, integrator_table, solver_table
from ancfsparse.studies.stability.run import Stability, stability


def as_text(result: Stability) -> str:
    """Set the tables for a terminal."""
    n = len(result.runs)
    counts = [f"{sum(r.outcome == kind for r in result.runs)} {kind}" for kind in OUTCOMES]
    tables = integrator_table(result), solver_table(result)
    return f"{n} runs: {', '.join(counts)}\n\n" + "\n\n".join(tables).replace("\n- ", "\n")


STUDY = Study(
    "stability",
    run=stability,
    text=as_text,
    rows=lambda result: [run.record() for run in result.runs],
    record=Stability.record,
    findings=findings,
    charts={"stability": integrator_chart, "stability-solvers": solver_chart},
    regions={"stability": integrator_table, "stability-solvers": solver_table},
)
