"""A file whose bytes at the last checkpoint can be restored, after any end of its process.

HDF5 changes bytes of a file in place: indices of its tables, and chunks that are not full.  A
process that is killed meanwhile leaves a file that HDF5 cannot read.  As in databases, old bytes
are therefore appended to a second file, the rollback journal, before they are overwritten.  The
journal begins with the data of the checkpoint.  The journal of the next checkpoint replaces it by a
renaming, so that data and old bytes always belong together.
"""

from __future__ import annotations

import os
import struct
import zlib
from contextlib import suppress
from io import FileIO
from pathlib import Path
from typing import BinaryIO

from ancfsparse.errors import InputError

JOURNAL_MARK = b"ancfsparse checkpoint 1\n"
NAME_SIZE = 64  # first bytes of a file, which contain the identifier of its run
# Bytes of the data, of the file at the checkpoint; checksum of the data; first bytes of the file.
HEAD = struct.Struct(f"<QQI{NAME_SIZE}s")
RECORD = struct.Struct("<QII")  # number of a block, its bytes, their checksum
BLOCK = 4096  # bytes that are stored together


def journal_of(path: Path) -> Path:
    """Return the name of the journal of a file."""
    return path.with_name(f"{path.name}.checkpoint")


def _checksum(number: int, data: bytes) -> int:
    """Return the checksum of a block, which is not zero for cleared bytes."""
    return zlib.crc32(data, number & 0xFFFFFFFF) ^ 0xFFFFFFFF


