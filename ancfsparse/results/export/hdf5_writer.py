"""Saved states, written to an HDF5 file while the run lasts."""

from __future__ import annotations

import errno
import json
import os
import shutil
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, OutputError
from ancfsparse.results.data.file_locks import HDF5_LOCKS
from ancfsparse.results.data.hdf5_format import FORMAT, MARK, USER_BLOCK
from ancfsparse.results.data.interpolation import Array
from ancfsparse.results.data.output_lock import OutputLock
from ancfsparse.results.data.run_statistics import RunStats
from ancfsparse.results.data.stored_tables import (
    LAST_MULTIPLIERS,
    LAST_STATE,
    MEMORY,
    REFERENCE,
    SCENE_RECORDS,
    encode_state,
)
from ancfsparse.results.geometry.scene_outline import Outline
from ancfsparse.system.coordinates.state import State

if TYPE_CHECKING:
    import h5py

# Numbers in one chunk of a data set (16 KiB), the most columns of it, and the columns of a table
# from which on a chunk has one row, so that appending a row does not read chunks back.
CHUNK, WIDE, VERY_WIDE = 2**11, 1024, 2**20
# The format whose notes have checksums and which can be read after a run was killed.
LIBRARY = ("v108", "v108")
# Bytes for what HDF5 notes about a chunk, and about the file beside them: its index, the counts.
NOTE, SLACK = 512, 2**19


