"""Verification of a plan by a run with finer meshes, shorter steps and a richer model."""

from __future__ import annotations

import math
from dataclasses import replace

from ancfsparse.integrators import Explicit
from ancfsparse.plans.execution.plan_data import PlanData
from ancfsparse.plans.execution.run_plan import run_once
from ancfsparse.plans.models.model import (
    MIN_LONGEST_COUNT,
    RIGID,
    Model,
    build_model,
    refine_given_meshes,
)
from ancfsparse.plans.selection.element_hierarchy import CABLE, SHEARED
from ancfsparse.plans.trial_runs.run_differences import goal_difference
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene
from ancfsparse.solve import simulate
from ancfsparse.solve.motion.arguments import DEFAULT_INTEGRATOR

SPATIAL = 3
STEP_RATIO = 2  # steps of the verification run over those of the plan
MESH_RATIO = 1.5  # elements of the verification run over those of the plan


def measure_errors(plan: PlanData, run: Trajectory) -> tuple[float, ...]:
    """Return the change of every quantity of a run one refinement level finer [its unit]."""
    scene = refine_given_meshes(plan.source) or plan.source
    finer = build_model(scene, refine_model(plan.model, plan.source.dim))
    return differences(plan, run, _verification_run(plan, finer, run))


def differences(plan: PlanData, one: Trajectory, other: Trajectory) -> tuple[float, ...]:
    """Return the difference of every quantity of two motions [its unit]."""
    scenes = one.system.scene, other.system.scene
    return tuple(
        goal_difference(
            each.goal,
            each.goal.quantity.in_scene(scenes[0]).history(one),
            each.goal.quantity.in_scene(scenes[1]).history(other),
        )
        for each in plan.predictions
    )


def refine_model(model: Model, dim: int) -> Model:
    """Return the model with finer meshes, and elements in place of rigid rods."""
    counts = {name: round(MESH_RATIO * n + 0.5) for name, n in model.counts.items()}
    rigid = [name for name, element in model.elements.items() if element == RIGID]
    element = SHEARED if dim == SPATIAL else CABLE
    return replace(
        model,
        elements={**model.elements, **dict.fromkeys(rigid, element)},
        counts={**counts, **dict.fromkeys(rigid, int(MIN_LONGEST_COUNT))},
    )


def _verification_run(plan: PlanData, finer: Scene, run: Trajectory) -> Trajectory:
    """Return the motion on finer meshes, with half the step, or by time integration."""
    if plan.t_end is None:
        return run_once(plan, finer)
    if isinstance(plan.integrator, SolutionMethod):
        sizes = (
            each.goal.quantity.size(each.goal.quantity.in_scene(run.system.scene).history(run))
            for each in plan.predictions
        )
        error = min(p.tolerance / size for p, size in zip(plan.predictions, sizes, strict=True))
        steps = plan.integrator.steps_to_verify(run, error)
        every = max(1, math.ceil(steps / plan.steps))
        dt = plan.t_end / (every * plan.steps)
        return simulate(
            finer, plan.t_end, dt, integrator=DEFAULT_INTEGRATOR, save_every=every, start=plan.start
        )
    every = STEP_RATIO * run.settings["save_every"]
    # Explicit steps may be too long for the finer mesh.
    integrator = DEFAULT_INTEGRATOR if isinstance(plan.integrator, Explicit) else plan.integrator
    shorter = replace(plan, steps=STEP_RATIO * plan.steps, integrator=integrator)
    return run_once(shorter, finer, save_every=every)
