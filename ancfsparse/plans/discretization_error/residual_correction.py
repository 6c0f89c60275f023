"""Error of the mesh of an equilibrium by one Newton correction on a mesh twice as fine.

The coarse solution has the residual r on the finer mesh, with the stiffness K.  A quantity with the
gradient j changes by j.(K^-1 r): the residual weighted with the adjoint solution K^-1 j (Becker and
Rannacher, 2001).  The correction K^-1 r takes one solution for all quantities, and they need not be
linear.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ancfsparse.errors import EquilibriumError, StepError
from ancfsparse.plans.discretization_error.richardson import (
    Estimate,
    from_observed_order,
)
from ancfsparse.plans.models.prolongation import prolongate
from ancfsparse.plans.trial_runs.run_differences import goal_difference
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns, as_trajectory
from ancfsparse.results import Equilibrium, RunStats, Trajectory
from ancfsparse.scene import Beam, Scene
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations
from ancfsparse.system import System

REFINEMENT = 2  # ratio of the numbers of elements
MAX_SECOND_CHANGE = 0.5  # by a second correction with the same stiffness, over both


def corrections(trials: TrialRuns, trial: TrialRun) -> list[float] | None:
    """Return the change of every quantity on a mesh twice as fine [its unit].

    If corrections are too large to be linear, or at an unstable state, the finer mesh is solved if
    its elements differ in length, else it is None, as without a finer mesh of the same coordinates.
    """
    if id(trial) not in trials.changes:
        trials.changes[id(trial)] = _changes(trials, trial)
    return trials.changes[id(trial)]


def _changes(trials: TrialRuns, trial: TrialRun) -> list[float] | None:
    finer = _halve_elements(trial)
    if finer is None:
        return None
    changes = _changes_by_corrections(trials, trial, finer)
    if changes is not None or not _is_uneven(finer, trial):
        return changes
    try:
        run = trials.solve(finer, 1, coarser=trial.run)
    except (EquilibriumError, StepError):
        return None
    quantities = [goal.quantity.in_scene(finer) for goal in trials.goals]
    columns = zip(trials.goals, trial.histories, quantities, strict=True)
    return [goal_difference(goal, history, each.history(run)) for goal, history, each in columns]


def _is_uneven(scene: Scene, trial: TrialRun) -> bool:
    """Return True if elements of a beam differ in length, as with nodes at given positions.

    Parts of such meshes may be the same on a mesh with 1.5 times the elements, whose difference is
    then no measure of the error.
    """
    beams = (scene.body(name) for name in trial.model.counts)
    return any(isinstance(beam, Beam) and beam.nodes is not None for beam in beams)


def _changes_by_corrections(trials: TrialRuns, trial: TrialRun, finer: Scene) -> list[float] | None:
    """Return the changes by two corrections; None if these are too large, or fail."""
    runs = _correct(trial.run, finer)
    if runs is None:
        return None
    trials.charge(runs[-1], 1)
    scene, out = runs[-1].system.scene, []
    for goal, history in zip(trials.goals, trial.histories, strict=True):
        once, twice = map(goal.quantity.in_scene(scene).history, runs)
        change = goal_difference(goal, history, twice)
        if goal_difference(goal, once, twice) > MAX_SECOND_CHANGE * change:
            return None
        out.append(change)
    return out


def _halve_elements(trial: TrialRun) -> Scene | None:
    """Return the scene with halved elements of automatic beams; None with meshes of cables."""
    scene = trial.run.system.scene
    for name in trial.model.counts:
        body = scene.body(name)
        if not isinstance(body, Beam):
            return None
        scene = scene.replaced(body, **body.finer(REFINEMENT))
    return scene


def _correct(run: Trajectory, scene: Scene) -> list[Trajectory] | None:
    """Return an equilibrium after one and two corrections on another mesh, by one factorization."""
    start = prolongate(run, scene)
    if start is None:
        return None
    system = System(scene, start)
    lam, t = np.asarray(run.lam)[-1], float(run.t[-1])
    if len(lam) != system.n_multipliers:
        return None
    stats = RunStats(solver="two corrections")
    equations = EquilibriumEquations(system, stats, t=t)
    state = equations.state(system.q0, lam, 1.0)
    if equations.factor(state, equations.stiffness(state, 1.0), 1.0) != 0:
        return None
    out = []
    for _ in range(2):
        state = equations.moved(state, *equations.correction(state), 1.0)
        out.append(as_trajectory(Equilibrium(system, state.q, state.lam, stats, t)))
    return out


def estimate_from_corrections(
    counts: Sequence[int], changes: Sequence[float], order: float
) -> Estimate:
    """Estimate the error of a quantity from its changes on meshes twice as fine.

    The changes [unit] on one mesh or two are proportional to the errors, so that two of them show
    the order.  The error is that at twice the elements of the last mesh.
    """
    n, last = REFINEMENT * counts[-1], changes[-1]
    is_exact = last == 0.0
    if is_exact or len(changes) < 2 or changes[0] == 0.0:
        error = last / (REFINEMENT**order - 1.0)
        return Estimate(n, error, order, is_exact, REFINEMENT, is_exact)
    growth = counts[-1] / counts[0]
    observed = math.log(changes[0] / last) / math.log(growth)
    return from_observed_order(n, last, changes[0] / growth**order, order, observed, REFINEMENT)
