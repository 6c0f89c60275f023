"""Selection of the beams whose bending and stretching are negligible, as rigid rods."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ancfsparse.errors import RedundantConstraintsWarning
from ancfsparse.kernels.catalog import ElementChoice
from ancfsparse.plans.discretization_error.mesh_error import COARSEST_COUNT
from ancfsparse.plans.model_error.effects import (
    NEGLIGIBLE_FRACTION,
    Effects,
    largest_negligible_set,
)
from ancfsparse.plans.model_error.rigid_link_error import (
    deflection,
    deflection_effect,
    transverse_deflection,
)
from ancfsparse.plans.models.model import RIGID, Model, coarse_count, open_bodies
from ancfsparse.plans.models.rigid_links import rigid_candidates
from ancfsparse.plans.quantities.tolerances import Goal
from ancfsparse.plans.selection.element_hierarchy import use_admitted
from ancfsparse.plans.trial_runs.run_differences import absolute_tolerances
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns
from ancfsparse.scene import Beam
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.joints.pin import Pin

FLEXIBILITY = "flexibility"


@dataclass(frozen=True)
class RigidLinks:
    """Beams that are rigid rods.

    Attributes
    ----------
    elements : mapping of str to ElementChoice
        `RIGID` for each, by its name.
    effects : Effects
        Modelling error of the rods, for every quantity [its unit].
    """

    elements: Mapping[str, ElementChoice] = field(default_factory=dict)
    effects: Effects = field(default_factory=Effects)


def select_rigid_links(trials: TrialRuns) -> RigidLinks:
    """Select rigid beams, by a trial run in which all candidates are rigid.

    There are none in an equilibrium.
    """
    if trials.t_end is None or isinstance(trials.integrator, SolutionMethod):
        return RigidLinks()
    beams = {b.name: b for b in open_bodies(trials.scene) if isinstance(b, Beam)}
    names = [
        name
        for name in rigid_candidates(trials.scene)
        if all(goal.quantity.admits_rigid(beams[name]) for goal in trials.goals)
        and not _bends_at_start(beams[name], trials)
    ]
    trial = _run_with_rods(trials, names) if names else None
    if trial is None:
        return RigidLinks()
    run, scene = trial.run, trial.run.system.scene
    effects = {}
    for name in names:
        rod = scene.body(name)
        assert isinstance(rod, RigidBody)
        deflected = deflection(run, rod, beams[name])
        quantities = (goal.quantity.in_scene(scene) for goal in trials.goals)
        effects[name] = Effects(
            {FLEXIBILITY: deflection_effect(deflected, beams[name], each, run)}
            for each in quantities
        )
    rigid, total = largest_negligible_set(effects, absolute_tolerances(trials.goals, trial))
    return RigidLinks(dict.fromkeys(rigid, RIGID), total) if rigid else RigidLinks()


def _run_with_rods(trials: TrialRuns, names: Sequence[str]) -> TrialRun | None:
    """Return a coarse run with rigid beams; None if no element admits them, or steps fail."""

    def run(model: Model) -> TrialRun | None:
        with warnings.catch_warnings():  # a beam that is overconstrained as a rod may bend
            warnings.simplefilter("error", RedundantConstraintsWarning)
            return trials.run(model, trials.base) or trials.run(model, 2 * trials.base)

    n_longest = coarse_count(trials.scene, COARSEST_COUNT)
    return use_admitted(trials, n_longest, run, dict.fromkeys(names, RIGID))


def _bends_at_start(beam: Beam, trials: TrialRuns) -> bool:
    """Return True if the weight of a pinned beam bends it too far at the start.

    The pinned end has no acceleration, so `deflection` finds no less.
    """
    scene, pins = trials.scene, (each for each in trials.scene.joints if isinstance(each, Pin))
    if trials.start is not None or not any(each.node.beam is beam for each in pins):
        return False
    along = (beam.positions[-1] - beam.positions[0]) / beam.length
    across = float(np.linalg.norm(scene.gravity - (scene.gravity @ along) * along))
    fraction = transverse_deflection(beam, across) / beam.length
    largest = min(_largest_fraction(goal, beam) for goal in trials.goals)
    return fraction > NEGLIGIBLE_FRACTION * largest


def _largest_fraction(goal: Goal, beam: Beam) -> float:
    """Return a bound of the deflection over the length of a beam within the tolerance of a goal.

    `deflection_effect` finds no less than this fraction of a quantity, or the deflection of a
    position.  A position on the beam moves by at most two of its lengths.
    """
    quantity = goal.quantity
    if quantity.is_displacement:
        is_on_beam = quantity.point is not None and quantity.point.beam is beam
        size = 2.0 if is_on_beam else np.inf
        return goal.error * size if goal.relative else goal.error / beam.length
    return goal.error if goal.relative else np.inf
