"""Initial states with an infinite force, as of a bent shape at a pin, which transmits no moment.

On every mesh the force is finite and grows with the number of elements, and long steps pass over
the shock, so agreement of trial runs is no proof.  The force at t = 0 is therefore compared on
finer meshes.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from ancfsparse.errors import PlanError
from ancfsparse.plans.discretization_error.run_estimates import elements_of
from ancfsparse.plans.quantities.quantity import Reaction, SectionForceAt
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns, absolute_tolerances
from ancfsparse.solve import simulate

REFINEMENTS = (4, 16)  # elements over those of the finest trial run
MIN_GROWTH_POWER = 0.25  # power of the number of elements with which a force has no limit


def check_initial_force(trials: TrialRuns, reference_run: TrialRun) -> None:
    """Refuse a force over time, or its largest value, that has no limit at t = 0.

    The reference run has the selected elements, on the finest mesh.

    Raises
    ------
    PlanError
        If the force grows with the number of elements by more than its tolerance.  Moments of
        straight beams at rest are rounding, which grows, too.
    """
    counts = reference_run.model.counts
    at_rest = trials.t_end is None or trials.start is not None
    if at_rest or isinstance(trials.integrator, SolutionMethod) or not counts:
        return
    n_elements = elements_of(reference_run)
    coarser = next((run for run in trials.done.values() if run is not None
                    and run.model.elements == reference_run.model.elements
                    and elements_of(run) < n_elements), None)  # fmt: skip
    for i, goal in enumerate(trials.goals):
        quantity = goal.quantity
        if quantity.at == "end" or not isinstance(quantity, Reaction | SectionForceAt):
            continue
        if coarser is not None:
            forces = _initial_force(coarser, i), _initial_force(reference_run, i)
            if _power(forces, (elements_of(coarser), n_elements)) < MIN_GROWTH_POWER:
                continue
        _compare_finer_meshes(trials, reference_run, i)


def _initial_force(run: TrialRun, i: int) -> float:
    return float(np.linalg.norm(run.histories[i][0]))


def _power(forces: tuple[float, float], elements: tuple[int, int]) -> float:
    """Return the power of the number of elements with which a force grows."""
    less, more = forces
    if less <= 0.0 or more <= 0.0:
        return 0.0
    return math.log(more / less) / math.log(elements[1] / elements[0])


def _compare_finer_meshes(trials: TrialRuns, reference_run: TrialRun, i: int) -> None:
    """Compare the initial states on finer meshes."""
    n_longest = max(reference_run.model.counts.values())
    assert trials.t_end is not None
    assert not isinstance(trials.integrator, SolutionMethod)
    dt = trials.t_end / (reference_run.steps * REFINEMENTS[-1])
    quantity, forces = trials.goals[i].quantity, [_initial_force(reference_run, i)]
    elements = [elements_of(reference_run)]
    for factor in REFINEMENTS:
        scene = trials.build(trials.with_mesh(reference_run.model, factor * n_longest))
        run = simulate(scene, dt, dt, integrator=trials.integrator)
        forces.append(float(np.linalg.norm(quantity.in_scene(scene).history(run)[0])))
        elements.append(sum(scene.body(name).n_elements for name in reference_run.model.counts))
    pairs = (pairwise(each) for each in (forces, elements))
    powers = [_power(*each) for each in zip(*pairs, strict=True)]
    tolerance = absolute_tolerances(trials.goals, reference_run)[i]
    if min(powers) >= MIN_GROWTH_POWER and forces[-1] - forces[0] > tolerance:
        raise PlanError(
            quantity.name, tolerance, forces[-1] - forces[-2], quantity.unit, len(forces), 0.0
        )
