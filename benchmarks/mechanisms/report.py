"""Table, chart and findings of mechanisms by both programs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from matplotlib.figure import Figure

from benchmarks.common.charts import draw_lines, new_figure, panels, set_axes, set_legend
from benchmarks.common.study import Study
from benchmarks.common.tables import Table, bullets
from benchmarks.common.timing import OURS
from benchmarks.mechanisms.run import MIN_RATIO, Comparison, Row, mechanisms

COLUMNS: dict[str, Callable[[tuple[Row, Row]], str]] = {
    "mechanism": lambda pair: pair[0].scene,
    "step [s]": lambda pair: f"{pair[0].dt:.2g}",
    "error [m]": lambda pair: ", ".join(f"{each.error:.1e}" for each in pair),
    "ours [ms]": lambda pair: f"{1e3 * pair[0].seconds:.1f}",
    "Exudyn [ms]": lambda pair: f"{1e3 * pair[1].seconds:.0f}",
    "how": lambda pair: pair[1].newton,
    "ratio": lambda pair: f"{pair[1].seconds / pair[0].seconds:.1f}",
}
"""Columns of our row and the fastest of Exudyn's."""


def comparison(found: Comparison) -> Table:
    """Set a line for each mechanism and step."""
    return Table.of(found.pairs(), COLUMNS, left=(0, 5))


def as_markdown(found: Comparison) -> str:
    """Set the table for a page."""
    lines = [*comparison(found).markdown(), "", *bullets([*found.findings(), _reached(found)])]
    return "\n".join(lines)


def _reached(found: Comparison) -> str:
    """State the number of mechanisms that reach the target, and the least ratio of the others."""
    targets = found.targets()
    missed = [f"{each.what.split(': ')[1]} {each.value:.1f}" for each in targets if not each.is_met]
    reached = len(targets) - len(missed)
    text = (
        f"The target, {MIN_RATIO:g} times at every step, is reached by {reached} of {len(targets)}"
    )
    return text + (f" and missed by {', '.join(missed)}." if missed else ".")


COLOURS = ("#0072b2", "#e69f00", "#d55e00", "#b15928", "#cc79a7", "#999999", "#666666")


def chart(found: Comparison) -> Figure:
    """Draw the error against the time, a panel for each mechanism."""
    scenes = list(dict.fromkeys(row.scene for row in found.rows))
    figure = new_figure(1.2 + 2.6 * -(-len(scenes) // 3), "Error of the steps against time")
    settings = dict.fromkeys((row.program, row.newton) for row in found.rows)
    colours = dict(zip(settings, COLOURS, strict=False))

    def look(key: tuple[str, str]) -> dict[str, Any]:
        shape = {"color": colours[key], "markersize": 4, "linewidth": 1.2}
        if key[0] == OURS:
            return {"label": OURS, "marker": "o", **shape}
        return {"label": f"Exudyn, {key[1]}", "marker": "s", "linestyle": "--", **shape}

    shown: dict[str, Any] = {}
    for ax, scene in zip(panels(figure, len(scenes), 3), scenes, strict=True):
        rows = [row for row in found.rows if row.scene == scene]
        shown |= draw_lines(
            ax, rows, lambda row: (row.program, row.newton), lambda row: 1e3 * row.seconds,
            lambda row: row.error, look,
        )  # fmt: skip
        title = scene.replace("_", " ")
        set_axes(ax, "processor time of the solver [ms]", "error [m]", title=title)
    set_legend(figure, shown, 2)
    return figure


STUDY = Study(
    "mechanisms",
    run=mechanisms,
    tables=lambda found: [comparison(found)],
    rows=lambda found: found.rows,
    findings=Comparison.findings,
    targets=Comparison.targets,
    charts={"mechanisms": chart},
    regions={"mechanisms": as_markdown},
)
