"""Times of the checkpoints of a run."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

from ancfsparse.checks import check_count
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value

UNITS = {"s": 1.0, "min": 60.0, "h": 3600.0}  # s


class Schedule:
    """When checkpoints are due: every few steps, after listed ones, or every few seconds.

    Parameters
    ----------
    argument : object
        The argument `checkpoint` of `simulate`.

    Attributes
    ----------
    argument : int, str or list of int
        The argument.
    steps : list of int
        Numbers of steps before the checkpoints, except for the one at the start.

    Raises
    ------
    InputError
        If the argument is invalid.
    """

    def __init__(self, argument: object) -> None:
        self.argument, self.steps = argument, list[int]()
        self._last, self._written = 0, time.monotonic()
        self._every: int | None = None
        self._seconds: float | None = None
        self._listed: list[int] = []
        if isinstance(argument, str):
            self._seconds = _seconds_in(argument)
        elif isinstance(argument, Sequence):
            self.argument = self._listed = [
                check_count("a step in checkpoint", each) for each in argument
            ]
            if sorted(set(self._listed)) != self._listed:
                raise InputError(
                    f"the steps in checkpoint must increase, got {format_value(argument)}: give "
                    "stats.checkpoints of a run"
                )
        else:
            self.argument = self._every = check_count("checkpoint", argument)

    def next_stop(self, step: int, end: int) -> int:
        """Return the next step, at most `end`, after which the run must stop."""
        if self._every is not None:
            return min(end, (step // self._every + 1) * self._every)
        return min((each for each in self._listed if step < each < end), default=end)

    def is_due(self, step: int) -> bool:
        """Return whether a checkpoint is due after a step."""
        if self._seconds is not None:
            return time.monotonic() >= self._written + self._seconds
        if self._every is not None:
            return step // self._every > self._last // self._every
        return any(self._last < each <= step for each in self._listed)

    def skip(self, step: int) -> None:
        """Wait for the next one, since there can be none after a step."""
        self._last = step

    def keep(self, step: int) -> None:
        """Note a checkpoint after a step."""
        self._last, self._written = step, time.monotonic()
        self.steps.append(step)

    def resume(self, steps: list[int]) -> None:
        """Continue after the checkpoints of a run."""
        self.steps, self._last = list(steps), steps[-1] if steps else 0


def _seconds_in(text: str) -> float:
    """Return a time such as "5 min" in seconds."""
    number, _, unit = text.strip().partition(" ")
    try:
        seconds = float(number) * UNITS[unit.strip()]
    except (KeyError, ValueError):
        seconds = 0.0
    if not 0.0 < seconds < math.inf:
        raise InputError(
            f"checkpoint must be a number of steps such as 1000, or a time such as '5 min', got "
            f"{format_value(text)}: units are {', '.join(UNITS)}"
        )
    return seconds
