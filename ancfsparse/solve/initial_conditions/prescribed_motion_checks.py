"""Check that prescribed motions are smooth, and that specified rates are their derivatives."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import MAX_MAGNITUDE
from ancfsparse.errors import InputError
from ancfsparse.scene import Signal
from ancfsparse.scene.records.prescribed_motion import PrescribedMotion, PrescribedValue
from ancfsparse.scene.records.signal import is_vectorized
from ancfsparse.system import System
from ancfsparse.system.loads.amplitudes import FunctionAmplitude

N_SAMPLES = 513  # times of the first level
MAX_EXAMINED_TIMES = 3  # intervals with the largest change of the acceleration, which are refined
N_LEVELS = 6  # levels of refinement
REFINEMENT_RATIO = 4  # interval between times of a level over the next level
N_FINER_SAMPLES = 17  # times of a finer level
# A smooth motion changes by a quarter from one level to the next, 2e-4 over all of them.
MIN_JUMP_RATIO = 0.3  # change over one interval on the finest level, over the largest, of a jump
MIN_RELATIVE_CHANGE = 1e-2  # of the largest acceleration, below which a jump is ignored
MAX_JUMP_ROUNDING = 0.1  # rounding over the change, beyond which refinement ends
QUANTITIES = ("acceleration", "velocity", "position")

N_RATE_TIMES = 24  # times at which rates are compared
FIRST_STEP_RATIO = 1e-3  # first step of the differences over the duration of the run
STEP_REDUCTION = 10.0  # between steps, so that motions far shorter than the run are resolved
N_RATE_STEPS = 7  # of the differences
# Error of a rate over the largest one: the impact that a start may have, too.  Rates that a user
# computes by differences are off by 1e-6, a wrong factor or unit by 1e-2 and more.
MAX_RATE_ERROR = 1e-3
MAX_RATE_ROUNDING = 1e-3  # rounding over the largest rate; beyond it differences are inaccurate


def check_prescribed_motions(system: System, t_end: float) -> None:
    """Check prescribed motions for jumps, and their rates by differences.

    Signals state how smooth they are; functions of the user are examined here.

    Parameters
    ----------
    system : System
        Its prescribed motions are checked from its start.
    t_end : float
        End of the motion [s].

    Raises
    ------
    InputError
        With the time of the jump; or with the time, the specified rate, and the one by differences.
    """
    for motion in system.prescribed.courses:
        if callable(motion.value.value) and not isinstance(motion.value.value, Signal):
            _check_smoothness(motion, system.t0, t_end)
        source = motion.source
        parts = source.value, source.rate, source.second_rate
        values = [value for value in parts if value is not None]
        for value, rate in pairwise(values):
            if isinstance(rate.value, Signal) or not is_vectorized(rate.value):
                _check_rate(value, rate, system.t0, t_end)


def _check_smoothness(motion: PrescribedMotion, begin: float, end: float) -> None:
    position = motion.value
    given = motion.second_rate
    source = FunctionAmplitude(position if given is None else given)
    order = 2 if given is None else 0
    times = np.linspace(begin, end, N_SAMPLES)
    values = _values(source, times)
    if values is None:
        return
    for column in range(values.shape[1]):
        jump = _find_jump(source, order, times, values[:, column], column)
        if jump is not None:
            kind, time, size = jump
            unit = position.unit + ("/s2", "/s", "")[kind]
            raise InputError(
                f"{position.what} is not smooth: its {QUANTITIES[kind]} jumps by about {size:.3g} "
                f"{unit} near t = {time:.6g} s, and the motion would ring; take a function whose "
                "second derivative is continuous, such as Ramp(..., smooth=True), "
                "Table(..., smooth=True)"
            )


def _values(source: FunctionAmplitude, times: Vector) -> Vector | None:
    """Return the values; None if the function fails or overflows, which the run reports."""
    values, failure = source.tabulate(times)
    if failure is not None or not np.max(np.abs(values)) < MAX_MAGNITUDE:
        return None
    return values


def _find_jump(
    source: FunctionAmplitude, order: int, times: Vector, values: Vector, column: int
) -> tuple[int, float, float] | None:
    """Return the jump: index in `QUANTITIES`, time [s] and size; None if there is none."""
    step = float(times[1] - times[0])
    accelerations = _accelerations(values, order, step)
    largest = float(np.max(np.abs(accelerations)))
    change = np.abs(np.diff(accelerations))
    size = float(np.max(np.abs(values)))
    for k in np.argsort(-change)[:MAX_EXAMINED_TIMES]:
        time = float(times[k + order // 2] + 0.5 * step)
        jump = _locate_jump(source, order, column, (time, step, float(change[k])), size)
        if jump is not None and jump[3] > MIN_RELATIVE_CHANGE * max(largest, jump[3]):
            return jump[:3]
    return None


def _locate_jump(
    source: FunctionAmplitude,
    order: int,
    column: int,
    coarse: tuple[float, float, float],
    size: float,
) -> tuple[int, float, float, float] | None:
    """Refine the interval of a jump; return its index in `QUANTITIES`, its time and its size.

    The last value is the change of the acceleration on the finest level.
    """
    time, step, change = coarse
    changes, last = [change], np.empty(0)
    for _ in range(N_LEVELS):
        finer = step / REFINEMENT_RATIO
        noise = 4.0 * np.finfo(float).eps * size / finer**order
        if noise > MAX_JUMP_ROUNDING * change:
            break
        times: Vector = time + finer * (
            np.arange(N_FINER_SAMPLES, dtype=float) - N_FINER_SAMPLES // 2
        )
        values = _values(source, times)
        if values is None:
            return None
        differences = np.abs(np.diff(_accelerations(values[:, column], order, finer)))
        k = int(np.argmax(differences))
        step, change, time = (
            finer,
            float(differences[k]),
            float(times[k + order // 2] + 0.5 * finer),
        )
        changes.append(change)
        last = values[:, column]
    if len(changes) < 4 or not changes[-1] > MIN_JUMP_RATIO * max(changes):
        return None
    if order == 0:
        return 0, time, change, change
    # Accelerations grow as 1/h with a jump of the velocity, as 1/h^2 with one of the position.
    growth = (changes[-1] / changes[-3]) ** 0.5
    kind = 0 if growth < REFINEMENT_RATIO**0.5 else 1 if growth < REFINEMENT_RATIO**1.5 else 2
    before, after = (np.diff(last[part], order - kind) for part in (slice(0, 4), slice(-4, None)))
    return kind, time, abs(float(after[-1] - before[0])) / step ** (order - kind), change


def _accelerations(values: Vector, order: int, step: float) -> Vector:
    return np.diff(values, order) / step**order if order else values


def _check_rate(value: PrescribedValue, rate: PrescribedValue, begin: float, end: float) -> None:
    times: Vector = begin + (end - begin) * (
        0.01 + 0.98 * np.arange(N_RATE_TIMES) / (N_RATE_TIMES - 1)
    )
    specified = _values(FunctionAmplitude(rate), times)
    if specified is None:
        return
    source, step = FunctionAmplitude(value), FIRST_STEP_RATIO * (end - begin)
    undecided, by_differences = np.ones(N_RATE_TIMES, dtype=bool), specified.copy()
    eps = float(np.finfo(float).eps)
    for _ in range(N_RATE_STEPS):
        points = _values(source, np.concatenate([times - step, times + step]))
        if points is None:
            return
        before, after = np.split(points, 2)
        measured = (after - before) / (2.0 * step)
        largest = max(float(np.max(np.abs(specified))), float(np.max(np.abs(measured))))
        size = float(np.max(np.abs(points))) + largest * max(abs(begin), abs(end))
        if 4.0 * eps * size / step > MAX_RATE_ROUNDING * largest:
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
