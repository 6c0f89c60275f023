"""HDF5 files of states that can be restored as they were at a checkpoint."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, TracebackType
from typing import TYPE_CHECKING, Any, Self

from ancfsparse.array_types import Vector
from ancfsparse.errors import OutputError
from ancfsparse.results.data.hdf5_format import USER_BLOCK
from ancfsparse.results.data.recoverable_file import RecoverableFile, read_checkpoint, restore
from ancfsparse.results.data.run_statistics import RunStats
from ancfsparse.results.export.hdf5_writer import (
    CHUNK_METADATA,
    FILE_METADATA,
    LIBRARY_VERSIONS,
    TABLES,
    Writer,
)
from ancfsparse.system.coordinates.state import State

if TYPE_CHECKING:
    import h5py

BLOCKS_PER_BYTE = 2  # bytes of the journal per byte of a chunk, which begins within a block


class RecoverableWriter(Writer):
    """Writer of a run with checkpoints; parameters and errors as for `Writer`.

    HDF5 writes through a file object of Python here (`RecoverableFile`).  An exception in it, as by
    Ctrl-C, would leave HDF5 in an undefined state, so signals wait until HDF5 returns.
    """

    _disk: RecoverableFile

    @classmethod
    def reopen(cls, path: Path) -> Self:
        """Restore the file of a run at its last checkpoint, and open it to continue the run.

        Raises
        ------
        InputError
            If the file cannot be written, is being written by another run, or has no checkpoint.
        """
        import h5py

        writer = cls.__new__(cls)
        writer._path, writer._run, data = path.absolute(), "", read_checkpoint(path)
        writer._acquire()
        try:
            writer._disk = RecoverableFile(writer._path, restore(writer._path), data)
            writer._file = file = h5py.File(writer._disk, "r+", libver=LIBRARY_VERSIONS)
            writer.rows, writer._last = len(file["t"]), float(file["t"][-1])
            writer._columns = file["places"][:] if "places" in file else None
        except BaseException as stop:  # the file must not stay locked
            writer._abandon()
            if isinstance(stop, OSError):
                raise writer._refusal(stop) from None
            raise
        return writer

    def _abandon(self) -> None:
        if hasattr(self, "_disk"):
            self._disk.close()
        super()._abandon()

    def _begin(self) -> h5py.File:
        import h5py

        self._disk = RecoverableFile(self._path)
        self._disk.truncate(0)
        return h5py.File(self._disk, "w", libver=LIBRARY_VERSIONS, userblock_size=USER_BLOCK)

    def seal(self, data: bytes) -> None:
        """Make the present states, with the head and other data, the last checkpoint.

        Raises
        ------
        OutputError
            If the disk is full; the last checkpoint then stays.
        """
        with defer_signals():
            self._file.flush()
            try:
                self._disk.seal(self.head + data, self._file.id.get_filesize())
                # The next rows are written into chunks that are not full.
                started = sum(map(self._size_of_started, TABLES))
                self._disk.reserve(BLOCKS_PER_BYTE * started + FILE_METADATA)
            except OSError as full:
                reason = os.strerror(full.errno or 0)
                raise OutputError(reason, str(self._path), self._last) from None

    def _size_of_started(self, name: str) -> int:
        """Return the number of bytes of chunks of a table that are not full."""
        if name not in self._file:
            return 0
        table = self._file[name]
        high, *wide = table.chunks
        across = -(-table.shape[1] // wide[0]) if wide else 1
        size = table.dtype.itemsize * high * (wide[0] if wide else 1) + CHUNK_METADATA
        return across * size if self.rows % high else 0

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
    ) -> None:
        """Append rows, as `Writer.append` does."""
        with defer_signals():
            super().append(t, q, v, a, lam, history, begin=begin)

    def _reserve(self, growth: int) -> None:
        super()._reserve(growth)
        try:
            self._disk.reserve(FILE_METADATA)
        except OSError as full:
            reason = os.strerror(full.errno or 0)
            raise OutputError(reason, str(self._path), self._last) from None

    def finish(self, stats: RunStats, last: State | None = None) -> None:
        """Add statistics and last state, as `Writer.finish` does."""
        with defer_signals():
            super().finish(stats, last)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the file, and the journal, which stays."""
        with defer_signals():
            try:
                super().__exit__(kind, error, trace)
            finally:
                self._disk.close()

    def _truncate(self, size: int) -> None:
        self._disk.release()


@contextmanager
def defer_signals() -> Iterator[None]:
    """Let signals with handlers in Python wait for the end of a block."""
    if threading.current_thread() is not threading.main_thread():  # others get no signals
        yield
        return
    waiting: list[tuple[int, FrameType | None]] = []

    def wait(number: int, frame: FrameType | None) -> None:
        waiting.append((number, frame))

    number: int
    handlers: dict[int, Callable[[int, FrameType | None], Any]] = {}
    try:
        for number in signal.valid_signals():
            handler = signal.getsignal(number)
            if callable(handler):
                handlers[number] = handler
                signal.signal(number, wait)
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for number, frame in waiting:
            handlers[number](number, frame)
