"""Mechanisms beside Exudyn as text, CSV, JSON and a chart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict

from matplotlib.figure import Figure

from benchmarks.common.charts import new_figure, set_axes, set_legend
from benchmarks.common.study import Study
from benchmarks.common.tables import Table, bullets
from benchmarks.common.timing import OURS
from benchmarks.mechanisms.run import WANTED, Comparison, Row, mechanisms

COLUMNS: dict[str, Callable[[tuple[Row, Row]], str]] = {
    "mechanism": lambda pair: pair[0].scene,
    "step [s]": lambda pair: f"{pair[0].dt:.2g}",
    "error [m]": lambda pair: ", ".join(f"{each.error:.1e}" for each in pair),
    "ours [ms]": lambda pair: f"{1e3 * pair[0].seconds:.1f}",
    "Exudyn [ms]": lambda pair: f"{1e3 * pair[1].seconds:.0f}",
    "how": lambda pair: pair[1].newton,
    "ratio": lambda pair: f"{pair[1].seconds / pair[0].seconds:.1f}",
}
"""Of our row and the fastest of Exudyn's."""


def comparison(found: Comparison) -> Table:
    """Set a line for each mechanism and step."""
    return Table.of(found.pairs(), COLUMNS, left=(0, 5))


def as_markdown(found: Comparison) -> str:
    """Set the table for a page."""
    lines = [*comparison(found).markdown(), "", *bullets([*found.findings(), _reached(found)])]
    return "\n".join(lines)


def _reached(found: Comparison) -> str:
    """State how many mechanisms reach the target, and the least ratio of each of the others."""
    targets = found.targets()
    missed = [f"{each.what.split(': ')[1]} {each.value:.1f}" for each in targets if not each.met]
    reached = len(targets) - len(missed)
    text = f"The target, {WANTED:g} times at every step, is reached by {reached} of {len(targets)}"
    return text + (f" and missed by {', '.join(missed)}." if missed else ".")


def chart(found: Comparison) -> Figure:
    """Draw the error against the time, a panel for each mechanism."""
    scenes = list(dict.fromkeys(row.scene for row in found.rows))
    columns = min(3, len(scenes))
    lines = -(-len(scenes) // columns)
    figure = new_figure(1.2 + 2.6 * lines, "Error of the steps against time")
    panels = figure.subplots(lines, columns, squeeze=False).ravel()
    shown = {}
    ways = dict.fromkeys((row.program, row.newton) for row in found.rows)
    colours = ("#0072b2", "#e69f00", "#d55e00", "#b15928", "#cc79a7", "#999999", "#666666")
    for ax, scene in zip(panels, scenes, strict=False):
        for way, colour in zip(ways, colours, strict=False):
            rows = [r for r in found.rows if (r.scene, r.program, r.newton) == (scene, *way)]
            x, y = [1e3 * r.seconds for r in rows], [r.error for r in rows]
            style = "o-" if way[0] == OURS else "s--"
            (line,) = ax.plot(x, y, style, color=colour, markersize=4, linewidth=1.2)
            shown[OURS if way[0] == OURS else f"Exudyn, {way[1]}"] = line
        title = scene.replace("_", " ")
        set_axes(ax, "processor time of the solver [ms]", "error [m]", title=title)
    for ax in panels[len(scenes) :]:
        ax.set_axis_off()
    set_legend(figure, shown, 2)
    return figure


STUDY = Study(
    "mechanisms",
    run=mechanisms,
    tables=lambda found: [comparison(found)],
    rows=lambda found: [asdict(row) for row in found.rows],
    findings=Comparison.findings,
    targets=Comparison.targets,
    charts={"mechanisms": chart},
    regions={"mechanisms": as_markdown},
)
