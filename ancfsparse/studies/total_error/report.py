"""The study of the whole error as text, CSV, JSON and a chart."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullFormatter, NullLocator, ScalarFormatter

from ancfsparse.studies.common import paper
from ancfsparse.studies.common.charts import (
    MODEL_COLOURS,
    SMALL,
    WIDTH,
    failures,
    mark_failures,
    set_head,
    set_legend,
    set_title,
    write_notes,
)
from ancfsparse.studies.common.race import OURS, Point
from ancfsparse.studies.common.study import Study
from ancfsparse.studies.common.tables import table, with_findings
from ancfsparse.studies.total_error.findings import about_steps, about_thick, findings, headline
from ancfsparse.studies.total_error.run import MESHES, TotalError, element_forces, total_error

PEERS = {"Exudyn": ("#555555", "s"), "PyElastica": ("#a0522d", "^")}
"""Colour and marker by peer."""

# Labels of two runs on the front need errors this far apart.
APART = 2.0

Size = Callable[[Point], float]


def as_text(result: TotalError) -> str:
    """Set the front, the paper's choices and what they say for a terminal."""
    settings = result.settings
    lines = [
        f"Whole error against cost, {settings['t_end_s']:g} s, {settings['instruction_set']}; "
        f"{settings['seconds']}",
        f"error: {settings['error']}",
        "",
        *(
            f"  {name:<14} converged to {each.uncertainty:.1e} m"
            for name, each in result.references.items()
        ),
        "",
        "The front: no run of ours has a smaller error at no more seconds",
        f"  {'':<32}{'elements':>9}{'dt [s]':>10}{'error [m]':>12}{'ms':>9}{'element forces':>16}",
        *(_line(p) for p in result.front()),
        "",
        "The paper's choice",
        *(_line(p) for p in result.paper_choices()),
    ]
    theirs = [p for p in result.points if p.task.program != OURS and p.finished]
    if theirs:
        lines += ["", "Peers", *(_line(p) for p in theirs)]
    failed = failures(result.points)
    lines += ["", "Without result", *(f"  {each}" for each in failed)] if failed else []
    return "\n".join([*lines, "", *findings(result), *result.missing])


def _line(p: Point) -> str:
    name = f"{p.task.model if p.task.program == OURS else p.task.program}, {p.task.method}"
    return (
        f"  {name:<32}{p.task.elements:>9}{p.task.value:>10.3g}{p.error:>12.1e}"
        f"{1e3 * p.seconds:>9.2f}{element_forces(p):>16,.0f}"
    )


def as_markdown(result: TotalError) -> str:
    """Set the front and the findings for a page."""
    rows = [
        [
            f"{p.error:.1e}", p.task.model, str(p.task.elements), p.task.method,
            f"{p.task.value:.3g}", f"{1e3 * p.seconds:.2f}",
        ]
        for p in reversed(result.front())
    ]  # fmt: skip
    head = ["error [m]", "element", "elements", "integrator", "dt [s]", "ms"]
    return with_findings(table(head, rows, left=(1, 3)), findings(result))


def chart(result: TotalError) -> Figure:
    """Draw cost against error with its front, in seconds and counts, and error by mesh and step."""
    figure = Figure(figsize=(WIDTH, 9.6), layout="constrained")
    seconds, counts, mesh, step = figure.subplots(2, 2).ravel()
    shown: dict[str, Any] = {}
    notes: list[str] = []
    _cloud(seconds, result, lambda p: p.seconds, "seconds", shown)
    mark_failures(seconds, result.points, _colour, notes)
    low, high = result.model_spread()
    set_title(seconds, _front_title(result))
    _cloud(counts, result, element_forces, "forces of elements evaluated", shown)
    set_title(counts, "The same without a clock: forces of elements that were evaluated")
    _by_mesh(mesh, result)
    _by_step(step, result)
    for ax in (seconds, counts, mesh, step):
        ax.grid(alpha=0.3, which="major")
    for ax in (seconds, counts):
        if not math.isnan(low):
            shown["distance between models"] = ax.axvspan(low, high, color="#dddddd", zorder=0)
    set_legend(figure, shown, 5, "areas of dots: number of elements")
    set_head(figure, headline(result))
    write_notes(figure, notes)
    return figure


def explicit(p: Point) -> bool:
    """Say whether a run solved no equations."""
    return not p.task.solver


def _colour(p: Point) -> str:
    return MODEL_COLOURS[p.task.model] if p.task.program == OURS else PEERS[p.task.program][0]


