"""Elements beam by beam: which beams refuse one, and which may keep a cheaper one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from ancfsparse.errors import InputError, LoadError
from ancfsparse.plans.model_error.neglected_energies import bending_effect
from ancfsparse.plans.model_error.section_energies import energies_of, rotary_energy, torsion_energy
from ancfsparse.plans.models.model import FEWEST_ELEMENTS, Model, Rung, built, coarsest, spread
from ancfsparse.plans.selection.element_hierarchy import NEGLIGIBLE, left_out, model_of, open_beams
from ancfsparse.plans.trial_runs.trial_runs import Pilot, Pilots
from ancfsparse.scene import ElasticBody, Scene

# Beams are tried one by one up to so many.
MOST = 64
SPATIAL = 3


def refusing(
    scene: Scene,
    rung: Rung,
    other: Rung,
    fixed: Mapping[str, Rung] | None = None,
    build: Callable[[Model], Scene] | None = None,
    finest: float | None = None,
) -> list[str]:
    """Return the open beams that refuse an element while all others have another one.

    Parameters
    ----------
    scene : Scene
        The scene.
    rung, other : Rung
        The element, and one that the scene takes.
    fixed : mapping of str to Rung, optional
        Elements of beams that were chosen before.
    build, finest
        See `candidates`.
    """
    fixed, build = dict(fixed or {}), build or partial(built, scene)
    names = [name for name in open_beams(scene) if name not in fixed]
    counts = spread(scene, finest or coarsest(scene, FEWEST_ELEMENTS))
    if _takes(build, model_of(scene, rung, fixed).with_counts(counts)):
        return []
    if not 1 < len(names) <= MOST:
        return names
    alone = ({**fixed, name: rung} for name in names)
    takes = [_takes(build, model_of(scene, other, each).with_counts(counts)) for each in alone]
    return [name for name, able in zip(names, takes, strict=True) if not able]


def _takes(build: Callable[[Model], Scene], model: Model) -> bool:
    """Whether a scene takes elements."""
    try:
        build(model)
    except (InputError, LoadError):
        return False
    return True


def staying(
    pilot: Pilot, names: Sequence[str], effects: Sequence[Mapping[str, float]], rung: Rung,
    asked: Sequence[float],
) -> tuple[list[str], list[dict[str, float]]]:  # fmt: skip
    """Return the beams that may stay cables where others must not, and what that neglects.

    Parameters
    ----------
    pilot : Pilot
        A run with cables.
    names : sequence of str
        The beams that are cables by choice.
    effects : sequence of mapping
        What cables neglect altogether, for every quantity [its unit].
    rung : Rung
        What cables are.
    asked : sequence of float
        Largest error of every quantity [its unit].
    """
    shares = _shares(pilot, names)
    own = [left_out(each, rung) for each in effects]
    stay: list[str] = []
    kept: list[dict[str, float]] = [dict.fromkeys(each, 0.0) for each in own]

    def worst(name: str) -> float:
        return max(
            sum(shares[name].get(k, 1.0) * v for k, v in each.items()) / most
            for each, most in zip(own, asked, strict=True)
        )

    for name in sorted(names, key=worst):
        more = [
            {k: left[k] + shares[name].get(k, 1.0) * v for k, v in each.items()}
            for each, left in zip(own, kept, strict=True)
        ]
        if any(sum(e.values()) > NEGLIGIBLE * most for e, most in zip(more, asked, strict=True)):
            break
        stay.append(name)
        kept = more
    return stay, kept


def _shares(pilot: Pilot, names: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return the share of every beam in the energies that cables neglect, by effect."""
    run = pilot.run
    scene = run.system.scene
    energies: dict[str, dict[str, float]] = {}
    for name in names:
        body = scene.body(name)
        assert isinstance(body, ElasticBody)
        own = {
            "shear": energies_of(run, body).shear,
            "rotary inertia": rotary_energy(run, body),
        }
        if scene.dim == SPATIAL:
            own["torsion"] = torsion_energy(scene, run, body)
        energies[name] = {effect: float(np.max(values)) for effect, values in own.items()}
    out: dict[str, dict[str, float]] = {name: {} for name in names}
    for effect in next(iter(energies.values()), {}):
        total = sum(each[effect] for each in energies.values())
        for name in names:
            # At rest without stress, as for frequencies, nothing shows which beam it is.
            out[name][effect] = energies[name][effect] / total if total > 0.0 else 1.0
    return out


def limp(
    pilots: Pilots, pilot: Pilot, names: Sequence[str], asked: Sequence[float], share: float
) -> list[str]:
    """Return the beams whose bending together changes quantities by less than a share of the error.

    Parameters
    ----------
    pilots : Pilots
        Runs.
    pilot : Pilot
        One with cables.
    names : sequence of str
        The beams.
    asked : sequence of float
        Largest error of every quantity [its unit].
    share : float
        Of that error.
    """
    scene = pilot.run.system.scene
    quantities = [each.quantity.on(scene) for each in pilots.wanted]
    alone = {}
    for name in names:
        body = scene.body(name)
        assert isinstance(body, ElasticBody)
        alone[name] = [bending_effect(pilot.run, [body], each) for each in quantities]
    out, left = [], np.zeros(len(asked))
    for name in sorted(names, key=lambda name: max(np.divide(alone[name], asked))):
        left = left + alone[name]
        if (left > share * np.asarray(asked)).any():
            break
        out.append(name)
    return out
