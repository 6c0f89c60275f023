"""The march of a plan, once."""

from __future__ import annotations

from typing import Any

from ancfsparse.errors import InputError
from ancfsparse.plans.execution.plan_data import PlanData
from ancfsparse.plans.trial_runs.solution_methods import Way
from ancfsparse.plans.trial_runs.trial_runs import at_rest
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene
from ancfsparse.solve import simulate, solve_static


def march(plan: PlanData, scene: Scene, **options: Any) -> Trajectory:
    """Return the motion of a scene as planned, with other arguments of `simulate`.

    Raises
    ------
    InputError
        If an argument does not belong to what is planned.
    """
    if plan.t_end is None or plan.dt is None:
        return at_rest(solve_static(scene, **options))
    if isinstance(plan.integrator, Way):
        for name in options.keys() - plan.integrator.options:
            raise InputError(
                f"{name} belongs to motions that are marched, and this plan has "
                f"{plan.integrator!r}: leave it out, or plan with integrator=GeneralizedAlpha()"
            )
        return plan.integrator.march(scene, plan.t_end, plan.steps, **options)
    how = {"integrator": plan.integrator, "solver": plan.solver}
    given: dict[str, Any] = {**how, "save_every": plan.save_every, **options, "start": plan.start}
    return simulate(scene, plan.t_end, plan.dt, **given)
