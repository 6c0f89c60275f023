"""Tables, chart and findings of the study of the total error."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator, ScalarFormatter

from benchmarks.accuracy.failure_notes import MODEL_COLOURS, mark_failures, write_notes
from benchmarks.accuracy.timed_runs import Point, front
from benchmarks.accuracy.total_error import MESHES, TotalError, element_forces, total_error
from benchmarks.common import paper
from benchmarks.common.charts import LETTER_SIZE, new_figure, set_axes, set_legend
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.common.timing import OURS

OTHERS = {"Exudyn": ("#555555", "s"), "PyElastica": ("#a0522d", "^")}
"""Colour and marker by other code."""

MIN_LABEL_RATIO = 2.0  # of the errors of two labelled runs on the front

Size = Callable[[Point], float]


def tables(result: TotalError) -> list[Table]:
    """Set the front, the paper's choices and the other codes."""
    title = "The front: no run of ours has a smaller error at no more seconds"
    others = [p for p in result.points if p.task.program != OURS and p.finished]
    return [
        _runs(result.front(), title),
        _runs(result.paper_choices(), "The paper's choice"),
        *[_runs(others, "Other codes")] * bool(others),
    ]


def front_table(result: TotalError) -> Table:
    """Set the front for a page, the most accurate run first."""
    return _runs(result.front()[::-1])


COLUMNS: dict[str, Callable[[Point], str]] = {
    "error [m]": lambda p: f"{p.error:.1e}",
    "element": lambda p: p.task.model,
    "elements": lambda p: str(p.task.elements),
    "integrator": lambda p: p.task.method,
    "dt [s]": lambda p: f"{p.task.value:.3g}",
    "ms": lambda p: f"{1e3 * p.seconds:.2f}",
}


def _runs(points: Sequence[Point], title: str = "") -> Table:
    return Table.of(points, COLUMNS, (1, 3), title)


def chart(result: TotalError) -> Figure:
    """Draw cost against error with its front, in seconds and counts, and error by mesh and step."""
    figure = new_figure(9.6, "Total error against cost, and by mesh and step")
    seconds, counts, mesh, step = figure.subplots(2, 2).ravel()
    keys: dict[str, Any] = {}
    notes: list[str] = []
    _cloud(seconds, result, lambda p: p.seconds, "seconds", "Time loop or solver alone", keys)
    mark_failures(seconds, result.points, _colour, notes)
    low, high = result.model_spread()
    what = "forces of elements evaluated"
    _cloud(counts, result, element_forces, what, "The same without a clock", keys)
    _draw_meshes(mesh, result)
    _by_step(step, result)
    for ax in (seconds, counts):
        if not math.isnan(low):
            keys["distance between models"] = ax.axvspan(low, high, color="#dddddd", zorder=0)
    set_legend(figure, keys, 5, "areas of dots: number of elements")
    write_notes(figure, notes)
    return figure


def explicit(p: Point) -> bool:
    """Return whether a run solved no equations."""
    return not p.task.solver


def _colour(p: Point) -> str:
    return MODEL_COLOURS[p.task.model] if p.task.program == OURS else OTHERS[p.task.program][0]


