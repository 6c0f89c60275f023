"""The work-precision study as text, CSV, JSON and a chart."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ancfsparse.studies.common.charts import (
    WIDTH,
    failures,
    mark_failures,
    set_head,
    set_legend,
    set_title,
    write_notes,
)
from ancfsparse.studies.common.entrants import INTEGRATORS
from ancfsparse.studies.common.race import OURS, Point, fastest
from ancfsparse.studies.common.study import Study
from ancfsparse.studies.common.tables import table, with_findings
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


def as_text(result: WorkPrecision) -> str:
    """Set the tables for a terminal: each model's fastest runs by error, failures, targets."""
    settings = result.settings
    lines = [
        f"Seconds against error in time, {settings['elements']} elements, "
        f"{settings['t_end_s']:g} s, {settings['instruction_set']}; {settings['seconds']}",
        f"error: {settings['error']}",
    ]
    for model, reference in result.references.items():
        lines += [
            "",
            f"{model}: the reference is known to {reference.uncertainty:.1e} m",
            f"  {'error [m]':>10}  {'our fastest':<40}{'ms':>8}{'residuals':>11}"
            + "".join(f"{name + ' / ours':>18}" for name in result.programs(model)),
        ]
        lines += [_line(result, model, level) for level in LEVELS]
    lines += ["", "Powers of the step with which the errors of ours fall"]
    lines += [f"  {name:<52}{order:>6.2f}" for name, order in result.orders().items()]
    failed = failures(result.points)
    lines += ["", "Without result", *(f"  {each}" for each in failed)] if failed else []
    return "\n".join([*lines, "", *map(str, result.targets()), *result.missing])


def _line(result: WorkPrecision, model: str, level: float) -> str:
    best = fastest(result.of(model, OURS), level)
    ours = f"  {level:>10.0e}  "
    if best is None:
        ours += f"{'none':<40}{'':>8}{'':>11}"
    else:
        what = f"{best.task.name}, {best.task.knob} = {best.task.value:g}"
        ours += f"{what:<40}{1e3 * best.seconds:>8.1f}{best.counts['residuals']:>11}"
    ratios = [result.ratio(model, name, level) for name in result.programs(model)]
    return ours + "".join(f"{_ratio(each):>18}" for each in ratios)


def _ratio(value: float) -> str:
    if math.isnan(value):
        return "neither"
    if value == 0.0:
        return "only they"
    return "only we" if math.isinf(value) else f"{value:.1f}"


def as_markdown(result: WorkPrecision) -> str:
    """Set the table of the fastest runs on Exudyn's discretisation for a page."""
    model = next(iter(result.references))
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
    return with_findings(table(head, rows, left=(1,)), findings(result))


def _times(value: float) -> str:
    return f"{value:.1f} times as long" if math.isfinite(value) and value > 0.0 else _ratio(value)


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
    ax.set_xscale("log")
    ax.set_yscale("log")
    blind = ax.axvspan(*_blind(result, model), color="#dddddd", zorder=0)
    shown.setdefault("below what the reference knows", blind)
    ax.set_xlabel("tip error in time [m]")
    ax.set_ylabel(unit)
    ax.grid(alpha=0.3, which="major")
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
    text=as_text,
    rows=lambda result: [p.record() for p in result.points],
    record=WorkPrecision.record,
    findings=findings,
    targets=WorkPrecision.targets,
    charts={"work-precision": chart},
    regions={"work-precision": as_markdown},
)
