"""States written to a file by a thread, while the next ones are computed."""

from __future__ import annotations

from threading import Thread
from time import sleep
from types import TracebackType
from typing import Self

from ancfsparse.array_types import Vector
from ancfsparse.results.data.run_statistics import RunStats
from ancfsparse.results.export.deferred_signals import defer_signals
from ancfsparse.results.export.hdf5_writer import Writer
from ancfsparse.system.coordinates.state import State

# Blocks of 1 MiB take 3 ms to write, and 0.25 ms to give to a thread; smaller ones are fast enough.
MIN_THREAD_BYTES = 2**20  # bytes of a block of states that is written by a thread


class BackgroundWriter:
    """Append states to a file; large blocks are written by a thread, one at a time.

    Each call waits for the block before it, so the file gets the same bytes in the same order as
    without the thread.  An error of the thread is raised by the next call.

    Parameters
    ----------
    writer : Writer
        The file.
    """

    def __init__(self, writer: Writer) -> None:
        self._writer, self._rows = writer, 0
        self._thread: Thread | None = None
        self._failure: BaseException | None = None

    @property
    def rows(self) -> int:
        """Number of states in the file, and of those that the thread is writing."""
        return self._writer.rows if self._thread is None else self._rows

    def append(
        self,
        t: Vector,
        q: Vector,
        v: Vector,
        a: Vector,
        lam: Vector,
        history: Vector | None = None,
        *,
        begin: int | None = None,
    ) -> bool:
        """Append or replace rows as `Writer.append` does.

        Returns
        -------
        bool
            True if the arrays must not change until the next call, as the thread reads them.

        Raises
        ------
        OutputError
            If the disk is full.
        """
        if self._thread is None and self._failure is not None:  # rows before these are missing
            raise self._failure
        block = t, q, v, a, lam, history
        if begin is not None or not self._writer.saves_all or 3 * q.nbytes < MIN_THREAD_BYTES:
            self._wait()
            self._writer.append(*block, begin=begin)
            return False
        self._start(*block)
        return True

    def _start(self, t: Vector, *tables: Vector | None) -> None:
        """Start the thread once the one before has ended."""
        with defer_signals():
            self._join()
            rows, thread = self._writer.rows + len(t), Thread(target=self._write, args=(t, *tables))
            thread.start()
            self._thread, self._rows = thread, rows

    def _write(self, *block: Vector) -> None:
        sleep(0.0)  # the computing thread goes on first: 0.3 ms
        try:
            self._writer.append(*block)
        except BaseException as failure:  # raised by the next call
            self._failure = failure

    def _wait(self) -> None:
        """Wait until the last block is in the file."""
        if self._thread is not None:
            with (
                defer_signals()
            ):  # Python 3.11 takes a thread whose `join` is interrupted for ended
                self._join()

    def _join(self) -> None:
        """Wait for the thread, and raise its error."""
        if self._thread is not None:
            self._thread.join()
            self._thread = None
            if self._failure is not None:
                raise self._failure

    def keep_checkpoint(self, data: bytes) -> None:
        """Make the present states, with other data, the last checkpoint."""
        self._wait()
        self._writer.keep_checkpoint(data)

    def finish(self, stats: RunStats, last: State | None = None) -> None:
        """Add the statistics of the run, and its last state if available."""
        self._wait()
        self._writer.finish(stats, last)

    def __enter__(self) -> Self:
        """Return the writer."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Wait until the thread has ended; raise its error unless there is another one."""
        try:
            self._wait()
        except BaseException:  # an earlier error is the one that is raised
            if error is None:
                raise
