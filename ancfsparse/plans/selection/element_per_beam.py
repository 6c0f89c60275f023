"""Elements of single beams: beams that reject an element, and beams that may keep a cheaper one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from ancfsparse.errors import InputError, LoadError
from ancfsparse.plans.model_error.neglected_energies import bending_effect
from ancfsparse.plans.model_error.section_energies import (
    loaded_nodes,
    rotary_energy,
    section_energies,
    torsion_energy,
)
from ancfsparse.plans.models.model import (
    MIN_LONGEST_COUNT,
    ElementChoice,
    Model,
    build_model,
    coarse_count,
    element_counts,
)
from ancfsparse.plans.selection.element_hierarchy import (
    effects_neglected,
    largest_negligible_set,
    model_of,
    open_beams,
)
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns
from ancfsparse.scene import ElasticBody, Scene

MAX_BEAMS = 64  # that are tried one by one
SPATIAL = 3


def beams_rejecting(
    scene: Scene,
    element: ElementChoice,
    other: ElementChoice,
    fixed: Mapping[str, ElementChoice] | None = None,
    build: Callable[[Model], Scene] | None = None,
    n_longest: float | None = None,
) -> list[str]:
    """Return the automatic beams that reject an element while the others have another one.

    The scene must admit the other element; `fixed`, `build` and `n_longest` as in `candidates`.
    """
    fixed, build = dict(fixed or {}), build or partial(build_model, scene)
    names = [name for name in open_beams(scene) if name not in fixed]
    counts = element_counts(scene, n_longest or coarse_count(scene, MIN_LONGEST_COUNT))
    if _is_admitted(build, model_of(scene, element, fixed).with_counts(counts)):
        return []
    if not 1 < len(names) <= MAX_BEAMS:
        return names
    return [
        name
        for name in names
        if not _is_admitted(
            build, model_of(scene, other, {**fixed, name: element}).with_counts(counts)
        )
    ]


def _is_admitted(build: Callable[[Model], Scene], model: Model) -> bool:
    """Return True if a scene admits a model."""
    try:
        build(model)
    except (InputError, LoadError):
        return False
    return True


def beams_kept_as_cables(
    trial: TrialRun,
    names: Sequence[str],
    effects: Sequence[Mapping[str, float]],
    element: ElementChoice,
    tolerances: Sequence[float],
) -> tuple[list[str], list[dict[str, float]]]:
    """Return the beams that may remain cables while others need richer elements, and their effects.

    From a run in which they are cables by selection, and the effects of all of them together, for
    every quantity [its unit].
    """
    fractions = _energy_fractions(trial, names)
    total = [effects_neglected(each, element) for each in effects]
    of_beams = {
        name: [{k: fractions[name].get(k, 1.0) * v for k, v in each.items()} for each in total]
        for name in names
    }
    return largest_negligible_set(of_beams, tolerances)


def _energy_fractions(trial: TrialRun, names: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return the fraction of every beam in the energies that cables neglect, by effect."""
    run = trial.run
    scene = run.system.scene
    energies: dict[str, dict[str, float]] = {}
    for name in names:
        body = scene.body(name)
        assert isinstance(body, ElasticBody)
        values = {
            "shear": section_energies(run, body).shear,
            "rotary inertia": rotary_energy(run, body),
        }
        if scene.dim == SPATIAL:
            values["torsion"] = torsion_energy(scene, run, body)
        energies[name] = {effect: float(np.max(value)) for effect, value in values.items()}
    out: dict[str, dict[str, float]] = {name: {} for name in names}
    for effect in next(iter(energies.values()), {}):
        total = sum(each[effect] for each in energies.values())
        for name in names:
            # At rest without stress, as for frequencies, the beams cannot be distinguished.
            out[name][effect] = energies[name][effect] / total if total > 0.0 else 1.0
    return out


def beams_without_bending(
    trials: TrialRuns,
    trial: TrialRun,
    names: Sequence[str],
    tolerances: Sequence[float],
    fraction: float,
) -> list[str]:
    """Return beams whose bending together changes quantities by less than a fraction of tolerances.

    From a run with cables; tolerances in the units of the quantities.
    """
    scene = trial.run.system.scene
    quantities = [each.quantity.in_scene(scene) for each in trials.goals]
    effects, loaded = {}, loaded_nodes(scene)
    for name in names:
        body = scene.body(name)
        assert isinstance(body, ElasticBody)
        effects[name] = [
            {"bending": bending_effect(trial.run, [body], q, loaded)} for q in quantities
        ]
    return largest_negligible_set(effects, tolerances, fraction)[0]
