"""Central differences in place of an implicit integrator, where their stable step is no burden."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ancfsparse.errors import AncfError
from ancfsparse.integrators import CentralDifference
from ancfsparse.plans.discretization_error.error_model import Found
from ancfsparse.plans.models.model import RIGID, spread
from ancfsparse.plans.trial_runs import cost_model
from ancfsparse.plans.trial_runs.trial_runs import FREE, Pilots, distances
from ancfsparse.scene import ElasticBody, Scene
from ancfsparse.solve import stable_step

# What is marched, the share of the stable step, and the work of a step for each coordinate: a
# residual, and a solution with the masses.
EXPLICIT, STABLE, EXPLICIT_STEP = CentralDifference(), 0.8, 2.2
# Stretch by the slope of one node over its inertia, (2/15 + 2/15) EA l : (1/105 + 1/105) rho A l^3.
SLOPE = 14.0


def explicit(pilots: Pilots, found: Found) -> tuple[Pilots, Found] | None:
    """Return runs by central differences where their stable steps take less work; else None.

    Parameters
    ----------
    pilots : Pilots
        Runs by an implicit integrator.
    found : Found
        What they have shown.

    Returns
    -------
    Pilots and Found, or None
        Explicit runs, and the same with their steps and their cost.
    """
    if RIGID in found.model.rungs.values():  # flexible beams are to verify it
        return None
    finest, steps = found.choice()
    model = found.model.with_counts(spread(pilots.scene, finest))
    scene = pilots.built(model)
    assert pilots.t_end is not None
    work = found.work(finest, steps)
    most = min(FREE, work)

    def of(stable: float) -> tuple[int, float]:
        """Return the steps that are needed, and their work."""
        assert pilots.t_end is not None
        needed = math.ceil(max(steps, pilots.t_end / (STABLE * stable)))
        return needed, needed * EXPLICIT_STEP * (found.coordinates(finest) + cost_model.BESIDE)

    if of(longest_step(scene))[1] >= most:
        return None
    try:
        needed, own = of(stable_step(scene, EXPLICIT))
    except AncfError:  # constraints or damping that it does not take
        return None
    if own >= most:
        return None
    mine = replace(pilots.with_integrator(EXPLICIT), base=needed)
    run = mine.run(model, needed)
    if run is None or run.cost.amount >= work:
        return None
    implicit = pilots.run(model, steps) if work <= FREE else None
    if implicit is not None:
        apart = distances(pilots.wanted, implicit, run)
        if any(far > limit for far, limit in zip(apart, found.asked, strict=True)):
            return None
    return mine, replace(found, chosen=(finest, mine.base), cost=cost_model.model(mine.costs))


def longest_step(scene: Scene) -> float:
    """Return a bound of the stable step of central differences that takes no factor [s].

    The slope along the axis of one node between two elements, with all else at rest, vibrates more
    slowly than the fastest vibration of the scene (Rayleigh): at least with ``sqrt(14 E / rho) /
    l`` for the longer length l of the two.  Strings have no slopes, and give no bound.
    """
    interval = EXPLICIT.tableau.interval
    least = math.inf
    for body in scene.beams:
        if not isinstance(body, ElasticBody) or body.kind.is_string or body.n_elements < 2:
            continue
        if body.kind.package:  # an element of somebody's own may stretch otherwise
            continue
        given = body.stiffnesses()
        stiff, dense = np.min(given["axial_stiffness"]), np.max(given["mass_per_length"])
        fastest = math.sqrt(SLOPE * stiff / dense) / float(np.max(body.lengths))
        least = min(least, interval / fastest)
    return least
