"""Charts of the maps of outcomes, and their studies."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from benchmarks.common.charts import LETTER_SIZE, new_figure
from benchmarks.common.study import Study
from benchmarks.stability import beam_map, contact_map
from benchmarks.stability.cells import FAILED, GAINED, OUTCOMES, Run
from benchmarks.stability.findings import completed, integrator_table, solver_table
from benchmarks.stability.map_spec import MapSpec
from benchmarks.stability.stability_map import MAX_GAIN, Stability, map_command

COLOURS = ("#bfe3d0", "#56b4e9", "#e69f00", "#8c1d04")
"""One for each of `OUTCOMES`."""

MARKED_LOSS = 0.1  # energy lost by a marked run, relative to the energy of its measure

OUTCOME_KEYS = [Patch(color=c, label=kind) for c, kind in zip(COLOURS, OUTCOMES, strict=True)]
HIDDEN_KEY = Line2D([], [], marker="x", color="black", linestyle="", label="gained, not stopped")
"""For legends."""
NUMBER_KEY = Line2D([], [], marker="$3$", color="black", linestyle="",
                    label="number of them that fail")  # fmt: skip


class Panel(NamedTuple):
    """Runs of a panel, of one or several solvers and scenes."""

    runs: list[Run]
    is_compared: bool  # with Newton's, to mark differences


def group_solvers(spec: MapSpec) -> dict[str, list[str]]:
    """Return the solvers that share a panel, by its title."""
    full = [name for name in spec.solvers if name.endswith("full")]
    others = [name for name in spec.solvers if name != "Newton" and name not in full]
    return {
        "Newton": ["Newton"],
        f"{len(others)} on kept seeds,\nworst": others,
        f"{len(full)} with full\nmatrix, worst": full,
    }


def integrator_chart(result: Stability) -> Figure:
    """Draw one panel for each group of scenes and integrator, with ``"auto"``."""
    integrators = result.integrators
    panels = [
        [Panel(result.of(scenes, integrator, "auto"), False) for integrator in integrators]
        for scenes in result.groups.values()
    ]
    titles = [re.sub("(?=Alpha|Momentum)", "-\n", name) for name in integrators]
    figure = _chart(result, panels, titles, "Outcome of runs by integrator")
    keys = [
        *OUTCOME_KEYS,
        HIDDEN_KEY,
        Line2D([], [], marker="_", color="black", linestyle="", label="lost a tenth or more"),
        *[NUMBER_KEY] * (len(result.groups) < len(result.scenes)),
    ]
    _legend(figure, keys)
    return figure


def solver_chart(result: Stability) -> Figure:
    """Draw for each group of scenes and integrator Newton, and the worst of the other solvers."""
    groups = group_solvers(result.spec)
    integrators = result.spec.for_all_solvers
    panels = [
        [
            Panel([run for name in solvers for run in result.of(scenes, integrator, name)], True)
            for integrator in integrators
            for solvers in groups.values()
        ]
        for scenes in result.groups.values()
    ]
    titles = [
        f"{integrator}\n\n{group}" if k == len(groups) // 2 else group
        for integrator in integrators
        for k, group in enumerate(groups)
    ]
    figure = _chart(result, panels, titles, "Outcome of runs by solver")
    keys = [
        *OUTCOME_KEYS,
        HIDDEN_KEY,
        NUMBER_KEY,
        Patch(fill=False, edgecolor="black", linewidth=1.5, label="Newton ends, not all of these"),
        Patch(fill=False, edgecolor="black", linestyle=":", linewidth=1.5,
              label="Newton fails, not all of these"),
    ]  # fmt: skip
    _legend(figure, keys)
    return figure


def _spot(run: Run) -> tuple[float, float]:
    return run.map_point.stiffness, run.map_point.dt


def _chart(
    result: Stability, panels: Sequence[Sequence[Panel]], columns: Sequence[str], title: str
) -> Figure:
    rows = list(result.groups)
    figure = new_figure(1.7 + 1.25 * len(rows), title)
    axes = figure.subplots(len(rows), len(columns), sharex=True, sharey=True, squeeze=False)
    for i, line in enumerate(panels):
        for j, panel in enumerate(line):
            _draw(axes[i, j], panel, result)
        axes[i, 0].set_ylabel(f"{rows[i]}\n[{result.spec.unit or '-'}]", fontsize=LETTER_SIZE)
    for j, name in enumerate(columns):
        axes[0, j].set_title(name, fontsize=LETTER_SIZE)
        axes[-1, j].set_xlabel("dt [s]", fontsize=LETTER_SIZE)
    return figure


def _legend(figure: Figure, keys: Sequence[Artist]) -> None:
    figure.legend(
        handles=list(keys), loc="outside lower center", ncols=4, fontsize=LETTER_SIZE, frameon=False
    )


def _draw(ax: Axes, panel: Panel, result: Stability) -> None:
    """Colour step against stiffness by the worst outcome; the corner has the share completed."""
    steps = sorted({run.map_point.dt for run in result.runs})
    stiff = sorted({run.map_point.stiffness for run in result.runs})
    cells = np.full((len(stiff), len(steps)), np.nan)
    for y, stiffness in enumerate(stiff):
        for x, dt in enumerate(steps):
            here = [run for run in panel.runs if _spot(run) == (stiffness, dt)]
            if here:
                cells[y, x] = max(OUTCOMES.index(run.outcome) for run in here)
                _mark(ax, x, y, here, alone=not panel.is_compared)
                if panel.is_compared:
                    _frame(ax, x, y, [(run, result.newton_at(run)) for run in here])
    ax.imshow(
        cells, cmap=ListedColormap(COLOURS), vmin=-0.5, vmax=len(OUTCOMES) - 0.5, origin="lower",
        aspect="auto",
    )  # fmt: skip
    ax.set_xticks(range(len(steps)), _some(steps), fontsize=LETTER_SIZE)
    ax.set_yticks(range(len(stiff)), _some(stiff), fontsize=LETTER_SIZE)
    ax.tick_params(length=2)
    fraction = f"{completed(panel.runs):.0f} %"
    ax.text(
        0.03, 0.96, fraction, transform=ax.transAxes, fontsize=LETTER_SIZE, va="top", zorder=4,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.5},
    )  # fmt: skip


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
    elif alone and all(run.is_complete and run.measures["loss"] > MARKED_LOSS for run in runs):
        ax.plot(x, y, "_", color="black", markersize=5)


def _frame(ax: Axes, x: int, y: int, pairs: Sequence[tuple[Run, Run | None]]) -> None:
    """Frame a cell in which some run does not end as Newton's."""
    other = [run for run, newton in pairs if newton and run.is_complete != newton.is_complete]
    if other:
        style = ":" if all(run.is_complete for run in other) else "-"
        ax.add_patch(
            Rectangle((x - 0.5, y - 0.5), 1.0, 1.0, fill=False, edgecolor="black", linewidth=1.5,
                      linestyle=style, zorder=3)
        )  # fmt: skip


