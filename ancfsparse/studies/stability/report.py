"""The stability map as text, CSV, JSON and charts."""

from __future__ import annotations

from pathlib import Path

from ancfsparse.studies.common.files import save, write_csv, write_json
from ancfsparse.studies.stability.cells import OUTCOMES
from ancfsparse.studies.stability.charts import integrator_chart, solver_chart
from ancfsparse.studies.stability.findings import findings, integrator_table, solver_table
from ancfsparse.studies.stability.run import Stability


def as_text(result: Stability) -> str:
    """Set the tables for a terminal."""
    n = len(result.runs)
    counts = [f"{sum(r.outcome == kind for r in result.runs)} {kind}" for kind in OUTCOMES]
    tables = integrator_table(result), solver_table(result)
    return f"{n} runs: {', '.join(counts)}\n\n" + "\n\n".join(tables).replace("\n- ", "\n")


def write(result: Stability, folder: Path) -> list[Path]:
    """Write stability.csv and .json, stability.png and stability-solvers.png.

    Parameters
    ----------
    result : Stability
        A finished study.
    folder : Path
        Where to; made if missing.

    Returns
    -------
    list of Path
        The files, the two charts last.
    """
    folder.mkdir(parents=True, exist_ok=True)
    names = ("stability.csv", "stability.json", "stability.png", "stability-solvers.png")
    paths = [folder / name for name in names]
    write_csv([run.record() for run in result.runs], paths[0])
    write_json({**result.record(), "findings": findings(result)}, paths[1])
    save(integrator_chart(result), paths[2])
    save(solver_chart(result), paths[3])
    return paths
