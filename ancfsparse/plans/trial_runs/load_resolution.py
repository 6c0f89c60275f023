"""Number of steps that resolves loads and prescribed motions in time.

Steps longer than the period of a load alias it to a longer period, and longer and shorter steps may
agree on that.  Trial runs therefore begin with steps in which loads are nearly linear.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.system import System

MAX_NONLINEARITY = 0.1  # deviation from a line between steps, relative to the variation of a load
ROUNDING = 1e-12  # relative to the largest amplitude of a source
MAX_HALVINGS = 8  # of the step
STEPS_PER_PERIOD = 8.0
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


def _resolves_loads(system: System, t_end: float, steps: int) -> bool:
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
