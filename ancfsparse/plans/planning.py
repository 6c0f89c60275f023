"""`plan`: from a scene and goals to a model, a mesh, a step and a method.

Stages, with their input and output (names of folders in parentheses):

1. Goals (`quantities`): quantities of interest and errors -> `Goal` each.
2. Reduction (`models`): a scene in space that moves in a plane -> a planar scene.
3. Selection of the method (`selection`, `trial_runs`): statics, sums of modes or time integration
   -> `TrialRuns` by that method.
4. Selection of the elements (`selection`, `model_error`): trial runs -> modelling errors by effect
   -> an element for every beam.
5. Selection of mesh and step (`discretization_error`): trial runs on coarse meshes with long steps
   -> `ErrorModel`: predicted errors and work on every mesh and step -> the resolution with least
   work within the tolerances.
6. Confirmation (`selection`): the selected run, if it is short -> corrected error model.
7. Plan (`execution`): error model -> `Plan` with predictions, alternatives and reasons;
   `Plan.run` -> `PlannedRun`, planned again if it leaves the range of the trial runs.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from ancfsparse.checks import check_choice, check_flag, check_positive
from ancfsparse.errors import (
    AncfError,
    EnergyIncreaseError,
    InputError,
    LoadError,
    PlanError,
    StepError,
)
from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.integrators.interface.time_grid import count_steps_from
from ancfsparse.plans.discretization_error.error_model import ErrorModel, scaled
from ancfsparse.plans.discretization_error.initial_singularity import (
    add_initial_error,
    check_initial_force,
)
from ancfsparse.plans.execution.plan_data import (
    MIN_INTERVALS,
    Alternative,
    PlanData,
    Prediction,
    describe_choice,
)
from ancfsparse.plans.execution.plan_reasons import contact_reasons, reasons
from ancfsparse.plans.execution.planned_trajectory import PlannedRun
from ancfsparse.plans.execution.replanning import execute
from ancfsparse.plans.execution.saved_states import save_run, split_options
from ancfsparse.plans.execution.unmet_errors import warn_of_unmet_errors
from ancfsparse.plans.execution.validity_range import validity_range
from ancfsparse.plans.execution.verification import measure_errors
from ancfsparse.plans.models.model import open_bodies, refine_given_meshes
from ancfsparse.plans.models.planar_reduction import PlanarScene, reduce_to_plane
from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.plans.quantities.tolerances import Goal, check_goals, check_quantities
from ancfsparse.plans.selection.confirmation_run import confirm_selection
from ancfsparse.plans.selection.method_selection import Selection, select_method
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.plans.trial_runs.trial_runs import MIN_STEPS, TrialRuns
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene, check_scene
from ancfsparse.solve.motion.arguments import DEFAULT_INTEGRATOR, EQUILIBRIUM, check_integrator
from ancfsparse.solve.preparation.memory_estimate import estimate_memory


@dataclass(frozen=True, eq=False, repr=False)
class Plan(PlanData):
    """Plan for a scene, as `plan` returns it; attributes as in `PlanData`."""

    def run(self, verify: bool = False, **options: Any) -> PlannedRun:
        """Run the scene as planned.

        Parameters
        ----------
        verify : bool, optional
            Whether to run it once more, one refinement level finer: with finer meshes, specified
            ones included, and half the step. The difference is reported next to the prediction.
        **options
            Other arguments of `simulate`, such as ``output`` or ``progress``; a run that the plan
            has made already is not repeated for them, unless they change its steps.  By default
            every step is saved up to 2000, and of more steps at least every 1000th part.

        Returns
        -------
        PlannedRun
            A `Trajectory` with the plan and the measured difference.  Handles of the planned scene
            may be used with it.  ``finished`` is true only if all errors, predicted and measured,
            are within the requested ones; ``stats.error`` is the error of the first
            quantity [its unit].

        Raises
        ------
        StepError
            If a step cannot be solved, even with steps 16 times shorter.
        PlanError
            If a motion whose equilibria cease to exist has no plan.

        Warns
        -----
        ErrorNotMetWarning
            If a predicted or measured error exceeds the requested one.
        PlanChangedWarning
            If the run leaves the range of the plan: a step fails; strains, rotations in a step or
            loads exceed those of the trial runs; a stop, a rope or a user force acts that did not
            act there; or an equilibrium ceases to exist.  After a failed step the run continues
            with half the step; otherwise meshes and steps are refined until two runs agree, or the
            scene is planned again with time integration.
        """
        check_flag("verify", verify)
        now, later = split_options(self, options)
        last, run = execute(self, now, plan)
        measured = measure_errors(last, run) if verify else ()
        warn_of_unmet_errors(last, measured, stacklevel=2)
        error = max(last.predictions[0].bound, *measured[:1], 0.0)
        saved = save_run(replace(run, stats=replace(run.stats, error=error)), later)
        return PlannedRun(
            **{name: getattr(saved, name) for name in Trajectory.__dataclass_fields__},
            plan=last,
            measured=measured,
        )


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
    """Select the cheapest model, mesh, step and method that give quantities within their errors.

    Trial runs on coarse meshes with long steps show how the errors of mesh and steps decrease; the
    mesh and step with least work are selected for which both together are small enough.

    Parameters
    ----------
    scene : Scene
        Beams with ``n_elements="auto"`` or ``element="auto"`` are planned; all others stay as
        specified.
    t_end : float, optional
        Time at the end [s]; omitted for quantities of the equilibrium.
    quantity : Quantity or sequence of Quantity
        From `position`, `velocity`, `slope_angle`, `reaction`, `section_force`, `strain` or
        `energy`; or, for the equilibrium, from `static_deflection` and `frequency`.
    error : float, str or sequence of them
        Largest error in the unit of the quantity, or a string such as ``"1 %"``, relative to its
        size; one for all, or one for each.
    dt : float, optional
        Prescribed time step [s].
    integrator : Implicit or "auto", optional
        Prescribed integrator, `GeneralizedAlpha`, `HHT`, `Newmark` or `EnergyMomentum`; ``"auto"``
        is ``GeneralizedAlpha(0.9)``.
    start : "equilibrium", optional
        The motion begins at rest at the equilibrium at t = 0, computed on each mesh; by default it
        begins at the stress-free shape with the initial velocities of the beams.

    Returns
    -------
    Plan
        The selection, its predicted errors by source, its cost, and the reasons; ``print(plan)``
        shows it.

    Raises
    ------
    InputError
        If an argument is invalid, the scene does not have the quantity, or nothing can be selected.
    PlanError
        If motions do not converge as steps are halved, or no step is short enough for a complete
        run.

    Examples
    --------
    >>> plan = ancf.plan(scene, 2.0, ancf.position(rod.end), 1e-3)
    >>> run = plan.run()
    """
    begin = time.perf_counter()
    check_scene(scene)
    goals = check_goals(check_quantities(quantity, scene), error)
    if start is not None:
        check_choice("start of a plan", start, (EQUILIBRIUM,))
    t_end = _check_t_end(goals[0].quantity, t_end, dt, start)
    named = check_integrator(integrator)
    if isinstance(named, Explicit):
        raise InputError(
            f"plans select the steps of implicit integrators; those of {named!r} are limited by "
            "the mesh: leave integrator out, or take GeneralizedAlpha(0.9)"
        )
    steps = None if dt is None or t_end is None else count_steps_from(0.0, t_end, dt)
    if steps is not None and not open_bodies(scene):
        raise InputError(
            f"dt={dt:g} and an error are both given, and no beam has n_elements='auto' or "
            "element='auto', so nothing remains to be selected: leave dt or the error out"
        )
    # Equilibria in a plane may be unstable out of it, and vibrations may leave it.
    planar = None
    if open_bodies(scene) and t_end is not None and not any(map(_is_off_axis, goals)):
        planar = reduce_to_plane(scene)
    arguments = t_end, goals, named, steps, start, begin
    try:
        try:
            return _plan(scene, planar, *arguments)
        except LoadError:
            if planar is None:
                raise
        return _plan(scene, None, *arguments)  # a load function may have left the plane
    except StepError as failure:
        raise _no_complete_run(goals[0].quantity, failure) from failure
    except PlanError as refusal:
        raise refusal.with_causes(contact_reasons(scene)) from refusal.__cause__


def _no_complete_run(first: Quantity, failure: StepError) -> PlanError:
    """Return the error of a plan whose trial runs fail with any step."""
    reason = str(failure.reason)
    if isinstance(failure, EnergyIncreaseError):
        reason = f"the motion gained {failure.gain:.3g} J that no load accounts for"
    nan = float("nan")
    return PlanError(
        first.name, nan, nan, first.unit, 0, failure.time, (reason.rstrip("."),), failure.dt
    )


def _is_off_axis(goal: Goal) -> bool:
    """Return True for a point off the axis of a beam, which has no planar form."""
    point = goal.quantity.point
    return point is not None and bool(point.offsets and point.beam.n_elements)


def _plan(
    scene: Scene,
    planar: PlanarScene | None,
    t_end: float | None,
    goals: Sequence[Goal],
    named: Implicit | None,
    steps: int | None,
    start: str | None,
    begin: float,
) -> Plan:
    """Plan in a plane or in space."""
    source = scene if planar is None else planar.scene
    moved = [replace(each, quantity=each.quantity.in_scene(source)) for each in goals]
    trials = TrialRuns(source, t_end, moved, named or DEFAULT_INTEGRATOR, steps or MIN_STEPS, start)
    is_free = named is None and steps is None
    arguments = trials, refine_given_meshes(source), steps
    selection = select_method(*arguments, is_free)
    check_initial_force(selection.trials, selection.error_model.reference_run)
    try:
        error_model = confirm_selection(selection.trials, selection.error_model)
    except (InputError, LoadError):
        raise
    except AncfError as failure:
        if isinstance(selection.trials.integrator, SolutionMethod):
            selection = select_method(*arguments, is_free=False)
        elif isinstance(failure, (StepError, PlanError)):
            selection = select_method(*arguments, is_free, failure)
        else:
            raise
        error_model = confirm_selection(selection.trials, selection.error_model)
    error_model = add_initial_error(selection.trials, error_model)
    why = selection.why
    if planar is not None:
        why = ("the scene moves in a plane, and is solved there", *why)
    selection = replace(selection, error_model=error_model, why=why)
    result = _build_plan(source, t_end, moved, selection, begin, named is not None)
    return replace(result, scene=scene, start=start, planar=planar)


def _check_t_end(
    first: Quantity, t_end: float | None, dt: float | None, start: str | None
) -> float | None:
    """Return the time at the end, None for an equilibrium."""
    if not first.is_static:
        if t_end is None:
            raise InputError(f"the {first.name} needs a time at the end: give t_end=1.0 [s]")
        return check_positive("t_end", t_end, "s")
    for name, value in (("t_end", t_end), ("dt", dt), ("start", start)):
        if value is not None:
            raise InputError(
                f"the {first.name} refers to the static equilibrium; omit {name}, as in "
                "ancf.plan(scene, quantity=..., error=...)"
            )
    return None


def _build_plan(
    scene: Scene,
    t_end: float | None,
    goals: Sequence[Goal],
    selection: Selection,
    begin: float,
    integrator_given: bool,
) -> Plan:
    trials, error_model = selection.trials, selection.error_model
    n_longest, steps = error_model.optimum()
    model = trials.with_mesh(error_model.model, n_longest)
    trial = trials.find(model, steps)
    errors = error_model.errors(n_longest, steps)
    floors = error_model.floors or (0.0,) * len(goals)
    columns = zip(goals, error_model.tolerances, errors, floors, strict=True)
    predictions = tuple(Prediction(*each) for each in columns)
    built = trials.build(model)
    memory = estimate_memory(built, min(steps, 2 * MIN_INTERVALS) + 1, None, False, "auto").total
    coarser, finer = (
        _alternative(scene, t_end, trials, error_model, *scaled(error_model, n_longest, steps, x))
        for x in (4.0, 0.25)  # times the error
    )
    operations = sum(run.work for run in trials.run_costs)
    reference = error_model.reference_run
    is_predicted = t_end is not None and trial is None
    return Plan(
        scene,
        t_end,
        model,
        steps,
        trials.integrator,
        trials.solver(built, steps) if trial is None else trial.solver,
        predictions,
        error_model.seconds(n_longest, steps),
        memory,
        coarser,
        finer,
        (*selection.why, *reasons(scene, error_model, predictions, integrator_given)),
        {
            "seconds": time.perf_counter() - begin,
            "runs": float(len(trials.done)),
            "work": operations / error_model.work(n_longest, steps),
            "operations": operations,
        },
        result=None if trial is None else trial.run,
        validity_range=validity_range(reference.run, reference.steps) if is_predicted else None,
    )


def _alternative(
    scene: Scene,
    t_end: float | None,
    trials: TrialRuns,
    error_model: ErrorModel,
    n_longest: float,
    steps: int,
) -> Alternative:
    model = trials.with_mesh(error_model.model, n_longest)
    errors = tuple(sum(each.values()) for each in error_model.errors(n_longest, steps))
    choice = describe_choice(scene, model, steps, t_end, trials.integrator)
    return Alternative(choice, errors, error_model.seconds(n_longest, steps))
