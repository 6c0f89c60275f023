"""The record of a plan: what was chosen, what it is predicted to do, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.nonlinear import Method
from ancfsparse.nonlinear.iteration import describe
from ancfsparse.plans.execution.validity_range import Span
from ancfsparse.plans.models.model import Model, built
from ancfsparse.plans.models.planar_reduction import InPlane
from ancfsparse.plans.quantities.tolerances import Wanted
from ancfsparse.plans.trial_runs.solution_methods import Way
from ancfsparse.results import Trajectory
from ancfsparse.scene import Mesh, Scene

Array = NDArray[np.float64]

MEGABYTE = 1e6
# Intervals between saved states at least, unless they are chosen by save_every.
SAVED = 1000


@dataclass(frozen=True)
class Prediction:
    """The error of one quantity.

    Attributes
    ----------
    wanted : Wanted
        The quantity and the error that was asked for.
    asked : float
        That error, absolute [unit of the quantity].
    sources : mapping of str to float
        Predicted error by source: ``"mesh"``, ``"time"``, ``"solver"``, and every effect that the
        model neglects [unit of the quantity].
    floor : float
        By how much elements that are all converged differ: no model promises less [likewise].
    """

    wanted: Wanted
    asked: float
    sources: Mapping[str, float]
    floor: float = 0.0

    @property
    def error(self) -> float:
        """Sum of all sources [unit of the quantity]."""
        return sum(self.sources.values())

    @property
    def is_met(self) -> bool:
        """Whether it is at most the error that was asked for, and a model can promise that."""
        return max(self.error, self.floor) <= self.asked

    def __str__(self) -> str:
        """Write it in one line."""
        unit = self.wanted.quantity.unit
        parts = ", ".join(f"{name} {value:.1e}" for name, value in self.sources.items() if value)
        text = f"{self.error:.1e} {unit}".rstrip() + f" ({parts})"
        if self.floor <= self.asked:
            return text
        return f"{text}, and no model promises less than {self.floor:.1e} {unit}".rstrip()


@dataclass(frozen=True)
class Alternative:
    """Another choice, with what it is predicted to do.

    Attributes
    ----------
    choice : str
        Elements, mesh and step.
    errors : tuple of float
        Predicted error of every quantity [its unit].
    seconds : float
        Predicted time of the run [s].
    """

    choice: str
    errors: tuple[float, ...]
    seconds: float

    def __str__(self) -> str:
        """Write it in one line."""
        errors = ", ".join(f"{each:.1e}" for each in self.errors)
        return f"{self.choice}: error {errors} in {self.seconds:.2g} s"


@dataclass(frozen=True, eq=False)
class PlanData:
    """How a scene is to be run, as `plan` returns it.

    Attributes
    ----------
    scene : Scene
        The scene, with what is open.
    t_end : float or None
        Time at the end [s]; None: the equilibrium is asked for.
    model : Model
        Element and number of elements of every beam of which they are open, by its name.
    steps : int
        Number of steps.
    integrator : Implicit, Explicit or Way
        How it is marched; or, as a `Way`, found without steps of an integrator.
    solver : Method or str
        How the equations of a step are solved.
    predictions : tuple of Prediction
        The error of every quantity, by source.
    seconds : float
        Predicted time of the run, set-up included [s].
    memory : float
        Predicted memory [bytes].
    cheaper, dearer : Alternative
        The next cheaper and the next dearer choice.
    reasons : tuple of str
        Why, in sentences.
    cost : Mapping of str to float
        What the plan itself took: ``"seconds"``, ``"runs"``, its counted work, ``"counted"``, in
        that of a residual of one coordinate, and ``"work"``, the same over that of the planned run.
    start : str or None
        ``"equilibrium"`` if the motion begins there.
    flat : InPlane or None
        The planar scene that is solved where one in space moves in a plane.
    span : Span or None
        What the pilots have met, beyond which the prediction is not known to hold; None where the
        run itself was one of them.
    answer : Trajectory or None
        The run that was planned, if it was made as a pilot: `run` returns it.
    """

    scene: Scene
    t_end: float | None
    model: Model
    steps: int
    integrator: Implicit | Explicit | Way
    solver: Method | str
    predictions: tuple[Prediction, ...]
    seconds: float
    memory: float
    cheaper: Alternative
    dearer: Alternative
    reasons: tuple[str, ...]
    cost: Mapping[str, float] = field(default_factory=dict)
    start: str | None = None
    flat: InPlane | None = None
    answer: Trajectory | None = None
    span: Span | None = None

    @property
    def dt(self) -> float | None:
        """Time step [s]; None in statics."""
        return None if self.t_end is None else self.t_end / self.steps

    @property
    def choice(self) -> str:
        """Elements, mesh, step and integrator in one line."""
        return described(self.scene, self.model, self.steps, self.t_end, self.integrator)

    @property
    def error(self) -> float:
        """Predicted error of the first quantity [its unit]."""
        return self.predictions[0].error

    @property
    def is_met(self) -> bool:
        """Whether all errors are predicted to be at most those that were asked for."""
        return all(each.is_met for each in self.predictions)

    def build(self) -> Scene:
        """Return the scene with the chosen elements and meshes."""
        return built(self.source, self.model)

    def __repr__(self) -> str:
        """Write the choice."""
        return f"Plan: {self.choice}"

    def __str__(self) -> str:
        """Write everything for a reader."""
        solver = self.solver if isinstance(self.solver, str) else describe(self.solver)
        span = "the equilibrium" if self.t_end is None else f"{self.t_end:g} s"
        lines = [f"Plan for {span}: {self.choice}, solver {solver}"]
        for each in self.predictions:
            lines += [f"  {each.wanted}", f"    predicted error {each}"]
        lines.append(f"  predicted {self.seconds:.2g} s, {self.memory / MEGABYTE:.2g} MB")
        lines.append(f"  cheaper: {self.cheaper}")
        lines.append(f"  dearer:  {self.dearer}")
        return "\n".join([*lines, *(f"  - {reason}" for reason in self.reasons)])

    @property
    def save_every(self) -> int:
        """Steps between saved states, unless others are asked for."""
        return max(1, self.steps // SAVED)

    @property
    def source(self) -> Scene:
        """The scene that is solved, with open beams: in the plane where it moves in one."""
        return self.scene if self.flat is None else self.flat.scene


def described(
    scene: Scene,
    model: Model,
    steps: int,
    t_end: float | None,
    integrator: Implicit | Explicit | Way,
) -> str:
    """Write elements, mesh, step and integrator in one line."""
    alike: dict[str, list[str]] = {}
    for name in dict.fromkeys([*model.rungs, *model.counts]):
        words = []
        if name in model.counts:
            graded = "graded " if name in model.grades else ""
            each = " on every edge" if isinstance(scene.body(name), Mesh) else ""
            plural = "s" if model.counts[name] > 1 else ""
            words.append(f"{model.counts[name]} {graded}element{plural}{each}")
        words += [str(model.rungs[name])] if name in model.rungs else []
        alike.setdefault(" ".join(words), []).append(name)
    parts = [
        f"{names[0]} {words}" if len(names) == 1 else f"{len(names)} beams of {words}"
        for words, names in alike.items()
    ]
    if t_end is None:
        return ", ".join([*parts, "statics"])
    return ", ".join([*parts, f"dt = {t_end / steps:.3g} s ({steps} steps)", repr(integrator)])
