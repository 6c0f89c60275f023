"""Pilot runs of one model, until its errors can be predicted for every mesh and step."""

from __future__ import annotations

from dataclasses import replace

from ancfsparse.errors import PlanError
from ancfsparse.plans.discretization_error.error_model import Found
from ancfsparse.plans.discretization_error.low_regularity import rugged
from ancfsparse.plans.discretization_error.mesh_error import (
    COARSEST,
    GROWTH,
    MeshError,
    given_error,
    mesh_error,
)
from ancfsparse.plans.discretization_error.mesh_grading import grades
from ancfsparse.plans.discretization_error.sampling_error import between
from ancfsparse.plans.discretization_error.simultaneous_refinement import beside, ladder
from ancfsparse.plans.discretization_error.time_error import TimeError, no_time_error, time_error
from ancfsparse.plans.models.model import Model, coarsest, order_of, spread, undecided
from ancfsparse.plans.trial_runs import cost_model
from ancfsparse.plans.trial_runs.solution_methods import Way
from ancfsparse.plans.trial_runs.trial_runs import FREE, SHARE, Pilot, Pilots, tolerances
from ancfsparse.scene import Scene

# The coarsest mesh may be refined so many times if shorter steps do not converge on it.
MOST_COARSE = 4.0
# Meshes are compared at steps whose own error is at most so many times the one asked for.
STEADY = 3.0
# Nodes are spread otherwise where the mesh needs so many times as many elements; and where no more
# pilots would be made, if at least this work is saved, a few times what the set-up of two takes.
PAYING, LEAST_SAVED = 1.5, 2e6
# Pilots, in those of the last, that lead to graded meshes.
BEFORE_GRADED = 4.0


def search(
    pilots: Pilots,
    model: Model,
    finer: Scene | None,
    fixed_steps: int | None,
    near: Found | None = None,
) -> Found:
    """Run pilots of one model until its errors can be predicted.

    Parameters
    ----------
    pilots : Pilots
        Runs.
    model : Model
        The elements of all beams whose element is open.
    finer : Scene or None
        The scene with every given mesh twice as fine; None if none was given.
    fixed_steps : int or None
        Number of steps if the step was given.
    near : Found, optional
        What pilots of other elements have shown, whose steps err about as much.

    Raises
    ------
    StepError
        If no step is short enough.
    PlanError
        If the motions do not approach each other.
    """
    if _is_open(pilots, model, finer, fixed_steps):
        short = _shortest(pilots, model, _order(pilots.scene, model), near)
        if short is not None:
            return short
    try:
        return thorough(pilots, model, finer, fixed_steps)
    except PlanError as failure:
        if pilots.t_end is None or isinstance(pilots.integrator, Way):
            raise
        return rugged(pilots, model, finer, fixed_steps, _order(pilots.scene, model), failure)


def thorough(pilots: Pilots, model: Model, finer: Scene | None, fixed_steps: int | None) -> Found:
    """Refine steps until their order has shown, and meshes until theirs has; see `search`."""
    order = _order(pilots.scene, model)
    finest, coarse, time = _coarse(pilots, model)
    steps = _steady(pilots, time)

    def affordable(last: Pilot) -> bool:
        """Whether a finer pilot costs little beside the run that is planned."""
        return pilots.spent < max(FREE, SHARE * last.cost.amount * time.runs[-1].steps / steps)

    given = (0.0,) * len(pilots.wanted)

    def found(mesh: MeshError | None) -> Found:
        """Return what pilots on several meshes have shown."""
        last = mesh.runs[-1] if mesh else time.runs[-1]
        own = model if mesh is None else replace(model, grades=last.model.grades)
        asked = tuple(tolerances(pilots.wanted, last))
        cost = cost_model.model(pilots.costs)
        base = pilots.base if pilots.t_end is not None else 1
        return Found(own, time, mesh, given, asked, cost, fixed_steps, base=base, order=order)

    def graded(mesh: MeshError, done: bool) -> Model | None:
        """Return graded meshes where they take less work with two pilots, in place of the next."""
        last = mesh.runs[-1]
        spread_, gain = grades(pilots.scene, last)
        if gain < PAYING:
            return None
        planned = found(mesh)
        work = planned.work(*planned.choice())
        more = 1.0 + 1.0 / GROWTH - (0.0 if done else GROWTH)
        saved = work * (1.0 - 1.0 / gain) - more * last.cost.amount
        pays = saved > (LEAST_SAVED if done else 0.0)
        return replace(last.model, grades=spread_) if pays else None

    if finer is not None:
        given = tuple(given_error(pilots, finer, coarse, steps, order))
    is_open = bool(coarse.counts)
    args = finest, steps, order, affordable, graded
    return found(mesh_error(pilots, coarse, *args) if is_open else None)


