"""`plan`: from a scene, a quantity and its error to a model, a mesh and a step."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from ancfsparse.checks import check_choice, check_flag, check_positive
from ancfsparse.errors import InputError, LoadError, PlanError
from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.integrators.interface.time_grid import count_steps_from
from ancfsparse.plans.discretization_error.error_model import Found, neighbours
from ancfsparse.plans.discretization_error.initial_singularity import check_start
from ancfsparse.plans.execution.plan_data import (
    SAVED,
    Alternative,
    PlanData,
    Prediction,
    described,
)
from ancfsparse.plans.execution.plan_reasons import reasons
from ancfsparse.plans.execution.planned_trajectory import PlannedRun
from ancfsparse.plans.execution.replanning import carried_out
from ancfsparse.plans.execution.validity_range import span_of
from ancfsparse.plans.execution.verification import measured
from ancfsparse.plans.models.model import refined, spread, undecided
from ancfsparse.plans.models.planar_reduction import InPlane, planar
from ancfsparse.plans.quantities.functions import checked
from ancfsparse.plans.quantities.quantity import AtPoint, Quantity
from ancfsparse.plans.quantities.tolerances import Wanted, wanted
from ancfsparse.plans.selection.confirmation_run import confirmed
from ancfsparse.plans.selection.method_selection import Chosen, choose
from ancfsparse.plans.trial_runs.trial_runs import FEWEST, Pilots
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene, check_scene
from ancfsparse.solve.motion.arguments import DEFAULT, EQUILIBRIUM, check_integrator
from ancfsparse.solve.preparation.memory_estimate import estimate_memory


@dataclass(frozen=True, eq=False, repr=False)
class Plan(PlanData):
    """How a scene is to be run, as `plan` returns it; fields as in `PlanData`."""

    def run(self, verify: bool = False, **options: Any) -> PlannedRun:
        """March the scene as planned.

        Parameters
        ----------
        verify : bool, optional
            Also run with finer meshes, given ones too, and half the step, and report the difference
            beside the prediction.
        **options
            Other arguments of `simulate`, such as ``output`` or ``progress``.  By default every
            step is saved up to 2000, and of more steps at least every 1000th part.

        Returns
        -------
        PlannedRun
            A `Trajectory` that also has the plan, and what was measured.  Handles of the scene that
            was planned may be used with it.

        Raises
        ------
        StepError
            If a step cannot be solved, even with steps 16 times shorter.
        PlanError
            If a motion whose equilibria cease to exist has no plan.

        Warns
        -----
        PlanChangedWarning
            If the run leaves the range of the plan: a step fails that pilots had passed, strains,
            turns in a step or loads are larger than theirs, a stop, a rope or a function of the
            motion pushes that did not push there, or an equilibrium ceases to exist.
            What is done is kept where a step fails, and goes on with half of it; otherwise meshes
            and steps are refined until two runs agree, or the scene is planned again with steps.
        """
        check_flag("verify", verify)
        last, run = carried_out(self, options, plan)
        off = measured(last, run) if verify else ()
        return PlannedRun(**{name: getattr(run, name) for name in Trajectory.__dataclass_fields__},
                          plan=last, measured=off)  # fmt: skip


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
    memory = estimate_memory(new, min(steps, 2 * SAVED) + 1, None, False, "auto").total
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
        (*chosen.why, *reasons(scene, found, predictions, integrator_given)),
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
