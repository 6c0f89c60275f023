"""Hierarchy of elements: those that a scene admits, for all beams and for single ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

from ancfsparse.errors import InputError, LoadError, RedundantConstraintsWarning
from ancfsparse.kernels.catalog import HIERARCHY, ElementChoice
from ancfsparse.plans.models.model import Model, open_bodies
from ancfsparse.plans.trial_runs.trial_runs import TrialRuns
from ancfsparse.scene import Scene

Result = TypeVar("Result")
BENDING = "bending"
STRING = next(each for each in HIERARCHY if BENDING in each.neglects)
CABLE = next(each for each in HIERARCHY if BENDING not in each.neglects)
SHEARED = HIERARCHY[-1]
MAX_BEAMS = 64  # that are tried one by one


def open_beams(scene: Scene, fixed: Mapping[str, ElementChoice] | None = None) -> list[str]:
    """Return the names of the beams with automatic elements, except fixed ones."""
    automatic = [beam.name for beam in open_bodies(scene) if "element" in beam.automatic]
    return [name for name in automatic if name not in (fixed or {})]


def model_of(
    scene: Scene, element: ElementChoice, fixed: Mapping[str, ElementChoice] | None = None
) -> Model:
    """Return a model with one element for all beams with automatic ones, except fixed beams."""
    return Model(elements=dict.fromkeys(open_beams(scene), element) | dict(fixed or {}))


def use_admitted(
    trials: TrialRuns,
    n_longest: float,
    use: Callable[[Model], Result],
    fixed: Mapping[str, ElementChoice] | None = None,
) -> Result | None:
    """Return a result with cables, or with sheared beams if a scene rejects those; None if both."""
    for element in (CABLE, SHEARED):
        try:
            return use(trials.with_mesh(model_of(trials.scene, element, fixed), n_longest))
        except (InputError, LoadError, RedundantConstraintsWarning):
            continue
    return None


def reason_against(trials: TrialRuns, model: Model) -> str:
    """Return the reason for which a scene rejects the elements of a model; empty if none."""
    try:
        trials.build(trials.with_mesh(model, trials.first[0]))
    except (InputError, LoadError) as error:
        return str(error)
    return ""


def candidates(
    trials: TrialRuns, fixed: Mapping[str, ElementChoice] | None = None
) -> tuple[list[ElementChoice], dict[str, str]]:
    """Return the elements that a scene admits, from the cheapest to the richest.

    With the reasons for rejecting others, by the name of the element.  Elements of beams in `fixed`
    were selected before.
    """
    models = ((element, model_of(trials.scene, element, fixed)) for element in HIERARCHY)
    reasons = [(element, reason_against(trials, model)) for element, model in models]
    rejected = {str(element): reason for element, reason in reasons if reason}
    return [element for element, reason in reasons if not reason], rejected


def beams_rejecting(
    trials: TrialRuns,
    element: ElementChoice,
    other: ElementChoice,
    fixed: Mapping[str, ElementChoice] | None = None,
) -> list[str]:
    """Return the automatic beams that reject an element while the others have another one.

    The scene must admit the other element; `fixed` as in `candidates`.
    """
    scene, names = trials.scene, open_beams(trials.scene, fixed)
    if not reason_against(trials, model_of(scene, element, fixed)):
        return []
    if not 1 < len(names) <= MAX_BEAMS:
        return names
    models = {name: model_of(scene, other, {**(fixed or {}), name: element}) for name in names}
    return [name for name, model in models.items() if reason_against(trials, model)]
