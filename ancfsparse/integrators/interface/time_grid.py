"""Times in round numbers: whole steps, and advice that still divides when it is typed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_finite, check_positive
from ancfsparse.errors import InputError, Parameter

# Rounding that whole steps may differ by from the end, over the end.
WHOLE = 1e-9

# Past this a double cannot count the steps exactly.
MOST_STEPS = 2.0**53

# Shorter times, and steps longer than the inverse, have no square among the doubles [s].
SHORTEST = 1e-150
SQUARES = "whose square is in the range of floating-point numbers"


class TimeGrid:
    """Times of equal steps.

    Where the begin is a whole number of steps they are, bit for bit, those of a run from t = 0.

    Parameters
    ----------
    begin, dt : float
        Time of the start, and the step [s].
    """

    def __init__(self, begin: float, dt: float) -> None:
        self.begin, self.dt = begin, dt
        first = round(begin / dt)
        self._first = float(first) if dt * first == begin else None

    def at(
        self, steps: float | NDArray[np.float64], share: float | NDArray[np.float64] = 0.0
    ) -> Any:
        """Return the time after so many steps and a share of the next [s], or times for arrays."""
        if self._first is None:
            return self.begin + self.dt * (steps + share)
        return self.dt * ((self._first + steps) + share)  # rounded alike whatever step is the first


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
    if max(abs(t_start), abs(end)) / dt > MOST_STEPS:
        raise InputError(
            f"dt = {dt:g} s is lost in the rounding of times from {t_start:g} s to {end:g} s: take "
            "a larger dt"
        )
    length = end - t_start
    n = max(1, round(length / dt))
    # The difference of two times is rounded as they are.
    if abs(n * dt - length) > WHOLE * max(abs(t_start), abs(end)):
        raise InputError(
            f"dt = {dt:g} s does not divide the {length:.6g} s from start, t = {t_start:.10g} s, "
            f"to t_end = {end:.10g} s into whole steps ({length / dt:.6g} of them): try t_end = "
            f"{t_start + n * dt:.15g} s, or dt = {length / n:.15g} s"
        )
    return n


def count_steps(t_end: float, dt: float) -> int:
    """Return the number of steps of length ``dt`` that make ``t_end``.

    Raises
    ------
    InputError
        If either is not positive or the step does not divide the time.
    """
    t_end, dt = as_double("t_end", t_end), as_double("dt", dt)
    step, end = Parameter("dt", f"{dt:g} s"), Parameter("t_end", f"{t_end:g} s")
    if t_end / dt > MOST_STEPS:
        raise InputError(
            "{step} makes {steps:.3g} steps of {end}: take a larger {dt}",
            step=step,
            end=end,
            steps=t_end / dt,
            dt=Parameter("dt"),
        )
    if dt > 1.0 / SHORTEST:
        raise InputError(
            "{dt} must be at most {most:g} s, {why}, got {given:g} s",
            dt=Parameter("dt"),
            most=1.0 / SHORTEST,
            why=SQUARES,
            given=dt,
        )
    if dt > t_end * (1.0 + WHOLE):
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
    """Whether whole steps make the time, but for rounding."""
    return abs(round(t_end / dt) * dt - t_end) <= WHOLE * t_end


def plain(number: float, serves: Callable[[float], bool]) -> str:
    """Write a number with as few digits as serve."""
    texts = (f"{number:.{digits}g}" for digits in range(3, 17))
    return next((text for text in texts if serves(float(text))), repr(number))


def as_double(what: str, value: object) -> float:
    """Return a positive time [s] in double precision, one that can be squared."""
    seconds = check_positive(what, value, "s")
    if seconds < SHORTEST:
        raise InputError(f"{what} must be at least {SHORTEST:g} s, {SQUARES}, got {seconds:g} s")
    return seconds