def _is_open(pilots: Pilots, model: Model, finer: Scene | None, fixed_steps: int | None) -> bool:
    """Whether mesh and steps of a motion may both be refined."""
    counts = model.with_counts(spread(pilots.scene, COARSEST)).counts
    marches = pilots.t_end is not None and not isinstance(pilots.integrator, Way)
    return marches and bool(counts) and finer is None and fixed_steps is None


def _shortest(pilots: Pilots, model: Model, order: int, near: Found | None) -> Found | None:
    """Refine mesh and steps together; None where that shows too little."""
    assert not isinstance(pilots.integrator, Way)
    found = None
    if near is not None and near.judge.model.counts:
        found = beside(pilots, model, order, near.time, near.judge)
    if found is None:
        found = ladder(pilots, model, order, pilots.integrator.order)
    if found is None:
        return None
    last = found.mesh.runs[-1]
    asked = tuple(tolerances(pilots.wanted, last))
    cost = cost_model.model([run.cost for run in found.runs])
    chosen = None if found.pair is None else (float(max(last.model.counts.values())), last.steps)
    none = (0.0,) * len(asked)
    made = Found(model, found.time, found.mesh, none, asked, cost, None, chosen=chosen,
                 base=pilots.base, pair=found.pair, is_short=True)  # fmt: skip
    return None if chosen is None and _is_uneven(pilots, made) else made


def _is_uneven(pilots: Pilots, found: Found) -> bool:
    """Whether graded meshes would take so much less work that they pay for pilots of their own."""
    last = found.judge
    _, gain = grades(pilots.scene, last)
    saved = found.work(*found.choice()) * (1.0 - 1.0 / gain)
    return gain >= PAYING and saved > LEAST_SAVED + BEFORE_GRADED * last.cost.amount


def _coarse(pilots: Pilots, model: Model) -> tuple[float, Model, TimeError]:
    """Find the errors of steps, on the coarsest mesh on which shorter steps converge."""
    finest = first = coarsest(pilots.scene, COARSEST)
    if pilots.t_end is None:
        coarse = model.with_counts(spread(pilots.scene, finest))
        return finest, coarse, no_time_error(pilots, coarse)
    if isinstance(pilots.integrator, Way):
        coarse = model.with_counts(spread(pilots.scene, finest))
        return finest, coarse, between(pilots, coarse)
    while True:
        coarse = model.with_counts(spread(pilots.scene, finest))
        is_last = not coarse.counts or finest >= first * MOST_COARSE
        try:
            return finest, coarse, time_error(pilots, coarse, pilots.integrator.order, not is_last)
        except PlanError:
            if is_last:
                raise
        finest *= 2.0


def _steady(pilots: Pilots, time: TimeError) -> int:
    """Return the fewest steps at which meshes can be compared: their own error is not too large."""
    asked = tolerances(pilots.wanted, time.runs[-1])
    for run in time.runs[:-1]:
        errors = [each.at(run.steps) for each in time.estimates]
        if all(e <= STEADY * most for e, most in zip(errors, asked, strict=True)):
            return run.steps
    return time.runs[-1].steps


def _order(scene: Scene, model: Model) -> int:
    """Return the lowest order of all elements."""
    own = {beam.name for beam in undecided(scene) if "element" in beam.automatic}
    orders = [rung.order for rung in model.rungs.values()]
    orders += [
        order_of(body.element if not body.kind.package else None)
        for body in scene.beams
        if body.name not in own
    ]
    return min(orders, default=4)
