"""Parts of a tip error: mesh, time step, tolerance of the solver, and the model itself.

Each part is measured alone, against a reference of its own with its uncertainty.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import typer
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ancfsparse.checks import check_choice
from benchmarks.accuracy.candidates import Integrator, task
from benchmarks.accuracy.failure_notes import MODEL_COLOURS
from benchmarks.accuracy.models import MODELS, Tips, distance, meets_outputs, step_up_to
from benchmarks.accuracy.references import Reference, converged, extrapolate, trapezoidal_tip
from benchmarks.common import paper
from benchmarks.common.charts import LETTER_SIZE, new_figure, set_axes, set_legend
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.other_codes.environment import environment

PARTS = ("mesh", "time step", "solver", "model")

MESHES = (5, 10, 20, 40)
TIMES = (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4)
TOLERANCES = (10.0, 1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5)

REFERENCE_TOLERANCE = 1e-8  # [m/s2]
TIGHT_TOLERANCE = 1e-7  # whose difference is the uncertainty of the reference [m/s2]

DEFAULT = "default"
"""The tolerance of the examined choice."""

SOLVER = "BFGS"
"""The solver whose tolerance is varied."""

TRAPEZOIDAL = Integrator("Newmark(0)")

FINE = 160  # elements of the finest reference
FINE_DT = 5e-4  # its largest step [s]


@dataclass(frozen=True)
class Part:
    """One measured error."""

    part: str  # one of `PARTS`
    model: str  # key of `MODELS`
    # number of elements, step [s], tolerance [m/s2] or `DEFAULT`, or the other model
    value: float | str
    error: float  # largest tip distance from the reference [m]
    uncertainty: float  # of the reference [m]

    @property
    def known(self) -> bool:
        """True if the error is larger than the uncertainty of the reference."""
        return self.error > self.uncertainty


@dataclass(frozen=True)
class Budget:
    """The error budget."""

    parts: list[Part]  # all that was measured
    elements: int  # elements of the examined choice
    dt: float  # its step [s]
    references: dict[str, Reference]  # motions converged in time and space, by model
    settings: dict[str, Any]  # of the study and the machine

    def curve(self, part: str, model: str) -> list[Part]:
        """Return all measured errors of a part."""
        return [p for p in self.parts if (p.part, p.model) == (part, model)]

    def choice(self, model: str) -> dict[str, Part]:
        """Return the parts of the error of the examined choice, with the largest model distance."""
        at = {"mesh": self.elements, "time step": self.dt, "solver": DEFAULT}
        chosen = {p.part: p for p in self.parts if p.model == model and at.get(p.part) == p.value}
        others = self.curve("model", model)
        if others:
            chosen["model"] = max(others, key=lambda p: p.error)
        return {part: chosen[part] for part in PARTS if part in chosen}

    def findings(self) -> list[str]:
        """State the largest part for each model, and its ratio to the second."""
        sentences = []
        for model in self.references:
            chosen = self.choice(model)
            ranked = sorted(chosen.values(), key=lambda p: p.error, reverse=True)
            first, second = ranked[:2]
            sentences.append(
                f"{model}, {self.elements} elements, dt = {self.dt:g} s: the {first.part} leaves "
                f"{first.error:.1e} m, {first.error / second.error:.0f} times the {second.part}"
            )
        return sentences


def error_budget(
    models: Sequence[str] = tuple(MODELS),
    elements: Annotated[int, typer.Option(help="Number of elements.")] = paper.ELEMENTS,
    dt: float = paper.DT,
    t_end: Annotated[float, typer.Option("--time", help="Simulated time [s].")] = paper.T_END,
    meshes: Sequence[int] = MESHES,
    fine: int = FINE,
    progress: bool = False,
) -> Budget:
    """Split the error of the paper's choice into mesh, time step, solver and model."""
    for model in models:
        check_choice("model", model, MODELS)
    dts = [each for each in sorted({*TIMES, dt}, reverse=True) if meets_outputs(each, t_end)]
    parts: list[Part] = []
    references: dict[str, Reference] = {}
    total = len(models) * 4
    with progress_bar(total, "part", progress) as bar:
        for model in models:
            bar.set_description(f"{model}, converged")
            references[model] = converged(model, fine, t_end, step_up_to(FINE_DT, t_end))
            bar.update()
            bar.set_description(f"{model}, meshes")
            parts += _mesh(model, sorted({*meshes, elements}), t_end, references[model])
            bar.update()
            bar.set_description(f"{model}, steps")
            parts += _time(model, elements, dts, t_end)
            bar.update()
            bar.set_description(f"{model}, tolerances")
            parts += _solver(model, elements, t_end, dt)
            bar.update()
    for model, one in references.items():
        for name, other in references.items():
            if name != model:
                error, known = distance(one.tip, other.tip), one.uncertainty + other.uncertainty
                parts.append(Part("model", model, name, error, known))
    settings = {"elements": elements, "dt_s": dt, "t_end_s": t_end, "solver": SOLVER}
    return Budget(parts, elements, dt, references, settings | environment())


def _mesh(model: str, meshes: list[int], t_end: float, reference: Reference) -> list[Part]:
    """Compare meshes, each solved exactly in time, with the converged motion."""
    found = []
    for n in meshes:
        tip, last = _exact(model, n, t_end)
        error = distance(tip, reference.tip)
        found.append(Part("mesh", model, n, error, last + reference.uncertainty))
    return found


def _time(model: str, elements: int, dts: list[float], t_end: float) -> list[Part]:
    """Compare steps with the same mesh solved exactly in time."""
    exact, last = _exact(model, elements, t_end)
    return [
        Part(
            "time step",
            model,
            dt,
            distance(trapezoidal_tip(model, elements, t_end, dt), exact),
            last,
        )
        for dt in dts
    ]


def _exact(model: str, elements: int, t_end: float) -> tuple[Tips, float]:
    dt = step_up_to(TIMES[-1], t_end)
    return extrapolate([trapezoidal_tip(model, elements, t_end, dt / 2**k) for k in range(3)])


def _solver(model: str, elements: int, t_end: float, dt: float) -> list[Part]:
    """Compare tolerances with a tight one, at the same step."""

    def tip(tolerance: float | str) -> Tips:
        return task(model, elements, t_end, TRAPEZOIDAL, dt, SOLVER, tolerance).run().tip

    exact = tip(REFERENCE_TOLERANCE)
    known = distance(tip(TIGHT_TOLERANCE), exact)
    tolerances: list[float | str] = [*TOLERANCES, DEFAULT]
    return [Part("solver", model, each, distance(tip(each), exact), known) for each in tolerances]


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
    keys: dict[str, Any] = {}
    for ax, part in zip(panels, AXES, strict=False):
        for model in budget.references:
            numbers = [p for p in budget.curve(part, model) if p.value != DEFAULT]
            keys[model] = _curve(ax, numbers, MODEL_COLOURS[model])
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
    panels[0].set_xticks([], minor=True)
    _models(panels[3], budget)
    text = "hollow: not larger than the uncertainty of the reference"
    set_legend(figure, keys, len(keys), text)
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
        fontsize=LETTER_SIZE,
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
