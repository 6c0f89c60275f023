"""Starts at which a force is infinite, as where a bent shape begins at a pin that holds no moment.

Every mesh has a finite one, which grows with its elements, and long steps pass over the shock: that
pilots agree is no proof.  So the force at t = 0 is looked at on finer meshes.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from ancfsparse.errors import PlanError
from ancfsparse.plans.discretization_error.mesh_error import elements_of
from ancfsparse.plans.models.model import spread
from ancfsparse.plans.quantities.quantity import Reaction, SectionForceAt
from ancfsparse.plans.trial_runs.solution_methods import Way
from ancfsparse.plans.trial_runs.trial_runs import Pilot, Pilots, tolerances
from ancfsparse.solve import simulate

# Elements of the meshes that are looked at, over those of the finest pilot.
FINER = (4, 16)
# A force that grows with this power of the elements has no limit.
GROWS = 0.25


def check_start(pilots: Pilots, judge: Pilot) -> None:
    """Refuse a force, asked for at all times or at its largest, that has no limit at t = 0.

    Parameters
    ----------
    pilots : Pilots
        Runs.
    judge : Pilot
        That of the chosen elements on the finest mesh.

    Raises
    ------
    PlanError
        If it grows with the number of elements.
    """
    counts = judge.model.counts
    at_rest = pilots.t_end is None or pilots.start is not None
    if at_rest or isinstance(pilots.integrator, Way) or not counts:
        return
    coarser = next((run for run in pilots.done.values() if run is not None
                    and run.model.rungs == judge.model.rungs
                    and elements_of(run) < elements_of(judge)), None)  # fmt: skip
    for i, each in enumerate(pilots.wanted):
        quantity = each.quantity
        if quantity.at == "end" or not isinstance(quantity, Reaction | SectionForceAt):
            continue
        if coarser is not None:
            forces = _first(coarser, i), _first(judge, i)
            if _power(forces, (elements_of(coarser), elements_of(judge))) < GROWS:
                continue
        _look(pilots, judge, i)


def _first(run: Pilot, i: int) -> float:
    return float(np.linalg.norm(run.histories[i][0]))


def _power(forces: tuple[float, float], elements: tuple[int, int]) -> float:
    """Return the power of the elements with which a force grows."""
    less, more = forces
    if less <= 0.0 or more <= 0.0:
        return 0.0
    return math.log(more / less) / math.log(elements[1] / elements[0])


def _look(pilots: Pilots, judge: Pilot, i: int) -> None:
    """Compare the first states of finer meshes."""
    finest = max(judge.model.counts.values())
    assert pilots.t_end is not None
    assert not isinstance(pilots.integrator, Way)
    dt = pilots.t_end / (judge.steps * FINER[-1])
    quantity, forces = pilots.wanted[i].quantity, [_first(judge, i)]
    elements = [elements_of(judge)]
    for more in FINER:
        scene = pilots.built(judge.model.with_counts(spread(pilots.scene, more * finest)))
        run = simulate(scene, dt, dt, integrator=pilots.integrator)
        forces.append(float(np.linalg.norm(quantity.on(scene).history(run)[0])))
        elements.append(sum(scene.body(name).n_elements for name in judge.model.counts))
    pairs = (pairwise(each) for each in (forces, elements))
    powers = [_power(*each) for each in zip(*pairs, strict=True)]
    if min(powers) >= GROWS:
        asked = tolerances(pilots.wanted, judge)[i]
        raise PlanError(
            quantity.name, asked, forces[-1] - forces[-2], quantity.unit, len(forces), 0.0
        )
