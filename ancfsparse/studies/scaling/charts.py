"""The chart of the scaling study: cost, memory, time by part and counts against size."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ancfsparse.studies.common.charts import (
    SMALL,
    WIDTH,
    set_axes,
    set_empty,
    set_head,
    set_legend,
    set_title,
)
from ancfsparse.studies.peers.exudyn_scene import SETTINGS as PEERS
from ancfsparse.studies.scaling.findings import (
    cost_title,
    count_title,
    headline,
    memory_title,
    shares_of,
    size_of,
    split_title,
)
from ancfsparse.studies.scaling.rows import TITLES, Row, Scaling
from ancfsparse.studies.scaling.worker import SOLVERS

COLOURS = dict(
    zip(
        [*SOLVERS, *(peer.name for peer in PEERS)],
        ["#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#999999"],
        strict=True,
    )
)
"""One colour per solver, distinguished by colour-blind eyes too."""

STYLES = dict(zip(TITLES, ("o-", "s--", "^:"), strict=True))
"""One line and marker per scene."""

PARTS = {
    "force": "#56b4e9", "tangent": "#0072b2", "factor": "#d55e00", "solve": "#e69f00",
    "rest": "#bbbbbb",
}  # fmt: skip
"""Parts of a march, from the bottom up."""


def chart(result: Scaling) -> Figure:
    """Draw cost per element and step for each scene, memory, time by part, and counts."""
    figure = Figure(figsize=(WIDTH, 10.5), layout="constrained")
    costs = figure.subplots(3, 2).ravel()
    memory, split, counted = costs[3:]
    shown: dict[str, Any] = {}
    for ax, scene in zip(costs, TITLES, strict=False):
        _costs(ax, result, scene, shown)
    autos = [row for scene in TITLES for row in result.done(scene, "auto")]
    known = [row for row in autos if row.bytes_per_element > 0]
    for scene, style in STYLES.items() if known else ():
        rows = [row for row in known if row.scene == scene]
        x, y = [r.job.elements for r in rows], [r.bytes_per_element for r in rows]
        memory.plot(x, y, style, color="black", markersize=5, label=TITLES[scene])
    if known:
        set_axes(memory, "elements", "bytes per element")
        memory.legend(fontsize=SMALL)
        set_title(memory, memory_title(result))
    else:
        set_empty(memory, "memory of auto: above that of an idle process at no size")
    _parts(split, [row for row in autos if len(row.record.get("split", {})) > 1])
    if autos:
        _counts(counted, result)
        set_title(counted, count_title(autos))
    else:
        set_empty(counted, "corrections and factorisations of auto: no result")
    set_legend(figure, shown, 4, "crosses: no result at that size, for reasons given in the table")
    set_head(figure, headline(result))
    return figure


def _costs(ax: Axes, result: Scaling, scene: tuple[str, str], shown: dict[str, Any]) -> None:
    if all(row.note for row in result.rows if row.scene == scene):
        ran = any(row.scene == scene for row in result.rows)
        set_empty(ax, f"{TITLES[scene].capitalize()}: {'no result' if ran else 'not run'}")
        return
    top = ax.get_xaxis_transform()
    for k, (solver, colour) in enumerate(COLOURS.items()):
        rows = result.done(scene, solver)
        if rows:
            x, y = [r.job.elements for r in rows], [r.microseconds for r in rows]
            shown[solver] = _curve(ax, x, y, solver, colour)
        here = [r for r in result.rows if (r.scene, r.job.solver) == (scene, solver)]
        missing = [r.job.elements for r in here if r.note]
        ax.plot(missing, [0.97 - 0.035 * k] * len(missing), "x", color=colour, markersize=5,
                transform=top)  # fmt: skip
    set_axes(ax, "elements", "us per element and step")
    low, high = ax.get_ylim()
    ax.set_ylim(low, high * (high / low) ** 0.25)  # room for crosses above the curves
    set_title(ax, cost_title(result, scene))


def _curve(ax: Axes, x: list[int], y: list[float], solver: str, colour: str) -> Any:
    auto = solver == "auto"
    (line,) = ax.plot(
        x, y, "--" if solver not in SOLVERS else "-", color=colour, marker="o" if auto else ".",
        markerfacecolor="none", markersize=9 if auto else 6, linewidth=2.4 if auto else 1.4,
        zorder=1 if auto else 2,  # what auto chose is drawn on top of it
    )  # fmt: skip
    return line


def _parts(ax: Axes, rows: list[Row]) -> None:
    """Stack the parts of the march of auto, a bar for each scene and size."""
    floor = np.zeros(len(rows))
    for part, colour in PARTS.items():
        height = np.array([shares_of(row).get(part, 0.0) for row in rows])
        ax.bar(range(len(rows)), height, 0.8, bottom=floor, color=colour, label=part)
        floor += height
    names = [f"{TITLES[row.scene].split()[0]} {_short(row)}, {row.job.motion}" for row in rows]
    ax.set_xticks(range(len(rows)), names, rotation=60, ha="right", rotation_mode="anchor",
                  fontsize=SMALL)  # fmt: skip
    ax.set_ylim(0.0, 118.0)
    ax.set_yticks(range(0, 101, 20))
    ax.set_ylabel("share of the march [%]")
    ax.legend(fontsize=SMALL, ncols=5, loc="upper center", columnspacing=0.8, handlelength=0.9)
    set_title(ax, split_title(rows))


def _short(row: Row) -> str:
    return f"{row.job.size:.0e}".replace("e+0", "e") if row.job.case == "chain" else size_of(row)


def _counts(ax: Axes, result: Scaling) -> None:
    """Draw corrections and factorisations per step of auto."""
    for scene, style in STYLES.items():
        rows = result.done(scene, "auto")
        x = [row.job.elements for row in rows]
        corrections = [row.record["iterations_per_step"] for row in rows]
        factors = [row.record["factorizations"] / row.job.steps for row in rows]
        ax.plot(x, corrections, style, color="black", markersize=5)
        ax.plot(x, factors, style, color="#d55e00", markersize=5)
    set_axes(ax, "elements", "per step; black: corrections,\norange: factorisations")
