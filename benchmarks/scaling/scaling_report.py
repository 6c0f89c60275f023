"""Tables and chart of the scaling study."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ancfsparse.dispatch import instruction_set
from benchmarks.common.charts import (
    LETTER_SIZE,
    draw_lines,
    new_figure,
    panels,
    set_axes,
    set_empty,
    set_legend,
)
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.other_codes.exudyn_scene import SETTINGS as OTHERS
from benchmarks.scaling.rows import TITLES, Row, Scaling, ratios
from benchmarks.scaling.scaling import scaling
from benchmarks.scaling.scaling_findings import findings, name_of, size_of, targets
from benchmarks.scaling.scaling_job import SOLVERS

COLOURS = dict(
    zip(
        [*SOLVERS, *(other.name for other in OTHERS)],
        ["#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#999999"],
        strict=True,
    )
)
"""One colour per solver, distinguished by colour-blind eyes too."""

STYLES = {
    scene: {"linestyle": line, "marker": marker, "markersize": 5}
    for scene, line, marker in zip(TITLES, ("-", "--", ":"), "os^", strict=True)
}
"""One line and marker per scene."""

PARTS = {
    "force": "#56b4e9", "tangent": "#0072b2", "factor": "#d55e00", "solve": "#e69f00",
    "rest": "#bbbbbb",
}  # fmt: skip
"""Parts of the time loop with their colours, from the bottom up."""


def _elements(row: Row) -> float:
    return float(row.job.elements)


def chart(result: Scaling) -> Figure:
    """Draw cost per element and step for each scene, memory, time by part, and counts."""
    figure = new_figure(10.5, "Cost, memory and counts against the number of elements")
    *costs, memory, split, counted = panels(figure, 6, 2)
    keys: dict[str, Any] = {}
    for ax, scene in zip(costs, TITLES, strict=True):
        keys |= _draw_costs(ax, result, scene)
    autos = [row for scene in TITLES for row in result.done(scene, "auto")]
    known = [row for row in autos if row.bytes_per_element > 0]
    if known:
        draw_lines(
            memory, known, lambda row: row.scene, _elements, lambda row: row.bytes_per_element,
            lambda scene: {"label": TITLES[scene], "color": "black", **STYLES[scene]},
        )  # fmt: skip
        title = "Memory of auto above an idle process"
        set_axes(memory, "elements", "bytes per element", title=title)
        memory.legend(fontsize=LETTER_SIZE)
    else:
        set_empty(memory, "memory of auto: above that of an idle process at no size")
    _draw_parts(split, [row for row in autos if len(row.record.get("split", {})) > 1])
    if autos:
        for value, colour in ((_corrections, "black"), (_factorizations, "#d55e00")):
            draw_lines(
                counted, autos, lambda row: row.scene, _elements, value,
                lambda scene, colour=colour: {"color": colour, **STYLES[scene]},  # type: ignore[misc]
            )  # fmt: skip
        label = "per step; black: corrections,\norange: factorisations"
        set_axes(counted, "elements", label, title="Corrections and factorisations of auto")
    else:
        set_empty(counted, "corrections and factorisations of auto: no result")
    set_legend(figure, keys, 4, "crosses: no result at that size, for reasons given in the table")
    return figure


def _corrections(row: Row) -> float:
    return float(row.record["iterations_per_step"])


def _factorizations(row: Row) -> float:
    return float(row.record["factorizations"] / row.job.steps)


def _draw_costs(ax: Axes, result: Scaling, scene: tuple[str, str]) -> dict[str, Any]:
    """Draw the cost of all solvers on a scene, and crosses at sizes without result."""
    own = [row for row in result.rows if row.scene == scene]
    if all(row.note for row in own):
        set_empty(ax, f"{TITLES[scene].capitalize()}: {'no result' if own else 'not run'}")
        return {}
    done = [row for solver in COLOURS for row in result.done(scene, solver)]
    keys = draw_lines(
        ax, done, lambda row: row.job.solver, _elements, lambda row: row.microseconds, _style_of
    )
    for k, (solver, colour) in enumerate(COLOURS.items()):
        missing = [row.job.elements for row in own if row.job.solver == solver and row.note]
        ax.plot(missing, [0.97 - 0.035 * k] * len(missing), "x", color=colour, markersize=5,
                transform=ax.get_xaxis_transform())  # fmt: skip
    set_axes(ax, "elements", "us per element and step", title=TITLES[scene].capitalize())
    low, high = ax.get_ylim()
    ax.set_ylim(low, high * (high / low) ** 0.25)  # room for crosses above the curves
    return keys


def _style_of(solver: str) -> dict[str, Any]:
    """Return the style of a solver; the choice of auto is drawn on top of its line."""
    style = {"label": solver, "color": COLOURS[solver], "markerfacecolor": "none"}
    style["linestyle"] = "-" if solver in SOLVERS else "--"
    if solver == "auto":
        return style | {"marker": "o", "markersize": 9, "linewidth": 2.4, "zorder": 1}
    return style | {"markersize": 6, "linewidth": 1.4, "zorder": 2}


def _draw_parts(ax: Axes, rows: list[Row]) -> None:
    """Stack the parts of the time of auto, a bar for each scene and size."""
    floor = np.zeros(len(rows))
    for part, colour in PARTS.items():
        height = np.array([100.0 * _fraction(row.record["split"], part) for row in rows])
        ax.bar(range(len(rows)), height, 0.8, bottom=floor, color=colour, label=part)
        floor += height
    names = [f"{TITLES[row.scene].split()[0]} {_short(row)}, {row.job.motion}" for row in rows]
    ax.set_xticks(range(len(rows)), names, rotation=60, ha="right", rotation_mode="anchor",
                  fontsize=LETTER_SIZE)  # fmt: skip
    ax.set_ylim(0.0, 118.0)
    ax.set_yticks(range(0, 101, 20))
    ax.set_ylabel("share of the time loop [%]")
    ax.legend(
        fontsize=LETTER_SIZE, ncols=5, loc="upper center", columnspacing=0.8, handlelength=0.9
    )
    ax.set_title("Time of auto by part", fontsize=LETTER_SIZE)


def _fraction(split: dict[str, float], part: str) -> float:
    return float(split.get(part, 0.0) / sum(split.values()))


def _short(row: Row) -> str:
    return f"{row.job.size:.0e}".replace("e+0", "e") if row.job.case == "chain" else size_of(row)


def heading(result: Scaling) -> str:
    """State the quantity, the steps and the rounds."""
    settings = result.settings
    return (
        f"Cost per element and step, dt = {settings['dt_s']:g} s, {settings['steps']} steps, "
        f"{instruction_set()}, the fastest of {settings['rounds']} rounds in turn, and of "
        "more where runs are short"
    )


def tables(result: Scaling) -> list[Table]:
    """Set the solvers of each scene and size, then powers and growth."""
    fits = {
        "Powers of the number of elements, from 500 on": result.slopes(),
        "Cost per element and step of auto on chains falling from rest": result.growth(),
    }
    return [
        *(_solvers(result, group) for group in result.by_size()),
        *(
            Table(["", ""], [[key, f"{value:.2f}"] for key, value in values.items()], (0,), title)
            for title, values in fits.items() if values
        ),
    ]  # fmt: skip


SOLVER_COLUMNS: dict[str, Callable[[Row], str]] = {
    "": lambda row: row.job.solver,
    "us": lambda row: f"{row.microseconds:.3f}",
    "it./step": lambda row: f"{row.record['iterations_per_step']:.2f}",
    "factors": lambda row: f"{row.record['factorizations']}",
    "set-up s": lambda row: f"{row.record['set_up_seconds']:.2f}",
    "peak MB": lambda row: f"{row.record['peak_bytes'] / 1e6:.0f}",
    "bytes/el.": lambda row: f"{row.bytes_per_element:.0f}",
    "us by part": lambda row: ", ".join(f"{k} {v:.3f}" for k, v in row.split.items()),
}


def _solvers(result: Scaling, group: list[Row]) -> Table:
    """Set the solvers of a scene and size, and how they compare."""
    job, title = group[0].job, TITLES[group[0].scene]
    count = next(c for c in result.counts if (c["scene"], c["size"]) == (title, job.size))
    above = (
        f"{title}, {job.size}: {job.elements} elements, {count['unknowns']} unknowns, "
        f"{count['factor_entries']} entries in L ({count['ordering']})"
    )
    compared = [f"{k} {v:.2f}" for k, v in ratios(group).items() if isinstance(v, float)]
    lines = [
        [row.job.solver, *[""] * (len(SOLVER_COLUMNS) - 2), row.note]
        if row.note
        else [cell(row) for cell in SOLVER_COLUMNS.values()]
        for row in group
    ]
    return Table(list(SOLVER_COLUMNS), lines, (0, 7), "\n".join([above, *compared]))


Compared = tuple[Row, dict[str, Any]]
AUTO_COLUMNS: dict[str, Callable[[Compared], str]] = {
    "us per element and step": lambda each: f"{each[0].microseconds:.3g}",
    "corrections per step": lambda each: f"{_corrections(each[0]):.2f}",
    "factorisations": lambda each: (
        f"{each[0].record['factorizations']} in {each[0].job.steps} steps"
    ),
    "MB at the peak": lambda each: f"{each[0].record['peak_bytes'] / 1e6:.0f}",
    "over best fixed solver": lambda each: (
        f"{each[1]['auto / best fixed']:.2f}" if "auto / best fixed" in each[1] else ""
    ),
    "Newton takes": lambda each: _times(each[1].get("Newton / auto")),
    "fastest other code takes": lambda each: _times(
        min((each[1][k] for p in OTHERS if (k := f"{p.name} / auto") in each[1]), default=None)
    ),
}


def of_auto(result: Scaling) -> Table:
    """Set cost and ratios of auto, scene by scene and size by size."""
    rows = []
    for group in result.by_size():
        auto = next((row for row in group if row.job.solver == "auto"), group[0])
        compared = auto, ratios(group)
        cells = [cell(compared) for cell in AUTO_COLUMNS.values() if not auto.note]
        cells = cells or [auto.note, *[""] * (len(AUTO_COLUMNS) - 1)]
        rows.append([name_of(auto), f"{auto.job.elements:,}", *cells])
    return Table(["with `auto`", "elements", *AUTO_COLUMNS], rows)


def _times(ratio: float | None) -> str:
    return "" if ratio is None else f"{ratio:.1f} times as long"


STUDY = Study(
    "scaling",
    run=scaling,
    heading=heading,
    tables=tables,
    rows=lambda result: [row.flat() for row in result.rows],
    findings=findings,
    targets=targets,
    notes=lambda result: [str(result.roofline)],
    charts={"scaling": chart},
    regions={"scaling": of_auto},
)
