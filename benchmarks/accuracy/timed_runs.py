"""Runs in turn against the clock: what each took, how far it was off, and why some failed."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from tqdm import tqdm

from benchmarks.accuracy.models import Tips, distance
from benchmarks.common.files import plain
from benchmarks.common.timing import OURS, in_turn

# A run that took so long is not repeated [s].
LONG = 0.5

# A timed part is most of its run from this share on.
MOST = 0.8

# A tip that is off by more than half the rod is no result [m].
LOST = 1.0


class FailedError(Exception):
    """A run ended without a result; the message is the reason, for the chart."""


@dataclass(frozen=True)
class Sample:
    """One run.

    Attributes
    ----------
    seconds : float
        Wall time of the march or solver alone [s].
    tip : (k, 2) float
        Tip at the instants of the study [m].
    counts : dict of str to int
        What was evaluated, factored and solved, as far as the program reports it.
    """

    seconds: float
    tip: Tips
    counts: dict[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Task:
    """Something to run, with its names in tables.

    Attributes
    ----------
    program : str
        `OURS` or the name of a peer.
    method : str
        The integrator.
    solver : str
        How its equations are solved; empty for explicit methods.
    model : str
        Key of `MODELS`, or the peer's own.
    elements : int
        Their number.
    knob : str
        What `value` is: ``"dt"`` [s] or ``"rtol"`` [-].
    value : float
        Time step or tolerance.
    run : callable
        Runs once; raises `FailedError` if there is no result.
    """

    program: str
    method: str
    solver: str
    model: str
    elements: int
    knob: str
    value: float
    run: Callable[[], Sample] = field(repr=False, compare=False)

    @property
    def name(self) -> str:
        """Program, method and solver in one line."""
        own = self.method if self.program == OURS else f"{self.program}, {self.method}"
        return f"{own}, {self.solver}" if self.solver else own


@dataclass(frozen=True)
class Point:
    """A task that was run.

    Attributes
    ----------
    task : Task
        What was run.
    seconds : float
        Its best time [s]; NaN without result.
    error : float
        Largest distance of the tip from the reference [m]; NaN without result.
    counts : dict of str to int
        Of one run.
    note : str
        Why there is no result.
    """

    task: Task
    seconds: float = math.nan
    error: float = math.nan
    counts: dict[str, int] = field(default_factory=dict)
    note: str = ""

    @property
    def finished(self) -> bool:
        """Whether there is a result."""
        return not self.note

    def record(self) -> dict[str, Any]:
        """Return it by the names that files use; None for what is missing."""
        found = {"seconds": self.seconds, "tip_error_m": self.error, **self.counts}
        row: dict[str, Any] = plain(plain(self.task) | found | {"note": self.note})
        return row


def race(
    tasks: Sequence[Task],
    reference: Callable[[Task], Tips],
    rounds: int,
    bar: tqdm[Any],
    long: float = LONG,
) -> list[Point]:
    """Run all tasks in turn; the time of each is its best, its error the distance of tips [m].

    A failed run, or one of at least `long` seconds, is not repeated.  There is one point for each
    task, in order, failures included.
    """

    def run(task: Task) -> Point:
        bar.set_description(f"{task.name}, {task.knob} = {task.value:g}")
        return _point(task, reference(task))

    def goes_on(task: Task, points: list[Point]) -> bool:
        return points[-1].finished and min(p.seconds for p in points) < long

    return [
        replace(points[0], seconds=min(p.seconds for p in points))
        for points in in_turn(tasks, run, rounds, bar, goes_on)
    ]


def _point(task: Task, reference: Tips) -> Point:
    try:
        sample = timed(task)
    except FailedError as failure:
        return Point(task, note=str(failure))
    error = distance(sample.tip, reference)
    if not error <= LOST:
        return Point(task, note=f"unstable, the tip is off by {error:.0e} m", counts=sample.counts)
    return Point(task, sample.seconds, error, sample.counts)


def timed(task: Task) -> Sample:
    """Run once, and take off the time that other processes took from a run.

    A run of a tenth of a second meets other processes on a busy machine, one of a millisecond may
    slip between them, and to compare their wall times would flatter the short one.  So a timed part
    that makes up most of its run is counted by the share of the processor that the run had.
    """
    wall, processor = time.perf_counter(), time.process_time()
    sample = task.run()
    wall, processor = time.perf_counter() - wall, time.process_time() - processor
    if MOST * wall < sample.seconds <= wall:
        return replace(sample, seconds=sample.seconds * min(1.0, processor / wall))
    return sample


def fastest(points: Sequence[Point], error: float) -> Point | None:
    """Return the fastest of the points whose error is no larger, or None.

    Nothing is interpolated between points.
    """
    good = [p for p in points if p.finished and p.error <= error]
    return min(good, key=lambda p: p.seconds, default=None)


def front(points: Sequence[Point]) -> list[Point]:
    """Return the points that no other beats in error without costing more time, fastest first."""
    best: list[Point] = []
    for point in sorted((p for p in points if p.finished), key=lambda p: (p.seconds, p.error)):
        if not best or point.error < best[-1].error:
            best.append(point)
    return best
