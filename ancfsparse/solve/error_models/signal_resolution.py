"""Resolution of signals by time steps: a pulse between two steps, a sine that steps alias."""

from __future__ import annotations

import math
import warnings

import numpy as np

from ancfsparse.errors import InputError, UnresolvedSignalWarning
from ancfsparse.integrators.interface.time_grid import TimeGrid
from ancfsparse.scene.records.signals import TIME_ROUNDING
from ancfsparse.system import System
from ancfsparse.system.used_signals import UsedSignal, signals_of

# Relative error of the impulse, and of the velocity of a free mass.  At 0.1 a sine has six steps in
# a period, and a pulse that does not begin with a step ten.
MAX_IMPULSE_ERROR = 0.1
N_FIRST_STEPS = 64  # of a table, in the search for steps that resolve it


def impulse_error(used: UsedSignal, clock: TimeGrid, n_steps: int) -> float:
    """Return the relative error of the impulse of a signal in a number of steps [-].

    The impulse is the integral of a load, or of the rate of a prescribed motion, and steps see it
    by the trapezoidal rule.  Errors count at the end, and as the sum of those between all times,
    except for the steps in which a signal jumps.  A sine has the error of its half waves.
    """
    scale, dt = used.signal.time_scale, clock.dt
    if not dt > MAX_IMPULSE_ERROR * scale.shortest:
        return 0.0
    if not scale.times:
        z = 0.5 * math.pi * dt / scale.shortest
        return 1.0 - z / math.tan(z) if z < 0.5 * math.pi else 1.0
    corners = np.array(scale.times)
    # Before the first corner and after the last the signal is constant.
    steps = (corners[[0, -1]] - clock.begin) / dt
    first, last = np.clip([math.floor(steps[0]) - 1.0, math.ceil(steps[1]) + 1.0], 0.0, n_steps)
    if last <= first:
        return 0.0
    times = np.asarray(clock.at(np.arange(first, last + 1.0)))
    inner = corners[(times[0] < corners) & (corners < times[-1])]
    nodes = np.union1d(times, inner)
    x, weights = np.polynomial.legendre.leggauss(3)  # exact for the rate of a smooth ramp
    half = 0.5 * np.diff(nodes)
    points = (0.5 * (nodes[1:] + nodes[:-1])[:, None] + half[:, None] * x).ravel()
    before = inner - 2.0 * TIME_ROUNDING * np.abs(inner)
    try:
        at_steps, values = used.values(times), used.values(points)
        jumps = np.abs(used.values(np.nextafter(inner, np.inf)) - used.values(before))
    except InputError:  # outside of a table, which the run reports
        return 0.0
    quadrature = (half[:, None] * weights).ravel()
    around = dt * (first * np.abs(at_steps[0]) + (n_steps - last) * np.abs(at_steps[-1]))
    # A run may end while a signal has just begun.
    size = max(float(np.max(quadrature @ np.abs(values) + around)), used.impulse_of_one_change)
    lines = np.stack([np.interp(points, times, column) for column in at_steps.T], axis=1)
    errors = (quadrature[:, None] * (values - lines)).reshape(len(half), len(x), -1).sum(axis=1)
    of_jumps = dt * np.minimum(jumps, np.max(np.abs(at_steps))).sum(axis=0)
    largest = np.maximum(np.abs(errors.sum(axis=0)), np.abs(errors).sum(axis=0) - of_jumps)
    return float(np.max(largest)) / size if size > 0.0 else 0.0


def max_impulse_error(
    system: System, clock: TimeGrid, n_steps: int
) -> tuple[float, UsedSignal | None]:
    """Return the largest relative error of an impulse in a number of steps, and its signal."""
    errors = [(impulse_error(each, clock, n_steps), each) for each in signals_of(system)]
    return max(errors, key=lambda pair: pair[0], default=(0.0, None))


def longest_step(used: UsedSignal, begin: float, end: float) -> float:
    """Return a step that does not alias a sine or a table from one time to another [s]."""
    shortest = used.signal.time_scale.shortest
    if not used.signal.time_scale.times:
        return 0.5 * shortest
    n = N_FIRST_STEPS
    while (end - begin) / n > shortest:
        if impulse_error(used, TimeGrid(begin, (end - begin) / n), n) <= MAX_IMPULSE_ERROR:
            break
        n *= 2
    return (end - begin) / n


def corners_between_steps(system: System, clock: TimeGrid, n_steps: int) -> list[float]:
    """Return the times of signals that steps do not resolve [s]; none if more than the steps."""
    times = {
        time
        for used in signals_of(system)
        if impulse_error(used, clock, n_steps) > MAX_IMPULSE_ERROR
        for time in used.signal.time_scale.times
    }
    return sorted(times) if len(times) <= n_steps else []


def warn_of_unresolved_signals(
    system: System, clock: TimeGrid, n_steps: int, stacklevel: int
) -> None:
    """Warn of the signal that equal steps resolve least, if one is not resolved.

    Warns
    -----
    UnresolvedSignalWarning
        If more than `MAX_IMPULSE_ERROR` of its impulse is missed or comes too early or late.
    """
    error, used = max_impulse_error(system, clock, n_steps)
    if used is not None and error > MAX_IMPULSE_ERROR:
        shortest = used.signal.time_scale.shortest
        warning = UnresolvedSignalWarning(
            f"dt = {clock.dt:.3g} s does not resolve {used.signal!r} of {used.what}, which changes "
            f"within {shortest:.3g} s: these steps miss or shift {100.0 * error:.0f} % of its "
            f"integral over time; take dt = {MAX_IMPULSE_ERROR * shortest:.2g} s or shorter, or an "
            "accuracy in place of dt"
        )
        warnings.warn(warning, stacklevel=stacklevel)
