"""HDF5 files of runs: how they are recognised, and sentences on why one cannot be opened."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results.data.file_locks import in_use

if TYPE_CHECKING:
    import h5py

# Every file of a run begins with these bytes, before what HDF5 writes, so that a file that is cut
# off or damaged is still known for one; and it carries the same as an attribute, with the number
# of its format.  Files of format 1, of version 0.1.0, have neither; those of format 2 lack the
# last state.
MARK, FORMAT = "ancfsparse run\n", 3
# Bytes before what HDF5 writes, the fewest it allows; how it begins; bytes that it writes first.
BLOCK, SIGNATURE, FIRST = 512, b"\x89HDF\r\n\x1a\n", 48
FIRST_ATTRIBUTES = {"settings", "scene", "run", "coordinates"}

# What HDF5 and the reading of what it returns raise on bytes that no run has written.
DAMAGE = (
    OSError, LookupError, ValueError, TypeError, AttributeError, RuntimeError, ArithmeticError
)  # fmt: skip


def file_name(what: str, value: object) -> Path:
    """Return the path of a file, which need not exist.

    Parameters
    ----------
    what : str
        What the file is for, in the message.
    value : object
        What was given.

    Raises
    ------
    InputError
        If no file can have that name.
    """
    if not isinstance(value, (str, Path)):
        raise InputError(
            f"{what} must be the name of a file such as 'run.h5', got {format_value(value)}"
        )
    try:
        os.stat(value)
    except FileNotFoundError:
        pass
    except OSError as refused:
        reason = os.strerror(refused.errno or 0)
        raise InputError(
            f"{what} cannot be the file {format_value(str(value))}: {reason}"
        ) from None
    except ValueError as refused:  # what the system cannot encode, or a NUL
        reason = "it has a NUL character" if "\0" in str(value) else str(refused)
        raise InputError(
            f"{what} cannot be the file {format_value(str(value))}: {reason}"
        ) from None
    return Path(value)


@contextmanager
def opened(
    path: Path, run: str | None = None, *, locking: bool | None = None
) -> Iterator[h5py.File]:
    """Open a file to read it.

    Parameters
    ----------
    path : Path
        The file.
    run : str, optional
        The mark of the run that wrote it; not given, any run is as good.
    locking : bool, optional
        Whether HDF5 locks the file; by default it does where it can.

    Raises
    ------
    InputError
        If it cannot be read, is not one that ``simulate`` wrote, or holds a later run; or if its
        contents are not those that a run writes.
    """
    import h5py

    try:
        file = h5py.File(path, "r", locking=locking)
    except DAMAGE as refused:
        raise InputError(unreadable(path, refused)) from None
    try:
        with file:
            check_format(path, file)
            if run is not None and text_of(file, "run") != run:
                raise InputError(
                    f"{path} was rewritten by a later run, which replaced the states of this one: "
                    "give every run an output of its own"
                )
            yield file
    except InputError:
        raise
    except DAMAGE as damage:
        raise InputError(damaged(path)) from damage


def damaged(path: Path, how: str = "") -> str:
    """Report that a file is not as a run has written it."""
    return f"{path} is damaged{how}: copy it again, or run again"


def check_format(path: Path, file: h5py.File) -> None:
    """Refuse a file that no run has written, or a later version of this package."""
    if file.attrs.get("mark", b"") == MARK.encode():
        number = int(file.attrs["format"])
        if number > FORMAT:
            raise InputError(
                f"{path} was written by a later version of ancfsparse, in format {number}, and "
                f"this one reads formats up to {FORMAT}: install the later version"
            )
    elif begins_with_mark(path):
        raise InputError(damaged(path))
    elif not is_of_first_format(file):
        raise InputError(f"{path} is not a file that simulate wrote")


def is_of_first_format(file: h5py.File) -> bool:
    """Whether everything is there that version 0.1.0 wrote, and the run has a mark as it made."""
    return (
        FIRST_ATTRIBUTES <= set(file.attrs)
        and set("tqva") <= set(file)
        and re.fullmatch("[0-9a-f]{32}", str(file.attrs["run"])) is not None
    )


def begins_with_mark(path: Path) -> bool:
    """Whether a file is of a run by its first bytes, whatever has become of the others."""
    with path.open("rb") as file:
        return file.read(len(MARK)) == MARK.encode()


def is_bare(path: Path) -> bool:
    """Whether HDF5 has begun a file with room for a mark and put nothing into it.

    A run that is killed before it marks its file leaves that.
    """
    with path.open("rb") as file:
        content = file.read(BLOCK + FIRST + 1)
    return len(content) <= BLOCK + FIRST and content.startswith(bytes(BLOCK) + SIGNATURE)


def text_of(file: h5py.File, name: str, missing: str | None = None) -> str:
    """Return one of the texts of a file; those of format 1 are attributes, without checksum."""
    if name in file:
        return bytes(file[name][:]).decode()
    if name not in file.attrs and missing is not None:
        return missing
    value = file.attrs[name]
    return value.decode() if isinstance(value, bytes) else str(value)


def unreadable(path: Path, refused: BaseException) -> str:
    """Explain why a file cannot be opened, without the jargon of HDF5."""
    if not path.exists():
        return f"there is no file {path.absolute()}: it was moved, removed or never written"
    if path.is_dir():
        return f"{path} is a folder: give the name of a file in it"
    if isinstance(refused, OSError) and refused.errno and refused.errno != errno.EAGAIN:
        return f"{path} cannot be opened: {os.strerror(refused.errno)}"
    if isinstance(refused, BlockingIOError) or in_use(path):
        return f"{path} cannot be opened, because a run writes to it just now: wait for its end"
    import h5py

    if begins_with_mark(path) or h5py.is_hdf5(path):
        return (
            f"{path} is cut off or damaged after {path.stat().st_size} bytes: copy it again, or "
            "run again if the disk was full"
        )
    return f"{path} is not a file that simulate wrote"