def _cloud(ax: Axes, result: TotalError, size: Size, unit: str, shown: dict[str, Any]) -> None:
    """Draw all runs, the front of ours through them, the paper's choices and the peers."""
    for model in result.references:
        points = result.ours(model)
        areas = [6.0 + 0.6 * p.task.elements for p in points]
        shown[model] = ax.scatter(
            [p.error for p in points], [size(p) for p in points], areas, color=MODEL_COLOURS[model],
            alpha=0.45, linewidths=0,
        )  # fmt: skip
    best: list[Point] = []
    for p in sorted(result.ours(), key=size):
        if not best or p.error < best[-1].error:
            best.append(p)
    (shown["front"],) = ax.step(
        [p.error for p in best], [size(p) for p in best], "k-", where="pre", linewidth=1.5
    )
    least = math.inf
    for p in best[:: max(1, len(best) // 6)]:
        if p.error > least / APART:
            continue
        least = p.error
        label = f"{p.task.elements}, {p.task.value:.2g} s{'*' * explicit(p)}"
        ax.annotate(
            label, (p.error, size(p)), fontsize=SMALL,
            xytext=(-6, -4), textcoords="offset points", ha="right", va="top",
        )  # fmt: skip
    for p in result.paper_choices():
        (shown["the paper's choice"],) = ax.plot(
            p.error, size(p), "*", color=_colour(p), markersize=17, markeredgecolor="black"
        )
    for program, (colour, marker) in PEERS.items():
        theirs = [p for p in result.points if p.task.program == program and p.finished]
        if theirs:
            shown[program] = ax.scatter(
                [p.error for p in theirs], [size(p) for p in theirs], 40, color=colour,
                marker=marker,
            )  # fmt: skip
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlim(0.02 * min(p.error for p in best), 1.5)  # room for labels
    ax.set_ylim(bottom=0.5 * min(size(p) for p in best))
    ax.set_xlabel("tip error [m]; labels: elements, step (*: explicit)")
    ax.set_ylabel(unit)


def _front_title(result: TotalError) -> str:
    """Name the models on the front."""
    names = dict.fromkeys(p.task.model for p in result.front())
    off = [model for model in result.references if model not in names]
    text = "On the front: " + ", ".join(names)
    return text + (f"; never: {', '.join(off)}" if off else "")


def _by_mesh(ax: Axes, result: TotalError) -> None:
    """Draw error against elements at the paper's step."""
    for model in result.references:
        curve = [p for n in MESHES if (p := result.at(model, n, paper.DT)) is not None]
        ax.plot([p.task.elements for p in curve], [p.error for p in curve], "o-",
                color=MODEL_COLOURS[model], markersize=4)  # fmt: skip
    ax.axvline(paper.ELEMENTS, color="black", linewidth=0.8, linestyle=":")
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.xaxis.set_major_locator(FixedLocator(list(MESHES)))
    ax.xaxis.set_major_formatter(ScalarFormatter())
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xlabel("elements")
    ax.set_ylabel(f"tip error at dt = {paper.DT:g} s [m]")
    about = about_thick(result) or ["Error by mesh"]
    set_title(ax, about[0])


def _by_step(ax: Axes, result: TotalError) -> None:
    """Draw error against step, on the paper's mesh and on a fine one."""
    meshes = sorted({p.task.elements for p in result.ours()})
    fine = meshes[-1]
    for model in result.references:
        for n, style in ((paper.ELEMENTS, "o-"), (fine, "s--")):
            curve = [p for p in result.ours(model) if p.task.elements == n and not explicit(p)]
            ax.plot([p.task.value for p in curve], [p.error for p in curve], style,
                    color=MODEL_COLOURS[model], markersize=4)  # fmt: skip
    ax.axvline(paper.DT, color="black", linewidth=0.8, linestyle=":")
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_xlabel(f"time step [s], implicit; solid: {paper.ELEMENTS} elements, dashed: {fine}")
    ax.set_ylabel("tip error [m]")
    thin = result.at("Thin", paper.ELEMENTS, paper.DT)
    about = about_steps(result, thin) if thin else "Error by step"
    set_title(ax, about)


STUDY = Study(
    "total-error",
    run=total_error,
    text=as_text,
    rows=lambda result: [p.record() for p in result.points],
    record=TotalError.record,
    findings=findings,
    charts={"total-error": chart},
    regions={"total-error": as_markdown},
)
