"""HDF5 files that cannot be opened, or must not be replaced, told in sentences."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from ancfsparse.errors import InputError


@contextmanager
def opened(path: Path, run: str | None = None) -> Iterator[h5py.File]:
    """Open a file to read it.

    Parameters
    ----------
    path : Path
        The file.
    run : str, optional
        The mark of the run that wrote it; not given, any run is as good.

    Raises
    ------
    InputError
        If it cannot be read, is none that ``simulate`` wrote, or holds a later run; or if what is
        read from it turns out not to be what a run writes.
    """
    try:
        file = h5py.File(path, "r")
    except OSError as refused:
        raise InputError(unreadable(path, refused)) from None
    with file:
        if "settings" not in file.attrs:
            raise InputError(f"{path} is not a file that simulate wrote")
        if run is not None and file.attrs.get("run") != run:
            raise InputError(
                f"{path} was rewritten by a later run, which replaced the states of this one: "
                "give every run an output of its own"
            )
        try:
            yield file
        except InputError:
            raise
        except (OSError, KeyError, ValueError, TypeError, AttributeError) as damage:
            raise InputError(
                f"{path} is damaged, or of another version of ancfsparse: run again"
            ) from damage


def unreadable(path: Path, refused: OSError) -> str:
    """Say why a file cannot be opened, without the words of HDF5."""
    if not path.exists():
        return f"there is no file {path.absolute()}: it was moved, removed or never written"
    if path.is_dir():
        return f"{path} is a folder: give the name of a file in it"
    if isinstance(refused, BlockingIOError):
        return f"{path} cannot be opened, because a run writes to it just now: wait for its end"
    if refused.errno:
        return f"{path} cannot be opened: {os.strerror(refused.errno)}"
    if h5py.is_hdf5(path):
        return (
            f"{path} is cut off or damaged after {path.stat().st_size} bytes: copy it again, or "
            "run again if the disk was full"
        )
    return f"{path} is not a file that simulate wrote"


def check_replaceable(path: Path) -> None:
    """Refuse to write where a folder is, or a file of anybody else.

    Raises
    ------
    InputError
        If there is one; files of earlier runs, and empty ones, may be replaced.
    """
    if path.is_dir():
        raise InputError(
            f"output {str(path)!r} cannot be written: it is a folder; give the name of a file in "
            f"it, such as {str(path / 'run.h5')!r}"
        )
    if not path.exists() or (path.is_file() and path.stat().st_size == 0):
        return
    try:
        with opened(path):
            pass
    except InputError as other:
        raise InputError(
            f"output {str(path)!r} exists and is not replaced: {other}; take another name, or "
            "remove it"
        ) from None
