"""Points of a sweep on forked processes of this machine: they begin in milliseconds."""

from __future__ import annotations

import math
import multiprocessing as mp
import signal
import sys
import warnings
from collections import deque
from collections.abc import Iterator
from multiprocessing.connection import Connection, wait
from typing import TYPE_CHECKING

from ancfsparse.sweeps.point import Row, Task, evaluate_all
from ancfsparse.sweeps.samples import ParameterPoint

if TYPE_CHECKING:
    from multiprocessing.context import ForkProcess

# Time that a call should take, beside a tenth of a millisecond that its messages need [s].
BATCH_SECONDS = 0.02
# Why a point has no numbers whose process ended.
ENDED = "the process of its worker ended"


def can_fork() -> bool:
    """Whether processes can be forked: on Linux, where nothing that is loaded forbids it."""
    return sys.platform == "linux" and not mp.current_process().daemon


class _Worker:
    """A forked process and its pipe.

    Parameters
    ----------
    task : Task
        What is done at every point.
    others : list of _Worker
        Workers whose pipes a new process inherits, and closes.

    Attributes
    ----------
    batch : list of dict
        The points it works on.
    pipe : Connection
        To it.
    """

    def __init__(self, task: Task, others: list[_Worker]) -> None:
        context = mp.get_context("fork")
        self.batch: list[ParameterPoint] = []
        self.pipe, theirs = context.Pipe()
        ends = [self.pipe, *(each.pipe for each in others)]
        self._process: ForkProcess = context.Process(
            target=_serve, args=(task, theirs, ends), daemon=True
        )
        with warnings.catch_warnings():  # threads of OpenMP are not used after a fork
            warnings.simplefilter("ignore", DeprecationWarning)
            self._process.start()
        theirs.close()

    def give(self, batch: list[ParameterPoint]) -> None:
        """Let it work on points."""
        self.batch = batch
        self.pipe.send(batch)

    def take(self) -> list[Row] | None:
        """Return the rows of its points; None if the process has ended."""
        try:
            rows: list[Row] = self.pipe.recv()
        except (EOFError, ConnectionError):
            return None
        return rows

    def end(self) -> None:
        """End the process."""
        self.pipe.close()
        self._process.terminate()
        self._process.join()


def _serve(task: Task, pipe: Connection, ends: list[Connection]) -> None:
    """Evaluate points until the other end of the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends this process
    for each in ends:  # or the other end would stay open here when the parent ends
        each.close()
    while True:
        try:
            batch = pipe.recv()
        except (EOFError, ConnectionError):
            return
        pipe.send(evaluate_all(task, batch))


def run_forked(
    task: Task, points: list[ParameterPoint], workers: int, each: float
) -> Iterator[tuple[ParameterPoint, Row]]:
    """Run points in forked processes, and yield them as they end.

    Parameters
    ----------
    task : Task
        What is done at every point; nothing of it is sent.
    points : list of dict
        The points.
    workers : int
        Number of processes.
    each : float
        Time that a point takes, about [s].

    Yields
    ------
    point, row
        In any order.  Points that were with a process that ended run once more, one at a time, so
        that the one that ends it is found.
    """
    most = max(1, len(points) // (4 * workers))
    size = min(most, max(1, round(BATCH_SECONDS / max(each, 1e-6))))
    batches = deque(points[k : k + size] for k in range(0, len(points), size))
    crew: list[_Worker] = []
    suspects: list[ParameterPoint] = []
    try:
        while batches or crew:
            while batches and len(crew) < workers:
                crew.append(_Worker(task, crew))
                crew[-1].give(batches.popleft())
            ready = wait([worker.pipe for worker in crew])
            for worker in [each for each in crew if each.pipe in ready]:
                rows = worker.take()
                if rows is None:
                    suspects += worker.batch
                else:
                    yield from zip(worker.batch, rows, strict=True)
                if rows is None or not batches:
                    crew.remove(worker)
                    worker.end()
                else:
                    worker.give(batches.popleft())
        for point in suspects:
            crew.append(_Worker(task, []))
            crew[0].give([point])
            rows = crew[0].take()
            yield (
                point,
                Row(dict.fromkeys(task.quantities, math.nan), ENDED) if not rows else rows[0],
            )
            crew.pop().end()
    finally:
        for worker in crew:
            worker.end()
