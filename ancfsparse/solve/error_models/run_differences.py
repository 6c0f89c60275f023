"""Frequencies and orders of convergence that the differences of runs show.

Shorter steps reduce the error of smooth motions with a power of the step, and that of unresolved
waves only once they resolve them.  Two runs differ by waves if they differ by more in velocity than
in position.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.solve.stepping.sampled_states import (
    SampledStates,
    distances,
    nodal_differences,
    slope_differences,
)
from ancfsparse.system import System

# Orders of convergence are assumed to exceed 1 by these parts of the theoretical excess, measured
# on 2536 pairs of explicit runs of 80 random scenes.
RESOLVED_EXCESS = 0.75
UNRESOLVED_EXCESS = 0.4
RESOLVED_PHASE = 0.1  # phase error of resolved vibrations [rad]
# Error of a run over its difference from a coarser one, however much longer the steps of that are:
# runs of 24 and 30 steps of order 8 showed order 6, and one of 67 had an error of 1 / 22.
MIN_REMAINING = 1.0 / 12.0
# Order of errors in scenes with contact, as of the times of impacts in their steps: with the order
# of the integrator, central differences had 1.6 times the estimate for a cable that falls level.
IMPACT_ORDER = 1.0
MIN_ORDER = 0.1  # observed order of convergence
# Smallest difference of slopes that counts over that of positions.  With 1, a beam off by 9.5 times
# the accuracy has a growth 1 % above the one that counts; with 0.1, ten times that growth, and
# 3000 random runs take 0.9 % more residuals.
MIN_SLOPE_RATIO = 0.1


def difference_frequency(
    system: System, one: SampledStates, other: SampledStates, resolved: bool = False
) -> float:
    """Return the angular frequency of the difference of two runs [rad/s].

    The ratio of velocity to position; if both runs resolve all vibrations, the root of the ratio of
    acceleration to position, which has more of the high ones.  At least a radian during the motion:
    runs begin equal, and where only loads cause accelerations these do not differ at all.
    """
    names = ("q", "a") if resolved else ("q", "v")
    tables = [(getattr(one, name), getattr(other, name)) for name in names]
    position, rate = (
        max(float(np.max(np.abs(x))) for x in nodal_differences(system, *pair)) for pair in tables
    )
    ratio = rate / position if position > 0.0 else 0.0
    return max(math.sqrt(ratio) if resolved else ratio, 1.0 / float(one.t[-1] - one.t[0]))


def difference_growth(
    system: System, one: SampledStates, other: SampledStates, minimum: float
) -> float:
    """Return the largest difference of two runs over the largest in the first half of their time.

    The largest ratio for positions and for each slope of a body: where a beam leaves its plane by
    torsion, errors of the steps in the plane hide it in the positions.  It is 1 if no state of the
    first half is known.

    Parameters
    ----------
    system : System
        Their system.
    one, other : SampledStates
        The runs.
    minimum : float
        Smallest difference of positions in the first half that counts [m].
    """
    t, states = one.t, (system, one.q, other.q)
    is_early = (t > t[0]) & (t <= 0.5 * (t[0] + t[-1]))
    if not is_early.any():
        return 1.0
    growths = [_growth(distances(*states), is_early, minimum)]
    minimum *= MIN_SLOPE_RATIO
    growths += [_growth(slopes, is_early, minimum) for slopes in slope_differences(*states)]
    return max(growths)


def _growth(differences: Vector, is_early: NDArray[np.bool_], minimum: float) -> float:
    largest = float(np.max(differences))
    return largest / max(float(np.max(differences[is_early])), minimum) if largest > 0.0 else 1.0


def assumed_order(order: int, phase: float, has_contact: bool = False) -> float:
    """Return the order of convergence to assume for two runs that differ by a vibration.

    Parameters
    ----------
    order : int
        Order of their integrator.
    phase : float
        Phase error of the vibration in the finer run [rad].
    has_contact : bool, optional
        True if there may be impacts.
    """
    if has_contact:
        return IMPACT_ORDER
    excess = RESOLVED_EXCESS if phase < RESOLVED_PHASE else UNRESOLVED_EXCESS
    return 1.0 + excess * (order - 1.0)


def remaining_error(ratio: float, order: float, minimum: float = MIN_REMAINING) -> float:
    """Return the error of a run over its difference from one with steps longer by a ratio."""
    return float(max(1.0 / (ratio**order - 1.0), minimum))


def observed_order(
    first: float, coarse_difference: float, second: float, third: float, fine_difference: float
) -> float:
    """Return the observed order of convergence, by the differences of three runs.

    Parameters
    ----------
    first, second, third : float
        Resolutions of the runs, ascending.
    coarse_difference, fine_difference : float
        Difference of the first two, and of the last two.
    """
    low, high = MIN_ORDER, 16.0
    ratio = fine_difference / coarse_difference if coarse_difference > 0.0 else math.inf
    if ratio >= difference_ratio(first, second, third, low):
        return low
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        is_low = ratio < difference_ratio(first, second, third, middle)
        low, high = (middle, high) if is_low else (low, middle)
    return low


def difference_ratio(first: float, second: float, third: float, order: float) -> float:
    """Return the difference of the last two of three runs over that of the first two.

    Parameters
    ----------
    first, second, third : float
        Resolutions of the runs, ascending.
    order : float
        Order of their errors.
    """
    a, b, c = (n**-order for n in (first, second, third))
    return float((b - c) / (a - b))
