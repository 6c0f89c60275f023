"""Runs of a sweep in forked processes, which start within milliseconds."""

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

BATCH_SECONDS = 0.02  # s, duration of a batch; its messages take 1e-4 s
WORKER_ENDED = "the process of its worker ended"
"""Reason for the failure of a point whose process has ended."""


def can_fork() -> bool:
    """Return True if processes can be forked: on Linux, where no loaded library forbids it."""
    return sys.platform == "linux" and not mp.current_process().daemon


class _Worker:
    """A forked process and its pipe.

    Parameters
    ----------
    task : Task
        The computation at a point.
    others : list of _Worker
        Workers whose pipes the new process inherits and closes.

    Attributes
    ----------
    batch : list of dict
        Its current points.
    pipe : Connection
        The pipe to the process.
    """

    def __init__(self, task: Task, others: list[_Worker]) -> None:
        context = mp.get_context("fork")
        self.batch: list[ParameterPoint] = []
        self.pipe, remote = context.Pipe()
        ends = [self.pipe, *(each.pipe for each in others)]
        self._process: ForkProcess = context.Process(
            target=_serve, args=(task, remote, ends), daemon=True
        )
        with warnings.catch_warnings():  # threads are not used after a fork
            warnings.simplefilter("ignore", DeprecationWarning)
            self._process.start()
        remote.close()

    def send(self, batch: list[ParameterPoint]) -> None:
        """Send points to the process."""
        self.batch = batch
        self.pipe.send(batch)

    def receive(self) -> list[Row] | None:
        """Return the results of its points; None if the process has ended."""
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
    for each in ends:  # otherwise this process would keep them open after the end of the parent
        each.close()
    while True:
        try:
            batch = pipe.recv()
        except (EOFError, ConnectionError):
            return
        pipe.send(evaluate_all(task, batch))


def run_forked(
    task: Task, points: list[ParameterPoint], workers: int, seconds: float
) -> Iterator[tuple[ParameterPoint, Row]]:
    """Run points in forked processes, and yield results as they arrive.

    Parameters
    ----------
    task : Task
        The computation at a point; forked processes inherit it.
    points : list of dict
        The points.
    workers : int
        Number of processes.
    seconds : float
        Approximate time of a point [s].

    Yields
    ------
    point, row
        In any order.  The points of a process that has ended run again one by one, which finds the
        point that ends its process.
    """
    largest = max(1, len(points) // (4 * workers))
    size = min(largest, max(1, round(BATCH_SECONDS / max(seconds, 1e-6))))
    batches = deque(points[k : k + size] for k in range(0, len(points), size))
    crew: list[_Worker] = []
    suspects: list[ParameterPoint] = []
    try:
        while batches or crew:
            while batches and len(crew) < workers:
                crew.append(_Worker(task, crew))
                crew[-1].send(batches.popleft())
            ready = wait([worker.pipe for worker in crew])
            for worker in [each for each in crew if each.pipe in ready]:
                rows = worker.receive()
                if rows is None:
                    suspects += worker.batch
                else:
                    yield from zip(worker.batch, rows, strict=True)
                if rows is None or not batches:
                    crew.remove(worker)
                    worker.end()
                else:
                    worker.send(batches.popleft())
        for point in suspects:
            crew.append(_Worker(task, []))
            crew[0].send([point])
            rows = crew[0].receive()
            yield (
                point,
                Row(dict.fromkeys(task.quantities, math.nan), WORKER_ENDED)
                if not rows
                else rows[0],
            )
            crew.pop().end()
    finally:
        for worker in crew:
            worker.end()
