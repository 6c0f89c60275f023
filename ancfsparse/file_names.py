"""Names of files, checked before the files are read or written."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value

RUN_MARK = "ancfsparse run\n"
"""First bytes of every file of a run, before those of HDF5, which identify also a damaged file; the
same text is an attribute."""
SWEEP_MARK = "ancfsparse sweep"
"""First key of every file of a sweep."""
RESULTS = {"a run": RUN_MARK, "a sweep": f'{{"{SWEEP_MARK}"'}
"""First bytes of files with results."""


def check_file_name(what: str, value: object, example: str = "run.h5") -> Path:
    """Return a valid name as the path of a file, which may be missing; `what` is its purpose."""
    if not isinstance(value, (str, Path)):
        raise InputError(
            f"{what} must be the name of a file such as {example!r}, got {format_value(value)}"
        )
    try:
        os.stat(value)
    except FileNotFoundError:
        pass
    except (OSError, ValueError) as refused:  # a NUL and names that are not encodable, too
        reason = "it has a NUL character" if "\0" in str(value) else str(refused)
        if isinstance(refused, OSError):
            reason = os.strerror(refused.errno or 0)
        raise InputError(
            f"{what} cannot be the file {format_value(str(value))}: {reason}"
        ) from None
    return Path(value)


def check_folder(target: Path) -> None:
    """Refuse to write into a folder that is missing."""
    if not target.absolute().parent.is_dir():
        raise InputError(f"{target} cannot be written: there is no folder {target.parent}")


def check_target(what: str, value: object, endings: Sequence[str]) -> Path:
    """Return a valid name as the path of a file to write, which may replace one of its kind.

    Parameters
    ----------
    what : str
        Purpose of the file, such as ``"a table"``.
    value : object
        The given name.
    endings : sequence of str
        Endings that it may have, such as ``".csv"``; any if there are none.

    Raises
    ------
    InputError
        If the name has another ending, its folder is missing, or it would replace a folder or the
        results of a run or a sweep.
    """
    target = check_file_name(what, value, f"result{endings[0] if endings else '.json'}")
    if endings and target.suffix.lower() not in endings:
        listing = " or ".join(filter(None, (", ".join(endings[:-1]), endings[-1])))
        raise InputError(f"{what} must end in {listing}, got {str(target)!r}")
    check_folder(target)
    if target.is_dir():
        raise InputError(f"{target} cannot be written: it is a folder")
    for kind, mark in RESULTS.items():
        if target.is_file() and begins_with(target, mark):
            raise InputError(
                f"{target} is not replaced, since it holds the results of {kind}: take another "
                "name, or remove it"
            )
    return target


def begins_with(path: Path, mark: str) -> bool:
    """Return True if the first bytes of a file are a mark, even if the rest is damaged."""
    with path.open("rb") as file:
        return file.read(len(mark)) == mark.encode()
