"""A plan carried out: what happens where its run leaves the range that it assumed."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from ancfsparse.errors import AncfError, InputError, LoadError, PlanChangedWarning, StepError
from ancfsparse.plans.execution.plan_data import PlanData
from ancfsparse.plans.execution.run_plan import march
from ancfsparse.plans.execution.validity_range import span_of
from ancfsparse.plans.execution.verification import FINER_STEPS, apart, richer
from ancfsparse.plans.models.model import built, refined
from ancfsparse.plans.trial_runs.solution_methods import Way
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.solve import simulate
from ancfsparse.solve.motion.arguments import DEFAULT
from ancfsparse.system import System

P = TypeVar("P", bound=PlanData)
Planner = Callable[..., P]

# How often a run is planned again.
MOST = 4
# Arguments of `simulate` with which a run can go on from where it failed.
JOINABLE = frozenset({"progress"})


def carried_out(plan: P, options: Mapping[str, Any], replan: Planner[P]) -> tuple[P, Trajectory]:
    """March a plan, and plan again where it leaves its range.

    Parameters
    ----------
    plan : P
        The plan.
    options : mapping of str to object
        Other arguments of `simulate`.
    replan : callable
        `plan`, which plans again by steps where a path of equilibria ends.

    Returns
    -------
    P
        The one that came to its end.
    Trajectory
        Its motion.
    """
    made = _made(plan, options)
    if made is not None:
        return plan, made
    if isinstance(plan.integrator, Way):
        return _by_way(plan, options, replan)
    plan, run = _halved(plan, options)
    return _refined(plan, run, options)


def _made(plan: PlanData, options: Mapping[str, Any]) -> Trajectory | None:
    """Return the run if it was made as a pilot, with as many states as would be saved."""
    if plan.answer is None or options:
        return None
    saved = plan.answer.settings.get("save_every", 1)
    return plan.answer if saved <= plan.save_every else None


def _changed(reason: str) -> None:
    warnings.warn(PlanChangedWarning(f"the run left the range of its plan: {reason}"), stacklevel=5)


def _by_way(plan: P, options: Mapping[str, Any], replan: Planner[P]) -> tuple[P, Trajectory]:
    """Follow equilibria or sum modes, and march where that is not possible."""
    try:
        run = march(plan, plan.build(), **options)
        reason = "an equilibrium ceased to exist" if run.stats.recoveries else _beyond(plan, run)
    except (InputError, LoadError):
        raise
    except AncfError as failure:
        reason = f"{plan.integrator!r} failed ({failure})"
    if not reason:
        return plan, run
    _changed(f"{reason}; it is planned again, by steps in time")
    asked = [(each.wanted.quantity, each.wanted) for each in plan.predictions]
    errors = [f"{100 * w.error!r} %" if w.relative else w.error for _, w in asked]
    fixed: dict[str, Any] = {"integrator": DEFAULT, "start": plan.start}
    again = replan(plan.source, plan.t_end, [each for each, _ in asked], errors, **fixed)
    again = replace(again, scene=plan.scene, flat=plan.flat)
    return carried_out(again, options, replan)


def _halved(plan: P, options: Mapping[str, Any]) -> tuple[P, Trajectory]:
    """March with half the step from where a step fails."""
    scene = plan.build()
    done: Trajectory | None = None
    for _ in range(MOST + 1):
        try:
            run = _onward(plan, scene, done, options)
        except StepError as failure:
            if _ == MOST:
                raise
            _changed(
                f"at t = {failure.time:.6g} s a step of {plan.dt or 0.0:.3g} s failed, so it goes "
                "on with half the step"
            )
            if set(options) <= JOINABLE:
                done = _saved(plan, done, failure.trajectory)
            plan = replace(plan, steps=2 * plan.steps, answer=None)
        else:
            break
    return plan, run


def _onward(
    plan: PlanData, scene: Any, done: Trajectory | None, options: Mapping[str, Any]
) -> Trajectory:
    """March from where a run was left, and return all of it."""
    if done is None:
        return march(plan, scene, **options)
    system = done.system
    assert isinstance(system, System)
    rows = (np.array(table[-1]) for table in (done.q, done.v, done.a, done.lam))
    last = system.state(float(done.t[-1]), *rows)
    assert plan.t_end is not None
    every = round(float(done.t[-1] - done.t[-2]) * plan.steps / plan.t_end)
    how = {"integrator": plan.integrator, "solver": plan.solver}
    given = {**how, "save_every": every, **options}
    try:
        rest = simulate(scene, plan.t_end, plan.dt, start=last, **given)
    except StepError as failure:
        failure.trajectory = _joined(done, failure.trajectory)
        raise
    return _joined(done, rest)


def _saved(plan: PlanData, done: Trajectory | None, path: Trajectory | None) -> Trajectory | None:
    """Return the states of a run that failed which are among those to be saved."""
    if path is None or plan.t_end is None:
        return done
    every = plan.save_every if done is None else round(
        float(done.t[1] - done.t[0]) * plan.steps / plan.t_end)  # fmt: skip
    number = (path.t - path.t[0]) * plan.steps / plan.t_end / every
    rows = np.flatnonzero(np.abs(number - np.round(number)) < 1e-6)
    if len(rows) < 2:
        return done
    t, q, v, a, lam = (np.asarray(x)[rows] for x in (path.t, path.q, path.v, path.a, path.lam))
    return replace(path, t=t, q=q, v=v, a=a, lam=lam, ending=None)


def _joined(one: Trajectory, other: Trajectory | None) -> Trajectory:
    """Return two runs, of which the other goes on from the last state of the one."""
    if other is None:
        return one
    t, q, v, a, lam = (
        np.concatenate([np.asarray(x), np.asarray(y)[1:]])
        for x, y in (
            (getattr(one, name), getattr(other, name)) for name in ("t", "q", "v", "a", "lam")
        )
    )
    stats = replace(other.stats)
    for each in fields(RunStats):
        if each.type == "int" and each.name not in ("threads", "runs"):
            both = getattr(one.stats, each.name) + getattr(other.stats, each.name)
            setattr(stats, each.name, both)
    settings = {**other.settings, "t_start": one.settings.get("t_start")}
    return replace(one, t=t, q=q, v=v, a=a, lam=lam, stats=stats, settings=settings, ending=None)


def _beyond(plan: PlanData, run: Trajectory) -> str:
    """Explain by what a run leaves the range of the pilots; empty if it does not."""
    return "" if plan.span is None else plan.span.left_by(span_of(run, plan.steps))


def _refined(plan: P, run: Trajectory, options: Mapping[str, Any]) -> tuple[P, Trajectory]:
    """Refine meshes and steps of a run that leaves its range until two runs agree."""
    reason = _beyond(plan, run) if plan.t_end is not None else ""
    if not reason or not set(options) <= JOINABLE:
        if reason:
            _changed(f"{reason}; its error is not known to be what was predicted")
        return plan, run
    _changed(f"{reason}; meshes and steps are refined until two runs agree")
    off: tuple[float, ...] = ()
    for _ in range(MOST):
        finer = replace(
            plan,
            model=richer(plan.model, plan.source.dim),
            steps=FINER_STEPS * plan.steps,
            answer=None,
        )
        scene = built(refined(finer.source) or finer.source, finer.model)
        every = FINER_STEPS * run.settings["save_every"]
        other = march(finer, scene, save_every=every, **options)
        off = apart(plan, run, other)
        plan, run = finer, other
        if all(far <= each.asked for far, each in zip(off, plan.predictions, strict=True)):
            break
    else:
        far = max(zip(off, plan.predictions, strict=True), key=lambda x: x[0] / x[1].asked)
        _changed(
            f"after {MOST} refinements the {far[1].wanted.quantity.name} still changes by "
            f"{far[0]:.2g}, and {far[1].asked:.2g} was asked for"
        )
    return plan, run
