"""Selection of elements: as rich as the goals require, and cheaper where that suffices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ancfsparse.errors import InputError, LoadError, PlanError, StepError
from ancfsparse.kernels.catalog import ElementChoice
from ancfsparse.plans.discretization_error.error_model import ErrorModel
from ancfsparse.plans.model_error.effects import (
    METHOD_EFFECTS,
    NEGLIGIBLE_FRACTION,
    Effects,
    largest_negligible_set,
)
from ancfsparse.plans.selection.discretization_search import search
from ancfsparse.plans.selection.element_hierarchy import (
    CABLE,
    STRING,
    beams_rejecting,
    candidates,
    model_of,
    open_beams,
)
from ancfsparse.plans.selection.element_per_beam import (
    divide_among_beams,
    estimate_bending,
    estimate_effects,
)
from ancfsparse.plans.trial_runs.trial_runs import BASE_BUDGET, TrialRuns
from ancfsparse.scene import Scene


def select_elements(
    trials: TrialRuns,
    finer: Scene | None,
    fixed_steps: int | None,
    fixed: Mapping[str, ElementChoice] | None = None,
) -> tuple[ErrorModel, list[str]]:
    """Select the elements of all beams with automatic ones, with trial runs.

    All get the cheapest element that suffices for most of them; single beams get another one if
    they reject it, need a richer one, or may be strings.  Beams in `fixed` were selected before;
    other arguments as in `search`.

    Returns
    -------
    ErrorModel
        Of the selected elements, with their modelling errors.
    list of str
        Reasons, in sentences.

    Raises
    ------
    InputError
        If the scene admits no element.
    """
    fixed, scene = dict(fixed or {}), trials.scene
    richer = [CABLE]
    rejected: dict[str, str] = {}
    if beams_rejecting(trials, CABLE, CABLE, fixed):
        fixed, richer, rejected = _elements_without_cables(trials, fixed)
    # The modelling error of a thick beam is not estimated, so without cables the richest is used.
    first = CABLE if CABLE in richer else richer[-1]
    error_model = search(trials, model_of(scene, first, fixed), finer, fixed_steps)
    effects = estimate_effects(trials, error_model.reference_run, error_model.coarse_run)
    reachable = list(map(max, error_model.tolerances, effects.floors))
    if richer == [CABLE] and not effects.only(CABLE.neglects).is_negligible(reachable):
        elements, rejected = candidates(trials, fixed)
        richer = [element for element in elements if element != STRING]
    element = cheapest_sufficient(richer[richer.index(first) :], effects, reachable)
    why = _reasons(first, element, effects, error_model.tolerances, trials)
    why += [f"{name} is not possible: {reason}" for name, reason in rejected.items()]
    neglected = effects.only(element.neglects)
    if element != first:
        names = open_beams(scene, fixed)
        of_beams = divide_among_beams(
            error_model.reference_run, names, effects.only(first.neglects)
        )
        kept, of_kept = largest_negligible_set(of_beams, reachable)
        fixed |= {name: element for name in names if name not in kept}
        error_model = search(trials, model_of(scene, first, fixed), finer, fixed_steps, error_model)
        if kept:
            why.append(f"{' and '.join(kept)} may remain {first}")
            neglected = of_kept
    strings = None
    if first == CABLE:
        strings = _try_strings(trials, error_model, finer, fixed_steps, fixed)
    if strings is not None and _rank(strings) < _rank(error_model):
        of = [name for name, each in strings.model.elements.items() if each == STRING]
        some = "" if len(of) == len(strings.model.elements) else f" for {' and '.join(of)}"
        sentence = (
            "neglecting bending changes the result by less than the tolerance, so string "
            f"elements suffice{some}"
        )
        return strings, [sentence, *(why if some else why[1:])]
    if strings is not None and _rank(strings)[0] <= 1.0:
        ratio = _rank(strings)[1] / _rank(error_model)[1]
        why.append(f"strings would suffice too, but take {ratio:.2g} times the work: more elements")
    return _add_effects(error_model, effects, neglected), why


def cheapest_sufficient(
    elements: Sequence[ElementChoice], effects: Effects, tolerances: Sequence[float]
) -> ElementChoice:
    """Return the cheapest of several elements with negligible modelling errors, or the richest."""
    sufficient = (e for e in elements if effects.only(e.neglects).is_negligible(tolerances))
    return next(sufficient, elements[-1])


def _add_effects(error_model: ErrorModel, effects: Effects, neglected: Effects) -> ErrorModel:
    """Return an error model with neglected effects, method errors included."""
    own = replace(error_model, floors=effects.floors)
    return own.with_effects(neglected + effects.only(METHOD_EFFECTS))


def _elements_without_cables(
    trials: TrialRuns, fixed: dict[str, ElementChoice]
) -> tuple[dict[str, ElementChoice], list[ElementChoice], dict[str, str]]:
    """Return the elements of beams that reject cables, and the candidates for all others.

    With the reasons for rejection.
    """
    elements, rejected = candidates(trials, fixed)
    if elements and elements[-1] != STRING:
        stiff = beams_rejecting(trials, CABLE, elements[-1], fixed)
        if 0 < len(stiff) < len(open_beams(trials.scene, fixed)):
            fixed = fixed | dict.fromkeys(stiff, elements[-1])
            elements, _ = candidates(trials, fixed)
    if not elements:
        raise InputError(f"no element suits the scene: {next(iter(rejected.values()))}")
    return fixed, [element for element in elements if element != STRING] or elements, rejected


def _try_strings(
    trials: TrialRuns,
    cables: ErrorModel,
    finer: Scene | None,
    fixed_steps: int | None,
    fixed: Mapping[str, ElementChoice],
) -> ErrorModel | None:
    """Return the error model of strings; None if bending matters.

    If not all beams can be strings, some of them may be.
    """
    # Strings are not tried if a short run of cables already meets the tolerances.
    is_done = cables.selected is not None and cables.excess(*cables.selected) <= 1.0
    if is_done and cables.optimal_work <= BASE_BUDGET:
        return None
    run, tolerances = cables.reference_run, cables.tolerances
    stiff = beams_rejecting(trials, STRING, CABLE, fixed)
    able = [name for name in open_beams(trials.scene, fixed) if name not in stiff]
    is_all = able and not stiff
    if not is_all or not estimate_bending(trials, run, able).is_negligible(tolerances):
        of_beams = {name: estimate_bending(trials, run, [name]) for name in able}
        able, _ = largest_negligible_set(of_beams, tolerances)
    if not able:
        return None
    model = model_of(trials.scene, CABLE, {**fixed, **dict.fromkeys(able, STRING)})
    try:
        strings = search(trials, model, finer, fixed_steps, cables)
    except (StepError, PlanError, InputError, LoadError):
        return None  # cables suffice
    effects = estimate_effects(trials, strings.reference_run)
    neglected = effects.only(STRING.neglects)
    if not neglected.is_negligible(strings.tolerances):
        return None
    return _add_effects(strings, effects, neglected)


def _rank(error_model: ErrorModel) -> tuple[float, float]:
    """Return the ratio of error to tolerance of the best resolution, at least 1, and its work."""
    return max(1.0, error_model.optimal_excess), error_model.optimal_work


def _reasons(
    first: ElementChoice,
    element: ElementChoice,
    effects: Effects,
    tolerances: Sequence[float],
    trials: TrialRuns,
) -> list[str]:
    """Return the reasons for the selected element, in sentences."""
    if first != CABLE:
        return [f"{first} is the richest element that the scene admits"] * len(trials.goals)
    out = []
    neglected = effects.only(first.neglects)
    columns = zip(neglected, tolerances, effects.floors, trials.goals, strict=True)
    for errors, tolerance, floor, goal in columns:
        name, unit, error = goal.quantity.name, goal.quantity.unit, sum(errors.values())
        parts = ", ".join(f"{effect} {value:.1e}" for effect, value in errors.items())
        limit = NEGLIGIBLE_FRACTION * max(tolerance, floor)
        if element == first:
            enough = "sufficient" if error <= tolerance else "as good as converged elements agree"
            effect = f"neglects {parts} {unit}" if parts else "neglects nothing"
            out.append(f"{first} is {enough} for the {name}: it {effect}".rstrip())
        elif error > limit:
            out.append(
                f"{first} is not sufficient for the {name}: it neglects {parts} {unit}, of which "
                f"at most {limit:.1e} is acceptable, so {element} is used"
            )
    return out