class RecoverableFile:
    """A binary file for h5py, with a journal from the first checkpoint on.

    Parameters
    ----------
    path : Path
        The file, which must exist.
    size : int, optional
        Its size at its last checkpoint, which `restore` returned.
    data : bytes, optional
        Data of that checkpoint.
    """

    def __init__(self, path: Path, size: int = 0, data: bytes | None = None) -> None:
        self._path, self._file = path, path.open("r+b", buffering=0)
        self._at, self._end = 0, os.fstat(self._file.fileno()).st_size
        self._journal: FileIO | None = None
        self._sealed, self._stored = 0, set[int]()
        if data is not None:
            self.seal(data, size)

    def seal(self, data: bytes, size: int) -> None:
        """Make the present bytes those that `restore` returns to.

        Parameters
        ----------
        data : bytes
            What else belongs to this checkpoint.
        size : int
            Number of bytes of the file that count.

        Raises
        ------
        OSError
            If the journal cannot be written; the last checkpoint then stays.
        """
        target = journal_of(self._path)
        part = target.with_name(f".{target.name}.{os.getpid()}")
        try:
            with part.open("wb") as file:
                self._file.seek(0)
                name = self._file.read(NAME_SIZE)
                file.write(JOURNAL_MARK + HEAD.pack(len(data), size, zlib.crc32(data), name))
                file.write(data)
                end = file.tell()
            before = None if self._journal is None else self._journal.tell()
            self._close_journal()  # some systems do not replace an open file
            try:
                part.replace(target)
            except OSError:
                if before is not None:
                    self._open_journal(before)
                raise
            self._open_journal(end)
        except BaseException:  # also an interruption must not leave a part
            with suppress(OSError):
                part.unlink(missing_ok=True)
            raise
        self._sealed, self._stored = size, set()

    def _open_journal(self, end: int) -> None:
        self._journal = journal_of(self._path).open("r+b", buffering=0)
        self._journal.seek(end)

    def _close_journal(self) -> None:
        if self._journal is not None:
            self._journal.close()
            self._journal = None

    def reserve(self, size: int) -> None:
        """Allocate disk space for the journal, since HDF5 cannot handle a full disk."""
        if self._journal is not None and hasattr(os, "posix_fallocate"):
            os.posix_fallocate(self._journal.fileno(), self._journal.tell(), size)

    def _keep(self, begin: int, end: int) -> None:
        """Append the sealed bytes of a range to the journal, unless they are there."""
        if self._journal is None:
            return
        for number in range(begin // BLOCK, -(-min(end, self._sealed) // BLOCK)):
            if number not in self._stored:
                self._file.seek(number * BLOCK)
                old = self._file.read(min(BLOCK, self._sealed - number * BLOCK))
                _write_all(
                    self._journal, RECORD.pack(number, len(old), _checksum(number, old)) + old
                )
                self._stored.add(number)

    def read(self, size: int = -1) -> bytes:
        """Read bytes."""
        self._file.seek(self._at)
        data = self._file.read(size)
        self._at += len(data)
        return data

    def readinto(self, buffer: bytearray) -> int:
        """Read bytes into a buffer; return their number."""
        self._file.seek(self._at)
        size = self._file.readinto(buffer)
        self._at += size
        return size

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Move to a position; allocated bytes that were not written yet are not in the file."""
        begin = {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._end}[whence]
        self._at = begin + offset
        return self._at

    def tell(self) -> int:
        """Return the position."""
        return self._at

    def write(self, data: bytes) -> int:
        """Write bytes, after those that they replace are in the journal; return their number."""
        end = self._at + len(data)
        if self._at < self._sealed:
            self._keep(self._at, end)
        self._file.seek(self._at)
        _write_all(self._file, data)
        self._at, self._end = end, max(self._end, end)
        return len(data)

    def truncate(self, size: int) -> int:
        """Set the size; allocated bytes stay at the end of a file that has it."""
        if size != self._end:
            if size < self._sealed:
                self._keep(size, self._sealed)
            self._end = self._file.truncate(size)
        return size

    def release(self) -> None:
        """Release the allocated bytes at the end."""
        self._file.truncate(self._end)

    def flush(self) -> None:
        """Return at once, since all bytes are written without delay."""

    def close(self) -> None:
        """Close the file and its journal."""
        self._close_journal()
        self._file.close()


def _write_all(file: FileIO, data: bytes) -> None:
    """Write all bytes; one call of the system may write a part of them."""
    rest = memoryview(data)
    while rest:
        rest = rest[file.write(rest) :]


def read_checkpoint(path: Path) -> bytes:
    """Return the data of the last checkpoint of a file.

    Raises
    ------
    InputError
        If there is none, or it is damaged or of another file.
    """
    journal = journal_of(path)
    try:
        with journal.open("rb") as file:
            data, _, name = _read_data(journal, file)
        with path.open("rb") as file:
            if file.read(NAME_SIZE) != name:
                raise InputError(
                    f"{journal} is the checkpoint of another run than {path}: keep both files "
                    "together"
                )
    except OSError as refused:
        reason = os.strerror(refused.errno or 0)
        raise InputError(f"{path} has no checkpoint that can be read: {reason}") from None
    return data


def restore(path: Path) -> int:
    """Restore the bytes of a file at its last checkpoint; return their number.

    A repeated call has no effect.
    """
    journal = journal_of(path)
    with journal.open("rb") as stored, path.open("r+b", buffering=0) as file:
        _, size, _ = _read_data(journal, stored)
        while len(head := stored.read(RECORD.size)) == RECORD.size:
            number, length, checksum = RECORD.unpack(head)
            old = stored.read(min(length, BLOCK))
            if len(old) != length or _checksum(number, old) != checksum:
                break  # the process ended here, before it overwrote these bytes
            file.seek(number * BLOCK)
            _write_all(file, old)
        file.truncate(size)
    return size


def _read_data(path: Path, journal: BinaryIO) -> tuple[bytes, int, bytes]:
    """Return the data of a checkpoint, and size and first bytes of its file."""
    mark, head = journal.read(len(JOURNAL_MARK)), journal.read(HEAD.size)
    if mark == JOURNAL_MARK and len(head) == HEAD.size:
        length, size, checksum, name = HEAD.unpack(head)
        data = journal.read(length) if length <= path.stat().st_size else b""
        if len(data) == length and zlib.crc32(data) == checksum:
            return data, size, name
    raise InputError(f"{path} is damaged, or not the checkpoint of a run: run again")
