"""Check that specified rates of prescribed motions are their derivatives."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import MAX_MAGNITUDE
from ancfsparse.errors import InputError
from ancfsparse.scene import Signal
from ancfsparse.scene.mechanisms.prescribed_joint import RotatingVector
from ancfsparse.scene.records.prescribed_motion import PrescribedMotion, PrescribedValue
from ancfsparse.scene.records.signal import is_vectorized
from ancfsparse.system import System
from ancfsparse.system.loads.amplitudes import FunctionAmplitude

N_TIMES = 24  # times at which rates are compared
FIRST_STEP_RATIO = 1e-3  # first step of the differences over the duration of the run
STEP_REDUCTION = 10.0  # between steps, so that motions far shorter than the run are resolved
N_STEPS = 7
# Error of a rate over the largest one: the impact that a start may have, too.  Rates that a user
# computes by differences are off by 1e-6, a wrong factor or unit by 1e-2 and more.
MAX_RATE_ERROR = 1e-3
MAX_ROUNDING_RATIO = 1e-3  # rounding over the largest rate; beyond it differences are inaccurate


def check_rates(system: System, t_end: float) -> None:
    """Check that rates that the user specifies are derivatives of the prescribed motions.

    Parameters
    ----------
    system : System
        Its prescribed motions are checked from its start.
    t_end : float
        End of the motion [s].

    Raises
    ------
    InputError
        With the time, the specified rate, and the one by differences.
    """
    for motion in system.prescribed.courses:
        values = [value for value in _parts(motion) if value is not None]
        for value, rate in pairwise(values):
            if isinstance(rate.value, Signal) or not is_vectorized(rate.value):
                _check_rate(value, rate, system.t0, t_end)


def _parts(motion: PrescribedMotion) -> tuple[PrescribedValue | None, ...]:
    """Return the motion and its rates; if it rotates a vector, the angle and its rates."""
    last = motion.value if motion.second_rate is None else motion.second_rate
    if isinstance(last.value, RotatingVector):
        return last.value.angle
    return motion.value, motion.rate, motion.second_rate


def _check_rate(value: PrescribedValue, rate: PrescribedValue, begin: float, end: float) -> None:
    times: Vector = begin + (end - begin) * (0.01 + 0.98 * np.arange(N_TIMES) / (N_TIMES - 1))
    specified, failure = FunctionAmplitude(rate).tabulate(times)
    if failure is not None or not np.max(np.abs(specified)) < MAX_MAGNITUDE:
        return  # it fails or overflows, which the run reports
    step = FIRST_STEP_RATIO * (end - begin)
    undecided, by_differences = np.ones(N_TIMES, dtype=bool), specified.copy()
    eps = float(np.finfo(float).eps)
    for _ in range(N_STEPS):
        points, failure = FunctionAmplitude(value).tabulate(
            np.concatenate([times - step, times + step])
        )
        if failure is not None:
            return
        before, after = np.split(points, 2)
        measured = (after - before) / (2.0 * step)
        largest = max(float(np.max(np.abs(specified))), float(np.max(np.abs(measured))))
        size = float(np.max(np.abs(points))) + largest * max(abs(begin), abs(end))
        if 4.0 * eps * size / step > MAX_ROUNDING_RATIO * largest:
            break
        by_differences[undecided] = measured[undecided]
        undecided &= np.any(np.abs(specified - measured) > MAX_RATE_ERROR * largest, axis=1)
        if not undecided.any():
            return
        step /= STEP_REDUCTION
    error = np.max(np.abs(specified - by_differences), axis=1) * undecided
    if not error.any():
        return  # rounding exceeds any rate
    row = int(np.argmax(error))
    column = int(np.argmax(np.abs(specified - by_differences)[row]))
    raise InputError(
        f"{rate.what} is {specified[row, column]:.6g} {rate.unit} at t = {times[row]:.6g} s, and "
        f"differences of {value.what} give {by_differences[row, column]:.6g} {rate.unit} there: "
        "give the derivative, or leave out rate and second_rate, which are approximated then"
    )
