"""Vibrations of quantities in trial runs, by their turning points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.plans.trial_runs.trial_runs import TrialRun

SWING_FRACTION = 0.5  # of the tolerance, above which swings count
MAX_PHASE_ERROR = 1.0  # rad
MIN_SWINGS = 10  # of a vibration
MIN_STATES_PER_SWING = 3.0  # saved states that determine its period


def find_swings(values: Vector, min_size: float) -> tuple[NDArray[np.intp], Vector]:
    """Return the swings of a quantity between successive turning points.

    Of values (k,) at equidistant times, swings above `min_size` [unit of the quantity].

    Returns
    -------
    rows : (n,) int
        Indices of the turning points at their ends.
    sizes : (n,) float
        Differences between the turning points [unit of the quantity].
    """
    turns = np.flatnonzero(np.diff(np.sign(np.diff(values)))) + 1
    sizes = np.abs(np.diff(values[turns]))
    counts = sizes > min_size
    return turns[1:][counts], sizes[counts]


def resolves_vibrations(run: TrialRun, tolerances: Sequence[float]) -> bool:
    """Return True if steps are short enough for the vibrations of the quantities.

    A method of order 2 delays a vibration in each step by a twelfth of the cube of its phase in the
    step.  Two runs whose phase errors exceed `MAX_PHASE_ERROR` may agree by chance.
    """
    for history, tolerance in zip(run.histories, tolerances, strict=True):
        for values in history.T:
            phase = np.pi * len(find_swings(values, SWING_FRACTION * tolerance)[0])
            if phase**3 > 12.0 * MAX_PHASE_ERROR * run.steps**2:
                return False
    return True


def describe_vibration(run: TrialRun, i: int, t_end: float, tolerance: float, unit: str) -> str:
    """Describe the vibration of quantity i in a run; empty without one."""
    history = run.histories[i]
    swings = (find_swings(values, tolerance) for values in history.reshape(len(history), -1).T)
    rows, sizes = max(swings, key=lambda each: len(each[0]))
    if len(rows) < MIN_SWINGS:
        return ""
    states = float(np.median(np.diff(rows)))
    period = 2.0 * t_end * states / (len(history) - 1)
    length = (
        f"about {period:.2g} s, {period * run.steps / t_end:.2g} steps"
        if states >= MIN_STATES_PER_SWING
        else f"{period:.2g} s or less"
    )
    return (
        f"In the last motion it vibrates by up to {sizes.max():.3g} {unit}".rstrip()
        + f" with periods of {length}: axial_damping and bending_damping of the material damp "
        "vibrations"
    )
