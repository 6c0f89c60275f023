"""Exclusive access to the output file of a run, which must be new or of an earlier run."""

from __future__ import annotations

import os
from pathlib import Path

from ancfsparse.errors import InputError
from ancfsparse.file_names import RUN_MARK, begins_with
from ancfsparse.results.data.file_locks import is_locked, try_lock, unlock
from ancfsparse.results.data.hdf5_format import USER_BLOCK, open_file


class OutputLock:
    """An exclusive lock on an output file.

    HDF5 truncates a file before it locks it, so that a second run would destroy the file of the
    first before it is refused.  This lock is acquired earlier.

    Parameters
    ----------
    path : Path
        The file; it is created if missing.
    run : str, optional
        Identifier of the run.

    Raises
    ------
    InputError
        If another run is writing it, or it was not written by a run.
    OSError
        If the system denies access.
    """

    def __init__(self, path: Path, run: str = "") -> None:
        self._run = run
        self._file = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            if not try_lock(self._file, alone=True):
                raise _busy(path)
            check_replaceable(path, is_locked_here=True)
        except BaseException:  # also an interruption must not leave the file locked
            self.release()
            raise

    def mark_new(self) -> None:
        """Write the mark to a new file; the file of an earlier run is not changed."""
        if os.fstat(self._file).st_size == 0:
            self._mark()

    def clear(self) -> None:
        """Remove all but the mark and the identifier of this run, before the bytes of HDF5."""
        self._mark()
        os.ftruncate(self._file, USER_BLOCK)

    def _mark(self) -> None:
        os.lseek(self._file, 0, os.SEEK_SET)
        os.write(self._file, f"{RUN_MARK}{self._run}\n".encode())

    def release(self) -> None:
        """Release the lock."""
        unlock(self._file)
        os.close(self._file)


def check_replaceable(path: Path, *, is_locked_here: bool = False) -> None:
    """Refuse to replace a folder, a file that is not of a run, or one that is being written.

    Files of earlier runs, even damaged ones, and empty files are replaced.  With `is_locked_here`
    this process holds the lock.
    """
    output = f"output {str(path)!r}"
    if path.is_dir():
        raise InputError(
            f"{output} cannot be written: it is a folder; give the name of a file in it, such as "
            f"{str(path / 'run.h5')!r}"
        )
    if not path.is_file():
        if path.exists():
            raise InputError(f"{output} is not a file: take another name")
        return
    try:
        if not is_locked_here and is_locked(path):
            raise _busy(path)
        if path.stat().st_size == 0 or begins_with(path, RUN_MARK):
            return
    except OSError as refused:
        reason = os.strerror(refused.errno or 0)
        raise InputError(f"{output} cannot be written: {reason}; take another name") from None
    try:
        with open_file(path, is_locked_here=is_locked_here):
            pass
    except InputError as other:
        raise InputError(
            f"{output} exists and is not replaced: {other}; take another name, or remove it"
        ) from None


def _busy(path: Path) -> InputError:
    return InputError(
        f"output {str(path)!r} is being written by another run: take another name, or wait for "
        "its end"
    )
