"""The ladder of elements: what each neglects, and which one a quantity needs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from ancfsparse.errors import InputError, LoadError
from ancfsparse.plans.model_error.neglected_energies import bending_effect, neglected_effects
from ancfsparse.plans.models.model import (
    FEWEST_ELEMENTS,
    Model,
    Rung,
    built,
    coarsest,
    spread,
    undecided,
)
from ancfsparse.plans.trial_runs.solution_methods import Way
from ancfsparse.plans.trial_runs.trial_runs import Pilot, Pilots, tolerances
from ancfsparse.results import Trajectory
from ancfsparse.scene import ElasticBody, Scene

STRING = Rung("string", {}, 2)
CABLE = Rung("thin", {}, 4)
TWISTED = Rung("thick", {"section_strain": "nodal"}, 2)
SHEARED = Rung("thick", {"curvature": "section", "section_strain": "nodal"}, 2)
LADDER = (STRING, CABLE, TWISTED, SHEARED)
"""From the cheapest to the richest."""

# What no richer element includes: converged elements differ by how their bending depends on it, so
# no choice of elements can promise less.
FLOOR = "stretch"
# What every element leaves out where the motion is not marched.
OF_WAYS = frozenset({"inertia", "nonlinearity", "modes", "flexibility"})
NAMES = {
    "mesh": "mesh",
    "time": "steps",
    "mesh and steps": "mesh and the steps",
    "solver": "solver",
    "shear": "neglected shear",
    "torsion": "neglected torsion",
    "rotary inertia": "neglected rotary inertia",
    "bending": "neglected bending",
    "inertia": "neglected inertia",
    "nonlinearity": "forces that are not linear",
    "flexibility": "flexibility of rigid rods",
    "modes": "modes that are left out",
}
"""Sources of errors, as sentences name them."""
# Effects below this share of the error asked for are neglected: short steps and fine meshes for the
# rest take less work than richer elements.
NEGLIGIBLE = 0.5


def neglects(rung: Rung) -> frozenset[str]:
    """Return the effects that an element leaves out."""
    cable = frozenset({"shear", "torsion", "rotary inertia"})
    if rung == SHEARED:
        return frozenset()
    if rung == TWISTED:
        return frozenset({"shear"})
    return cable | {"bending"} if rung == STRING else cable


def open_beams(scene: Scene) -> list[str]:
    """Return the names of the beams whose element is open."""
    return [beam.name for beam in undecided(scene) if "element" in beam.automatic]


def model_of(scene: Scene, rung: Rung, fixed: Mapping[str, Rung] | None = None) -> Model:
    """Return a model with one element for all beams whose own is open, but those that are fixed."""
    return Model(rungs=dict.fromkeys(open_beams(scene), rung) | dict(fixed or {}))


def candidates(
    scene: Scene,
    fixed: Mapping[str, Rung] | None = None,
    build: Callable[[Model], Scene] | None = None,
    finest: float | None = None,
) -> tuple[list[Rung], dict[str, str]]:
    """Return the elements that a scene takes, and why others are refused.

    Parameters
    ----------
    scene : Scene
        The scene.
    fixed : mapping of str to Rung, optional
        Elements of beams that were chosen before.
    build : callable, optional
        Returns the scene with a model, such as `Pilots.built`, which builds none twice.
    finest : float, optional
        Elements on the longest beam of the mesh that is built.

    Returns
    -------
    list of Rung
        From the cheapest to the richest.
    dict of str to str
        Sentences by the name of the element.
    """
    taken, refused = [], {}
    build = build or partial(built, scene)
    counts = spread(scene, finest or coarsest(scene, FEWEST_ELEMENTS))
    for rung in LADDER:
        try:
            build(model_of(scene, rung, fixed).with_counts(counts))
        except (InputError, LoadError) as error:
            refused[str(rung)] = str(error)
        else:
            taken.append(rung)
    return taken, refused


def effects_of(pilots: Pilots, pilot: Pilot, rough: Pilot | None = None) -> list[dict[str, float]]:
    """Estimate what the model of a pilot neglects, for every quantity [its unit].

    Parameters
    ----------
    pilots : Pilots
        Runs.
    pilot : Pilot
        One of them.
    rough : Pilot, optional
        A cheaper one, of which more runs measure how quantities respond to compliance and density,
        where that may matter.
    """
    scene = pilot.run.system.scene
    march = None if rough is None else _marching(pilots, rough)
    out = []
    for each, most in zip(pilots.wanted, tolerances(pilots.wanted, pilot), strict=True):
        quantity, base = each.quantity.on(scene), None
        if rough is not None:
            base = rough.run, each.quantity.on(rough.run.system.scene)
        neglected = neglected_effects(scene, pilot.run, quantity, march, NEGLIGIBLE * most, base)
        if isinstance(pilots.integrator, Way):
            neglected |= pilots.integrator.neglected(pilot.run, quantity)
        out.append(neglected)
    return out


def _marching(pilots: Pilots, rough: Pilot) -> Callable[[Scene], Trajectory]:
    """Return what runs changed scenes as a pilot was run."""
    runs = pilots.with_integrator(rough.integrator)
    return lambda changed: runs.march(changed, rough.steps, coarser=rough.run, solver=rough.solver)


def bending_of(pilots: Pilots, pilot: Pilot) -> list[dict[str, float]]:
    """Estimate what strings would neglect, from a run with bending, for every quantity."""
    scene, own = pilot.run.system.scene, pilot.model.rungs
    bodies = [b for b in scene.beams if b.name in own and isinstance(b, ElasticBody)]
    wanted = (each.quantity.on(scene) for each in pilots.wanted)
    return [{"bending": bending_effect(pilot.run, bodies, each)} for each in wanted]


def needed(
    rungs: Sequence[Rung], first: Rung, effects: Sequence[Mapping[str, float]],
    asked: Sequence[float],
) -> Rung:  # fmt: skip
    """Return the cheapest element whose neglected effects are negligible.

    Parameters
    ----------
    rungs : sequence of Rung
        From the cheapest to the richest.
    first : Rung
        The element that effects were estimated with.
    effects : sequence of mapping
        What it neglects, for every quantity [its unit].
    asked : sequence of float
        Largest error of every quantity that elements are to leave, see `within_reach` [its unit].
    """
    richer = rungs[list(rungs).index(first) :]
    return next((rung for rung in richer if is_enough(rung, effects, asked)), richer[-1])


def is_enough(rung: Rung, effects: Sequence[Mapping[str, float]], asked: Sequence[float]) -> bool:
    """Whether what an element neglects is negligible, for every quantity."""
    return all(
        sum(left_out(each, rung).values()) < NEGLIGIBLE * most or not left_out(each, rung)
        for each, most in zip(effects, asked, strict=True)
    )


def floors(effects: Sequence[Mapping[str, float]]) -> tuple[float, ...]:
    """Return by how much converged elements differ in every quantity [its unit]."""
    return tuple(each.get(FLOOR, 0.0) for each in effects)


def within_reach(effects: Sequence[Mapping[str, float]], asked: Sequence[float]) -> list[float]:
    """Return the errors that elements are chosen for: those asked for, or what none falls below."""
    return [max(pair) for pair in zip(asked, floors(effects), strict=True)]


def left_out(effects: Mapping[str, float], rung: Rung) -> dict[str, float]:
    """Return the effects that an element leaves out, and not what only other measures change."""
    return {name: value for name, value in effects.items() if name in neglects(rung)}


def of_way(effects: Mapping[str, float]) -> dict[str, float]:
    """Return the effects that are left out where the motion is not marched."""
    return {name: value for name, value in effects.items() if name in OF_WAYS}
