"""The error of the mesh of an equilibrium, by one correction on a mesh twice as fine.

The coarse solution leaves forces r unbalanced on the finer mesh, whose stiffness is K.  A quantity
with the derivative j changes by j.(K^-1 r): the residual weighted by the adjoint solution K^-1 j,
as Becker and Rannacher (2001) have it.  With one correction K^-1 r there is one solution for all
quantities, and they need not be linear.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ancfsparse.plans.discretization_error.richardson import LEAST_ORDER, SETTLED, Estimate
from ancfsparse.plans.models.prolongation import prolonged
from ancfsparse.plans.trial_runs.trial_runs import Pilot, Pilots, at_rest, distance
from ancfsparse.results import Equilibrium, RunStats, Trajectory
from ancfsparse.scene import Beam, Scene
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations
from ancfsparse.system import System

FINER = 2
# Where a second correction with the same stiffness is more than this share of both, they are no
# small changes.
LINEAR = 0.5


def corrections(pilots: Pilots, pilot: Pilot) -> list[float] | None:
    """Return by how much every quantity changes on a mesh twice as fine [its unit].

    None where corrections do not show it: without a finer mesh of the same coordinates, where they
    are too large to be linear, or at a state that is not stable.
    """
    if id(pilot) not in pilots.changes:
        pilots.changes[id(pilot)] = _changes(pilots, pilot)
    return pilots.changes[id(pilot)]


def _changes(pilots: Pilots, pilot: Pilot) -> list[float] | None:
    finer = _finer(pilot)
    runs = None if finer is None else _corrected(pilot.run, finer)
    if runs is None:
        return None
    pilots.charge(runs[-1], 1)
    scene, out = runs[-1].system.scene, []
    for each, own in zip(pilots.wanted, pilot.histories, strict=True):
        once, twice = map(each.quantity.on(scene).history, runs)
        change = distance(each, own, twice)
        if distance(each, once, twice) > LINEAR * change:
            return None
        out.append(change)
    return out


def _finer(pilot: Pilot) -> Scene | None:
    """Return the scene with all elements divided of open beams; None with open meshes of cables."""
    scene = pilot.run.system.scene
    for name in pilot.model.counts:
        body = scene.body(name)
        if not isinstance(body, Beam):
            return None
        scene = scene.replaced(body, **body.finer(FINER))
    return scene


def _corrected(run: Trajectory, scene: Scene) -> list[Trajectory] | None:
    """Return an equilibrium after one correction on another mesh, and after two by one factor."""
    start = prolonged(run, scene)
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
        out.append(at_rest(Equilibrium(system, state.q, state.lam, stats, t)))
    return out


def of_corrections(
    counts: Sequence[int], changes: Sequence[float], order: float, noise: float
) -> Estimate:
    """Estimate the error of a quantity from its changes on meshes twice as fine.

    Parameters
    ----------
    counts : sequence of int
        Elements of one mesh or of two.
    changes : sequence of float
        The changes, which are as the errors, so that two of them show the order [unit].
    order : float
        Order in which it is known to converge.
    noise : float
        Changes up to here are rounding [unit].

    Returns
    -------
    Estimate
        At twice the elements of the last mesh.
    """
    at, last = FINER * counts[-1], changes[-1]
    is_known = last <= noise
    if is_known or len(changes) < 2 or changes[0] <= noise:
        return Estimate(at, last / (FINER**order - 1.0), order, is_known, FINER, is_known)
    seen = math.log(changes[0] / last) / math.log(counts[-1] / counts[0])
    believed = min(order, max(seen, LEAST_ORDER))
    settled = SETTLED[0] * order <= seen <= SETTLED[1] * order
    return Estimate(at, last / (FINER**believed - 1.0), believed, settled, FINER)
