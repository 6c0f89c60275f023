"""Tables, chart and findings of the work-precision study."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.accuracy.candidates import INTEGRATORS
from benchmarks.accuracy.failure_notes import mark_failures, write_notes
from benchmarks.accuracy.timed_runs import Point, fastest
from benchmarks.accuracy.work_precision import LEVELS, WorkPrecision, work_precision
from benchmarks.common.charts import new_figure, set_axes, set_legend
from benchmarks.common.study import Study
from benchmarks.common.tables import Table, group_by
from benchmarks.common.timing import OURS

COLOURS = {
    "Exudyn": ("#d55e00", "#e69f00", "#8c3b00", "#b8860b", "#ff9955"),
    "SciPy": ("#009e73", "#7fcdb5"),
    "SUNDIALS": ("#cc79a7", "#7b3f66", "#e6b3d0", "#a0407c"),
}
"""Shades of one colour for each other code, one for each of its methods."""

STYLES = {OURS: "-o", "Exudyn": "--s", "SciPy": ":^", "SUNDIALS": "-.v"}
"""One style of line and marker per program."""

Size = Callable[[Point], float]


def tables(result: WorkPrecision) -> list[Table]:
    """Set the fastest runs of each model, and the orders of the curves."""
    orders = [[name, f"{order:.2f}"] for name, order in result.orders().items()]
    title = "Observed orders of the integrators of ancfsparse"
    return [
        *(fastest_runs(result, m) for m in result.references),
        Table(["", ""], orders, (0,), title),
    ]


def fastest_runs(result: WorkPrecision, model: str = "") -> Table:
    """Set the fastest run at each error, and the times of the other codes.

    By default for the first model, which has Exudyn's discretisation.
    """
    model = model or next(iter(result.references))
    names = result.programs(model)
    rows = []
    for level in LEVELS:
        best = fastest(result.of(model, OURS), level)
        ours = ["none", ""]
        if best is not None:
            ours = [f"{best.task.name}, {best.task.value:g} s", f"{1e3 * best.seconds:.1f}"]
        others = [_times(result.ratio(model, name, level)) for name in names]
        rows.append([f"{level:.0e}", *ours, *others])
    head = [
        "error at most [m]",
        "fastest of ancfsparse",
        "ms",
        *(f"{name} takes" for name in names),
    ]
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
    lines = -(-(len(models) + 1) // 2)
    figure = new_figure(1.6 + 3.9 * lines, "Seconds against error in time")
    panels = figure.subplots(lines, 2, squeeze=False).ravel()
    keys: dict[str, Any] = {}
    notes: list[str] = []
    first = models[0]
    _panel(panels[0], result, first, lambda p: p.seconds, "seconds", keys, notes)
    _panel(panels[1], result, first, evaluations, "residuals or right-hand sides", keys, None)
    for ax, model in zip(panels[2:], models[1:], strict=False):
        _panel(ax, result, model, lambda p: p.seconds, "seconds", keys, notes)
    for ax in panels[len(models) + 1 :]:
        ax.remove()
    set_legend(figure, keys, 4, "lines: best solver at each step; small dots: other solvers")
    write_notes(figure, notes)
    return figure


def _panel(
    ax: Axes,
    result: WorkPrecision,
    model: str,
    size: Size,
    unit: str,
    keys: dict[str, Any],
    notes: list[str] | None,
) -> None:
    """Draw a line through the best solver at each step, and the other solvers as dots."""
    curves = group_by(result.of(model), lambda p: (p.task.program, p.task.method))
    for (program, method), points in curves.items():
        colour, style = _style_of(result, program, method)
        good = [p for p in points if p.finished and not math.isnan(size(p))]
        best: dict[float, Point] = {}
        for p in good:
            if p.task.value not in best or size(p) < size(best[p.task.value]):
                best[p.task.value] = p
        if not best:
            continue
        label = method if program == OURS else f"{program}, {method}"
        (keys[label],) = ax.plot(
            [p.error for p in best.values()], [size(p) for p in best.values()], style,
            color=colour, markersize=5, linewidth=2.2 if program == OURS else 1.3,
        )  # fmt: skip
        ax.plot([p.error for p in good], [size(p) for p in good], ".", color=colour,
                markersize=3, alpha=0.5)  # fmt: skip
    title = f"{model}, {result.settings['elements']} elements"
    set_axes(ax, "tip error in time [m]", unit, title=title)
    blind = ax.axvspan(*_blind(result, model), color="#dddddd", zorder=0)
    keys.setdefault("below the uncertainty of the reference", blind)
    if notes is not None:
        colours = {
            p.task: _style_of(result, p.task.program, p.task.method)[0] for p in result.points
        }
        mark_failures(ax, result.of(model), lambda p: colours[p.task], notes)


def _blind(result: WorkPrecision, model: str) -> tuple[float, float]:
    """Return the errors that are smaller than the uncertainty of the reference."""
    known = result.references[model].uncertainty
    least = min((p.error for p in result.of(model) if p.finished), default=known)
    return 0.5 * min(least, known), known


def _style_of(result: WorkPrecision, program: str, method: str) -> tuple[str, str]:
    """Return colour and style of a curve."""
    if program == OURS:
        return {i.name: i.colour for i in INTEGRATORS}.get(method, "#0072b2"), STYLES[OURS]
    methods = dict.fromkeys(p.task.method for p in result.points if p.task.program == program)
    shades = COLOURS[program]
    return shades[list(methods).index(method) % len(shades)], STYLES[program]


def findings(result: WorkPrecision) -> list[str]:
    """State the times of each other code, the evaluations, and the targets."""
    sentences = []
    for model in result.references:
        sentences += [_finding(result, model, program) for program in result.programs(model)]
        sentences += _implicit_only(result, model) + _about_counts(result, model)
    return [*sentences, *(f"{target.sentence()}." for target in result.targets())]


def _finding(result: WorkPrecision, model: str, program: str) -> str:
    ratios = {level: result.ratio(model, program, level) for level in LEVELS}
    both = {level: r for level, r in ratios.items() if 0.0 < r < math.inf}
    alone = [level for level, r in ratios.items() if r == 0.0]
    lost = [level for level, r in both.items() if r < 1.0]
    if not both:
        return f"{program} and we have no error in common."
    low, high = min(both.values()), max(both.values())
    first = f"{model}: {program} takes {low:.1f} to {high:.1f} times as long as our fastest"
    if lost:
        first += "; it is faster at " + ", ".join(f"{level:.0e}" for level in lost) + " m"
    if alone:
        first += f"; from {max(alone):.0e} m down only it has a result"
    return first + "."


def _implicit_only(result: WorkPrecision, model: str) -> list[str]:
    """Compare implicit methods with implicit methods, where Exudyn ran."""
    found = [result.ratio(model, "Exudyn", v, implicit=True, alike=True) for v in LEVELS]
    both = [each for each in found if 0.0 < each < math.inf]
    if not both:
        return []
    return [
        f"{model}: implicit against implicit, Exudyn takes {min(both):.1f} to {max(both):.1f} "
        "times as long."
    ]


def _about_counts(result: WorkPrecision, model: str) -> list[str]:
    """State the errors at which another code evaluates its equations least often."""
    fewer: dict[str, list[float]] = {}
    for level in LEVELS:
        good = [p for p in result.of(model) if p.finished and p.error <= level]
        counted = [p for p in good if evaluations(p) > 0]
        best = min(counted, key=evaluations, default=None)
        if best is not None and best.task.program != OURS:
            name = f"{best.task.program}'s {best.task.method}"
            fewer.setdefault(name, []).append(level)
    return [
        f"{model}: {name} needs the fewest evaluations of the equations at "
        + ", ".join(f"{level:.0e}" for level in levels)
        + " m, Jacobians and factorizations not counted."
        for name, levels in fewer.items()
    ]


def evaluations(point: Point) -> float:
    """Return the number of residuals or right-hand sides of a run; NaN where unknown."""
    return float(point.counts.get("residuals", math.nan))


STUDY = Study(
    "work-precision",
    run=work_precision,
    heading=lambda result: result.heading(
        f"Seconds against error in time, {result.settings['elements']} elements",
        "references are known",
    ),
    tables=tables,
    rows=lambda result: [p.record() for p in result.points],
    findings=findings,
    targets=WorkPrecision.targets,
    notes=WorkPrecision.notes,
    charts={"work-precision": chart},
    regions={"work-precision": fastest_runs},
)
