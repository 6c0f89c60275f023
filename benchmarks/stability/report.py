"""Charts of the stability map."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from benchmarks.common.charts import LETTER_SIZE, new_figure
from benchmarks.common.study import Study
from benchmarks.stability.cells import INTEGRATORS, OUTCOMES, SOLVERS, Run
from benchmarks.stability.findings import completed, findings, integrator_table, solver_table
from benchmarks.stability.stability_map import FOR_ALL_SOLVERS, MAX_GAIN, Stability, stability_map

COLOURS = ("#bfe3d0", "#56b4e9", "#e69f00", "#8c1d04")
"""One for each of `OUTCOMES`."""

MARKED_LOSS = 0.1  # energy lost by a marked run, over its largest kinetic energy

FULL = [name for name in SOLVERS if name.endswith("full")]
WITH_PAIRS = [name for name in SOLVERS if name != "Newton" and name not in FULL]
GROUPS = {
    "Newton": ["Newton"],
    f"{len(WITH_PAIRS)} on kept seeds,\nworst": WITH_PAIRS,
    f"{len(FULL)} with full\nmatrix, worst": FULL,
}
"""Solvers that share a panel, by its title."""

OUTCOME_KEYS = [Patch(color=c, label=kind) for c, kind in zip(COLOURS, OUTCOMES, strict=True)]
HIDDEN_KEY = Line2D([], [], marker="x", color="black", linestyle="", label="gained, not stopped")
"""For legends."""


class Panel(NamedTuple):
    """Runs of a panel."""

    runs: list[Run]  # with one or several solvers
    # Newton's runs by stiffness [Pa] and step [s], to mark differences in; or nothing
    newton: dict[tuple[float, float], Run]


def integrator_chart(result: Stability) -> Figure:
    """Draw one panel for each scene and integrator, with ``"auto"``."""
    panels = [
        [Panel(result.of(scene, integrator, "auto"), {}) for integrator in INTEGRATORS]
        for scene in result.scenes
    ]
    titles = [re.sub("(?=Alpha|Momentum)", "-\n", name) for name in INTEGRATORS]
    figure = _chart(panels, result.scenes, titles, "Outcome of runs by integrator")
    keys = [
        *OUTCOME_KEYS,
        HIDDEN_KEY,
        Line2D([], [], marker="_", color="black", linestyle="", label="lost a tenth or more"),
    ]
    _legend(figure, keys)
    return figure


def solver_chart(result: Stability) -> Figure:
    """Draw for each scene and integrator of the cut Newton, and the worst of the other solvers."""
    panels = []
    for scene in result.scenes:
        line = []
        for integrator in FOR_ALL_SOLVERS:
            newton = {_spot(run): run for run in result.of(scene, integrator, "Newton")}
            for group in GROUPS.values():
                runs = [run for solver in group for run in result.of(scene, integrator, solver)]
                line.append(Panel(runs, newton))
        panels.append(line)
    titles = [
        f"{integrator}\n\n{group}" if k == len(GROUPS) // 2 else group
        for integrator in FOR_ALL_SOLVERS
        for k, group in enumerate(GROUPS)
    ]
    figure = _chart(panels, result.scenes, titles, "Outcome of runs by solver")
    keys = [
        *OUTCOME_KEYS,
        HIDDEN_KEY,
        Line2D([], [], marker="$3$", color="black", linestyle="", label="number of them that fail"),
        Patch(fill=False, edgecolor="black", linewidth=1.5, label="Newton ends, not all of these"),
        Patch(fill=False, edgecolor="black", linestyle=":", linewidth=1.5,
              label="Newton fails, not all of these"),
    ]  # fmt: skip
    _legend(figure, keys)
    return figure


def _spot(run: Run) -> tuple[float, float]:
    return run.map_point.youngs_modulus, run.map_point.dt


def _chart(
    panels: Sequence[Sequence[Panel]], rows: Sequence[str], columns: Sequence[str], title: str
) -> Figure:
    figure = new_figure(1.7 + 1.25 * len(rows), title)
    axes = figure.subplots(len(rows), len(columns), sharex=True, sharey=True, squeeze=False)
    for i, line in enumerate(panels):
        for j, panel in enumerate(line):
            _draw(axes[i, j], panel)
        axes[i, 0].set_ylabel(rows[i] + "\n[Pa]", fontsize=LETTER_SIZE)
    for j, name in enumerate(columns):
        axes[0, j].set_title(name, fontsize=LETTER_SIZE)
        axes[-1, j].set_xlabel("dt [s]", fontsize=LETTER_SIZE)
    return figure


def _legend(figure: Figure, keys: Sequence[Artist]) -> None:
    figure.legend(
        handles=list(keys), loc="outside lower center", ncols=4, fontsize=LETTER_SIZE, frameon=False
    )


def _draw(ax: Axes, panel: Panel) -> None:
    """Colour step against stiffness by the worst outcome; the corner has the share completed."""
    steps = sorted({run.map_point.dt for run in panel.runs})
    stiff = sorted({run.map_point.youngs_modulus for run in panel.runs})
    cells = np.full((len(stiff), len(steps)), np.nan)
    for y, stiffness in enumerate(stiff):
        for x, dt in enumerate(steps):
            here = [run for run in panel.runs if _spot(run) == (stiffness, dt)]
            if here:
                cells[y, x] = max(OUTCOMES.index(run.outcome) for run in here)
                _mark(ax, x, y, here, alone=not panel.newton)
                _frame(ax, x, y, here, panel.newton.get((stiffness, dt)))
    ax.imshow(
        cells, cmap=ListedColormap(COLOURS), vmin=-0.5, vmax=len(OUTCOMES) - 0.5, origin="lower",
        aspect="auto",
    )  # fmt: skip
    ax.set_xticks(range(len(steps)), _some(steps), fontsize=LETTER_SIZE)
    ax.set_yticks(range(len(stiff)), _some(stiff), fontsize=LETTER_SIZE)
    ax.tick_params(length=2)
    fraction = f"{completed(panel.runs):.0f} %"
    ax.text(0.03, 0.96, fraction, transform=ax.transAxes, fontsize=LETTER_SIZE, va="top")


def _some(values: Sequence[float]) -> list[str]:
    """Label a few of the values, the first among them."""
    every = -(-len(values) // 3)
    return ["" if k % every else _short(value) for k, value in enumerate(values)]


def _short(value: float) -> str:
    """Write one digit and an exponent without a redundant sign or zero: 1e6, 1e-4."""
    digit, exponent = f"{value:.0e}".split("e")
    return f"{digit}e{int(exponent)}"


def _mark(ax: Axes, x: int, y: int, runs: Sequence[Run], alone: bool) -> None:
    """Mark the number of failures, an undetected gain of energy, or a large loss."""
    dead = sum(not run.is_complete for run in runs)
    if dead and len(runs) > 1:
        dark = max(OUTCOMES.index(run.outcome) for run in runs) == len(OUTCOMES) - 1
        ax.text(x, y, str(dead), fontsize=LETTER_SIZE, ha="center", va="center_baseline",
                color="white" if dark else "black")  # fmt: skip
    elif any(run.is_complete and run.gain > MAX_GAIN for run in runs):
        ax.plot(x, y, "x", color="black", markersize=4)
    elif alone and runs[0].is_complete and runs[0].loss > MARKED_LOSS:
        ax.plot(x, y, "_", color="black", markersize=5)


def _frame(ax: Axes, x: int, y: int, runs: Sequence[Run], newton: Run | None) -> None:
    """Frame a cell in which some run does not end as Newton's."""
    if newton is None or all(run.is_complete == newton.is_complete for run in runs):
        return
    ax.add_patch(
        Rectangle((x - 0.5, y - 0.5), 1.0, 1.0, fill=False, edgecolor="black", linewidth=1.5,
                  linestyle="-" if newton.is_complete else ":", zorder=3)
    )  # fmt: skip


def heading(result: Stability) -> str:
    """Count the outcomes."""
    counts = [f"{sum(r.outcome == kind for r in result.runs)} {kind}" for kind in OUTCOMES]
    return f"{len(result.runs)} runs: {', '.join(counts)}"


STUDY = Study(
    "stability",
    run=stability_map,
    heading=heading,
    tables=lambda result: [integrator_table(result), solver_table(result)],
    rows=lambda result: [run.record() for run in result.runs],
    findings=findings,
    charts={"stability": integrator_chart, "stability-solvers": solver_chart},
    regions={
        "stability": integrator_table,
        "stability-solvers": lambda result: "\n".join(solver_table(result).markdown()),
    },
)
