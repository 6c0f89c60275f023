"""How many steps show what loads and drives do.

Steps longer than the period of a load see it at a slower one, and longer and shorter steps may
agree on that.  So pilots begin with steps in which loads are about linear.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ancfsparse.system import System

Array = NDArray[np.float64]

# Loads are followed where, between steps, they are off a line by this share of their variation.
STRAIGHT = 0.1
# Share of the largest amplitude of a source below which its others are rounding.
ROUNDING = 1e-12
# Steps are halved at most so often.
MOST_HALVINGS = 8
# Steps for each period of a vibration.
SEEN = 8.0
# Places between steps, no two alike, which no period fits.
GOLDEN = 0.5 * (5.0**0.5 - 1.0)


def paced(system: System, t_end: float, fewest: int) -> int:
    """Return the fewest steps, of `fewest` times a power of two, that follow loads and drives.

    Parameters
    ----------
    system : System
        Of the scene, on any mesh.
    t_end : float
        Time at the end [s].
    fewest : int
        Of which there are at least so many.
    """
    return _doubled(fewest, lambda steps: _follows(system, t_end, steps))


def resolving(omega: float, t_end: float, fewest: int) -> int:
    """Return the fewest steps, of `fewest` times a power of two, that show a vibration.

    Parameters
    ----------
    omega : float
        Its angular frequency [1/s].
    t_end : float
        Time at the end [s].
    fewest : int
        Of which there are at least so many.
    """
    return _doubled(fewest, lambda steps: 2.0 * np.pi * steps >= SEEN * omega * t_end)


def _doubled(steps: int, enough: Callable[[int], bool]) -> int:
    for _ in range(MOST_HALVINGS):
        if enough(steps):
            break
        steps *= 2
    return steps


def courses(system: System, times: Array) -> list[Array]:
    """Return amplitudes of loads and coordinates of drives over time, each (k, m)."""
    tables = [np.asarray(system.loads.amplitudes(times))]
    if system.prescribed:
        tables.append(np.asarray(system.prescribed.tabulate(times)[0]))
    return tables


def _follows(system: System, t_end: float, steps: int) -> bool:
    dt, first = t_end / steps, np.arange(steps)
    share = GOLDEN * (first + 1.0) % 1.0
    known = courses(system, dt * np.arange(steps + 1.0))
    between = courses(system, dt * (first + share))
    for at, off, widths in zip(known, between, _widths(system), strict=True):
        if len(at) <= steps or len(off) < steps:  # a function fails, which its motion states
            return True
        line = (1.0 - share)[:, None] * at[:-1] + share[:, None] * at[1:]
        apart = np.abs(off - line).mean(axis=0)
        varies = np.abs(off - off.mean(axis=0)).mean(axis=0)
        # Parameters that an eigenstrain does not change, say, have amplitudes that are rounding.
        largest = np.abs(off).max(axis=0, initial=0.0)
        of_source = np.repeat(np.arange(len(widths)), widths)
        size = np.zeros(len(widths))
        np.maximum.at(size, of_source, largest)
        if (apart > STRAIGHT * varies + ROUNDING * size[of_source]).any():
            return False
    return True


def _widths(system: System) -> list[list[int]]:
    """Return how many columns of each table of `courses` belong to a source, for all sources."""
    widths = [[each.width for each in system.loads.sources]]
    if system.prescribed:
        widths.append(system.prescribed.widths)
    return widths
