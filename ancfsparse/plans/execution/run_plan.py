"""One run of a plan."""

from __future__ import annotations

from typing import Any

from ancfsparse.errors import InputError
from ancfsparse.plans.execution.plan_data import PlanData
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.plans.trial_runs.trial_runs import as_trajectory
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene
from ancfsparse.solve import simulate, solve_static


def run_once(plan: PlanData, scene: Scene, **options: Any) -> Trajectory:
    """Return the motion of a scene as planned, with other arguments of `simulate`.

    Raises
    ------
    InputError
        If an argument does not apply to the planned method.
    """
    if plan.t_end is None or plan.dt is None:
        return as_trajectory(solve_static(scene, **options))
    if isinstance(plan.integrator, SolutionMethod):
        for name in options.keys() - plan.integrator.options:
            raise InputError(
                f"{name} applies to time integration only, and this plan has "
                f"{plan.integrator!r}: leave it out, or plan with integrator=GeneralizedAlpha()"
            )
        return plan.integrator.solve(scene, plan.t_end, plan.steps, **options)
    given: dict[str, Any] = {
        "integrator": plan.integrator,
        "solver": plan.solver,
        "save_every": plan.save_every,
        **options,
        "start": plan.start,
    }
    return simulate(scene, plan.t_end, plan.dt, **given)
