"""Number of steps that resolves loads and prescribed motions in time.

Steps longer than the period of a load alias it to a longer period, and longer and shorter steps may
agree on that.  Trial runs therefore begin with steps in which loads are nearly linear.  Loads are
sampled, and signals give the times that samples may miss.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.integrators.interface.time_grid import TimeGrid
from ancfsparse.scene.records.signals import TIME_ROUNDING
from ancfsparse.solve.error_models.signal_resolution import MAX_IMPULSE_ERROR, max_impulse_error
from ancfsparse.system import System
from ancfsparse.system.used_signals import signals_of

MAX_NONLINEARITY = 0.1  # deviation from a line between steps, relative to the variation of a load
ROUNDING = 1e-12  # relative to the largest amplitude of a source
MAX_HALVINGS = 8  # of the step
STEPS_PER_PERIOD = 8.0
MIN_JUMP = 1e-3  # change of a load within rounding of a time, over its largest value there
GOLDEN_RATIO = 0.5 * (5.0**0.5 - 1.0)  # positions between steps that fit no period


def steps_resolving_loads(system: System, t_end: float, min_steps: int) -> int:
    """Return the least of `min_steps` times a power of two that resolves loads until `t_end` [s].

    The system of the scene may have any mesh.
    """
    return _double_until(min_steps, lambda steps: _resolves_loads(system, t_end, steps))


def steps_resolving_vibration(omega: float, t_end: float, min_steps: int) -> int:
    """Return the least of `min_steps` times a power of two that resolves a vibration.

    Its angular frequency is `omega` [1/s], and its duration `t_end` [s].
    """
    phase = STEPS_PER_PERIOD * omega * t_end
    return _double_until(min_steps, lambda steps: 2.0 * np.pi * steps >= phase)


def _double_until(steps: int, is_enough: Callable[[int], bool]) -> int:
    for _ in range(MAX_HALVINGS):
        if is_enough(steps):
            break
        steps *= 2
    return steps


def amplitudes_over_time(system: System, times: Vector) -> list[Vector]:
    """Return amplitudes of loads and prescribed coordinates over time, each (k, m)."""
    tables = [np.asarray(system.loads.amplitudes(times))]
    if system.prescribed:
        tables.append(np.asarray(system.prescribed.tabulate(times)[0]))
    return tables


def check_signals(system: System, t_end: float, steps: int) -> None:
    """Check that a number of steps resolves all signals until `t_end` [s].

    Raises
    ------
    InputError
        If a signal is so short that equal steps would be too many.
    """
    error, used = max_impulse_error(system, TimeGrid(0.0, t_end / steps), steps)
    if used is not None and error > MAX_IMPULSE_ERROR:
        raise InputError(
            f"{used.signal!r} of {used.what} changes within {used.signal.time_scale.shortest:.3g} "
            f"s, and the {steps} equal steps of a trial run of {t_end:g} s would miss or shift "
            f"{100.0 * error:.0f} % of its integral over time: use simulate with an accuracy, "
            "whose steps end where signals begin and end, or a shorter t_end"
        )


def times_with_corners(system: System, times: Vector) -> Vector:
    """Return times with those at which signals begin, end or kink, and the middles between.

    There are at most three times as many.
    """
    corners = [time for used in signals_of(system) for time in used.signal.time_scale.times]
    if not 0 < len(corners) <= len(times):
        return times
    nodes = np.unique(np.clip(corners, times[0], times[-1]))
    return np.union1d(times, np.concatenate([nodes, 0.5 * (nodes[1:] + nodes[:-1])]))


def jumps_inside_steps(system: System, t_end: float, steps: int) -> bool:
    """Return True if a signal of a load jumps inside a step.

    In the step of a jump the load has an error of the size of the jump, which halved steps share if
    their times are as far from the jump.
    """
    for used in signals_of(system):
        times = np.array([each for each in used.signal.time_scale.times if 0.0 < each < t_end])
        number = times * steps / t_end
        times = times[np.abs(number - np.round(number)) > TIME_ROUNDING * steps]
        if used.is_motion or not len(times):
            continue
        ratios = 1.0 - 2.0 * TIME_ROUNDING, 1.0 + 2.0 * TIME_ROUNDING
        before, after = (used.values(ratio * times) for ratio in ratios)
        if (np.abs(after - before) > MIN_JUMP * np.max(np.abs([before, after]))).any():
            return True
    return False


def _resolves_loads(system: System, t_end: float, steps: int) -> bool:
    if max_impulse_error(system, TimeGrid(0.0, t_end / steps), steps)[0] > MAX_IMPULSE_ERROR:
        return False
    dt, first = t_end / steps, np.arange(steps)
    x = GOLDEN_RATIO * (first + 1.0) % 1.0
    at_steps = amplitudes_over_time(system, dt * np.arange(steps + 1.0))
    between = amplitudes_over_time(system, dt * (first + x))
    for at, off, widths in zip(at_steps, between, _widths(system), strict=True):
        if len(at) <= steps or len(off) < steps:  # a function fails; the motion reports it
            return True
        line = (1.0 - x)[:, None] * at[:-1] + x[:, None] * at[1:]
        deviation = np.abs(off - line).mean(axis=0)
        variation = np.abs(off - off.mean(axis=0)).mean(axis=0)
        # Amplitudes of parameters that an eigenstrain leaves constant are rounding errors.
        largest = np.abs(off).max(axis=0, initial=0.0)
        of_source = np.repeat(np.arange(len(widths)), widths)
        size = np.zeros(len(widths))
        np.maximum.at(size, of_source, largest)
        if (deviation > MAX_NONLINEARITY * variation + ROUNDING * size[of_source]).any():
            return False
    return True


def _widths(system: System) -> list[list[int]]:
    """Return the numbers of columns of each source in the tables of `amplitudes_over_time`."""
    widths = [[each.width for each in system.loads.sources]]
    if system.prescribed:
        widths.append(system.prescribed.widths)
    return widths
