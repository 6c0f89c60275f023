"""Interleaved timed runs: time, error, counts, and reasons of failures."""

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

MAX_REPEATED = 0.5  # time of a run that is repeated [s]
MIN_TIMED_FRACTION = 0.8  # timed part of a run that is corrected for other processes
MAX_ERROR = 1.0  # of a tip that is a result: half the rod [m]


class FailedError(Exception):
    """A run ended without a result; the message is the reason, for the chart."""


@dataclass(frozen=True)
class Sample:
    """One run."""

    seconds: float  # wall time of the time loop or solver alone [s]
    tip: Tips  # (k, 2), tip at the output times [m]
    # evaluations, factorizations and solutions, as far as the program reports them
    counts: dict[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Task:
    """Something to run, with its names in tables."""

    program: str  # `OURS` or the name of another code
    method: str  # the integrator
    solver: str  # how its equations are solved; empty for explicit methods
    model: str  # key of `MODELS`, or that of another code
    elements: int  # their number
    knob: str  # what `value` is: ``"dt"`` [s] or ``"rtol"`` [-]
    value: float  # time step or tolerance
    # runs once; raises `FailedError` if there is no result
    run: Callable[[], Sample] = field(repr=False, compare=False)

    @property
    def name(self) -> str:
        """Program, method and solver in one line."""
        own = self.method if self.program == OURS else f"{self.program}, {self.method}"
        return f"{own}, {self.solver}" if self.solver else own


@dataclass(frozen=True)
class Point:
    """A task that was run."""

    task: Task
    seconds: float = math.nan  # its best time [s]; NaN without result
    # largest distance of the tip from the reference [m]; NaN without result
    error: float = math.nan
    counts: dict[str, int] = field(default_factory=dict)  # of one run
    note: str = ""  # why there is no result

    @property
    def finished(self) -> bool:
        """True if there is a result."""
        return not self.note

    def record(self) -> dict[str, Any]:
        """Return the entries of the CSV table; None where there is no result."""
        found = {"seconds": self.seconds, "tip_error_m": self.error, **self.counts}
        row: dict[str, Any] = plain(plain(self.task) | found | {"note": self.note})
        return row


def measure(
    tasks: Sequence[Task],
    reference: Callable[[Task], Tips],
    rounds: int,
    bar: tqdm[Any],
    long: float = MAX_REPEATED,
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
    if not error <= MAX_ERROR:
        return Point(task, note=f"unstable, the tip is off by {error:.0e} m", counts=sample.counts)
    return Point(task, sample.seconds, error, sample.counts)


def timed(task: Task) -> Sample:
    """Run once, corrected for the time that other processes took.

    On a busy machine long runs are interrupted and short ones are not, so a timed part that makes
    up most of its run is multiplied by the fraction of the processor that the run had.
    """
    wall, processor = time.perf_counter(), time.process_time()
    sample = task.run()
    wall, processor = time.perf_counter() - wall, time.process_time() - processor
    if MIN_TIMED_FRACTION * wall < sample.seconds <= wall:
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
