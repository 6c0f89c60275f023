"""Whether what drives prescribe has a continuous acceleration, and where not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import MAX_MAGNITUDE
from ancfsparse.errors import InputError
from ancfsparse.scene import Signal
from ancfsparse.scene.records.prescribed_motion import Course
from ancfsparse.system import System
from ancfsparse.system.loads.amplitudes import FunctionAmplitude

Vector = NDArray[np.float64]

# Times at which a motion is looked at, and on how many finer levels the places are where its
# acceleration changes most, each of which has a quarter of the distance between times.
N_SAMPLES, MAX_EXAMINED_TIMES, N_LEVELS, REFINEMENT_RATIO, N_FINER_SAMPLES = 513, 3, 6, 4, 17
# A change over one distance that is left on the finest level is a jump; of a smooth motion it falls
# by a quarter on each, 2e-4 in all.
MIN_JUMP_RATIO = 0.3
# Share of the largest acceleration below which a change is of no consequence, and how much of it
# may be rounding.
MIN_RELATIVE_CHANGE, MAX_ROUNDING_RATIO = 1e-2, 0.1
QUANTITIES = ("acceleration", "velocity", "position")


def check_smoothness(system: System, t_end: float) -> None:
    """Refuse a prescribed motion whose acceleration, velocity or position jumps.

    Signals state how smooth they are; functions of the user are examined here.

    Parameters
    ----------
    system : System
        Its drives are looked at from its start on.
    t_end : float
        End of the motion [s].

    Raises
    ------
    InputError
        With the time of the jump.
    """
    for course in system.prescribed.courses:
        if callable(course.places.value) and not isinstance(course.places.value, Signal):
            _check_motion(course, system.t0, t_end)


def _check_motion(course: Course, begin: float, end: float) -> None:
    places = course.places
    given = course.second_rates
    source = FunctionAmplitude(places if given is None else given)
    order = 2 if given is None else 0
    times = np.linspace(begin, end, N_SAMPLES)
    values = _values(source, times)
    if values is None or not np.max(np.abs(values)) < MAX_MAGNITUDE:
        return  # it fails or overflows somewhere, which the run reports
    for column in range(values.shape[1]):
        found = _find_jump(source, order, times, values[:, column], column)
        if found is not None:
            kind, time, size = found
            unit = places.unit + ("/s2", "/s", "")[kind]
            raise InputError(
                f"{places.what} is not smooth: its {QUANTITIES[kind]} jumps by about {size:.3g} "
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
    """Return what jumps (in `QUANTITIES`), when [s], and by how much; None if nothing does."""
    step = float(times[1] - times[0])
    accelerations = _accelerations(values, order, step)
    largest = float(np.max(np.abs(accelerations)))
    change = np.abs(np.diff(accelerations))
    size = float(np.max(np.abs(values)))
    for k in np.argsort(-change)[:MAX_EXAMINED_TIMES]:
        time = float(times[k + order // 2] + 0.5 * step)
        found = _locate_jump(source, order, column, (time, step, float(change[k])), size)
        if found is not None and found[3] > MIN_RELATIVE_CHANGE * max(largest, found[3]):
            return found[:3]
    return None


def _locate_jump(
    source: FunctionAmplitude,
    order: int,
    column: int,
    coarse: tuple[float, float, float],
    size: float,
) -> tuple[int, float, float, float] | None:
    """Look at a place more and more closely; return what jumps there, when, by how much.

    Behind it is the change of the acceleration on the finest level.
    """
    time, step, change = coarse
    changes, seen = [change], np.empty(0)
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
        apart = np.abs(np.diff(_accelerations(values[:, column], order, finer)))
        k = int(np.argmax(apart))
        step, change, time = finer, float(apart[k]), float(times[k + order // 2] + 0.5 * finer)
        changes.append(change)
        seen = values[:, column]
    if len(changes) < 4 or not changes[-1] > MIN_JUMP_RATIO * max(changes):
        return None
    if order == 0:
        return 0, time, change, change
    # A jump of the velocity makes accelerations that grow as 1/h, one of the position as 1/h^2.
    growth = (changes[-1] / changes[-3]) ** 0.5
    kind = 0 if growth < REFINEMENT_RATIO**0.5 else 1 if growth < REFINEMENT_RATIO**1.5 else 2
    before, after = (np.diff(seen[part], order - kind) for part in (slice(0, 4), slice(-4, None)))
    return kind, time, abs(float(after[-1] - before[0])) / step ** (order - kind), change


def _accelerations(values: Vector, order: int, step: float) -> Vector:
    return np.diff(values, order) / step**order if order else values
