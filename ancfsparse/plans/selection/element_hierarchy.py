"""Hierarchy of elements: the effects that each neglects, and the cheapest that suffices."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from ancfsparse.errors import InputError, LoadError
from ancfsparse.plans.model_error.neglected_energies import bending_effect, neglected_effects
from ancfsparse.plans.model_error.section_energies import loaded_nodes
from ancfsparse.plans.models.model import (
    MIN_LONGEST_COUNT,
    ElementChoice,
    Model,
    build_model,
    coarse_count,
    element_counts,
    open_bodies,
)
from ancfsparse.plans.trial_runs.run_differences import absolute_tolerances
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns
from ancfsparse.results import Trajectory
from ancfsparse.scene import ElasticBody, Scene

STRING = ElementChoice("string", {}, 2)
CABLE = ElementChoice("thin", {}, 4)
TWISTED = ElementChoice("thick", {"section_strain": "nodal"}, 2)
SHEARED = ElementChoice("thick", {"curvature": "section", "section_strain": "nodal"}, 2)
HIERARCHY = (STRING, CABLE, TWISTED, SHEARED)
"""From the cheapest to the richest."""

# Converged elements differ by how bending depends on stretch, so no selection avoids this effect.
FLOOR = "stretch"
# Effects that every element neglects in a motion without time integration.
METHOD_EFFECTS = frozenset({"inertia", "nonlinearity", "modes", "flexibility"})
SOURCE_NAMES = {
    "mesh": "mesh",
    "time": "steps",
    "mesh and steps": "mesh and the steps",
    "solver": "solver",
    "shear": "neglected shear",
    "torsion": "neglected torsion",
    "rotary inertia": "neglected rotary inertia",
    "bending": "neglected bending",
    "inertia": "neglected inertia",
    "nonlinearity": "nonlinear forces",
    "flexibility": "flexibility of rigid rods",
    "modes": "modes left out",
}
"""Names of the sources of errors in sentences."""
# Shorter steps and finer meshes for the rest take less work than richer elements.
NEGLIGIBLE_FRACTION = 0.5  # of the tolerance, up to which modelling errors are accepted


def neglected_by(element: ElementChoice) -> frozenset[str]:
    """Return the effects that an element neglects."""
    cable = frozenset({"shear", "torsion", "rotary inertia"})
    if element == SHEARED:
        return frozenset()
    if element == TWISTED:
        return frozenset({"shear"})
    return cable | {"bending"} if element == STRING else cable


def open_beams(scene: Scene) -> list[str]:
    """Return the names of the beams with automatic elements."""
    return [beam.name for beam in open_bodies(scene) if "element" in beam.automatic]


def model_of(
    scene: Scene, element: ElementChoice, fixed: Mapping[str, ElementChoice] | None = None
) -> Model:
    """Return a model with one element for all beams with automatic ones, except fixed beams."""
    return Model(elements=dict.fromkeys(open_beams(scene), element) | dict(fixed or {}))


def candidates(
    scene: Scene,
    fixed: Mapping[str, ElementChoice] | None = None,
    build: Callable[[Model], Scene] | None = None,
    n_longest: float | None = None,
) -> tuple[list[ElementChoice], dict[str, str]]:
    """Return the elements that a scene admits, and the reasons for rejecting others.

    Parameters
    ----------
    scene : Scene
        The scene.
    fixed : mapping of str to ElementChoice, optional
        Elements of beams that were selected before.
    build : callable, optional
        Returns the scene with a model, such as `TrialRuns.build`, which builds none twice.
    n_longest : float, optional
        Elements on the longest beam of the mesh that is built.

    Returns
    -------
    list of ElementChoice
        From the cheapest to the richest.
    dict of str to str
        Sentences by the name of the element.
    """
    admitted, rejected = [], {}
    build = build or partial(build_model, scene)
    counts = element_counts(scene, n_longest or coarse_count(scene, MIN_LONGEST_COUNT))
    for element in HIERARCHY:
        try:
            build(model_of(scene, element, fixed).with_counts(counts))
        except (InputError, LoadError) as error:
            rejected[str(element)] = str(error)
        else:
            admitted.append(element)
    return admitted, rejected


def estimate_effects(
    trials: TrialRuns, trial: TrialRun, coarse_run: TrialRun | None = None
) -> list[dict[str, float]]:
    """Estimate the modelling errors of a trial run by effect, for every quantity [its unit].

    Where the response of quantities may matter, it is measured by a cheaper, coarse run, repeated
    with changed compliance and density.
    """
    scene = trial.run.system.scene
    solve = None if coarse_run is None else _solver_like(trials, coarse_run)
    tolerances = absolute_tolerances(trials.goals, trial)
    out = []
    for goal, tolerance in zip(trials.goals, tolerances, strict=True):
        quantity, coarse = goal.quantity.in_scene(scene), None
        if coarse_run is not None:
            run = coarse_run.run
            coarse = run, goal.quantity.in_scene(run.system.scene)
        enough = NEGLIGIBLE_FRACTION * tolerance
        effects = neglected_effects(scene, trial.run, quantity, solve, enough, coarse)
        if isinstance(trials.integrator, SolutionMethod):
            effects |= trials.integrator.neglected(trial.run, quantity)
        out.append(effects)
    return out


def _solver_like(trials: TrialRuns, trial: TrialRun) -> Callable[[Scene], Trajectory]:
    """Return a function that solves changed scenes with the settings of a trial run."""
    runs = trials.with_integrator(trial.integrator)
    return lambda scene: runs.solve(scene, trial.steps, coarser=trial.run, solver=trial.solver)


def estimate_bending(trials: TrialRuns, trial: TrialRun) -> list[dict[str, float]]:
    """Estimate the modelling error of strings from a run with bending, for every quantity."""
    scene, elements = trial.run.system.scene, trial.model.elements
    bodies = [b for b in scene.beams if b.name in elements and isinstance(b, ElasticBody)]
    quantities = (each.quantity.in_scene(scene) for each in trials.goals)
    loaded = loaded_nodes(scene)
    return [{"bending": bending_effect(trial.run, bodies, each, loaded)} for each in quantities]


def cheapest_sufficient(
    elements: Sequence[ElementChoice],
    first: ElementChoice,
    effects: Sequence[Mapping[str, float]],
    tolerances: Sequence[float],
) -> ElementChoice:
    """Return the cheapest of several elements with negligible modelling errors.

    From the effects of the `first` element and `reachable_tolerances` of every quantity [its unit].
    """
    richer = elements[list(elements).index(first) :]
    return next((each for each in richer if is_sufficient(each, effects, tolerances)), richer[-1])


def is_sufficient(
    element: ElementChoice, effects: Sequence[Mapping[str, float]], tolerances: Sequence[float]
) -> bool:
    """Return True if the modelling errors of an element are negligible for every quantity."""
    return all(
        sum(effects_neglected(each, element).values()) < NEGLIGIBLE_FRACTION * tolerance
        or not effects_neglected(each, element)
        for each, tolerance in zip(effects, tolerances, strict=True)
    )


def largest_negligible_set(
    effects: Mapping[str, Sequence[Mapping[str, float]]],
    tolerances: Sequence[float],
    fraction: float = NEGLIGIBLE_FRACTION,
) -> tuple[list[str], list[dict[str, float]]]:
    """Return the beams whose modelling errors together are negligible, the smallest first.

    They may use a fraction of the tolerances.  Errors of every beam by effect, tolerances, and the
    sum of the errors of these beams are for every quantity [its unit].
    """

    def excess(errors: Sequence[Mapping[str, float]]) -> float:
        pairs = zip(errors, tolerances, strict=True)
        return max(sum(each.values()) / tolerance for each, tolerance in pairs)

    names: list[str] = []
    total: list[dict[str, float]] = []
    for name in sorted(effects, key=lambda name: excess(effects[name])):
        total = total or [dict.fromkeys(each, 0.0) for each in effects[name]]
        pairs = list(zip(total, effects[name], strict=True))
        more = [{k: one[k] + value for k, value in other.items()} for one, other in pairs]
        if any(sum(each.values()) > fraction * x for each, x in zip(more, tolerances, strict=True)):
            break
        names.append(name)
        total = more
    return names, total


def floors(effects: Sequence[Mapping[str, float]]) -> tuple[float, ...]:
    """Return the difference between converged elements in every quantity [its unit]."""
    return tuple(each.get(FLOOR, 0.0) for each in effects)


def reachable_tolerances(
    effects: Sequence[Mapping[str, float]], tolerances: Sequence[float]
) -> list[float]:
    """Return the tolerances, at least the difference between converged elements."""
    return [max(pair) for pair in zip(tolerances, floors(effects), strict=True)]


def effects_neglected(effects: Mapping[str, float], element: ElementChoice) -> dict[str, float]:
    """Return the effects, of several, that an element neglects."""
    return {name: value for name, value in effects.items() if name in neglected_by(element)}


def method_effects(effects: Mapping[str, float]) -> dict[str, float]:
    """Return the effects, of several, of motions without time integration."""
    return {name: value for name, value in effects.items() if name in METHOD_EFFECTS}
