"""Error of a sequence of equilibria for a slow motion: inertia, damping and vibrations."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import ApproximateModesWarning
from ancfsparse.plans.quantities.quantity import Quantity, largest_norm
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.solutions.selected_states import select_states
from ancfsparse.scene import Scene
from ancfsparse.solve import solve_static
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.solve.vibration.modes import modes
from ancfsparse.system import State, System

N_SAMPLES = 9  # states of a motion at which forces are evaluated


def inertia_error(run: Trajectory, quantity: Quantity) -> float:
    """Estimate the difference of a quantity between a slow motion and its equilibria.

    Largest over time [unit of the quantity], from the path that `quasi_static` has returned.

    Notes
    -----
    The sum of the static response to the forces ``M a + C v`` along the path, and of vibrations by
    every change of its rate over the lowest angular frequency.  If that frequency is not positive,
    motions have no equilibrium to follow, and the estimate is infinite.  Vibrations about the first
    equilibrium add to it, see `start_error`.
    """
    omega = lowest_frequency(run)
    if not omega > 0.0:
        return np.inf
    values, dt = quantity.history(run), float(np.diff(run.t).min())
    rates = np.diff(values, axis=0) / dt
    changes = largest_norm(np.diff(rates, axis=0)) if len(rates) > 1 else 0.0
    # Between two states a rate may jump, which excites a vibration by the whole change, or its
    # slope may, which excites one by the acceleration.
    vibration = changes * max(1.0 / (omega**2 * dt), 1.0 / omega)
    vibration += float(np.linalg.norm(rates[0])) / omega
    return vibration + _dynamic_response(run, quantity, values)


def start_error(run: Trajectory, quantity: Quantity) -> float:
    """Return the amplitude of vibrations of a motion that does not begin at equilibrium.

    That is the difference of a quantity between the start and the first equilibrium [its unit].
    """
    assert isinstance(run.system, System)
    start = run.system.q0[None]
    rest = np.zeros_like(start)
    states = select_states(run, slice(1), q=start, v=rest, a=rest)
    first = quantity.history(select_states(run, slice(1)))
    return quantity.largest_difference(quantity.history(states), first)


def is_dynamic(scene: Scene, t_end: float, changes: Sequence[Vector], limit: float) -> bool:
    """Return True if loads are so fast compared with the lowest frequency that inertia matters.

    Parameters
    ----------
    scene : Scene
        On a coarse mesh.
    t_end : float
        Time at the end [s].
    changes : sequence of ndarray, each (k, m)
        Amplitudes of loads and prescribed coordinates at k even times from 0 to the end.
    limit : float
        Largest effect of inertia, relative to the motion [-].

    Notes
    -----
    A displacement with the acceleration ``y''`` lags behind its equilibrium by ``y'' / omega^2``,
    with the lowest angular frequency about the first equilibrium.  Changes faster than the table
    are not resolved.

    Raises
    ------
    AncfError
        If the scene has no equilibrium at its start.
    """
    square = _lowest_eigenvalue(scene, solve_static(scene).state)
    return square <= 0.0 or max_load_acceleration(changes, t_end) > limit * square


def max_load_acceleration(changes: Sequence[Vector], t_end: float) -> float:
    """Return the largest second derivative of loads over their range, see `is_dynamic` [1/s2]."""
    largest = 0.0
    for table in changes:
        rates = np.diff(table, n=2, axis=0) / (t_end / (len(table) - 1)) ** 2
        largest = max(largest, float(np.abs(rates).max() / np.ptp(table, axis=0).max()))
    return largest


def _lowest_eigenvalue(scene: Scene, at: State) -> float:
    with warnings.catch_warnings():  # the symmetric part of the matrices suffices for an estimate
        warnings.simplefilter("ignore", ApproximateModesWarning)
        return float(modes(scene, 1, at=at).eigenvalues[0])


def lowest_frequency(run: Trajectory) -> float:
    """Return the lowest angular frequency about the first, middle and last state [1/s]."""
    squares = []
    for k in sorted({0, len(run.t) // 2, len(run.t) - 1}):
        at = run.system.state(float(run.t[k]), run.q[k], run.v[k], run.a[k], run.lam[k])
        squares.append(_lowest_eigenvalue(run.system.scene, at))
    return float(np.sqrt(max(min(squares), 0.0)))


def _dynamic_response(run: Trajectory, quantity: Quantity, values: Vector) -> float:
    """Return the change of a quantity by forces of inertia and damping along the path."""
    system, t, q = run.system, np.asarray(run.t), np.asarray(run.q)
    assert isinstance(system, System)
    if len(t) < 3:
        return 0.0
    v = np.gradient(q, t, axis=0)
    a = np.zeros_like(q)
    a[1:-1] = (q[2:] - 2.0 * q[1:-1] + q[:-2]) / (t[1] - t[0]) ** 2
    equations, rest = EquilibriumEquations(system, RunStats()), np.zeros(system.n_all)
    samples = np.unique(np.linspace(1, len(t) - 2, N_SAMPLES).astype(int))
    displaced = q[samples].copy()
    for row, k in zip(displaced, samples, strict=True):
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
    changed = select_states(run, samples, q=displaced)
    return quantity.largest_difference(quantity.history(changed), values[samples])
