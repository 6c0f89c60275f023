"""Parts of a tip error: mesh, time step, tolerance of the solver, and the model itself.

Each part is measured alone, against a reference of its own with its uncertainty.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import typer

from ancfsparse.checks import check_choice
from benchmarks.accuracy.candidates import Integrator, task
from benchmarks.accuracy.models import MODELS, Tips, distance, meets_outputs, step_up_to
from benchmarks.accuracy.references import Reference, converged, extrapolate, march
from benchmarks.common import paper
from benchmarks.common.progress import bar as progress_bar
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
    elements: int  # elements of the choice that is looked at
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
        Part("time step", model, dt, distance(march(model, elements, t_end, dt), exact), last)
        for dt in dts
    ]


def _exact(model: str, elements: int, t_end: float) -> tuple[Tips, float]:
    dt = step_up_to(TIMES[-1], t_end)
    return extrapolate([march(model, elements, t_end, dt / 2**k) for k in range(3)])


def _solver(model: str, elements: int, t_end: float, dt: float) -> list[Part]:
    """Compare tolerances with a tight one, at the same step."""

    def tip(tolerance: float | str) -> Tips:
        return task(model, elements, t_end, TRAPEZOIDAL, dt, SOLVER, tolerance).run().tip

    exact = tip(REFERENCE_TOLERANCE)
    known = distance(tip(TIGHT_TOLERANCE), exact)
    tolerances: list[float | str] = [*TOLERANCES, DEFAULT]
    return [Part("solver", model, each, distance(tip(each), exact), known) for each in tolerances]
