"""HDF5 files of runs: recognition, and messages for files that cannot be opened."""

from __future__ import annotations

import errno
import math
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ancfsparse.errors import InputError
from ancfsparse.file_names import RUN_MARK, begins_with
from ancfsparse.results.data.file_locks import is_locked
from ancfsparse.results.data.recoverable_file import recover

if TYPE_CHECKING:
    import h5py

# Files of format 1, of version 0.1.0, have no mark; those of format 2 lack the last state.
FORMAT = 3  # number of the format, an attribute
USER_BLOCK = 512  # bytes before those of HDF5, the smallest number it allows
# Filters of a table that is not compressed.  The checksum of zlib (Adler-32) takes 15 % longer to
# write than Fletcher's, which earlier versions wrote: that is equal for the words 0 and 0xffff,
# which begin numbers just below 1, and zero for zeros.
CHECKED: dict[str, Any] = {"compression": "gzip", "compression_opts": 0}
CHECKSUM_SIZE = 4  # bytes of either checksum of a chunk
FIRST_ATTRIBUTES = {"settings", "scene", "run", "coordinates"}
"""Attributes of files of format 1."""

# Exceptions of h5py, and of the conversion of its values, for invalid bytes.
DAMAGE_ERRORS = (
    OSError, LookupError, ValueError, TypeError, AttributeError, RuntimeError, ArithmeticError
)  # fmt: skip


@contextmanager
def open_file(
    path: Path, run: str | None = None, *, is_locked_here: bool = False
) -> Iterator[h5py.File]:
    """Open a file for reading; restore it first if its run was killed.

    Parameters
    ----------
    path : Path
        The file.
    run : str, optional
        Identifier of the run that wrote it; any run by default.
    is_locked_here : bool, optional
        Whether this process holds the lock of the file.

    Raises
    ------
    InputError
        If it cannot be read, was not written by ``simulate``, contains a later run, or is damaged.
    """
    import h5py

    try:
        recover(path, is_locked_here=is_locked_here)
        file = h5py.File(path, "r", locking=False if is_locked_here else None)
    except InputError:
        raise
    except DAMAGE_ERRORS as refused:
        raise InputError(describe_failure(path, refused)) from None
    try:
        with file:
            check_format(path, file)
            if run is None:  # opened for the first time
                _check_chunks(path, file)
            elif read_text(file, "run") != run:
                raise InputError(
                    f"{path} was rewritten by a later run, which replaced the states of this one: "
                    "give every run an output of its own"
                )
            yield file
    except InputError:
        raise
    except DAMAGE_ERRORS as damage:
        raise InputError(describe_damage(path)) from damage


def describe_damage(path: Path, how: str = "") -> str:
    """Return a message on a damaged file."""
    return f"{path} is damaged{how}: copy it again, or run again"


def check_format(path: Path, file: h5py.File) -> None:
    """Refuse a file that was not written by a run, or by a later version of this package."""
    if file.attrs.get("mark", b"") == RUN_MARK.encode():
        number = int(file.attrs["format"])
        if number > FORMAT:
            raise InputError(
                f"{path} was written by a later version of ancfsparse, in format {number}, and "
                f"this one reads formats up to {FORMAT}: install the later version"
            )
    elif begins_with(path, RUN_MARK):
        raise InputError(describe_damage(path))
    elif not is_of_first_format(file):
        raise InputError(f"{path} is not a file that simulate wrote")


def _check_chunks(path: Path, file: h5py.File) -> None:
    """Refuse a file with chunks that HDF5 cannot read or would read without their checksum.

    The index of chunks has no checksum.  HDF5 ends the process at a chunk of size zero, and skips
    the checksum of one that is marked as written without it.
    """
    import h5py

    largest = path.stat().st_size

    def check(_: str, table: object) -> None:
        if not isinstance(table, h5py.Dataset) or table.chunks is None:
            return
        smallest = CHECKSUM_SIZE + 1
        if table.compression_opts in (None, CHECKED["compression_opts"]):
            smallest = math.prod(table.chunks) * table.dtype.itemsize
        for chunk in _chunks(table):
            if chunk.filter_mask or not smallest <= chunk.size <= largest:
                raise InputError(describe_damage(path))

    file.visititems(check)


def _chunks(table: h5py.Dataset) -> list[Any]:
    """Return size and filter mask of the chunks of a table."""
    if not hasattr(table.id, "chunk_iter"):  # before HDF5 1.12.3
        return [table.id.get_chunk_info(k) for k in range(table.id.get_num_chunks())]
    chunks: list[Any] = []
    table.id.chunk_iter(chunks.append)
    return chunks


def is_of_first_format(file: h5py.File) -> bool:
    """Return True for a file of version 0.1.0, by its attributes, tables and run identifier."""
    return (
        FIRST_ATTRIBUTES <= set(file.attrs)
        and set("tqva") <= set(file)
        and re.fullmatch("[0-9a-f]{32}", str(file.attrs["run"])) is not None
    )


def read_text(file: h5py.File, name: str, missing: str | None = None) -> str:
    """Return a text of a file; in format 1 texts are attributes without checksum."""
    if name in file:
        return bytes(file[name][:]).decode()
    if name not in file.attrs and missing is not None:
        return missing
    value = file.attrs[name]
    return value.decode() if isinstance(value, bytes) else str(value)


def describe_failure(path: Path, refused: BaseException) -> str:
    """Return the reason why a file cannot be opened, without terms of HDF5."""
    if not path.exists():
        return f"there is no file {path.absolute()}: it was moved, removed or never written"
    if path.is_dir():
        return f"{path} is a folder: give the name of a file in it"
    if isinstance(refused, OSError) and refused.errno and refused.errno != errno.EAGAIN:
        return f"{path} cannot be opened: {os.strerror(refused.errno)}"
    if isinstance(refused, BlockingIOError) or is_locked(path):
        return f"{path} cannot be opened, because a run is writing to it: wait for its end"
    import h5py

    if begins_with(path, RUN_MARK) or h5py.is_hdf5(path):
        return (
            f"{path} is cut off or damaged after {path.stat().st_size} bytes: copy it again, or "
            "run again if the disk was full"
        )
    return f"{path} is not a file that simulate wrote"
