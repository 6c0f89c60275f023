"""What equilibria leave out of a slow motion: inertia, damping, and vibrations about them."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import ApproximateModesWarning
from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.scene import Scene
from ancfsparse.solve import solve_static
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.solve.vibration.modes import modes
from ancfsparse.system import System

Array = NDArray[np.float64]

# States of the path at which forces of inertia and damping are looked at.
LOOKS = 9


def late(run: Trajectory, quantity: Quantity) -> float:
    """Estimate by how much a quantity of a slow motion differs from that of its equilibria.

    Parameters
    ----------
    run : Trajectory
        What `quasi_static` has returned.
    quantity : Quantity
        Of its scene.

    Returns
    -------
    float
        Largest difference over time [unit of the quantity].

    Notes
    -----
    The sum of what the forces ``M a + C v`` of the path move by its own stiffness, and of
    vibrations: about the first equilibrium, where the motion begins beside it, and by every change
    of its rate over the lowest angular frequency.  Where that frequency is not positive, motions
    have no equilibrium to follow, and the estimate is infinite.
    """
    omega = lowest(run)
    if not omega > 0.0:
        return np.inf
    values, dt = quantity.history(run), float(np.diff(run.t).min())
    rates = np.diff(values, axis=0) / dt
    turns = _largest(np.diff(rates, axis=0)) if len(rates) > 1 else 0.0
    # Between two states a rate may change at once, which leaves a vibration of the whole change,
    # or its slope may, which leaves one of the acceleration.
    vibration = turns * max(1.0 / (omega**2 * dt), 1.0 / omega)
    vibration += float(np.linalg.norm(rates[0])) / omega
    return vibration + _beside(run, quantity, values[:1]) + _pushed(run, quantity, values)


def hurried(scene: Scene, t_end: float, changes: Sequence[Array], most: float) -> bool:
    """Whether inertia surely matters: loads or drives change fast beside the lowest frequency.

    Parameters
    ----------
    scene : Scene
        On a coarse mesh.
    t_end : float
        Time at the end [s].
    changes : sequence of ndarray, each (k, m)
        Amplitudes of loads and coordinates of drives at k even times from 0 to the end.
    most : float
        Share of the motion that inertia may make up [-].

    Notes
    -----
    What changes by ``y''`` lags behind its equilibrium by ``y'' / omega^2``, with the lowest
    angular frequency about the first equilibrium.  Changes faster than the table are not seen.

    Raises
    ------
    AncfError
        If the scene has no equilibrium at its start.
    """
    start = solve_static(scene)
    with warnings.catch_warnings():  # their symmetric part is enough for an estimate
        warnings.simplefilter("ignore", ApproximateModesWarning)
        square = float(modes(scene, 1, at=start.state).eigenvalues[0])
    return square <= 0.0 or haste(changes, t_end) > most * square


def haste(changes: Sequence[Array], t_end: float) -> float:
    """Return the largest second derivative of what changes over its range, see `hurried` [1/s2]."""
    found = 0.0
    for table in changes:
        rates = np.diff(table, n=2, axis=0) / (t_end / (len(table) - 1)) ** 2
        found = max(found, float(np.abs(rates).max() / np.ptp(table, axis=0).max()))
    return found


def _largest(vectors: Array) -> float:
    return float(np.linalg.norm(vectors, axis=1).max(initial=0.0))


def lowest(run: Trajectory) -> float:
    """Return the lowest angular frequency about the first, the middle and the last state [1/s]."""
    scene, found = run.system.scene, []
    for k in sorted({0, len(run.t) // 2, len(run.t) - 1}):
        at = run.system.state(float(run.t[k]), run.q[k], run.v[k], run.a[k], run.lam[k])
        with warnings.catch_warnings():  # their symmetric part is enough for an estimate
            warnings.simplefilter("ignore", ApproximateModesWarning)
            found.append(float(modes(scene, 1, at=at).eigenvalues[0]))
    return float(np.sqrt(max(min(found), 0.0)))


def _beside(run: Trajectory, quantity: Quantity, first: Array) -> float:
    """Return by how much the quantity differs at the start from that of the first equilibrium."""
    assert isinstance(run.system, System)
    start = run.system.q0[None]
    rest = np.zeros_like(start)
    at_start = replace(run, t=run.t[:1], q=start, v=rest, a=rest, lam=run.lam[:1])
    return _largest(quantity.difference(quantity.history(at_start), first))


def _pushed(run: Trajectory, quantity: Quantity, values: Array) -> float:
    """Return what forces of inertia and damping along the path change of the quantity."""
    system, t, q = run.system, np.asarray(run.t), np.asarray(run.q)
    assert isinstance(system, System)
    if len(t) < 3:
        return 0.0
    v = np.gradient(q, t, axis=0)
    a = np.zeros_like(q)
    a[1:-1] = (q[2:] - 2.0 * q[1:-1] + q[:-2]) / (t[1] - t[0]) ** 2
    equations, rest = EquilibriumEquations(system, RunStats()), np.zeros(system.n_all)
    looks = np.unique(np.linspace(1, len(t) - 2, LOOKS).astype(int))
    moved = q[looks].copy()
    for row, k in zip(moved, looks, strict=True):
        equations.move_to(float(t[k]))
        here = equations.state(q[k], run.lam[k], 1.0)
        if equations.factor(here, equations.stiffness(here, 1.0), 1.0) != 0:
            return np.inf
        lam, dead = run.lam[k], system.dead_load
        amplitudes = system.loads.amplitudes(t[k : k + 1])[0]
        moving, _ = system.assembly.residual(q[k], v[k], a[k], lam, dead, amplitudes)
        resting, _ = system.assembly.residual(q[k], rest, rest, lam, dead, amplitudes)
        r = (np.asarray(moving) - np.asarray(resting))[: system.n_free]
        dx, _ = equations.correction(StaticState(here.q, here.lam, r, np.zeros_like(here.phi)))
        row[: len(dx)] += dx
    changed = replace(run, t=t[looks], q=moved, v=run.v[looks], a=run.a[looks], lam=run.lam[looks])
    return _largest(quantity.difference(quantity.history(changed), values[looks]))
