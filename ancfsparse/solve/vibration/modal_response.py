"""Linear response of a scene to its loads by modal superposition."""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import MAX_MAGNITUDE, check_reals
from ancfsparse.errors import InputError
from ancfsparse.integrators.interface.time_grid import TimeGrid, count_steps_from
from ancfsparse.messages import format_value
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.solutions.modes import Modes
from ancfsparse.solve.error_models.signal_resolution import warn_of_unresolved_signals
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.system import System
from ancfsparse.system_memory import check_memory

N_SAMPLES = 9  # states at which forces of second order are evaluated


def modal_response(
    modes: Modes, t_end: float, dt: float, *, damping: ArrayLike | None = None
) -> Trajectory:
    """Superpose the responses of modes to the loads of a scene, for small linear motions.

    Each mode is integrated exactly under loads that are linear between saved times, so `dt` may be
    as long as the loads allow, at any frequency.  The motion starts from the state of the modes,
    with its velocities.

    Parameters
    ----------
    modes : Modes
        Result of `modes` about an equilibrium, or about another state, whose residual forces then
        cause a motion.
    t_end : float
        Time at the end [s], a whole number of steps after the state.
    dt : float
        Time between saved states, over which loads are taken as linear [s].
    damping : float or array_like, shape (n,), optional
        Damping ratios of all modes or of each [-]; by default the damping of the scene, without
        coupling of modes.

    Returns
    -------
    Trajectory
        ``stats.error`` estimates the displacement by forces of second order in the motion [m], the
        error of linearity.  Multipliers are those of the state.

    Raises
    ------
    InputError
        If an argument is invalid, or the scene has prescribed motions.

    Warns
    -----
    UnresolvedSignalWarning
        If the steps miss or alias a signal that a load follows.

    Notes
    -----
    With modal coordinates of unit mass, ``y'' + c y' + omega^2 y = p(t)``, where ``p`` is the
    residual of the state under the loads at time t.  The exponential of the matrix of ``(y, y', p,
    p')`` gives a step.  The response of omitted modes is missing, about ``p / omega^2`` of each.
    """
    if not isinstance(modes, Modes):
        raise InputError(
            f"modal_response needs the modes of a scene, from modes(...), got {format_value(modes)}"
        )
    system, about = modes.system, modes.about
    assert isinstance(system, System)
    if system.prescribed:
        raise InputError(
            "modal_response takes no prescribed motions: replace them by forces, or use simulate "
            "or quasi_static"
        )
    n = count_steps_from(about.t, t_end, dt)
    clock = TimeGrid(about.t, float(dt))
    rates = _damping_rates(modes, damping)
    check_memory("the states of a modal response", 8.0 * (n + 1) * 4 * system.n_all, "a larger dt")
    begin = time.perf_counter()
    t = np.asarray(clock.at(np.arange(n + 1.0)))
    warn_of_unresolved_signals(system, clock, n, stacklevel=3)
    amplitudes = system.loads.amplitudes(t)
    p = _modal_forces(system, modes, amplitudes)
    speeds = modes.shapes @ np.asarray(system.assembly.inertia(about.v))
    y, y_rate = _integrate_modes(modes.eigenvalues, rates, p, speeds, clock.dt)
    y_second = p - rates * y_rate - modes.eigenvalues * y
    q, v, a = (x @ modes.shapes for x in (y, y_rate, y_second))
    q += about.q
    lam = np.repeat(about.lam[None], n + 1, axis=0)
    stats = RunStats(solver=f"{len(modes)} modes, exact for loads linear over {clock.dt:.3g} s")
    stats.steps = n
    stats.error = _quadratic_error(system, modes, q, stats)
    stats.march_seconds = time.perf_counter() - begin
    settings = {"t_start": None, "t_end": float(t_end), "dt": clock.dt}
    return Trajectory(system, t, q, v, a, lam, stats, settings)


def _damping_rates(modes: Modes, damping: ArrayLike | None) -> Vector:
    """Return the damping rates c of all modes [1/s]."""
    if damping is None:
        return modes.damping_rates
    needed = f"a ratio from 0 to {MAX_MAGNITUDE:g}, or {len(modes)} of them"
    ratios = check_reals("damping", damping, needed)
    if ratios.shape not in ((), (len(modes),)) or not np.all(
        (ratios >= 0.0) & (ratios <= MAX_MAGNITUDE)
    ):
        raise InputError(f"damping must be {needed}, got {format_value(damping)}")
    return np.asarray(4.0 * np.pi * modes.frequencies * ratios)


def _modal_forces(system: System, modes: Modes, amplitudes: Vector) -> Vector:
    """Return the modal forces in the state at all times, (k, n) [N / sqrt(kg)]."""
    about, zero = modes.about, np.zeros(system.n_all)
    shapes = modes.shapes[:, : system.n_free]
    p = np.empty((len(amplitudes), len(modes)))
    for k, amplitude in enumerate(amplitudes):
        if k and (amplitude == amplitudes[k - 1]).all():
            p[k] = p[k - 1]
            continue
        args = about.q, zero, zero, about.lam, system.dead_load, amplitude
        r, _ = system.assembly.residual(*args)
        p[k] = -(shapes @ np.asarray(r)[: system.n_free])
    return p


def _integrate_modes(
    eigenvalues: Vector, rates: Vector, p: Vector, speeds: Vector, dt: float
) -> tuple[Vector, Vector]:
    """Return modal coordinates and their rates at all times, each (k, n)."""
    from scipy.linalg import expm

    n = len(eigenvalues)
    matrix = np.zeros((n, 4, 4))
    matrix[:, 0, 1] = matrix[:, 1, 2] = matrix[:, 2, 3] = 1.0
    matrix[:, 1, 0], matrix[:, 1, 1] = -eigenvalues, -rates
    step = expm(dt * matrix)
    state = np.zeros((n, 4))
    state[:, 1] = speeds
    y = np.empty((len(p), 2, n))
    slopes = np.diff(p, axis=0, append=p[-1:]) / dt
    for k in range(len(p)):
        y[k] = state[:, :2].T
        state[:, 2], state[:, 3] = p[k], slopes[k]
        state = (step @ state[:, :, None])[:, :, 0]
    return y[:, 0], y[:, 1]


def _quadratic_error(system: System, modes: Modes, q: Vector, stats: RunStats) -> float:
    """Return the largest displacement of a node by forces of second order in the motion [m].

    They are the even part of the static forces, balanced by the full stiffness: the modes of a
    rotating beam stretch it, and forces of second order undo that.
    """
    about = modes.about
    equations = EquilibriumEquations(system, stats, t=about.t)
    origin = equations.state(about.q, about.lam, 1.0)
    negative = equations.factor(origin, equations.stiffness(origin, 1.0), 1.0)
    if negative is None:
        return math.nan
    displacements = q - about.q
    farthest = int(np.argmax(np.abs(displacements[:, system.positions]).max(axis=1)))
    samples = np.linspace(0, len(q) - 1, N_SAMPLES).astype(int)
    largest = 0.0
    for x in displacements[np.unique([*samples, farthest])]:
        plus, minus = (equations.state(about.q + sign * x, about.lam, 1.0) for sign in (1.0, -1.0))
        r = 0.5 * (plus.r + minus.r) - origin.r
        phi = 0.5 * (plus.phi + minus.phi) - origin.phi
        dx, _ = equations.correction(StaticState(about.q, about.lam, r, phi))
        full = np.append(dx, np.zeros(system.n_all - len(dx)))
        positions = full[system.positions].reshape(-1, system.dim)
        largest = max(largest, float(np.linalg.norm(positions, axis=1).max()))
    return largest
