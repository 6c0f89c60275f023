"""The run that proves a plan: finer meshes, shorter steps, and what was left out."""

from __future__ import annotations

import math
from dataclasses import replace

from ancfsparse.integrators import Explicit
from ancfsparse.plans.execution.plan_data import PlanData
from ancfsparse.plans.execution.run_plan import march
from ancfsparse.plans.models.model import RIGID, Model, Rung, built, refined
from ancfsparse.plans.trial_runs.solution_methods import Way
from ancfsparse.plans.trial_runs.trial_runs import distance
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene
from ancfsparse.solve import simulate
from ancfsparse.solve.motion.arguments import DEFAULT

SPATIAL = 3
# Steps and elements of the run that proves a plan, over those of the plan.
FINER_STEPS, FINER_MESH = 2, 1.5
# Elements in place of a rigid rod in that run.
LINK = 4


def measured(plan: PlanData, run: Trajectory) -> tuple[float, ...]:
    """Return by how much every quantity changes one rung up [its unit].

    Parameters
    ----------
    plan : PlanData
        The plan.
    run : Trajectory
        The motion by it.
    """
    finer = built(refined(plan.source) or plan.source, richer(plan.model, plan.source.dim))
    return apart(plan, run, _beside(plan, finer, run))


def apart(plan: PlanData, one: Trajectory, other: Trajectory) -> tuple[float, ...]:
    """Return by how much every quantity of two motions differs [its unit]."""
    scenes = one.system.scene, other.system.scene
    return tuple(
        distance(
            each.wanted,
            each.wanted.quantity.on(scenes[0]).history(one),
            each.wanted.quantity.on(scenes[1]).history(other),
        )
        for each in plan.predictions
    )


def richer(model: Model, dim: int) -> Model:
    """Return finer meshes, and elements in place of rigid rods."""
    counts = {name: round(FINER_MESH * n + 0.5) for name, n in model.counts.items()}
    rigid = [name for name, rung in model.rungs.items() if rung == RIGID]
    rung = Rung("thick" if dim == SPATIAL else "thin")
    return replace(
        model,
        rungs={**model.rungs, **dict.fromkeys(rigid, rung)},
        counts={**counts, **dict.fromkeys(rigid, LINK)},
    )


def _beside(plan: PlanData, finer: Scene, run: Trajectory) -> Trajectory:
    """Return the motion on finer meshes: by half the step, or by steps where none were."""
    if plan.t_end is None:
        return march(plan, finer)
    if isinstance(plan.integrator, Way):
        sizes = (
            each.wanted.quantity.size(each.wanted.quantity.on(run.system.scene).history(run))
            for each in plan.predictions
        )
        share = min(p.asked / size for p, size in zip(plan.predictions, sizes, strict=True))
        needed = plan.integrator.steps_to_verify(run, share)
        more = max(1, math.ceil(needed / plan.steps))
        dt = plan.t_end / (more * plan.steps)
        return simulate(
            finer, plan.t_end, dt, integrator=DEFAULT, save_every=more, start=plan.start
        )
    every = FINER_STEPS * run.settings["save_every"]
    # Explicit steps may be too long for the finer mesh.
    integrator = DEFAULT if isinstance(plan.integrator, Explicit) else plan.integrator
    shorter = replace(plan, steps=FINER_STEPS * plan.steps, integrator=integrator)
    return march(shorter, finer, save_every=every)