def heading(result: Stability) -> str:
    """Count the outcomes."""
    counts = [f"{sum(r.outcome == kind for r in result.runs)} {kind}" for kind in OUTCOMES]
    return f"{len(result.runs)} runs: {', '.join(counts)}"


def record(result: Stability) -> dict[str, Any]:
    """Return runs and settings, and the commands of the runs that only Newton finishes."""
    worse = [*result.worse_than_newton(FAILED), *result.worse_than_newton(GAINED)]
    return {
        "runs": [run.record() for run in result.runs],
        "settings": result.settings,
        "only_newton_finishes": [result.spec.repeat(run.map_point) for run in worse],
    }


def map_study(
    name: str, spec: MapSpec, purpose: str, findings: Callable[[Stability], list[str]]
) -> Study[Stability]:
    """Return the study of a map, whose files begin with this name."""
    return Study(
        name,
        run=map_command(spec, purpose),
        heading=heading,
        tables=lambda result: [integrator_table(result), solver_table(result)],
        rows=lambda result: [run.record() for run in result.runs],
        record=record,
        findings=findings,
        charts={name: integrator_chart, f"{name}-solvers": solver_chart},
        regions={
            name: integrator_table,
            f"{name}-solvers": lambda result: "\n".join(solver_table(result).markdown()),
        },
    )


STUDY = map_study(
    "stability",
    beam_map.BEAMS,
    "Map the runs that complete, over step, stiffness, integrator and solver; minutes.",
    beam_map.findings,
)
CONTACT_STUDY = map_study(
    "stability-contact",
    contact_map.CONTACTS,
    "Map the runs with contact that complete, over step, stiffness of contact and friction.",
    contact_map.findings,
)
