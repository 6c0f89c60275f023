"""`plan`: from a scene, a quantity and its error to a model, a mesh and a step."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

from ancfsparse.checks import check_choice, check_positive
from ancfsparse.errors import InputError, LoadError, PlanError
from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.integrators.interface.time_grid import count_steps_from
from ancfsparse.plans.discretization_error.error_model import Found, neighbours
from ancfsparse.plans.discretization_error.initial_singularity import check_start
from ancfsparse.plans.discretization_error.mesh_grading import described as spread_by
from ancfsparse.plans.execution.plan_data import SAVED, Alternative, Plan, Prediction, described
from ancfsparse.plans.execution.validity_range import span_of
from ancfsparse.plans.models.model import refined, spread, undecided
from ancfsparse.plans.models.planar_reduction import InPlane, planar
from ancfsparse.plans.quantities.functions import checked
from ancfsparse.plans.quantities.quantity import AtPoint, Quantity
from ancfsparse.plans.quantities.tolerances import Wanted, wanted
from ancfsparse.plans.selection.confirmation_run import confirmed
from ancfsparse.plans.selection.element_hierarchy import NAMES
from ancfsparse.plans.selection.method_selection import Chosen, choose
from ancfsparse.plans.trial_runs.trial_runs import FEWEST, Pilots
from ancfsparse.scene import Scene, check_scene
from ancfsparse.solve.motion.arguments import DEFAULT, EQUILIBRIUM, check_integrator
from ancfsparse.solve.preparation.memory_estimate import estimate


def plan(
    scene: Scene,
    t_end: float | None = None,
    quantity: Quantity | Sequence[Quantity] = (),
    error: float | str | Sequence[float | str] | None = None,
    *,
    dt: float | None = None,
    integrator: Implicit | Explicit | str = "auto",
    start: str | None = None,
) -> Plan:
    """Choose the cheapest mesh and step that give quantities to their errors.

    Pilot runs on coarse meshes with long steps show how errors of mesh and steps decrease; the
    choice is where both together are small enough at least cost.

    Parameters
    ----------
    scene : Scene
        Beams with ``n_elements="auto"`` or ``element="auto"`` are open; everything else stays as it
        is.
    t_end : float, optional
        Time at the end [s]; left out for quantities of the equilibrium.
    quantity : Quantity or sequence of Quantity
        What `position`, `velocity`, `slope_angle`, `reaction`, `section_force`, `strain` or
        `energy` return; or, of the equilibrium, `static_deflection` and `frequency`.
    error : float, str or sequence of them
        Largest error in the unit of the quantity, or a string such as ``"1 %"``, a share of its
        size; one for all, or one for each.
    dt : float, optional
        A step that is to be kept [s].
    integrator : Implicit or "auto", optional
        An integrator that is to be kept, `GeneralizedAlpha`, `HHT`, `Newmark` or `EnergyMomentum`;
        ``"auto"`` is ``GeneralizedAlpha(0.9)``.
    start : "equilibrium", optional
        The motion begins at rest at the equilibrium at t = 0, which is found on each mesh; by
        default from the stress-free shape with the initial velocities of the beams.

    Returns
    -------
    Plan
        The choice, its predicted errors by source, its cost, and why; ``print(plan)`` shows it.

    Raises
    ------
    InputError
        If an argument is invalid, the scene does not have the quantity, or nothing is open.
    StepError
        If no step is short enough to finish.
    PlanError
        If motions do not approach each other as steps are halved.

    Examples
    --------
    >>> plan = ancf.plan(scene, 2.0, ancf.position(rod.end), 1e-3)
    >>> run = plan.run()
    """
    begin = time.perf_counter()
    check_scene(scene)
    asked = wanted(checked(quantity, scene), error)
    if start is not None:
        check_choice("start of a plan", start, (EQUILIBRIUM,))
    t_end = _span(asked[0].quantity, t_end, dt, start)
    named = check_integrator(integrator)
    if isinstance(named, Explicit):
        raise InputError(
            f"plans choose steps of implicit integrators, and those of {named!r} are bound to the "
            "mesh: leave integrator out, or take GeneralizedAlpha(0.9)"
        )
    steps = None if dt is None or t_end is None else count_steps_from(0.0, t_end, dt)
    if steps is not None and not undecided(scene):
        raise InputError(
            f"dt={dt:g} and an error are both given, and no beam has n_elements='auto' or "
            "element='auto', so nothing is left to choose: leave dt or the error out"
        )
    # Equilibria in a plane may give way to its sides, and vibrations may leave it.
    flat = None
    if undecided(scene) and t_end is not None and not any(map(_beside, asked)):
        flat = planar(scene)
    arguments = t_end, asked, named, steps, start, begin
    try:
        return _planned(scene, flat, *arguments)
    except LoadError:
        if flat is None:
            raise
    return _planned(scene, None, *arguments)  # a function may have left the plane


def _beside(wanted: Wanted) -> bool:
    """Whether a quantity is of a point beside the axis of a beam, which has no place in a plane."""
    of = wanted.quantity
    return isinstance(of, AtPoint) and bool(of.point.offsets and of.point.beam.n_elements)


def _planned(
    scene: Scene,
    flat: InPlane | None,
    t_end: float | None,
    asked: Sequence[Wanted],
    named: Implicit | None,
    steps: int | None,
    start: str | None,
    begin: float,
) -> Plan:
    """Plan in a plane or in space."""
    own = scene if flat is None else flat.scene
    moved = [replace(each, quantity=each.quantity.on(own)) for each in asked]
    pilots = Pilots(own, t_end, moved, named or DEFAULT, steps or FEWEST, start)
    finer = refined(own)
    chosen = choose(pilots, finer, steps, named is None and steps is None)
    check_start(chosen.pilots, chosen.found.judge)
    try:
        found = confirmed(chosen.pilots, chosen.found)
    except PlanError as failure:  # steps have surprised, so that no other way was tried yet
        chosen = choose(pilots, finer, steps, named is None and steps is None, failure)
        found = confirmed(chosen.pilots, chosen.found)
    chosen = replace(chosen, found=found)
    why = ["the scene moves in a plane, and is solved there"] if flat is not None else []
    chosen = replace(chosen, why=(*why, *chosen.why))
    made = _record(own, t_end, moved, chosen, begin, named is not None)
    return replace(made, scene=scene, start=start, flat=flat)


def _span(
    first: Quantity, t_end: float | None, dt: float | None, start: str | None
) -> float | None:
    """Return the time at the end, None for an equilibrium."""
    if not first.static:
        if t_end is None:
            raise InputError(f"the {first.name} needs a time at the end: give t_end=1.0 [s]")
        return check_positive("t_end", t_end, "s")
    for name, value in (("t_end", t_end), ("dt", dt), ("start", start)):
        if value is not None:
            raise InputError(
                f"the {first.name} is one of the equilibrium, which has no time: leave {name} out, "
                "as in ancf.plan(scene, quantity=..., error=...)"
            )
    return None


def _record(
    scene: Scene,
    t_end: float | None,
    asked: Sequence[Wanted],
    chosen: Chosen,
    begin: float,
    integrator_given: bool,
) -> Plan:
    pilots, found = chosen.pilots, chosen.found
    finest, steps = found.choice()
    model = found.model.with_counts(spread(scene, finest))
    answer = pilots.find(model, steps)
    errors = found.errors(finest, steps)
    floors = found.floors or (0.0,) * len(asked)
    predictions = tuple(
        Prediction(*each) for each in zip(asked, found.asked, errors, floors, strict=True)
    )
    new = pilots.built(model)
    memory = estimate(new, min(steps, 2 * SAVED) + 1, None, False, "auto").total
    cheaper, dearer = (_alternative(scene, t_end, pilots, found, *each)
                       for each in neighbours(found, finest, steps))  # fmt: skip
    own = sum(run.amount for run in pilots.bill)
    return Plan(
        scene,
        t_end,
        model,
        steps,
        pilots.integrator,
        pilots.solver(new, steps) if answer is None else answer.solver,
        predictions,
        found.seconds(finest, steps),
        memory,
        cheaper,
        dearer,
        (*chosen.why, *_reasons(scene, found, predictions, integrator_given)),
        {
            "seconds": time.perf_counter() - begin,
            "runs": float(len(pilots.done)),
            "work": own / found.work(finest, steps),
            "counted": own,
        },
        answer=None if answer is None else answer.run,
        span=None
        if t_end is None or answer is not None
        else span_of(found.judge.run, found.judge.steps),
    )


def _alternative(
    scene: Scene, t_end: float | None, pilots: Pilots, found: Found, finest: float, steps: int
) -> Alternative:
    model = found.model.with_counts(spread(scene, finest))
    errors = tuple(sum(each.values()) for each in found.errors(finest, steps))
    choice = described(scene, model, steps, t_end, pilots.integrator)
    return Alternative(choice, errors, found.seconds(finest, steps))


def _reasons(
    scene: Scene, found: Found, predictions: Sequence[Prediction], integrator_given: bool
) -> list[str]:
    """Explain what decided, in sentences."""
    out = []
    worst = max(predictions, key=lambda each: each.error / each.asked)
    largest = max(worst.sources, key=lambda name: worst.sources[name])
    out.append(
        f"the largest part of the error is that of the {NAMES[largest]}, "
        f"{worst.sources[largest]:.1e} of {worst.asked:.1e} {worst.wanted.quantity.unit}".rstrip()
    )
    if found.model.grades:
        out.append(spread_by(found.model.grades))
    for name, part in (("mesh", found.mesh), ("steps", found.time)):
        if found.is_bound:
            break
        if part is not None and not all(each.settled for each in part.estimates):
            reserve = "" if found.chosen else ", and half of the error stays in reserve"
            out.append(
                f"pilots of the {name} do not show the order of the method, so the more "
                f"pessimistic order is used{reserve}"
            )
    if found.is_bound:
        out.append(
            "whole motions do not approach each other as steps are halved, as after jumps; what is "
            "asked for does as mesh and steps are refined together, by order 1 or less, so errors "
            "are bounds that four motions show"
        )
    elif found.chosen is not None:
        out.append(
            "the run was made as the last pilot, and is as far from those before as foreseen"
        )
    for body in scene.beams:
        if "n_elements" not in body.automatic:
            share = max(each / most for each, most in zip(found.given, found.asked, strict=True))
            word = "above" if share > 1.0 else "below"
            out.append(
                f"mesh of {body.name} given: the error of given meshes is predicted to be "
                f"{max(found.given):.1e}, {word} what was asked for"
            )
    if found.fixed_steps is not None:
        out.append("step given")
    if integrator_given:
        out.append("integrator given")
    for each in predictions:
        unit = each.wanted.quantity.unit
        if each.floor > each.asked:
            out.append(
                f"elements that are all converged differ by about {each.floor:.1e} {unit} in the "
                f"{each.wanted.quantity.name}, because bending and stretch are measured in several "
                f"ways: no model here can promise {each.asked:.1e} {unit}".rstrip()
            )
    if any(each.error > each.asked for each in predictions):
        out.append(
            f"the error asked for is not reached: most of what is left, "
            f"{worst.sources[largest]:.1e} {worst.wanted.quantity.unit}".rstrip()
            + f", is that of the {NAMES[largest]}, and what is open cannot reduce it further"
        )
    return out