def _cloud(
    ax: Axes, result: TotalError, size: Size, unit: str, title: str, keys: dict[str, Any]
) -> None:
    """Draw all runs, the front of ancfsparse, the paper's choices and the other codes."""
    for model in result.references:
        points = result.ours(model)
        areas = [6.0 + 0.6 * p.task.elements for p in points]
        keys[model] = ax.scatter(
            [p.error for p in points], [size(p) for p in points], areas, color=MODEL_COLOURS[model],
            alpha=0.45, linewidths=0,
        )  # fmt: skip
    best: list[Point] = []
    for p in sorted(result.ours(), key=size):
        if not best or p.error < best[-1].error:
            best.append(p)
    (keys["front"],) = ax.step(
        [p.error for p in best], [size(p) for p in best], "k-", where="pre", linewidth=1.5
    )
    least = math.inf
    for p in best[:: max(1, len(best) // 6)]:
        if p.error > least / MIN_LABEL_RATIO:
            continue
        least = p.error
        label = f"{p.task.elements}, {p.task.value:.2g} s{'*' * explicit(p)}"
        ax.annotate(
            label, (p.error, size(p)), fontsize=LETTER_SIZE,
            xytext=(-6, -4), textcoords="offset points", ha="right", va="top",
        )  # fmt: skip
    for p in result.paper_choices():
        (keys["the paper's choice"],) = ax.plot(
            p.error, size(p), "*", color=_colour(p), markersize=17, markeredgecolor="black"
        )
    for program, (colour, marker) in OTHERS.items():
        others = [p for p in result.points if p.task.program == program and p.finished]
        if others:
            keys[program] = ax.scatter(
                [p.error for p in others], [size(p) for p in others], 40, color=colour,
                marker=marker,
            )  # fmt: skip
    set_axes(ax, "tip error [m]; labels: elements, step (*: explicit)", unit, title=title)
    ax.set_xlim(0.02 * min(p.error for p in best), 1.5)  # room for labels
    ax.set_ylim(bottom=0.5 * min(size(p) for p in best))


def _draw_meshes(ax: Axes, result: TotalError) -> None:
    """Draw error against elements at the paper's step."""
    for model in result.references:
        curve = [p for n in MESHES if (p := result.at(model, n, paper.DT)) is not None]
        ax.plot([p.task.elements for p in curve], [p.error for p in curve], "o-",
                color=MODEL_COLOURS[model], markersize=4)  # fmt: skip
    ax.axvline(paper.ELEMENTS, color="black", linewidth=0.8, linestyle=":")
    set_axes(ax, "elements", "tip error [m]", title=f"By mesh, dt = {paper.DT:g} s")
    ax.xaxis.set_major_locator(FixedLocator(list(MESHES)))
    ax.xaxis.set_major_formatter(ScalarFormatter())
    ax.xaxis.set_minor_locator(NullLocator())


def _by_step(ax: Axes, result: TotalError) -> None:
    """Draw error against step, on the paper's mesh and on a fine one."""
    fine = max(p.task.elements for p in result.ours())
    for model in result.references:
        for n, style in ((paper.ELEMENTS, "o-"), (fine, "s--")):
            curve = [p for p in result.ours(model) if p.task.elements == n and not explicit(p)]
            ax.plot([p.task.value for p in curve], [p.error for p in curve], style,
                    color=MODEL_COLOURS[model], markersize=4)  # fmt: skip
    ax.axvline(paper.DT, color="black", linewidth=0.8, linestyle=":")
    meshes = f"solid: {paper.ELEMENTS} elements, dashed: {fine}"
    set_axes(ax, f"time step [s], implicit; {meshes}", "tip error [m]", title="By step")


def findings(result: TotalError) -> list[str]:
    """State the paper's choices relative to the front, locking, steps and models."""
    sentences = [_about_choice(result, p) for p in result.paper_choices()]
    sentences += [_about_steps(result, p) for p in result.paper_choices()]
    sentences += _about_thick(result)
    low, high = result.model_spread()
    if not math.isnan(low):
        sentences.append(
            f"Models that are converged differ by {low:.0e} to {high:.0e} m: below that the choice "
            "of the model decides, not the mesh."
        )
    return sentences + _about_others(result)


def _about_choice(result: TotalError, p: Point) -> str:
    better = [q for q in result.front() if q.error <= p.error]
    name = f"{p.task.model}, the paper's choice: {p.error:.1e} m in {1e3 * p.seconds:.1f} ms"
    if p in better:
        return f"{name}, on the front."
    cheapest = min(better, key=lambda q: q.seconds)
    return (
        f"{name}; {_say(cheapest)} is as good in {1e3 * cheapest.seconds:.2f} ms, "
        f"{p.seconds / cheapest.seconds:.0f} times faster."
    )


def _say(p: Point) -> str:
    return (
        f"{p.task.model} with {p.task.elements} elements, {p.task.method} and "
        f"dt = {p.task.value:.3g} s"
    )


def _about_steps(result: TotalError, p: Point) -> str:
    """State the largest step of a choice that leaves its error as it is."""
    largest = result.largest_step(p.task.model, p.task.elements)
    name = f"{p.task.model}, {p.task.elements} elements"
    if largest is None or largest.task.value <= p.task.value:
        return f"{name}: no step larger than dt = {p.task.value:g} s leaves the error as it is."
    return (
        f"{name}: the error is the mesh's, and {largest.task.method} with "
        f"dt = {largest.task.value:g} s, {largest.task.value / p.task.value:.0f} times the "
        f"paper's, leaves it at {largest.error:.1e} m."
    )


def _about_thick(result: TotalError) -> list[str]:
    """State the locking of the thick element on the paper's mesh, if it and Thin were run."""
    found = {m: result.at(m, paper.ELEMENTS, paper.DT) for m in ("Thin", "Thick", "Thick, nodal")}
    thin, thick, nodal = found.values()
    if thin is None or thick is None:
        return []
    ratio = thick.error / thin.error
    if ratio < 2.0:
        return [f"Thick on {paper.ELEMENTS} elements does not lock: {thick.error:.1e} m."]
    text = (
        f"Thick on {paper.ELEMENTS} elements locks: its error is {thick.error:.1e} m, {ratio:.0f} "
        "times that of as many Thin ones"
    )
    needed = result.elements_for("Thick", thin.error)
    text += (
        f", and of the meshes that were run {needed} do what {paper.ELEMENTS} Thin ones do"
        if needed
        else ", and no mesh that was run does what the Thin ones do"
    )
    if nodal is not None:
        text += f"; nodal section strains bring it to {nodal.error:.1e} m"
    return [text + "."]


def _about_others(result: TotalError) -> list[str]:
    sentences = []
    for program in dict.fromkeys(p.task.program for p in result.points):
        others = [p for p in result.points if p.task.program == program and p.finished]
        if program == OURS or not others:
            continue
        best = front(others)[-1]
        ours = min(
            (p for p in result.ours() if p.error <= best.error),
            key=lambda p: p.seconds,
            default=None,
        )
        first = (
            f"{program}'s most accurate run, {best.task.elements} elements, is off by "
            f"{best.error:.1e} m after {best.seconds:.2g} s"
        )
        if ours is None:
            sentences.append(f"{first}, which no run of ours reaches.")
        else:
            sentences.append(
                f"{first}; {_say(ours)} is as good in {1e3 * ours.seconds:.1f} ms, "
                f"{best.seconds / ours.seconds:.0f} times faster."
            )
    return sentences


STUDY = Study(
    "total-error",
    run=total_error,
    heading=lambda result: result.heading("Total error against cost", "converged"),
    tables=tables,
    rows=lambda result: [p.record() for p in result.points],
    findings=findings,
    notes=TotalError.notes,
    charts={"total-error": chart},
    regions={"total-error": front_table},
)
