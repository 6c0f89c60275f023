"""Selection of the method with least work: statics, sums of modes, or time integration."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ancfsparse.errors import AncfError, PlanError, StepError
from ancfsparse.plans.discretization_error.error_model import ErrorModel
from ancfsparse.plans.discretization_error.mesh_error import COARSEST_COUNT
from ancfsparse.plans.discretization_error.run_series import RUN_GROWTH
from ancfsparse.plans.model_error.effects import METHOD_EFFECTS, SOURCE_NAMES, Effects
from ancfsparse.plans.model_error.quasi_static_error import lowest_frequency
from ancfsparse.plans.models.model import Model, coarse_count, open_bodies
from ancfsparse.plans.selection.discretization_search import search
from ancfsparse.plans.selection.element_hierarchy import open_beams, use_admitted
from ancfsparse.plans.selection.element_per_beam import estimate_effects
from ancfsparse.plans.selection.element_selection import select_elements
from ancfsparse.plans.selection.explicit_alternative import select_explicit
from ancfsparse.plans.selection.rigid_link_selection import select_rigid_links
from ancfsparse.plans.trial_runs.load_resolution import (
    check_signals,
    jumps_inside_steps,
    steps_resolving_loads,
    steps_resolving_vibration,
)
from ancfsparse.plans.trial_runs.run_differences import absolute_tolerances
from ancfsparse.plans.trial_runs.solution_methods import ModalSum, SolutionMethod, Statics
from ancfsparse.plans.trial_runs.trial_runs import BASE_BUDGET, TrialRuns
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene
from ancfsparse.system import System

# Statics is tried before time integration, sums of modes only if that takes long: computing modes
# takes as much work as short motions do.
FIRST: tuple[type[SolutionMethod], ...] = (Statics,)
LAST: tuple[type[SolutionMethod], ...] = (ModalSum,)
VIBRATION_FRACTION = 0.25  # of the tolerance, above which vibrations must be resolved


@dataclass(frozen=True)
class Selection:
    """Selected method, elements, mesh and step.

    Attributes
    ----------
    trials : TrialRuns
        The runs, with the integrator or the method.
    error_model : ErrorModel
        Their result.
    why : tuple of str
        Reasons, in sentences.
    """

    trials: TrialRuns
    error_model: ErrorModel
    why: tuple[str, ...]


def select_method(
    trials: TrialRuns,
    finer: Scene | None,
    fixed_steps: int | None,
    is_free: bool,
    failure: StepError | PlanError | None = None,
) -> Selection:
    """Select the method, the elements, the mesh and the step.

    If the method `is_free`, others than the integrator of the runs are tried, and only these after
    a failure of time integration; `finer` and `fixed_steps` as in `search`.
    """
    trials = _resolve_loads(trials, fixed_steps)
    why: list[str] = []
    other, error_model = None, None
    for method in _applicable(trials, FIRST) if is_free and failure is None else ():
        attempt, other, against = _attempt_method(trials, method, finer)
        why += against
        trials = _resolve_vibrations(trials, attempt)
        if other is not None and other.error_model.optimal_work <= _min_work(
            trials, other.error_model
        ):
            return other
    try:
        if failure is None:
            error_model, reasons = select_model(trials, finer, fixed_steps)
    except (StepError, PlanError) as error:
        failure = error
    is_long = (
        error_model is None
        or error_model.optimal_excess > 1.0
        or error_model.optimal_work > BASE_BUDGET
    )
    if is_free and is_long:
        for method in _applicable(trials, LAST):
            _, last, against = _attempt_method(trials, method, finer)
            why += against
            other = last or other
    if failure is not None and other is None:
        raise failure.with_causes(why) if isinstance(failure, PlanError) else failure
    if error_model is None:
        assert other is not None
        return other
    explicit = None
    if is_free and trials.t_end is not None:
        explicit = select_explicit(trials, error_model)
    if explicit is not None:
        trials, error_model = explicit
        reasons = [
            *reasons,
            "explicit steps take less work, because this mesh needs no shorter ones for stability",
        ]
    if other is not None and (
        error_model.optimal_excess > 1.0
        or other.error_model.optimal_work < error_model.optimal_work
    ):
        return other
    return Selection(trials, error_model, (*why, *reasons))


def _attempt_method(
    trials: TrialRuns, method: SolutionMethod, finer: Scene | None
) -> tuple[TrialRuns, Selection | None, list[str]]:
    """Return trial runs by a method, the selection if it meets the goals, and reasons against it.

    Where only modes are missing, the same with more modes.
    """
    against: list[str] = []
    richer: SolutionMethod | None = method
    while richer is not None:
        method, richer = richer, None
        attempt = replace(trials.with_integrator(method), base=method.min_intervals)
        try:
            reason, lacks_modes = _reason_against(attempt)
            if not reason:
                result, reasons = select_model(attempt, finer, None)
                excess = result.optimal_excess
                if excess <= 1.0:
                    selection = Selection(attempt, result, (method.reason, *reasons))
                    return attempt, selection, against
                errors = result.errors(*result.optimum())
                reason = _describe_excess(method, errors, result.tolerances, excess)
                lacks_modes = _is_met_without_modes(errors, result.tolerances)
            against.append(reason)
            richer = method.richer() if lacks_modes else None
        except AncfError as error:
            against.append(f"{method} is not possible: {error}")
    return attempt, None, against


def _resolve_loads(trials: TrialRuns, fixed_steps: int | None) -> TrialRuns:
    """Return trial runs whose longest steps resolve loads and prescribed motions."""
    if trials.t_end is None or fixed_steps is not None:
        return trials
    system = _coarse_system(trials)
    if system is None:
        return trials
    steps = steps_resolving_loads(system, trials.t_end, trials.base)
    check_signals(system, trials.t_end, steps)
    order = 1 if jumps_inside_steps(system, trials.t_end, steps // 2) else trials.max_step_order
    return replace(trials, base=steps, max_step_order=order)


def _resolve_vibrations(trials: TrialRuns, equilibria: TrialRuns) -> TrialRuns:
    """Return trial runs whose longest steps resolve vibrations that equilibria lack.

    Steps longer than the period of a vibration damp most of it, even an undamped one, and longer
    and shorter steps agree on the rest.
    """
    trial = next((each for each in equilibria.done.values() if each is not None), None)
    method, t_end = equilibria.integrator, trials.t_end
    if trial is None or t_end is None or not isinstance(method, Statics):
        return trials
    effects = _neglected_by_method(equilibria, trial.run)
    pairs = zip(effects, absolute_tolerances(trials.goals, trial), strict=True)
    if all(sum(each.values()) <= VIBRATION_FRACTION * tolerance for each, tolerance in pairs):
        return trials
    steps = steps_resolving_vibration(lowest_frequency(trial.run), t_end, trials.base)
    return replace(trials, base=steps)


def select_model(
    trials: TrialRuns, finer: Scene | None, fixed_steps: int | None
) -> tuple[ErrorModel, list[str]]:
    """Select the elements of beams with automatic ones, with trial runs."""
    names = open_beams(trials.scene)
    if names:
        return _select_with_rigid_links(trials, finer, fixed_steps, names)
    error_model = search(trials, Model(), finer, fixed_steps)
    if not open_bodies(trials.scene) and not isinstance(trials.integrator, SolutionMethod):
        return error_model, []
    effects = estimate_effects(trials, error_model.reference_run, error_model.coarse_run)
    errors = effects.only(METHOD_EFFECTS)
    return error_model.with_effects(errors), _describe_given_elements(trials, effects)


def _select_with_rigid_links(
    trials: TrialRuns, finer: Scene | None, fixed_steps: int | None, names: Sequence[str]
) -> tuple[ErrorModel, list[str]]:
    """Select rigid beams, and the elements of the others."""
    rods = select_rigid_links(trials)
    if not rods.elements:
        return select_elements(trials, finer, fixed_steps)
    why = [
        f"{' and '.join(rods.elements)} may be rigid: deflections are predicted to change the "
        f"{goal.quantity.name} by {effects['flexibility']:.1e} {goal.quantity.unit}".rstrip()
        for goal, effects in zip(trials.goals, rods.effects, strict=True)
    ]
    try:
        if len(rods.elements) < len(names):
            error_model, more = select_elements(trials, finer, fixed_steps, rods.elements)
        else:
            error_model, more = search(trials, Model(rods.elements), finer, fixed_steps), []
    except (StepError, PlanError):
        return select_elements(trials, finer, fixed_steps)
    own = error_model.effects or ({},) * len(rods.effects)
    return error_model.with_effects(Effects(own) + rods.effects), why + more


def _applicable(
    trials: TrialRuns, methods: Sequence[type[SolutionMethod]]
) -> Iterator[SolutionMethod]:
    """Yield the methods that may apply."""
    if trials.t_end is None:
        return
    system = _coarse_system(trials)
    if system is None:
        return
    goals = [replace(each, quantity=each.quantity.in_scene(system.scene)) for each in trials.goals]
    for each in methods:
        try:
            method = each.fit(system, trials.t_end, goals, trials.start)
        except AncfError:  # time integration reports errors of the scene
            continue
        if method is not None:
            yield method


def _is_met_without_modes(
    errors: Sequence[Mapping[str, float]], tolerances: Sequence[float]
) -> bool:
    """Return True if tolerances would be met without the error by the modes left out."""
    return all(
        sum(each.values()) - each.get("modes", 0.0) <= tolerance
        for each, tolerance in zip(errors, tolerances, strict=True)
    )


def _coarse_system(trials: TrialRuns) -> System | None:
    """Return the system of cables, or thick beams, on the mesh of the first trial run."""
    return use_admitted(trials, trials.first[0], trials.system_of)


def _neglected_by_method(trials: TrialRuns, run: Trajectory) -> list[dict[str, float]]:
    """Return the errors of a method in a run by effect, for every quantity [its unit]."""
    method, scene = trials.integrator, run.system.scene
    assert isinstance(method, SolutionMethod)
    return [method.neglected(run, each.quantity.in_scene(scene)) for each in trials.goals]


def _reason_against(trials: TrialRuns) -> tuple[str, bool]:
    """Return a sentence on the error of a method on a coarse mesh, and True if modes are missing.

    The sentence is empty if tolerances are met.
    """
    method = trials.integrator
    assert isinstance(method, SolutionMethod)
    n_longest = coarse_count(trials.scene, COARSEST_COUNT)
    trial = use_admitted(trials, n_longest, lambda model: trials.run(model, trials.base))
    if trial is None:
        return "", False
    tolerances = absolute_tolerances(trials.goals, trial)
    errors = _neglected_by_method(trials, trial.run)
    pairs = zip(errors, tolerances, strict=True)
    excess = max(sum(each.values()) / tolerance for each, tolerance in pairs)
    if excess <= 1.0:
        return "", False
    sentence = _describe_excess(method, errors, tolerances, excess)
    return sentence, _is_met_without_modes(errors, tolerances)


def _describe_excess(
    method: SolutionMethod,
    errors: Sequence[Mapping[str, float]],
    tolerances: Sequence[float],
    excess: float,
) -> str:
    """Return a sentence on the error by which a method misses a tolerance."""
    worst = max(zip(errors, tolerances, strict=True), key=lambda x: sum(x[0].values()) / x[1])[0]
    largest = max(worst, key=lambda name: worst[name])
    if not np.isfinite(excess):
        return (
            f"{method} is not applicable: {SOURCE_NAMES[largest]} has no bound, because the "
            "equilibrium path ends or becomes unstable"
        )
    return (
        f"{method} would exceed the tolerance by a factor of {excess:.2g}, mostly by "
        f"{SOURCE_NAMES[largest]}"
    )


def _min_work(trials: TrialRuns, error_model: ErrorModel) -> float:
    """Return the least work of time integration with two trial runs, by the longest steps.

    One such trial is run on the coarsest mesh; time integration needs it anyway.
    """
    n_coarse = coarse_count(trials.scene, COARSEST_COUNT)
    model = trials.with_mesh(error_model.model, n_coarse)
    trial = trials.run(model, trials.base)
    if trial is None:  # shorter steps take more work
        trial = trials.run(model, 2 * trials.base)
    if trial is None:
        return float("inf")
    n_longest, _ = error_model.optimum()
    per_coordinate = trial.cost.unit_work * trial.steps
    coordinates = error_model.coordinates(n_longest) + (1.0 + RUN_GROWTH) * trial.cost.coordinates
    return per_coordinate * coordinates


def _describe_given_elements(trials: TrialRuns, effects: Effects) -> list[str]:
    """Return sentences on the modelling errors of specified elements, which add to the errors."""
    out = []
    for goal, each in zip(trials.goals, effects, strict=True):
        of_elements = each.keys() - METHOD_EFFECTS
        parts = ", ".join(
            f"{name} {value:.1e}" for name, value in each.items() if name in of_elements and value
        )
        if parts:
            out.append(
                f"element given: for the {goal.quantity.name} it neglects about {parts} "
                f"{goal.quantity.unit}".rstrip()
                + ", in addition to the errors of mesh and steps (stretch: difference between "
                "converged elements)"
            )
    return out
