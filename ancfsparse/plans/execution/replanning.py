"""Execution of a plan, and new plans if its run leaves the range of the trial runs."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from ancfsparse.errors import AncfError, InputError, LoadError, PlanChangedWarning, StepError
from ancfsparse.plans.execution.plan_data import PlanData
from ancfsparse.plans.execution.run_plan import run_once
from ancfsparse.plans.execution.validity_range import validity_range
from ancfsparse.plans.execution.verification import STEP_RATIO, differences, refine_model
from ancfsparse.plans.models.model import build_model, refine_given_meshes
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.solutions.selected_states import select_states
from ancfsparse.scene import Scene
from ancfsparse.solve import simulate
from ancfsparse.solve.motion.arguments import DEFAULT_INTEGRATOR
from ancfsparse.system import System
from ancfsparse.system.coordinates.state import StateHistory

P = TypeVar("P", bound=PlanData)

MAX_CHANGES = 4  # halvings of the step, or refinements, of a run
# Arguments of `simulate` with which a run can be continued after a failure.
CONTINUABLE = frozenset({"progress"})


def execute(plan: P, options: Mapping[str, Any], replan: Callable[..., P]) -> tuple[P, Trajectory]:
    """Run a plan, and plan again if the run leaves the range of the trial runs.

    Parameters
    ----------
    plan : PlanData
        The plan.
    options : mapping of str to object
        Other arguments of `simulate`; with none, a run that is one of the trial runs is returned.
    replan : callable
        `ancfsparse.plan`, for time integration where a path of equilibria ends.

    Returns
    -------
    PlanData
        The plan of the completed run.
    Trajectory
        Its motion.
    """
    if plan.result is not None and not options:
        return plan, plan.result
    if isinstance(plan.integrator, SolutionMethod):
        return _execute_method(plan, options, replan)
    plan, run = _run_with_halvings(plan, options)
    return _refine(plan, run, options)


def _warn(reason: str) -> None:
    warnings.warn(PlanChangedWarning(f"the run left the range of its plan: {reason}"), stacklevel=5)


def _execute_method(
    plan: P, options: Mapping[str, Any], replan: Callable[..., P]
) -> tuple[P, Trajectory]:
    """Follow equilibria or sum modes; integrate in time if that fails."""
    try:
        run = run_once(plan, plan.build(), **options)
        lost = "an equilibrium ceased to exist"
        reason = lost if run.stats.recoveries else _exceeded_range(plan, run)
    except (InputError, LoadError):
        raise
    except AncfError as failure:
        reason = f"{plan.integrator!r} failed ({failure})"
    if not reason:
        return plan, run
    _warn(f"{reason}; it is planned again with time integration")
    goals = [each.goal for each in plan.predictions]
    errors = [f"{100 * goal.error!r} %" if goal.relative else goal.error for goal in goals]
    quantities = [goal.quantity for goal in goals]
    again = replan(
        plan.source, plan.t_end, quantities, errors, integrator=DEFAULT_INTEGRATOR, start=plan.start
    )
    again = replace(again, scene=plan.scene, planar=plan.planar)
    return execute(again, options, replan)


def _run_with_halvings(plan: P, options: Mapping[str, Any]) -> tuple[P, Trajectory]:
    """Integrate in time, with half the step from where a step fails."""
    scene, selected = plan.build(), plan.choice
    done: Trajectory | None = None
    for halvings in range(MAX_CHANGES + 1):
        try:
            run = _continue(plan, scene, done, options)
        except StepError as failure:
            if halvings == MAX_CHANGES:
                failure.replace_advice(
                    f"The plan had selected {selected}, and {2**MAX_CHANGES} times shorter steps "
                    "fail as well: give the material axial_damping and bending_damping, request a "
                    "shorter time, or plan with integrator=GeneralizedAlpha(0.5) or "
                    "EnergyMomentum()."
                )
                raise
            _warn(
                f"at t = {failure.time:.6g} s a step of {plan.dt or 0.0:.3g} s failed; the run "
                "continues with half the step"
            )
            if set(options) <= CONTINUABLE:
                done = _saved_part(plan, done, failure.trajectory)
            plan = replace(plan, steps=2 * plan.steps, result=None)
        else:
            break
    return plan, run


def _continue(
    plan: PlanData, scene: Scene, done: Trajectory | None, options: Mapping[str, Any]
) -> Trajectory:
    """Continue a run, and return it from the start."""
    if done is None:
        return run_once(plan, scene, **options)
    system = done.system
    assert isinstance(system, System)
    rows = (np.array(table[-1]) for table in (done.q, done.v, done.a, done.lam))
    last = system.state(float(done.t[-1]), *rows)
    assert plan.t_end is not None
    every = round(float(done.t[-1] - done.t[-2]) * plan.steps / plan.t_end)
    given: dict[str, Any] = {"integrator": plan.integrator, "solver": plan.solver}
    given |= {"save_every": every, **options}
    try:
        rest = simulate(scene, plan.t_end, plan.dt, start=last, **given)
    except StepError as failure:
        failure.trajectory = _join(done, failure.trajectory)
        raise
    return _join(done, rest)


def _saved_part(
    plan: PlanData, done: Trajectory | None, path: Trajectory | None
) -> Trajectory | None:
    """Return the states of a failed run that are among those to be saved."""
    if path is None or plan.t_end is None:
        return done
    every = plan.save_every if done is None else round(
        float(done.t[1] - done.t[0]) * plan.steps / plan.t_end)  # fmt: skip
    number = (path.t - path.t[0]) * plan.steps / plan.t_end / every
    rows = np.flatnonzero(np.abs(number - np.round(number)) < 1e-6)
    return done if len(rows) < 2 else select_states(path, rows, ending=None)


def _join(one: Trajectory, other: Trajectory | None) -> Trajectory:
    """Return two runs as one, where the second continues from the last state of the first."""
    if other is None:
        return one
    arrays: dict[str, Any] = {
        name: np.concatenate([np.asarray(getattr(one, name)), np.asarray(getattr(other, name))[1:]])
        for name in StateHistory._fields
    }
    stats = replace(other.stats)
    for each in fields(RunStats):
        if each.type == "int" and each.name not in ("threads", "runs"):
            both = getattr(one.stats, each.name) + getattr(other.stats, each.name)
            setattr(stats, each.name, both)
    settings = {**other.settings, "t_start": one.settings.get("t_start")}
    return replace(one, **arrays, stats=stats, settings=settings, ending=None)


def _exceeded_range(plan: PlanData, run: Trajectory) -> str:
    """Return a sentence on the range of the trial runs that a run exceeds; empty if none."""
    known = plan.validity_range
    return "" if known is None else known.exceeded_by(validity_range(run, plan.steps))


def _refine(plan: P, run: Trajectory, options: Mapping[str, Any]) -> tuple[P, Trajectory]:
    """Refine meshes and steps of a run outside the range of the trial runs until two runs agree.

    If no mesh and step meet the errors, as the plan predicts, finer runs would not agree either.
    """
    reason = _exceeded_range(plan, run) if plan.t_end is not None else ""
    if not reason or not plan.is_met or not set(options) <= CONTINUABLE:
        if reason:
            _warn(f"{reason}; its error may exceed the prediction")
        return plan, run
    _warn(f"{reason}; meshes and steps are refined until two runs agree")
    changes: tuple[float, ...] = ()
    for _ in range(MAX_CHANGES):
        finer = replace(
            plan,
            model=refine_model(plan.model, plan.source.dim),
            steps=STEP_RATIO * plan.steps,
            result=None,
        )
        scene = build_model(refine_given_meshes(finer.source) or finer.source, finer.model)
        every = STEP_RATIO * run.settings["save_every"]
        other = run_once(finer, scene, save_every=every, **options)
        changes = differences(plan, run, other)
        plan, run = finer, other
        pairs = zip(changes, plan.predictions, strict=True)
        if all(change <= each.tolerance for change, each in pairs):
            break
    pairs = zip(changes, plan.predictions, strict=True)
    errors = tuple(replace(each, sources={"mesh and steps": change}) for change, each in pairs)
    return replace(plan, predictions=errors), run
