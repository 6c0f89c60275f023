"""Find discontinuities of prescribed motions in position, velocity and acceleration."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import MAX_MAGNITUDE
from ancfsparse.errors import InputError
from ancfsparse.scene import Signal
from ancfsparse.scene.records.prescribed_motion import PrescribedMotion
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
MAX_ROUNDING_RATIO = 0.1  # rounding over the change, beyond which refinement ends
QUANTITIES = ("acceleration", "velocity", "position")


def check_smoothness(system: System, t_end: float) -> None:
    """Check that prescribed motions have no jump in acceleration, velocity or position.

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
        With the time of the jump.
    """
    for course in system.prescribed.courses:
        if callable(course.value.value) and not isinstance(course.value.value, Signal):
            _check_motion(course, system.t0, t_end)


def _check_motion(course: PrescribedMotion, begin: float, end: float) -> None:
    position = course.value
    given = course.second_rate
    source = FunctionAmplitude(position if given is None else given)
    order = 2 if given is None else 0
    times = np.linspace(begin, end, N_SAMPLES)
    values = _values(source, times)
    if values is None or not np.max(np.abs(values)) < MAX_MAGNITUDE:
        return  # it fails or overflows, which the run reports
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
    values, failure = source.tabulate(times)
    return values if failure is None else None


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
        if noise > MAX_ROUNDING_RATIO * change:
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
