"""The last checkpoint of a run: a second file.

A new checkpoint replaces the last one by a renaming, so that one of them is always whole.
"""

from __future__ import annotations

import os
import struct
import zlib
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from ancfsparse.errors import InputError
from ancfsparse.results.data.recoverable_file import NAME_SIZE

MARK = b"ancfsparse checkpoint 2\n"
HEAD = struct.Struct(f"<QQI{NAME_SIZE}s")  # bytes of the data, states, checksum of the data, name


class StoredCheckpoint(NamedTuple):
    """A checkpoint: the number of states in the file of the run at it, and other data."""

    rows: int
    data: bytes


def checkpoint_of(path: Path) -> Path:
    """Return the name of the checkpoint of a file."""
    return path.with_name(f"{path.name}.checkpoint")


def write_checkpoint(path: Path, rows: int, data: bytes) -> None:
    """Replace the checkpoint of a file of `rows` states.

    Raises
    ------
    OSError
        If it cannot be written; the last checkpoint then stays.
    """
    target = checkpoint_of(path)
    part = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        with part.open("wb") as file:
            file.write(MARK + HEAD.pack(len(data), rows, zlib.crc32(data), _name(path)))
            file.write(data)
        part.replace(target)
    except BaseException:  # also an interruption must not leave a part
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


def read_checkpoint(path: Path) -> StoredCheckpoint:
    """Return the last checkpoint of a file.

    Raises
    ------
    InputError
        If there is none, or it is damaged or of another file.
    """
    target = checkpoint_of(path)
    try:
        content, name = target.read_bytes(), _name(path)
    except OSError as refused:
        reason = os.strerror(refused.errno or 0)
        raise InputError(f"{path} has no checkpoint that can be read: {reason}") from None
    begin = len(MARK) + HEAD.size
    if content.startswith(MARK) and len(content) >= begin:
        length, rows, checksum, owner = HEAD.unpack(content[len(MARK) : begin])
        data = content[begin:]
        if len(data) == length and zlib.crc32(data) == checksum:
            if owner != name:
                raise InputError(
                    f"{target} is the checkpoint of another run than {path}: keep both files "
                    "together"
                )
            return StoredCheckpoint(rows, data)
    raise InputError(f"{target} is damaged, or not the checkpoint of a run: run again")


def _name(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(NAME_SIZE)
