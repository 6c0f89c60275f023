"""Central differences in place of an implicit integrator, if their stable steps take less work."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ancfsparse.errors import AncfError
from ancfsparse.integrators import CentralDifference
from ancfsparse.plans.discretization_error.error_model import ErrorModel
from ancfsparse.plans.models.model import RIGID
from ancfsparse.plans.trial_runs.cost_model import STEP_OVERHEAD, fit_cost_model
from ancfsparse.plans.trial_runs.run_differences import goal_differences
from ancfsparse.plans.trial_runs.trial_runs import BASE_BUDGET, TrialRuns
from ancfsparse.scene import ElasticBody, Scene
from ancfsparse.solve import stable_step

EXPLICIT = CentralDifference()
STABLE_FRACTION = 0.8  # of the stable step
EXPLICIT_STEP_WORK = 2.2  # per coordinate, relative to a residual: a residual and a mass solve
# Stretch by the slope of one node over its inertia, (2/15 + 2/15) EA l : (1/105 + 1/105) rho A l^3.
SLOPE_RATIO = 14.0  # of E / (rho l^2)


def select_explicit(
    trials: TrialRuns, error_model: ErrorModel
) -> tuple[TrialRuns, ErrorModel] | None:
    """Return runs by central differences if their stable steps take less work; else None.

    With the error model of the implicit runs, but explicit steps and their cost.
    """
    if RIGID in error_model.model.elements.values():  # flexible beams are needed to verify it
        return None
    n_longest, steps = error_model.optimum()
    model = trials.with_mesh(error_model.model, n_longest)
    scene = trials.build(model)
    assert trials.t_end is not None
    t_end = trials.t_end
    work = error_model.work(n_longest, steps)
    limit = min(BASE_BUDGET, work)

    def cost(stable: float) -> tuple[int, float]:
        """Return the number of explicit steps, and their work."""
        n = math.ceil(max(steps, t_end / (STABLE_FRACTION * stable)))
        return n, n * EXPLICIT_STEP_WORK * (error_model.coordinates(n_longest) + STEP_OVERHEAD)

    if cost(stable_step_bound(scene))[1] >= limit:
        return None
    try:
        n_steps, explicit_work = cost(stable_step(scene, EXPLICIT))
    except AncfError:  # constraints or damping that it does not admit
        return None
    if explicit_work >= limit:
        return None
    explicit = replace(trials.with_integrator(EXPLICIT), base=n_steps)
    run = explicit.run(model, n_steps)
    if run is None or run.cost.work >= work:
        return None
    implicit = trials.run(model, steps) if work <= BASE_BUDGET else None
    if implicit is not None:
        differences = goal_differences(trials.goals, implicit, run)
        pairs = zip(differences, error_model.tolerances, strict=True)
        if any(difference > tolerance for difference, tolerance in pairs):
            return None
    selected, cost_model = (n_longest, explicit.base), fit_cost_model(explicit.costs)
    error_model = replace(error_model, selected=selected, cost=cost_model)
    # Confirmation would lead to a finer mesh, and that has a shorter stable step.
    return (explicit, error_model) if error_model.excess(*selected) <= 1.0 else None


def stable_step_bound(scene: Scene) -> float:
    """Return an upper bound of the stable step of central differences without factorization [s].

    The axial slope of one node between two elements, with all other coordinates fixed, vibrates
    more slowly than the fastest vibration of the scene (Rayleigh), at ``sqrt(14 E / rho) / l`` or
    faster, with the greater length l of the two.  Strings have no slopes, and give no bound.
    """
    interval = EXPLICIT.tableau.interval
    least = math.inf
    for body in scene.beams:
        if not isinstance(body, ElasticBody) or body.kind.is_string or body.n_elements < 2:
            continue
        if body.kind.package:  # a user element may stretch otherwise
            continue
        given = body.stiffnesses()
        stiffness, mass = np.min(given["axial_stiffness"]), np.max(given["mass_per_length"])
        omega = math.sqrt(SLOPE_RATIO * stiffness / mass) / float(np.max(body.lengths))
        least = min(least, interval / omega)
    return least
