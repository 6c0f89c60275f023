"""A file that can be read after any end of its process.

HDF5 changes bytes of a file in place: indices of its tables, and chunks that are not full.  A
process that is killed meanwhile leaves a file that HDF5 cannot read.  As in databases, old bytes
are therefore written to a second file, the rollback journal, before they are overwritten.  The
journal is removed when the file is closed; if the process was killed, it restores the last sealed
bytes.
"""

from __future__ import annotations

import os
import struct
import zlib
from io import FileIO
from pathlib import Path

from ancfsparse.errors import InputError
from ancfsparse.results.data.disk_space import allocate_disk
from ancfsparse.results.data.file_locks import try_lock

JOURNAL_MARK = b"ancfsparse journal 1\n"
NAME_SIZE = 64  # first bytes of a file, which contain the identifier of its run
# Number of the seal, bytes of the file at it, their checksum; first bytes of the file.
HEAD = struct.Struct(f"<QQI{NAME_SIZE}s")
RECORD = struct.Struct("<QII")  # number of a block, its bytes, their checksum
BLOCK = 4096  # bytes that are stored together


def journal_of(path: Path) -> Path:
    """Return the name of the journal of a file."""
    return path.with_name(f"{path.name}.journal")


def _checksum(seal: int, number: int, data: bytes) -> int:
    """Return the checksum of a block, which differs for earlier seals and is not zero."""
    return zlib.crc32(data, zlib.crc32(struct.pack("<QQ", seal, number))) ^ 0xFFFFFFFF


class RecoverableFile:
    """A binary file for h5py, with a journal from its first seal on.

    Its first bytes must not change, as in a user block: they identify the file.

    Parameters
    ----------
    path : Path
        The file, which must exist.
    size : int, optional
        Number of its bytes that count.
    """

    def __init__(self, path: Path, size: int = 0) -> None:
        self._path, self._file = path, path.open("r+b", buffering=0)
        self._at, self._end = 0, size
        self._journal = journal_of(path).open("wb", buffering=0)
        self._seal, self._sealed, self._stored = 0, 0, set[int]()

    def seal(self, size: int) -> None:
        """Make the present bytes those that `recover` returns to.

        Parameters
        ----------
        size : int
            Number of bytes of the file that count.

        Raises
        ------
        OSError
            If the journal cannot be written; the last seal then stays.
        """
        self._file.seek(0)
        name = self._file.read(NAME_SIZE)
        head = HEAD.pack(self._seal + 1, size, _checksum(self._seal + 1, size, name), name)
        self._journal.seek(0)
        _write_all(self._journal, JOURNAL_MARK + head)  # less than a page: whole or not at all
        # From here on the blocks of the last seal have wrong checksums, and are overwritten.
        self._seal, self._sealed, self._stored = self._seal + 1, size, set()

    def reserve(self, size: int) -> None:
        """Allocate disk space for the journal, since HDF5 cannot handle a full disk."""
        allocate_disk(journal_of(self._path), self._journal.tell(), size)

    def _keep(self, begin: int, end: int) -> None:
        """Write the sealed bytes of a range to the journal, unless they are there."""
        for number in range(begin // BLOCK, -(-min(end, self._sealed) // BLOCK)):
            if number not in self._stored:
                self._file.seek(number * BLOCK)
                old = self._file.read(min(BLOCK, self._sealed - number * BLOCK))
                checksum = _checksum(self._seal, number, old)
                _write_all(self._journal, RECORD.pack(number, len(old), checksum) + old)
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

    def flush(self) -> None:
        """Return at once, since all bytes are written without delay."""

    def finish(self) -> None:
        """Close the file that HDF5 has closed: release allocated bytes, remove the journal."""
        self._file.truncate(self._end)
        self.close()
        journal_of(self._path).unlink()

    def close(self) -> None:
        """Close the file as a killed process would leave it."""
        self._journal.close()
        self._file.close()


def _write_all(file: FileIO, data: bytes) -> None:
    """Write all bytes; one call of the system may write a part of them."""
    rest = memoryview(data)
    while rest:
        rest = rest[file.write(rest) :]


def recover(path: Path, *, is_locked_here: bool = False) -> None:
    """Restore the last sealed bytes of a file whose process was killed.

    Files without a journal, or with the journal of another run, stay as they are.  With
    `is_locked_here` this process holds the lock.

    Raises
    ------
    InputError
        If that needs a permission.
    BlockingIOError
        If a run is writing the file.
    """
    journal = journal_of(path)
    if not (journal.exists() and path.is_file()):
        return
    try:
        with path.open("r+b", buffering=0) as file:  # closing it releases the lock
            if not (is_locked_here or try_lock(file.fileno(), alone=True)):
                raise BlockingIOError
            # Another process may have restored the file meanwhile.
            if journal.exists() and _restore(file, journal):
                journal.unlink()  # last, in case this is interrupted too
    except PermissionError as refused:
        raise InputError(
            f"{path} is of a run that was killed, and must be restored from {journal} before it is "
            f"read, which the system refuses ({refused.strerror}): copy both files to a folder "
            "where you may write"
        ) from None


def _restore(file: FileIO, journal: Path) -> bool:
    """Return False if the journal is of another file."""
    with journal.open("rb") as stored:
        mark, head = stored.read(len(JOURNAL_MARK)), stored.read(HEAD.size)
        if mark != JOURNAL_MARK or len(head) != HEAD.size:
            return True  # the process ended before the first seal
        seal, size, checksum, name = HEAD.unpack(head)
        if checksum != _checksum(seal, size, name) or file.read(NAME_SIZE) != name:
            return False
        while len(head := stored.read(RECORD.size)) == RECORD.size:
            number, length, checksum = RECORD.unpack(head)
            old = stored.read(min(length, BLOCK))
            if len(old) != length or checksum != _checksum(seal, number, old):
                break  # the process ended here, before it overwrote these bytes
            file.seek(number * BLOCK)
            _write_all(file, old)
    file.truncate(size)
    return True
