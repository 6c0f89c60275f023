"""The linear response of a scene to its loads, as a sum of its modes."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import MAX_MAGNITUDE, check_reals
from ancfsparse.errors import InputError
from ancfsparse.integrators.interface.time_grid import TimeGrid, count_steps_from
from ancfsparse.messages import format_value
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.solutions.modes import Modes
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.system import System
from ancfsparse.system_memory import check_memory

if TYPE_CHECKING:
    from ancfsparse.results.solutions.modes import Modes

Vector = NDArray[np.float64]

# States at which forces of second order are looked at.
LOOKS = 9


def modal_response(
    modes: Modes, t_end: float, dt: float, *, damping: ArrayLike | None = None
) -> Trajectory:
    """Sum the responses of modes to the loads of a scene, in motions so small that it is linear.

    Each mode is integrated exactly under loads that are linear from one saved time to the next, so
    `dt` may be as long as the loads allow, whatever the frequencies are.  The motion starts from
    the state the modes are about, with its velocities.

    Parameters
    ----------
    modes : Modes
        Those that take part, from `modes` about an equilibrium, or about another state, whose
        unbalanced forces then set it in motion.
    t_end : float
        Time at the end [s], a whole number of steps after the state.
    dt : float
        Time between saved states, over which loads are taken as linear [s].
    damping : float or array_like, shape (n,), optional
        Damping ratios of all modes or of each [-]; by default the damping of the scene, of which
        what couples modes is left out.

    Returns
    -------
    Trajectory
        ``stats.error`` estimates how far the forces that grow with the square of the motion move a
        node [m], and so what is lost by linearity.  Multipliers are those of the state.

    Raises
    ------
    InputError
        If an argument is invalid, or the scene has drives.

    Notes
    -----
    With modal coordinates of unit mass, ``y'' + c y' + omega^2 y = p(t)``, where ``p`` is what is
    unbalanced in the state by the loads at time t.  The exponential of the matrix of ``(y, y', p,
    p')`` gives a step.  What modes that are left out would move is missing: about ``p / omega^2``
    of each.
    """
    if not isinstance(modes, Modes):
        raise InputError(
            f"modal_response needs the modes of a scene, from modes(...), got {format_value(modes)}"
        )
    system, about = modes.system, modes.about
    assert isinstance(system, System)
    if system.prescribed:
        raise InputError(
            "modal_response takes no drives: replace them by forces, or take simulate or "
            "quasi_static"
        )
    n = count_steps_from(about.t, t_end, dt)
    clock = TimeGrid(about.t, float(dt))
    rates = _damping(modes, damping)
    check_memory("the states of a modal response", 8.0 * (n + 1) * 4 * system.n_all, "a larger dt")
    begin = time.perf_counter()
    t = np.asarray(clock.at(np.arange(n + 1.0)))
    amplitudes = system.loads.amplitudes(t)
    p = _forces(system, modes, amplitudes)
    speeds = modes.shapes @ np.asarray(system.assembly.inertia(about.v))
    y, y_rate = _marched(modes.eigenvalues, rates, p, speeds, clock.dt)
    y_second = p - rates * y_rate - modes.eigenvalues * y
    q, v, a = (x @ modes.shapes for x in (y, y_rate, y_second))
    q += about.q
    lam = np.repeat(about.lam[None], n + 1, axis=0)
    stats = RunStats(solver=f"{len(modes)} modes, exact for loads linear over {clock.dt:.3g} s")
    stats.steps = n
    stats.error = _second_order(system, modes, q, stats)
    stats.march_seconds = time.perf_counter() - begin
    settings = {"t_start": None, "t_end": float(t_end), "dt": clock.dt}
    return Trajectory(system, t, q, v, a, lam, stats, settings)


def _damping(modes: Modes, damping: ArrayLike | None) -> Vector:
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


def _forces(system: System, modes: Modes, amplitudes: Vector) -> Vector:
    """Return the modal forces in the state at all times, (k, n) [N / sqrt(kg)]."""
    about, rest = modes.about, np.zeros(system.n_all)
    shapes = modes.shapes[:, : system.n_free]
    p = np.empty((len(amplitudes), len(modes)))
    for k, each in enumerate(amplitudes):
        if k and (each == amplitudes[k - 1]).all():
            p[k] = p[k - 1]
            continue
        r, _ = system.assembly.residual(about.q, rest, rest, about.lam, system.dead_load, each)
        p[k] = -(shapes @ np.asarray(r)[: system.n_free])
    return p


def _marched(
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


def _second_order(system: System, modes: Modes, q: Vector, stats: RunStats) -> float:
    """Return how far forces of second order in the motion move a node at most [m].

    They are the even part of the forces at rest, which the whole stiffness balances: the modes of a
    beam that turns stretch it, and forces of second order take that back.
    """
    about = modes.about
    equations = EquilibriumEquations(system, stats, t=about.t)
    here = equations.state(about.q, about.lam, 1.0)
    negative = equations.factor(here, equations.stiffness(here, 1.0), 1.0)
    if negative is None:
        return math.nan
    moved = q - about.q
    farthest = int(np.argmax(np.abs(moved[:, system.positions]).max(axis=1)))
    looks = np.linspace(0, len(q) - 1, LOOKS).astype(int)
    worst = 0.0
    for x in moved[np.unique([*looks, farthest])]:
        there, back = (equations.state(about.q + sign * x, about.lam, 1.0) for sign in (1.0, -1.0))
        r, phi = (
            0.5 * (one + other) - none
            for one, other, none in ((there.r, back.r, here.r), (there.phi, back.phi, here.phi))
        )
        dx, _ = equations.correction(StaticState(about.q, about.lam, r, phi))
        whole = np.append(dx, np.zeros(system.n_all - len(dx)))
        places = whole[system.positions].reshape(-1, system.dim)
        worst = max(worst, float(np.linalg.norm(places, axis=1).max()))
    return worst
