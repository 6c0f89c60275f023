"""The work-precision study as text, CSV, JSON and a chart."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ancfsparse.studies.common.charts import (
    WIDTH,
    mark_failures,
    set_axes,
    set_head,
    set_legend,
    set_title,
    write_notes,
)
from ancfsparse.studies.common.entrants import INTEGRATORS
from ancfsparse.studies.common.race import OURS, Point, fastest
from ancfsparse.studies.common.study import Study
from ancfsparse.studies.common.tables import Table
from ancfsparse.studies.work_precision.findings import (
    count_title,
    evaluations,
    findings,
    headline,
    title,
)
from ancfsparse.studies.work_precision.run import LEVELS, WorkPrecision, work_precision

COLOURS = {
    "Exudyn": ("#d55e00", "#e69f00", "#8c3b00", "#b8860b", "#ff9955"),
    "SciPy": ("#009e73", "#7fcdb5"),
    "SUNDIALS": ("#cc79a7", "#7b3f66", "#e6b3d0", "#a0407c"),
}
"""Shades of one colour per peer, one for each of its methods."""

STYLES = {OURS: "-o", "Exudyn": "--s", "SciPy": ":^", "SUNDIALS": "-.v"}
"""One style of line and marker per program."""

Size = Callable[[Point], float]


def heading(result: WorkPrecision) -> str:
    """State what is measured, and how well the references are known."""
    settings = result.settings
    known = [f"{model} to {each.uncertainty:.1e} m" for model, each in result.references.items()]
    return (
        f"Seconds against error in time, {settings['elements']} elements, "
        f"{settings['t_end_s']:g} s, {settings['instruction_set']}; {settings['seconds']}\n"
        f"error: {settings['error']}\nreferences are known: {', '.join(known)}"
    )


def tables(result: WorkPrecision) -> list[Table]:
    """Set the fastest runs of each model, and the orders of the curves."""
    orders = [[name, f"{order:.2f}"] for name, order in result.orders().items()]
    title = "Powers of the step with which the errors of ours fall"
    return [
        *(fastest_runs(result, m) for m in result.references),
        Table(["", ""], orders, (0,), title),
    ]


def fastest_runs(result: WorkPrecision, model: str = "") -> Table:
    """Set our fastest run at each error, and how long each peer takes.

    Of the first model by default, which has Exudyn's discretisation.
    """
    model = model or next(iter(result.references))
    names = result.programs(model)
    rows = []
    for level in LEVELS:
        best = fastest(result.of(model, OURS), level)
        ours = ["none", ""]
        if best is not None:
            ours = [f"{best.task.name}, {best.task.value:g} s", f"{1e3 * best.seconds:.1f}"]
        theirs = [_times(result.ratio(model, name, level)) for name in names]
        rows.append([f"{level:.0e}", *ours, *theirs])
    head = ["error at most [m]", "our fastest", "ms", *(f"{name} takes" for name in names)]
    return Table(head, rows, left=(1,), title=model)


def _times(ratio: float) -> str:
    if math.isnan(ratio):
        return "neither"
    if ratio == 0.0:
        return "only they"
    return "only we" if math.isinf(ratio) else f"{ratio:.1f} times as long"


def chart(result: WorkPrecision) -> Figure:
    """Draw seconds against error for each model, and residuals against error for the first."""
    models = list(result.references)
    figure = Figure(figsize=(WIDTH, 1.6 + 3.9 * -(-(len(models) + 1) // 2)), layout="constrained")
    panels = figure.subplots(-(-(len(models) + 1) // 2), 2, squeeze=False).ravel()
    shown: dict[str, Any] = {}
    notes: list[str] = []
    first = models[0]
    _panel(panels[0], result, first, lambda p: p.seconds, "seconds", shown, notes)
    set_title(panels[0], title(result, first))
    _panel(panels[1], result, first, evaluations, "residuals or right-hand sides", shown, None)
    set_title(panels[1], count_title(result, first))
    for ax, model in zip(panels[2:], models[1:], strict=False):
        _panel(ax, result, model, lambda p: p.seconds, "seconds", shown, notes)
        set_title(ax, title(result, model))
    for ax in panels[len(models) + 1 :]:
        ax.remove()
    set_head(figure, headline(result))
    set_legend(figure, shown, 4, "lines: best solver at each step; small dots: other solvers")
    write_notes(figure, notes)
    return figure


def _panel(
    ax: Axes,
    result: WorkPrecision,
    model: str,
    size: Size,
    unit: str,
    shown: dict[str, Any],
    notes: list[str] | None,
) -> None:
    """Draw a line through the best solver at each step, and the other solvers as dots."""
    for (program, method), points in _curves(result.of(model)).items():
        colour, style = _looks(result, program, method)
        good = [p for p in points if p.finished and not math.isnan(size(p))]
        best: dict[float, Point] = {}
        for p in good:
            if p.task.value not in best or size(p) < size(best[p.task.value]):
                best[p.task.value] = p
        if not best:
            continue
        label = method if program == OURS else f"{program}, {method}"
        (shown[label],) = ax.plot(
            [p.error for p in best.values()], [size(p) for p in best.values()], style,
            color=colour, markersize=5, linewidth=2.2 if program == OURS else 1.3,
        )  # fmt: skip
        ax.plot([p.error for p in good], [size(p) for p in good], ".", color=colour,
                markersize=3, alpha=0.5)  # fmt: skip
    set_axes(ax, "tip error in time [m]", unit)
    blind = ax.axvspan(*_blind(result, model), color="#dddddd", zorder=0)
    shown.setdefault("below the uncertainty of the reference", blind)
    if notes is not None:
        colours = {p.task: _looks(result, p.task.program, p.task.method)[0] for p in result.points}
        mark_failures(ax, result.of(model), lambda p: colours[p.task], notes)


def _blind(result: WorkPrecision, model: str) -> tuple[float, float]:
    """Return the errors that are smaller than the uncertainty of the reference."""
    known = result.references[model].uncertainty
    least = min((p.error for p in result.of(model) if p.finished), default=known)
    return 0.5 * min(least, known), known


def _curves(points: Sequence[Point]) -> dict[tuple[str, str], list[Point]]:
    curves: dict[tuple[str, str], list[Point]] = {}
    for p in points:
        curves.setdefault((p.task.program, p.task.method), []).append(p)
    return curves


def _looks(result: WorkPrecision, program: str, method: str) -> tuple[str, str]:
    """Return colour and style of a curve."""
    if program == OURS:
        return {i.name: i.colour for i in INTEGRATORS}.get(method, "#0072b2"), STYLES[OURS]
    methods = dict.fromkeys(p.task.method for p in result.points if p.task.program == program)
    shades = COLOURS[program]
    return shades[list(methods).index(method) % len(shades)], STYLES[program]


STUDY = Study(
    "work-precision",
    run=work_precision,
    heading=heading,
    tables=tables,
    rows=lambda result: [p.record() for p in result.points],
    record=WorkPrecision.record,
    findings=findings,
    targets=WorkPrecision.targets,
    notes=WorkPrecision.notes,
    charts={"work-precision": chart},
    regions={"work-precision": fastest_runs},
)
