"""Data of a plan: the selected model and method, predicted errors and cost, and the reasons."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.nonlinear import Method
from ancfsparse.nonlinear.iteration import describe
from ancfsparse.plans.execution.validity_range import ValidityRange
from ancfsparse.plans.models.model import Model, build_model, mesh_counts
from ancfsparse.plans.models.planar_reduction import PlanarScene
from ancfsparse.plans.quantities.tolerances import Goal
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.plans.trial_runs.trial_runs import MAX_INTERVALS
from ancfsparse.results import Trajectory
from ancfsparse.scene import Mesh, Scene

MEGABYTE = 1e6  # bytes
MIN_INTERVALS = MAX_INTERVALS // 2  # between saved states, unless save_every is given


@dataclass(frozen=True)
class Prediction:
    """Predicted error of one quantity.

    Attributes
    ----------
    goal : Goal
        The quantity and its largest error.
    tolerance : float
        That error, absolute [unit of the quantity].
    sources : mapping of str to float
        Predicted error by source: ``"mesh"``, ``"time"``, ``"solver"``, and every effect that the
        model neglects [unit of the quantity].
    floor : float
        Difference between converged elements, a bound for all models [unit of the quantity].
    """

    goal: Goal
    tolerance: float
    sources: Mapping[str, float]
    floor: float = 0.0

    @property
    def error(self) -> float:
        """Sum of all sources [unit of the quantity]."""
        return sum(self.sources.values())

    @property
    def bound(self) -> float:
        """The larger of error and floor [unit of the quantity]."""
        return max(self.error, self.floor)

    @property
    def is_met(self) -> bool:
        """True if error and floor are within the tolerance."""
        return self.bound <= self.tolerance

    def __str__(self) -> str:
        """Write the prediction in one line."""
        unit = self.goal.quantity.unit
        parts = ", ".join(f"{name} {value:.1e}" for name, value in self.sources.items() if value)
        text = f"{self.error:.1e} {unit}".rstrip() + f" ({parts})"
        if self.floor <= self.tolerance:
            return text
        return f"{text}, and converged elements differ by {self.floor:.1e} {unit}".rstrip()


@dataclass(frozen=True)
class Alternative:
    """Another mesh and step with their predictions.

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
        """Write the alternative in one line."""
        errors = ", ".join(f"{each:.1e}" for each in self.errors)
        return f"{self.choice}: error {errors} in {self.seconds:.2g} s"


@dataclass(frozen=True, eq=False)
class PlanData:
    """Selected model, mesh, step and method, with predicted errors and cost.

    Attributes
    ----------
    scene : Scene
        The scene, with automatic elements and meshes.
    t_end : float or None
        Time at the end [s]; None for an equilibrium.
    model : Model
        Elements and numbers of elements of the beams with automatic ones, by name.
    steps : int
        Number of steps.
    integrator : Implicit, Explicit or SolutionMethod
        Integrator, or method without time integration.
    solver : Method or str
        Nonlinear solver of the steps.
    predictions : tuple of Prediction
        Error of every quantity, by source.
    seconds : float
        Predicted time of the run, set-up included [s].
    memory : float
        Predicted memory [bytes].
    coarser, finer : Alternative
        Resolutions with four times and a quarter of the error.
    reasons : tuple of str
        Reasons, in sentences.
    cost : mapping of str to float
        Cost of the plan itself: ``"seconds"``, ``"runs"``, its operation count, ``"operations"``,
        relative to a residual of one coordinate, and ``"work"``, the same over that of the planned
        run.
    start : str or None
        ``"equilibrium"`` if the motion begins there.
    planar : PlanarScene or None
        The planar scene that is solved if a scene in space moves in a plane.
    result : Trajectory or None
        The planned run if it was one of the trial runs; `run` returns it.
    validity_range : ValidityRange or None
        Range of the trial runs, in which predictions hold; None if the run was one of them.
    """

    scene: Scene
    t_end: float | None
    model: Model
    steps: int
    integrator: Implicit | Explicit | SolutionMethod
    solver: Method | str
    predictions: tuple[Prediction, ...]
    seconds: float
    memory: float
    coarser: Alternative
    finer: Alternative
    reasons: tuple[str, ...]
    cost: Mapping[str, float] = field(default_factory=dict)
    start: str | None = None
    planar: PlanarScene | None = None
    result: Trajectory | None = None
    validity_range: ValidityRange | None = None

    @property
    def dt(self) -> float | None:
        """Time step [s]; None in statics."""
        return None if self.t_end is None else self.t_end / self.steps

    @property
    def choice(self) -> str:
        """Elements, mesh, step and integrator in one line."""
        return describe_choice(self.source, self.model, self.steps, self.t_end, self.integrator)

    @property
    def error(self) -> float:
        """Predicted error of the first quantity [its unit]."""
        return self.predictions[0].error

    @property
    def is_met(self) -> bool:
        """True if all predicted errors are within their tolerances."""
        return all(each.is_met for each in self.predictions)

    @property
    def save_every(self) -> int:
        """Steps between saved states by default; 1 where states are chosen for interpolation."""
        if isinstance(self.integrator, SolutionMethod):
            return 1
        return max(1, self.steps // MIN_INTERVALS)

    @property
    def source(self) -> Scene:
        """The scene that is solved, before its automatic beams are meshed."""
        return self.scene if self.planar is None else self.planar.scene

    def build(self) -> Scene:
        """Return the scene with the selected elements and meshes."""
        return build_model(self.source, self.model)

    def __repr__(self) -> str:
        """Return the selection in one line."""
        return f"Plan: {self.choice}"

    def __str__(self) -> str:
        """Return the plan in sentences."""
        solver = self.solver if isinstance(self.solver, str) else describe(self.solver)
        span = "the equilibrium" if self.t_end is None else f"{self.t_end:g} s"
        lines = [f"Plan for {span}: {self.choice}, solver {solver}"]
        for each in self.predictions:
            lines += [f"  {each.goal}", f"    predicted error {each}"]
        lines.append(f"  predicted {self.seconds:.2g} s, {self.memory / MEGABYTE:.2g} MB")
        lines.append(f"  coarser: {self.coarser}")
        lines.append(f"  finer:   {self.finer}")
        return "\n".join([*lines, *(f"  - {reason}" for reason in self.reasons)])


def describe_choice(
    scene: Scene,
    model: Model,
    steps: int,
    t_end: float | None,
    integrator: Implicit | Explicit | SolutionMethod,
) -> str:
    """Return elements, mesh, step and integrator in one line."""
    names_of: dict[str, list[str]] = {}
    counts = mesh_counts(scene, model)
    for name in dict.fromkeys([*model.elements, *model.counts]):
        words = []
        if name in counts:
            graded = "graded " if name in model.gradings else ""
            each = " on every edge" if isinstance(scene.body(name), Mesh) else ""
            plural = "s" if counts[name] > 1 else ""
            words.append(f"{counts[name]} {graded}element{plural}{each}")
        words += [str(model.elements[name])] if name in model.elements else []
        names_of.setdefault(" ".join(words), []).append(name)
    parts = [
        f"{names[0]} {words}" if len(names) == 1 else f"{len(names)} beams of {words}"
        for words, names in names_of.items()
    ]
    if t_end is None:
        return ", ".join([*parts, "statics"])
    return ", ".join([*parts, f"dt = {t_end / steps:.3g} s ({steps} steps)", repr(integrator)])