class Writer:
    """Append saved states to an HDF5 file; what was appended stays readable whatever comes.

    Data sets ``t`` (k,) [s]; ``q``, ``v``, ``a`` (k, c); ``lam`` (k, m) if there are
    multipliers; ``places`` (c,) if only some coordinates are kept; and as JSON in bytes
    ``settings``, ``scene`` and, once it ends, ``stats``; ``records`` is the scene itself, unless a
    file cannot hold it; the group ``outline`` has what pictures need of the scene, and `tables` the
    last state of a run that has ended.  All have checksums, and what was never written reads as
    NaN.  Attributes: ``mark`` and ``format`` identify the file (`hdf5`),
    ``coordinates`` counts those of the system, and ``run`` is a mark that no other run has.

    HDF5 cannot close a file it has no room for.  So the room for new rows is taken before they are
    given to it.

    Parameters
    ----------
    path : str or Path
        The file; that of an earlier run is replaced.
    n, m : int
        Coordinates of the system, multipliers.
    places : (c,) int array or None
        The coordinates to be kept; None keeps all.
    settings : mapping
        What the run was started with.
    scene : mapping
        Identifies the scene, as `Scene.digest` returns it.

    Raises
    ------
    InputError
        If the file cannot be written, is written by another run, or is of anybody else.
    """

    def __init__(
        self,
        path: str | Path,
        n: int,
        m: int,
        places: NDArray[np.integer[Any]] | None,
        settings: Mapping[str, Any],
        scene: Mapping[str, str],
    ) -> None:
        self._path, self._places = Path(path).absolute(), places
        self.rows, self._last = 0, 0.0
        texts = {"settings": json.dumps(dict(settings), default=str)}
        texts["scene"] = json.dumps(dict(scene))
        try:
            self._claim = OutputLock(self._path)
        except OSError as refused:
            raise self._refusal(refused) from None
        try:
            self._make(texts, n, m)
        except BaseException as stop:  # an interruption, too, must not leave the file locked
            self._claim.release()
            if isinstance(stop, OSError):
                raise self._refusal(stop) from None
            raise

    def _make(self, texts: dict[str, str], n: int, m: int) -> None:
        """Make the file, empty of states."""
        import h5py

        # A run that is killed from here on leaves a file that is known for ours.
        self._claim.begin()
        # HDF5 writes nothing of a file before it is flushed.
        _take_room(self._path, 0, SLACK + sum(map(len, texts.values())))
        self._file = h5py.File(
            self._path, "w", locking=HDF5_LOCKS, libver=LIBRARY, userblock_size=USER_BLOCK
        )
        self._claim.mark()
        kept = n if self._places is None else len(self._places)
        for name, columns in (dict.fromkeys("qva", kept) | ({"lam": m} if m else {})).items():
            wide = min(columns, WIDE)
            high = max(1, min(CHUNK // wide, VERY_WIDE // columns))
            self._table(name, (columns,), (high, wide))
        self._table("t", (), (CHUNK,))
        if self._places is not None:
            self._file.create_dataset("places", data=self._places, fletcher32=True)
        for name, text in texts.items():
            self._text(name, text)
        self._file.attrs["mark"] = np.bytes_(MARK)
        self._file.attrs["format"] = FORMAT
        self._file.attrs["coordinates"] = n
        import uuid

        self._file.attrs["run"] = np.bytes_(uuid.uuid4().hex)
        self._file.flush()

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
            fletcher32=True,
            fillvalue=np.nan,
        )

    def _text(self, name: str, text: str) -> None:
        values = np.frombuffer(text.encode(), np.uint8)
        self._file.create_dataset(
            name, data=values, compression="gzip", compression_opts=1, fletcher32=True
        )

    def add_reference(self, q_ref: Array) -> None:
        """Add the stress-free shape of a run that starts elsewhere, (n_all,) [m, 1]."""
        self._reserve(q_ref.nbytes)
        self._file.create_dataset(REFERENCE, data=q_ref, fletcher32=True)

    def add_outline(self, outline: Outline) -> None:
        """Add the data of the scene that pictures need."""
        self._reserve(outline.nbytes)
        outline.write(self._file)

    def add_records(self, text: str) -> None:
        """Add the scene as the text of a file of its own, see `Scene.save`."""
        self._reserve(len(text))
        self._text(SCENE_RECORDS, text)

    def append(
        self, t: Array, q: Array, v: Array, a: Array, lam: Array, *, begin: int | None = None
    ) -> None:
        """Add rows for the times `t`; from a row on, they take the place of all after it.

        Raises
        ------
        OutputError
            If there is no room for all of them; those there is room for are added.
        """
        kept = [x if self._places is None else x[:, self._places] for x in (q, v, a)]
        tables = dict(zip(("q", "v", "a", "lam", "t"), (*kept, lam, t), strict=True))
        tables = {name: rows for name, rows in tables.items() if name in self._file}
        begin = self.rows if begin is None else begin
        rows = begin + len(t)
        try:
            self._reserve(sum(self._growth(self._file[name], rows) for name in tables))
        except OutputError:
            if len(t) < 2:
                raise
            for half in (slice(0, len(t) // 2), slice(len(t) // 2, len(t))):
                self.append(t[half], q[half], v[half], a[half], lam[half], begin=begin + half.start)
            return
        for name, values in tables.items():
            table = self._file[name]
            table.resize(rows, axis=0)
            table[begin:] = values
        self._file.flush()
        self.rows = rows
        if len(t):
            self._last = float(t[-1])

    def finish(self, stats: RunStats, last: State | None = None) -> None:
        """Add the counts of the run, and all of its last state if that is known."""
        text = json.dumps(asdict(stats))
        tables: dict[str, Array] = {}
        texts = {"stats": text}
        if last is not None:
            tables[LAST_STATE], tables[LAST_MULTIPLIERS], texts[MEMORY] = encode_state(last)
        size = sum(map(len, texts.values())) + sum(table.nbytes for table in tables.values())
        if size > SLACK // 2:  # the room for less was taken with the last rows
            self._reserve(size)
        for name in (*texts, *tables):
            if name in self._file:
                del self._file[name]
        for name, table in tables.items():
            self._file.create_dataset(name, data=table, fletcher32=table.size > 0)
        for name, text in texts.items():
            self._text(name, text)

    def _growth(self, table: h5py.Dataset, rows: int) -> int:
        """Return how many bytes a table will grow by."""
        high, *wide = table.chunks
        across = -(-table.shape[1] // wide[0]) if wide else 1
        chunks = max(0, -(-rows // high) - -(-self.rows // high)) * across
        return int(chunks * (8 * np.prod(table.chunks) + NOTE))

    def _reserve(self, growth: int) -> None:
        try:
            _take_room(self._path, self._file.id.get_filesize(), growth + SLACK)
        except OSError as full:
            reason = os.strerror(full.errno or 0)
            raise OutputError(reason, str(self._path), self._last) from None

    def __enter__(self) -> Self:
        """Give itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the file, without rows that came in part and room that was not used."""
        try:
            for name in ("q", "v", "a", "lam", "t"):
                if name in self._file and len(self._file[name]) != self.rows:
                    self._file[name].resize(self.rows, axis=0)
            self._file.flush()
            size = self._file.id.get_filesize()
            self._file.close()
            if self._path.stat().st_size > size:
                os.truncate(self._path, size)
        finally:
            self._claim.release()


def _take_room(path: Path, begin: int, length: int) -> None:
    """Let a file have some bytes from a place on, or raise the OSError of the system."""
    if not hasattr(os, "posix_fallocate"):  # only Linux has it: look at what is free
        if shutil.disk_usage(path.parent).free < length:
            raise OSError(errno.ENOSPC, "")
        return
    with path.open("r+b") as file:
        size = os.fstat(file.fileno()).st_size
        try:
            os.posix_fallocate(file.fileno(), begin, length)
        except OSError:
            os.ftruncate(file.fileno(), size)
            raise
