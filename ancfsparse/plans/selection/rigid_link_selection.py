"""Which beams of a scene are rigid rods: those whose bending and stretching do not matter."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ancfsparse.errors import InputError, RedundantConstraintsWarning
from ancfsparse.plans.discretization_error.mesh_error import COARSEST
from ancfsparse.plans.model_error.rigid_link_error import EVEN, change, deflection, under
from ancfsparse.plans.models.model import RIGID, Rung, coarsest, spread, undecided
from ancfsparse.plans.models.rigid_links import possible
from ancfsparse.plans.quantities.quantity import AtPoint, EnergyOf, Position, Velocity
from ancfsparse.plans.quantities.tolerances import Wanted
from ancfsparse.plans.selection.element_hierarchy import CABLE, NEGLIGIBLE, SHEARED, model_of
from ancfsparse.plans.trial_runs.solution_methods import Way
from ancfsparse.plans.trial_runs.trial_runs import Pilots, tolerances
from ancfsparse.scene import Beam
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.joints.pin import Pin

# Under their own weight beams may deflect so many times the error and yet be tried: they may hang.
HANGING = 100.0


@dataclass(frozen=True)
class Links:
    """Beams that are rigid rods.

    Attributes
    ----------
    rungs : mapping of str to Rung
        `RIGID` for each, by its name.
    effects : tuple of mapping of str to float
        What that neglects, for every quantity [its unit].
    """

    rungs: Mapping[str, Rung] = field(default_factory=dict)
    effects: tuple[Mapping[str, float], ...] = ()


def links(pilots: Pilots) -> Links:
    """Find the beams that may be rigid, by a pilot in which all that are stiff enough are.

    Parameters
    ----------
    pilots : Pilots
        Runs of a motion; equilibria have none.

    Returns
    -------
    Links
        Empty if none may.
    """
    if pilots.t_end is None or isinstance(pilots.integrator, Way):
        return Links()
    gravity = float(np.linalg.norm(pilots.scene.gravity))
    beams = {b.name: b for b in undecided(pilots.scene) if isinstance(b, Beam)}
    names = [
        name
        for name in possible(pilots.scene)
        if all(_may(beams[name], each, gravity) for each in pilots.wanted)
        and not _bends(beams[name], pilots)
    ]
    if not names:
        return Links()
    fixed = dict.fromkeys(names, RIGID)
    run = None
    counts = spread(pilots.scene, coarsest(pilots.scene, COARSEST))
    for rung in (CABLE, SHEARED):
        model = model_of(pilots.scene, rung, fixed).with_counts(counts)
        try:
            with warnings.catch_warnings():  # a beam that drives or joints hold as a rod may bend
                warnings.simplefilter("error", RedundantConstraintsWarning)
                run = pilots.run(model, pilots.base) or pilots.run(model, 2 * pilots.base)
            break
        except (
            InputError,
            RedundantConstraintsWarning,
        ):  # of the element, or a joint that rods lack
            continue
    if run is None:
        return Links()
    scene, asked = run.run.system.scene, tolerances(pilots.wanted, run)
    effects = {}
    for name in names:
        body = scene.body(name)
        assert isinstance(body, RigidBody)
        far = deflection(run.run, body, beams[name])
        effects[name] = [
            change(far, beams[name].length, each.quantity.on(scene), run.run)
            for each in pilots.wanted
        ]
    return _chosen(effects, asked)


def _chosen(effects: Mapping[str, Sequence[float]], asked: Sequence[float]) -> Links:
    """Return the beams whose effects together are negligible, the smallest first."""
    left, rungs = np.zeros(len(asked)), {}
    for name in sorted(effects, key=lambda name: max(np.divide(effects[name], asked))):
        more = left + effects[name]
        if (more > NEGLIGIBLE * np.asarray(asked)).any():
            break
        left, rungs[name] = more, RIGID
    found = tuple({"flexibility": float(each)} for each in left) if rungs else ()
    return Links(rungs, found)


def _may(beam: Beam, wanted: Wanted, gravity: float) -> bool:
    """Whether a beam is stiff enough to be tried, and a quantity is not of its deformation."""
    quantity = wanted.quantity
    if isinstance(quantity, EnergyOf):
        return quantity.part == "kinetic"
    own = isinstance(quantity, AtPoint) and quantity.point.beam is beam
    if own and not isinstance(quantity, Position | Velocity):
        return False
    given = {name: float(np.mean(value)) for name, value in beam.stiffnesses().items()}
    sag = EVEN * given["mass_per_length"] * gravity * beam.length**4 / given["bending_stiffness_z"]
    share = wanted.error if wanted.relative else wanted.error / beam.length
    return not isinstance(quantity, Position) or sag <= HANGING * share * beam.length


def _bends(beam: Beam, pilots: Pilots) -> bool:
    """Whether the weight of a beam that is pinned surely bends it too far, before it has moved.

    The pinned end has no acceleration, so `deflection` finds no less; and `change` finds no less
    than that share of a quantity, or of a position.  That of the beam moves by its two lengths at
    most.
    """
    scene, pins = pilots.scene, (each for each in pilots.scene.joints if isinstance(each, Pin))
    if pilots.start is not None or not any(each.node.beam is beam for each in pins):
        return False
    along = (beam.positions[-1] - beam.positions[0]) / beam.length
    across = float(np.linalg.norm(scene.gravity - (scene.gravity @ along) * along))
    share = under(beam, across) / beam.length
    for each in pilots.wanted:
        moves = isinstance(each.quantity, Position)
        own = isinstance(each.quantity, AtPoint) and each.quantity.point.beam is beam
        if each.relative and (own or not moves):
            most = each.error * (2.0 if moves else 1.0)
        elif moves and not each.relative:
            most = each.error / beam.length
        else:
            continue
        if share > NEGLIGIBLE * most:
            return True
    return False
