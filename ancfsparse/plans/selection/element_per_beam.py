"""Elements of single beams: beams that reject an element, and beams that may keep a cheaper one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from ancfsparse.errors import InputError, LoadError
from ancfsparse.plans.model_error.neglected_energies import bending_effect
from ancfsparse.plans.model_error.section_energies import (
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
    NEGLIGIBLE_FRACTION,
    effects_neglected,
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

    Parameters
    ----------
    scene : Scene
        The scene.
    element, other : ElementChoice
        The element, and one that the scene admits.
    fixed : mapping of str to ElementChoice, optional
        Elements of beams that were selected before.
    build, n_longest
        See `candidates`.
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
    """Return the beams that may remain cables while others need richer elements.

    Parameters
    ----------
    trial : TrialRun
        A run with cables.
    names : sequence of str
        The beams that are cables by selection.
    effects : sequence of mapping
        Modelling errors of all cables together, for every quantity [its unit].
    element : ElementChoice
        That of cables.
    tolerances : sequence of float
        Largest error of every quantity [its unit].

    Returns
    -------
    list of str
        The beams.
    list of dict
        Modelling errors of these cables, for every quantity [its unit].
    """
    fractions = _energy_fractions(trial, names)
    total = [effects_neglected(each, element) for each in effects]
    kept: list[str] = []
    errors: list[dict[str, float]] = [dict.fromkeys(each, 0.0) for each in total]

    def excess(name: str) -> float:
        return max(
            sum(fractions[name].get(k, 1.0) * v for k, v in each.items()) / tolerance
            for each, tolerance in zip(total, tolerances, strict=True)
        )

    for name in sorted(names, key=excess):
        more = [
            {k: error[k] + fractions[name].get(k, 1.0) * v for k, v in each.items()}
            for each, error in zip(total, errors, strict=True)
        ]
        pairs = zip(more, tolerances, strict=True)
        if any(sum(e.values()) > NEGLIGIBLE_FRACTION * tolerance for e, tolerance in pairs):
            break
        kept.append(name)
        errors = more
    return kept, errors


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

    Parameters
    ----------
    trials : TrialRuns
        Runs.
    trial : TrialRun
        One with cables.
    names : sequence of str
        The beams.
    tolerances : sequence of float
        Largest error of every quantity [its unit].
    fraction : float
        Of these tolerances.
    """
    scene = trial.run.system.scene
    quantities = [each.quantity.in_scene(scene) for each in trials.goals]
    effects = {}
    for name in names:
        body = scene.body(name)
        assert isinstance(body, ElasticBody)
        effects[name] = [bending_effect(trial.run, [body], each) for each in quantities]
    out, total = [], np.zeros(len(tolerances))
    for name in sorted(names, key=lambda name: max(np.divide(effects[name], tolerances))):
        total = total + effects[name]
        if (total > fraction * np.asarray(tolerances)).any():
            break
        out.append(name)
    return out
