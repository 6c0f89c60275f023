"""Time grids of equal steps, and suggested step sizes with few digits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_finite, check_positive
from ancfsparse.errors import InputError, Parameter

ROUNDING = 1e-9  # of a number of steps, relative to the time at the end
MAX_STEPS = 2.0**53  # that a double counts exactly
MIN_TIME = 1e-150  # s; the squares of shorter times, and of longer ones than its inverse, overflow
SQUARES = "whose square is in the range of floating-point numbers"


class TimeGrid:
    """Times of equal steps.

    If the start is an integer multiple of the step, they equal those of a run from t = 0 bit for
    bit.

    Parameters
    ----------
    begin, dt : float
        Start time, and time step [s].
    """

    def __init__(self, begin: float, dt: float) -> None:
        self.begin, self.dt = begin, dt
        first = round(begin / dt)
        self._first = float(first) if dt * first == begin else None

    def at(
        self, steps: float | NDArray[np.float64], fraction: float | NDArray[np.float64] = 0.0
    ) -> Any:
        """Return the time after a number of steps and a fraction of the next [s], or an array."""
        if self._first is None:
            return self.begin + self.dt * (steps + fraction)
        return self.dt * ((self._first + steps) + fraction)  # rounding is that of a run from t = 0


def count_steps_from(t_start: float, t_end: float, dt: float) -> int:
    """Return the number of steps of length ``dt`` from one time to another.

    Raises
    ------
    InputError
        If the end is not after the start, or the step does not divide the time between them.
    """
    if t_start == 0.0:
        return count_steps(t_end, dt)
    end = check_finite("t_end", t_end, "s")
    if end <= t_start:
        raise InputError(
            f"t_end = {end:.10g} s is not after the start, which is a state at t = {t_start:.10g} "
            "s: t_end is the time at the end, not the length of the run"
        )
    dt = as_double("dt", dt)
    if max(abs(t_start), abs(end)) / dt > MAX_STEPS:
        raise InputError(
            f"dt = {dt:g} s is lost in the rounding of times from {t_start:g} s to {end:g} s: take "
            "a larger dt"
        )
    length = end - t_start
    n = max(1, round(length / dt))
    # The rounding of a difference is relative to the times.
    if abs(n * dt - length) > ROUNDING * max(abs(t_start), abs(end)):
        raise InputError(
            f"dt = {dt:g} s does not divide the {length:.6g} s from start, t = {t_start:.10g} s, "
            f"to t_end = {end:.10g} s into whole steps ({length / dt:.6g} of them): try t_end = "
            f"{t_start + n * dt:.15g} s, or dt = {length / n:.15g} s"
        )
    return n


def count_steps(t_end: float, dt: float) -> int:
    """Return the number of steps of length ``dt`` up to ``t_end``.

    Raises
    ------
    InputError
        If either is not positive or the step does not divide the time.
    """
    t_end, dt = as_double("t_end", t_end), as_double("dt", dt)
    step, end = Parameter("dt", f"{dt:g} s"), Parameter("t_end", f"{t_end:g} s")
    if t_end / dt > MAX_STEPS:
        raise InputError(
            "{step} makes {steps:.3g} steps of {end}: take a larger {dt}",
            step=step,
            end=end,
            steps=t_end / dt,
            dt=Parameter("dt"),
        )
    if dt > 1.0 / MIN_TIME:
        raise InputError(
            "{dt} must be at most {most:g} s, {why}, got {given:g} s",
            dt=Parameter("dt"),
            most=1.0 / MIN_TIME,
            why=SQUARES,
            given=dt,
        )
    if dt > t_end * (1.0 + ROUNDING):
        shorter = plain(0.1 * t_end, lambda x: divides(t_end, x))
        raise InputError(
            "{step} is longer than the run, {end}: try {shorter}",
            step=step,
            end=end,
            shorter=Parameter("dt", f"{shorter} s"),
        )
    n = round(t_end / dt)
    if not divides(t_end, dt):
        other_end = plain(n * dt, lambda x: divides(x, dt))
        other_step = plain(t_end / n, lambda x: divides(t_end, x))
        raise InputError(
            "{step} does not divide {end} into whole steps ({steps:.6g} of them): "
            "try {other_end}, or {other_step}",
            step=step,
            end=end,
            steps=t_end / dt,
            other_end=Parameter("t_end", f"{other_end} s"),
            other_step=Parameter("dt", f"{other_step} s"),
        )
    return n


def divides(t_end: float, dt: float) -> bool:
    """Return True if the time is an integer multiple of the step, up to rounding."""
    return abs(round(t_end / dt) * dt - t_end) <= ROUNDING * t_end


def plain(number: float, serves: Callable[[float], bool]) -> str:
    """Return a number as text with the fewest digits for which `serves` is true."""
    texts = (f"{number:.{digits}g}" for digits in range(3, 17))
    return next((text for text in texts if serves(float(text))), repr(number))


def as_double(what: str, value: object) -> float:
    """Return a positive time [s] in double precision whose square does not overflow."""
    seconds = check_positive(what, value, "s")
    if seconds < MIN_TIME:
        raise InputError(f"{what} must be at least {MIN_TIME:g} s, {SQUARES}, got {seconds:g} s")
    return seconds
