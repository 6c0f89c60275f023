"""Table and chart of the error budget."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.accuracy.error_budget import DEFAULT, PARTS, Budget, Part, error_budget
from benchmarks.accuracy.failure_notes import MODEL_COLOURS
from benchmarks.common.charts import SMALL, new_figure, set_axes, set_legend
from benchmarks.common.study import Study
from benchmarks.common.tables import Table

AXES = {
    "mesh": "elements",
    "time step": "time step [s]",
    "solver": "tolerance: error left in the accelerations [m/s2]",
}


def heading(budget: Budget) -> str:
    """Name the examined choice."""
    return (
        f"Error budget of {budget.elements} elements, dt = {budget.dt:g} s, default tolerance: "
        "tip error [m] and uncertainty of its reference"
    )


def parts(budget: Budget) -> Table:
    """Set a line per model, a column per part."""
    rows = [[model, *(_cell(budget, model, part) for part in PARTS)] for model in budget.references]
    return Table(["", *PARTS], rows)


def _cell(budget: Budget, model: str, part: str) -> str:
    found = budget.choice(model).get(part)
    if found is None:
        return ""
    return f"{found.error:.1e} ± {found.uncertainty:.0e}"


def chart(budget: Budget) -> Figure:
    """Draw each part against its parameter, and the distances between the models."""
    name = f"{budget.elements} elements, dt = {budget.dt:g} s"
    figure = new_figure(7.6, f"The parts of the error of {name}")
    panels = figure.subplots(2, 2, sharey=True).ravel()
    shown: dict[str, Any] = {}
    for ax, part in zip(panels, AXES, strict=False):
        for model in budget.references:
            numbers = [p for p in budget.curve(part, model) if p.value != DEFAULT]
            shown[model] = _curve(ax, numbers, MODEL_COLOURS[model])
            if part == "solver":
                error = budget.choice(model)[part].error
                ax.axhline(error, color=MODEL_COLOURS[model], linewidth=0.8, linestyle=":")
        chosen = {"mesh": budget.elements, "time step": budget.dt}.get(part)
        if chosen is not None:
            ax.axvline(chosen, color="black", linewidth=0.8, linestyle=":")
        dotted = DEFAULT if chosen is None else f"{chosen:g}"
        what = AXES[part] + f"; dotted: {dotted}"
        set_axes(ax, what, "tip error [m]", title=part.capitalize())
        ax.tick_params(labelleft=True)
    meshes = sorted({int(p.value) for p in budget.parts if p.part == "mesh"})
    panels[0].set_xticks(meshes, [str(n) for n in meshes])
    _models(panels[3], budget)
    text = "hollow: not larger than the uncertainty of the reference"
    set_legend(figure, shown, len(shown), text)
    return figure


def _curve(ax: Axes, curve: list[Part], colour: str) -> Any:
    x, y = [p.value for p in curve], [p.error for p in curve]
    (line,) = ax.plot(x, y, "-", color=colour, linewidth=1.4)
    for p in curve:
        ax.plot([p.value], [p.error], "o", color=colour, markersize=5,
                markerfacecolor=colour if p.known else "white")  # fmt: skip
    return line


def _models(ax: Axes, budget: Budget) -> None:
    """Draw the distance of each pair of converged models, with its uncertainty."""
    names = list(budget.references)
    pairs = [
        p for p in budget.parts
        if p.part == "model" and names.index(p.model) < names.index(str(p.value))
    ]  # fmt: skip
    for row, p in enumerate(pairs):
        ax.errorbar(
            row, p.error, yerr=[[min(p.uncertainty, 0.9 * p.error)], [p.uncertainty]], fmt="D",
            color=MODEL_COLOURS[p.model], markersize=6, capsize=3,
            markerfacecolor=MODEL_COLOURS[str(p.value)], markeredgewidth=2,
        )  # fmt: skip
    ax.set_xticks(
        range(len(pairs)), [f"{p.model} – {p.value}" for p in pairs], rotation=35, ha="right",
        fontsize=SMALL,
    )  # fmt: skip
    what = "two models, both converged in mesh and time"
    set_axes(ax, what, "distance of the tips [m]", "y", "Model")
    ax.tick_params(labelleft=True)


STUDY = Study(
    "error-budget",
    run=error_budget,
    heading=heading,
    tables=lambda budget: [parts(budget)],
    rows=lambda budget: [asdict(p) for p in budget.parts],
    findings=Budget.findings,
    charts={"error-budget": chart},
    regions={"error-budget": parts},
)
