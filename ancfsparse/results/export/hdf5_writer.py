"""HDF5 files of states, written during a run."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError, OutputError
from ancfsparse.file_names import RUN_MARK
from ancfsparse.results.data.checkpoint_file import checkpoint_of, read_checkpoint, write_checkpoint
from ancfsparse.results.data.disk_space import allocate_disk
from ancfsparse.results.data.hdf5_format import CHECKED, FORMAT, USER_BLOCK
from ancfsparse.results.data.output_lock import OutputLock
from ancfsparse.results.data.recoverable_file import RecoverableFile, recover
from ancfsparse.results.data.run_statistics import RunStats
from ancfsparse.results.data.stored_tables import (
    LAST_MULTIPLIERS,
    LAST_STATE,
    MEMORY,
    REFERENCE,
    SCENE_RECORDS,
    STATISTICS,
    encode_state,
)
from ancfsparse.results.export.deferred_signals import defer_signals
from ancfsparse.results.geometry.scene_outline import Outline
from ancfsparse.system.coordinates.state import State

if TYPE_CHECKING:
    import h5py

TABLES = "q", "v", "a", "lam", "history", "t"
CHUNK_SIZE = 2**11  # numbers in a chunk of a data set (16 KiB)
CHUNK_COLUMNS = 1024  # columns of a chunk, or more in wide tables
# With 586 chunks a state of 600 000 coordinates takes 28 ms to write, with 64 chunks 11 ms, with 16
# chunks 9 ms; a file of forty states 70, 6 and 3 ms to open, and one node of it 1, 1 and 4 ms.
CHUNKS = 16  # of a row, or more in very wide tables
# Larger chunks take new pages of memory: those of 3 MB up to 340 ms in place of 70 for 144 MB.
MAX_CHUNK_COLUMNS = 2**15  # columns of a chunk (256 KiB)
# Chunks of wider tables have one row, so that appending a row does not read chunks back.
MAX_ROWS_TIMES_COLUMNS = 2**20  # numbers in the rows of a chunk
LIBRARY_VERSIONS = ("v108", "v108")
"""Format of HDF5 with checksums of metadata."""
CHUNK_METADATA = 512  # bytes
FILE_METADATA = 2**19  # bytes, also for the statistics of the run
BLOCKS_PER_BYTE = 2  # bytes of the journal per byte of a chunk, which begins within a block


class Writer:
    """Append states to an HDF5 file, which stays readable after any end of the process.

    Data sets ``t`` (k,) [s]; ``q``, ``v``, ``a`` (k, c); ``lam`` (k, m) if there are multipliers;
    ``history`` (k, h) if there are history variables; ``places`` (c,) if only some coordinates are
    saved; as JSON in bytes ``settings``, ``scene`` and, at the end, ``stats``; ``records``, the
    scene itself if a file can contain it; the group ``outline`` for plots; and the last state of a
    finished run (`stored_tables`).  All have checksums; values that were never written are NaN.
    Attributes: ``mark`` and ``format`` identify the file (`hdf5_format`), ``coordinates`` is the
    number of coordinates of the system, and ``run`` a unique identifier of the run.

    HDF5 cannot close a file on a full disk.  The disk space for new rows is therefore allocated
    before they are written.  It writes through a file object of Python (`RecoverableFile`), whose
    bytes are sealed after each of the calls below.  An exception in it, as by Ctrl-C, would leave
    HDF5 in an undefined state, so signals wait until HDF5 returns.

    Parameters
    ----------
    path : str or Path
        The file; a file of an earlier run is replaced.
    n, m, n_history : int
        Numbers of coordinates, multipliers and history variables of the system.
    places : (c,) int array or None
        The coordinates to save; None saves all.
    settings : mapping
        Arguments of the run.
    scene : mapping
        Description of the scene, see `Scene.digest`.

    Attributes
    ----------
    head : bytes
        The run as stored in every checkpoint, if there are checkpoints.

    Raises
    ------
    InputError
        If the file cannot be written, is being written by another run, or is not of a run.
    """

    head = b""

    def __init__(
        self,
        path: str | Path,
        n: int,
        m: int,
        places: NDArray[np.integer[Any]] | None,
        settings: Mapping[str, Any],
        scene: Mapping[str, str],
        n_history: int = 0,
    ) -> None:
        self._path, self._columns = Path(path).absolute(), places
        self.rows, self._last = 0, 0.0
        import uuid

        self._run = uuid.uuid4().hex
        texts = {"settings": json.dumps(dict(settings), default=str)}
        texts["scene"] = json.dumps(dict(scene))
        self._acquire()
        try:
            with defer_signals():
                self._create(texts, n, {"lam": m, "history": n_history})
        except BaseException as stop:  # also an interruption must not leave the file locked
            self._abandon()
            if isinstance(stop, OSError):
                raise self._refusal(stop) from None
            raise

    @classmethod
    def reopen(cls, path: Path) -> Self:
        """Open the file of a run that was killed or interrupted, at its last checkpoint.

        Raises
        ------
        InputError
            If the file cannot be written, is being written by another run, or has no checkpoint.
        """
        import h5py

        writer = cls.__new__(cls)
        writer._path, writer._run = path.absolute(), ""
        rows = read_checkpoint(path).rows
        writer._acquire()
        try:
            with defer_signals():
                recover(writer._path, is_locked_here=True)
                size = writer._path.stat().st_size
                writer._disk = RecoverableFile(writer._path, size)
                writer._disk.seal(size)
                writer._file = file = h5py.File(writer._disk, "r+", libver=LIBRARY_VERSIONS)
                writer.rows, writer._last = rows, float(file["t"][rows - 1])
                writer._columns = file["places"][:] if "places" in file else None
                writer._remove_ending()
                writer._truncate_tables()
                writer._seal()
        except BaseException as stop:  # the file must not stay locked
            writer._abandon()
            if isinstance(stop, OSError):
                raise writer._refusal(stop) from None
            raise
        return writer

    def _abandon(self) -> None:
        """Release a file that was not opened."""
        if hasattr(self, "_disk"):
            self._disk.close()
        self._lock.release()

    def _acquire(self) -> None:
        """Lock the file."""
        try:
            self._lock = OutputLock(self._path, self._run)
        except OSError as refused:
            raise self._refusal(refused) from None

    @property
    def saves_all(self) -> bool:
        """True if all coordinates are saved."""
        return self._columns is None

    def _begin(self) -> h5py.File:
        """Return the empty file."""
        import h5py

        self._lock.clear()
        self._disk = RecoverableFile(self._path)
        return h5py.File(self._disk, "w", libver=LIBRARY_VERSIONS, userblock_size=USER_BLOCK)

    def _create(self, texts: dict[str, str], n: int, others: dict[str, int]) -> None:
        """Create the file without states."""
        # If the run is killed from here on, its file is recognised as that of a run.
        self._lock.mark_new()
        checkpoint_of(self._path).unlink(missing_ok=True)  # of an earlier run
        # HDF5 writes to the disk only when the file is flushed.
        allocate_disk(self._path, 0, FILE_METADATA + sum(map(len, texts.values())))
        self._file = self._begin()
        saved = n if self._columns is None else len(self._columns)
        widths = dict.fromkeys("qva", saved) | {name: n for name, n in others.items() if n}
        for name, columns in widths.items():
            across = max(CHUNKS, -(-columns // MAX_CHUNK_COLUMNS))
            wide = min(columns, max(CHUNK_COLUMNS, -(-columns // across)))
            high = max(1, min(CHUNK_SIZE // wide, MAX_ROWS_TIMES_COLUMNS // columns))
            self._table(name, (columns,), (high, wide))
        self._table("t", (), (CHUNK_SIZE,))
        if self._columns is not None:
            self._file.create_dataset("places", data=self._columns, **CHECKED)
        for name, text in texts.items():
            self._text(name, text)
        self._file.attrs["mark"] = np.bytes_(RUN_MARK)
        self._file.attrs["format"] = FORMAT
        self._file.attrs["coordinates"] = n
        self._file.attrs["run"] = np.bytes_(self._run)
        self._seal()

    def _refusal(self, refused: OSError) -> InputError:
        reason = os.strerror(refused.errno or 0)
        return InputError(f"output {str(self._path)!r} cannot be written: {reason}")

    def _table(self, name: str, columns: tuple[int, ...], chunks: tuple[int, ...]) -> None:
        self._file.create_dataset(
            name,
            (0, *columns),
            float,
            maxshape=(None, *columns),
            chunks=chunks,
            fillvalue=np.nan,
            **CHECKED,
        )

    def _text(self, name: str, text: str) -> None:
        values = np.frombuffer(text.encode(), np.uint8)
        self._file.create_dataset(name, data=values, compression="gzip", compression_opts=1)

    def add_reference(self, q_ref: Vector) -> None:
        """Add the stress-free shape of a run that starts in another shape, (n_all,) [m, 1]."""
        with self._adding(q_ref.nbytes):
            self._file.create_dataset(REFERENCE, data=q_ref, **CHECKED)

    def add_outline(self, outline: Outline) -> None:
        """Add the outline of the scene for plots."""
        with self._adding(outline.nbytes):
            outline.write(self._file)

    def add_records(self, text: str) -> None:
        """Add the scene as the text of a scene file, see `Scene.save`."""
        with self._adding(len(text)):
            self._text(SCENE_RECORDS, text)

    @contextmanager
    def _adding(self, size: int | None) -> Iterator[None]:
        """Change the file, whole or not at all; allocate `size` new bytes, or none for None."""
        with defer_signals():
            if size is not None:
                self._reserve(size)
            yield
            self._seal()

    def _seal(self) -> None:
        """Write the file, and make its present bytes those that are restored after a kill."""
        self._file.flush()
        try:
            self._disk.seal(self._file.id.get_filesize())
        except OSError as full:
            raise self._full(full) from None

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
        """Append rows for the times `t`, or replace all rows from `begin` on.

        Raises
        ------
        OutputError
            If the disk is full; as many rows as fit are appended.
        """
        selected = [x if self._columns is None else x[:, self._columns] for x in (q, v, a)]
        tables = dict(zip(TABLES, (*selected, lam, history, t), strict=True))
        tables = {name: x for name, x in tables.items() if name in self._file and x is not None}
        begin = self.rows if begin is None else begin
        rows = begin + len(t)
        growth = sum(self._growth(self._file[name], rows) for name in tables)
        try:
            with self._adding(growth):
                for name, values in tables.items():
                    table = self._file[name]
                    table.resize(rows, axis=0)
                    table[begin:] = values
        except OutputError:
            if len(t) < 2:
                raise
            for half in (slice(0, len(t) // 2), slice(len(t) // 2, len(t))):
                later = None if history is None else history[half]
                states = q[half], v[half], a[half], lam[half]
                self.append(t[half], *states, later, begin=begin + half.start)
            return
        self.rows = rows
        if len(t):
            self._last = float(t[-1])

    def finish(self, stats: RunStats, last: State | None = None) -> None:
        """Add the statistics of the run, and its last state if available."""
        text = json.dumps(asdict(stats))
        tables: dict[str, Vector] = {}
        texts = {STATISTICS: text}
        if last is not None:
            tables[LAST_STATE], tables[LAST_MULTIPLIERS], texts[MEMORY] = encode_state(last)
        size = sum(map(len, texts.values())) + sum(table.nbytes for table in tables.values())
        # Less was allocated with the last rows, and is there on a full disk.
        with self._adding(size if size > FILE_METADATA // 2 else None):
            self._remove_ending()
            for name, table in tables.items():
                self._file.create_dataset(name, data=table, **(CHECKED if table.size else {}))
            for name, text in texts.items():
                self._text(name, text)

    def _remove_ending(self) -> None:
        """Remove what `finish` has added."""
        for name in (STATISTICS, LAST_STATE, LAST_MULTIPLIERS, MEMORY):
            if name in self._file:
                del self._file[name]

    def keep_checkpoint(self, data: bytes) -> None:
        """Make the present states, with the head and other data, the last checkpoint.

        Raises
        ------
        OutputError
            If the disk is full; the last checkpoint then stays.
        """
        try:
            write_checkpoint(self._path, self.rows, self.head + data)
        except OSError as full:
            raise self._full(full) from None

    def _growth(self, table: h5py.Dataset, rows: int) -> int:
        """Return the number of bytes by which a table grows."""
        high, *wide = table.chunks
        across = -(-table.shape[1] // wide[0]) if wide else 1
        chunks = max(0, -(-rows // high) - -(-self.rows // high)) * across
        return int(chunks * (8 * np.prod(table.chunks) + CHUNK_METADATA))

    def _reserve(self, growth: int) -> None:
        """Allocate new bytes of the file and of the journal."""
        try:
            allocate_disk(self._path, self._file.id.get_filesize(), growth + FILE_METADATA)
            # The next rows are written into chunks that are not full.
            started = sum(map(self._size_of_started, TABLES))
            self._disk.reserve(BLOCKS_PER_BYTE * started + FILE_METADATA)
        except OSError as full:
            raise self._full(full) from None

    def _full(self, refused: OSError) -> OutputError:
        reason = os.strerror(refused.errno or 0)
        return OutputError(reason, str(self._path), self._last)

    def _size_of_started(self, name: str) -> int:
        """Return the number of bytes of chunks of a table that are not full."""
        if name not in self._file or not self.rows % self._file[name].chunks[0]:
            return 0
        table = self._file[name]
        _, *wide = table.chunks
        across = -(-table.shape[1] // wide[0]) if wide else 1
        return int(across * (8 * np.prod(table.chunks) + CHUNK_METADATA))

    def __enter__(self) -> Self:
        """Return the writer."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the file without incomplete rows and unused disk space."""
        with defer_signals():
            try:
                self._truncate_tables()
                self._file.close()
                self._disk.finish()
            finally:
                self._abandon()

    def _truncate_tables(self) -> None:
        """Remove incomplete rows, and those after a checkpoint."""
        for name in TABLES:
            if name in self._file and len(self._file[name]) != self.rows:
                self._file[name].resize(self.rows, axis=0)
