"""The stability map as text, CSV, JSON and charts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ancfsparse.studies.charts import save, write_json
from ancfsparse.studies.scaling_report import write_csv
from ancfsparse.studies.stability import FOR_ALL_SOLVERS, MOST_GAIN, Stability
from ancfsparse.studies.stability_findings import (
    alive,
    findings,
    headline,
    integrator_table,
    solver_headline,
    solver_table,
)
from ancfsparse.studies.stability_run import INTEGRATORS, OUTCOMES, SOLVERS, Run

COLOURS = ("#bfe3d0", "#56b4e9", "#e69f00", "#8c1d04")
"""One for each of `OUTCOMES`."""

# A run that loses more than this of its largest kinetic energy is marked.
MUCH = 0.1


def scenes_of(result: Stability) -> list[str]:
    """Return the names of the scenes, in order."""
    return list(dict.fromkeys(run.place.scene for run in result.runs))


def as_text(result: Stability) -> str:
    """Set the tables for a terminal."""
    n = len(result.runs)
    counts = [f"{sum(r.outcome == kind for r in result.runs)} {kind}" for kind in OUTCOMES]
    tables = integrator_table(result, scenes_of(result)), solver_table(result)
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


def integrator_chart(result: Stability) -> Figure:
    """Draw one panel for each scene and integrator, with ``"auto"``."""
    rows = [(scene, scene) for scene in scenes_of(result)]
    panels = [
        [result.of(scene, integrator, "auto") for integrator in INTEGRATORS] for scene, _ in rows
    ]
    return _chart(panels, [title for _, title in rows], list(INTEGRATORS), headline(result))


def solver_chart(result: Stability) -> Figure:
    """Draw one panel for each scene, integrator of the cut, and solver."""
    rows = [(scene, name) for scene in scenes_of(result) for name in FOR_ALL_SOLVERS]
    panels = [[result.of(*row, solver) for solver in SOLVERS] for row in rows]
    titles = [f"{scene}\n{name}" for scene, name in rows]
    return _chart(panels, titles, list(SOLVERS), solver_headline(result))


def _chart(
    panels: Sequence[Sequence[list[Run]]], rows: Sequence[str], columns: Sequence[str], title: str
) -> Figure:
    figure = Figure(
        figsize=(2.0 + 1.35 * len(columns), 1.1 + 1.35 * len(rows)), layout="constrained"
    )
    axes = figure.subplots(len(rows), len(columns), sharex=True, sharey=True, squeeze=False)
    for i, line in enumerate(panels):
        for j, runs in enumerate(line):
            _panel(axes[i, j], runs)
        axes[i, 0].set_ylabel(rows[i] + "\nPa", fontsize=7)
    for j, name in enumerate(columns):
        axes[0, j].set_title(name, fontsize=7)
        axes[-1, j].set_xlabel("dt [s]", fontsize=7)
    figure.suptitle(title, fontsize=11)
    figure.legend(
        handles=[
            *(Patch(color=c, label=kind) for c, kind in zip(COLOURS, OUTCOMES, strict=True)),
            Line2D([], [], marker="_", color="black", linestyle="", label="lost a tenth or more"),
            Line2D([], [], marker="x", color="black", linestyle="", label="gained, not stopped"),
        ],
        loc="outside lower center", ncols=6, fontsize=8, frameon=False,
    )  # fmt: skip
    return figure


def _panel(ax: Axes, runs: Sequence[Run]) -> None:
    """Colour time step against stiffness by outcome; the corner says how many live."""
    steps = sorted({run.place.dt for run in runs})
    stiff = sorted({run.place.youngs_modulus for run in runs})
    cells = np.full((len(stiff), len(steps)), np.nan)
    for run in runs:
        x, y = steps.index(run.place.dt), stiff.index(run.place.youngs_modulus)
        cells[y, x] = OUTCOMES.index(run.outcome)
        if run.whole and run.gain > MOST_GAIN:
            ax.plot(x, y, "x", color="black", markersize=4)
        elif run.whole and run.loss > MUCH:
            ax.plot(x, y, "_", color="black", markersize=5)
    ax.imshow(
        cells, cmap=ListedColormap(COLOURS), vmin=-0.5, vmax=len(OUTCOMES) - 0.5, origin="lower",
        aspect="auto",
    )  # fmt: skip
    ax.set_xticks(range(len(steps)), [f"{s:g}" for s in steps], fontsize=5, rotation=90)
    ax.set_yticks(range(len(stiff)), [f"{s:.0e}".replace("e+", "e") for s in stiff], fontsize=5)
    ax.tick_params(length=1.5)
    ax.text(0.03, 0.96, f"{alive(runs):.0f} %", transform=ax.transAxes, fontsize=6, va="top")
