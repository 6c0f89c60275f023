"""Selection of elements: as rich as the goals require, and cheaper where that suffices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ancfsparse.errors import InputError, LoadError, PlanError, StepError
from ancfsparse.plans.discretization_error.error_model import ErrorModel
from ancfsparse.plans.models.model import ElementChoice
from ancfsparse.plans.selection.discretization_search import search
from ancfsparse.plans.selection.element_hierarchy import (
    CABLE,
    NEGLIGIBLE_FRACTION,
    STRING,
    candidates,
    cheapest_sufficient,
    effects_neglected,
    estimate_bending,
    estimate_effects,
    floors,
    is_sufficient,
    method_effects,
    model_of,
    open_beams,
    reachable_tolerances,
)
from ancfsparse.plans.selection.element_per_beam import (
    beams_kept_as_cables,
    beams_rejecting,
    beams_without_bending,
)
from ancfsparse.plans.trial_runs.trial_runs import BASE_BUDGET, TrialRuns
from ancfsparse.scene import Scene

MAX_COARSE_RATIO = 10.0  # of the bending of coarse cables to that of fine strings


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
    fixed, richer = dict(fixed or {}), [CABLE]
    scene, coarse = trials.scene, trials.first[0]
    rejected: dict[str, str] = {}
    if beams_rejecting(scene, CABLE, CABLE, fixed, trials.build, coarse):
        fixed, richer, rejected = _elements_without_cables(trials, fixed)
    # The modelling error of a thick beam is not estimated, so without cables the richest is used.
    first = CABLE if CABLE in richer else richer[-1]
    error_model = search(trials, model_of(scene, first, fixed), finer, fixed_steps)
    effects = estimate_effects(trials, error_model.reference_run, error_model.coarse_run)
    tolerances = reachable_tolerances(effects, error_model.tolerances)
    if richer == [CABLE] and not is_sufficient(CABLE, effects, tolerances):
        elements, rejected = candidates(scene, fixed, trials.build, coarse)
        richer = [element for element in elements if element != STRING]
    element = cheapest_sufficient(richer, first, effects, tolerances)
    why = _reasons(first, element, effects, error_model.tolerances, trials)
    why += [f"{name} is not possible: {reason}" for name, reason in rejected.items()]
    names = [name for name in open_beams(scene) if name not in fixed]
    errors = [effects_neglected(each, element) for each in effects]
    if element != first:
        kept, kept_errors = beams_kept_as_cables(
            error_model.reference_run, names, effects, first, tolerances
        )
        fixed |= {name: element for name in names if name not in kept}
        model = model_of(scene, first, fixed)
        error_model = search(trials, model, finer, fixed_steps, error_model)
        if kept:
            why.append(f"{' and '.join(kept)} may remain {first}")
            names, errors = kept, kept_errors
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
            why.append(
                f"strings would suffice too, but take {ratio:.2g} times the work: more elements"
            )
    error_model = replace(error_model, floors=floors(effects))
    pairs = zip(errors, effects, strict=True)
    return error_model.with_effects([own | method_effects(each) for own, each in pairs]), why


def _elements_without_cables(
    trials: TrialRuns, fixed: dict[str, ElementChoice]
) -> tuple[dict[str, ElementChoice], list[ElementChoice], dict[str, str]]:
    """Return the elements of beams that reject cables, and the candidates for all others.

    With the reasons for rejection.
    """
    scene, coarse = trials.scene, trials.first[0]
    elements, rejected = candidates(scene, fixed, trials.build, coarse)
    if elements and elements[-1] != STRING:
        stiff = beams_rejecting(scene, CABLE, elements[-1], fixed, trials.build, coarse)
        if 0 < len(stiff) < len(open_beams(scene)) - len(fixed):
            fixed = fixed | dict.fromkeys(stiff, elements[-1])
            elements, _ = candidates(scene, fixed, trials.build, coarse)
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
    # If a run of cables already meets the tolerances, strings are tried only if they certainly do,
    # and not at all if it was short.
    is_done = cables.selected is not None and cables.excess(*cables.selected) <= 1.0
    if is_done and cables.optimal_work <= BASE_BUDGET:
        return None
    scene = trials.scene
    names = [name for name in open_beams(scene) if name not in fixed]
    stiff = beams_rejecting(scene, STRING, CABLE, fixed, trials.build, trials.first[0])
    able = [name for name in names if name not in stiff]
    if not able:
        return None
    run, tolerances = cables.reference_run, cables.tolerances
    factor = 1.0 if is_done else MAX_COARSE_RATIO
    is_all = not stiff and _is_bending_negligible(estimate_bending(trials, run), tolerances, factor)
    if not is_all and len(names) == 1:
        return None
    if not is_all:
        able = beams_without_bending(trials, run, able, tolerances, factor * NEGLIGIBLE_FRACTION)
    if not able:
        return None
    model = model_of(scene, CABLE, {**fixed, **dict.fromkeys(able, STRING)})
    try:
        error_model = search(trials, model, finer, fixed_steps, cables)
    except (StepError, PlanError, InputError, LoadError):
        return None  # cables suffice
    effects = estimate_effects(trials, error_model.reference_run)
    if not _is_bending_negligible(effects, error_model.tolerances):
        return None
    errors = [effects_neglected(each, STRING) | method_effects(each) for each in effects]
    if len(able) < len(names):
        pairs = zip(errors, error_model.tolerances, strict=True)
        if any(sum(e.values()) > NEGLIGIBLE_FRACTION * tolerance for e, tolerance in pairs):
            return None
    return replace(error_model, floors=floors(effects)).with_effects(errors)


def _is_bending_negligible(
    effects: Sequence[Mapping[str, float]], tolerances: Sequence[float], factor: float = 1.0
) -> bool:
    """Return True if bending is negligible up to a factor."""
    return all(
        each.get("bending", 0.0) <= factor * NEGLIGIBLE_FRACTION * tolerance
        for each, tolerance in zip(effects, tolerances, strict=True)
    )


def _rank(error_model: ErrorModel) -> tuple[float, float]:
    """Return the ratio of error to tolerance of the best resolution, at least 1, and its work."""
    return max(1.0, error_model.optimal_excess), error_model.optimal_work


def _reasons(
    first: ElementChoice,
    element: ElementChoice,
    effects: Sequence[Mapping[str, float]],
    tolerances: Sequence[float],
    trials: TrialRuns,
) -> list[str]:
    """Return the reasons for the selected element, in sentences."""
    out = []
    reachable = reachable_tolerances(effects, tolerances)
    columns = zip(effects, tolerances, reachable, trials.goals, strict=True)
    for each, tolerance, reached, goal in columns:
        name, unit = goal.quantity.name, goal.quantity.unit
        errors = effects_neglected(each, first)
        parts = ", ".join(f"{effect} {value:.1e}" for effect, value in errors.items())
        is_enough = sum(errors.values()) <= tolerance
        enough = "sufficient" if is_enough else "as good as converged elements agree"
        limit = NEGLIGIBLE_FRACTION * reached
        if first != CABLE:
            out.append(f"{first} is the richest element that the scene admits")
        elif element == first:
            effect = f"neglects {parts} {unit}" if parts else "neglects nothing"
            out.append(f"{first} is {enough} for the {name}: it {effect}".rstrip())
        elif sum(errors.values()) > limit:
            out.append(
                f"{first} is not sufficient for the {name}: it neglects {parts} {unit}, of which "
                f"at most {limit:.1e} is acceptable, so {element} is used"
            )
    return out
