"""Which files a run may write: new ones and those of earlier runs, one run at a time."""

from __future__ import annotations

import os
from pathlib import Path

from ancfsparse.errors import InputError
from ancfsparse.results.data.file_locks import in_use, locked, unlock
from ancfsparse.results.data.hdf5_format import MARK, begins_with_mark, is_bare, opened


class Claim:
    """The right to write a file, held until it is released.

    HDF5 empties a file before it locks it, and so a second run would destroy the file of the first
    before it is refused.  This lock is taken before.

    Parameters
    ----------
    path : Path
        The file; it is made if missing.

    Raises
    ------
    InputError
        If another run writes it, or it is the file of anybody else.
    OSError
        If the system refuses it.
    """

    def __init__(self, path: Path) -> None:
        self._file = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            if not locked(self._file, alone=True):
                raise _busy(path)
            check_replaceable(path, ours=True)
        except BaseException:  # an interruption, too, must not leave the file locked
            self.release()
            raise

    def begin(self) -> None:
        """Write our mark to a new file; one of an earlier run stays as it is."""
        if os.fstat(self._file).st_size == 0:
            self.mark()

    def mark(self) -> None:
        """Write our mark before what HDF5 has written."""
        os.lseek(self._file, 0, os.SEEK_SET)
        os.write(self._file, MARK.encode())

    def release(self) -> None:
        """Let others write the file."""
        unlock(self._file)
        os.close(self._file)


def check_replaceable(path: Path, *, ours: bool = False) -> None:
    """Refuse to write where a folder is, a file of anybody else, or one that is being written.

    Parameters
    ----------
    path : Path
        The file.
    ours : bool, optional
        Whether the lock is ours already.

    Raises
    ------
    InputError
        If there is one; files of earlier runs, damaged ones too, and empty ones may be replaced.
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
        if not ours and in_use(path):
            raise _busy(path)
        if path.stat().st_size == 0 or begins_with_mark(path) or is_bare(path):
            return
    except OSError as refused:
        reason = os.strerror(refused.errno or 0)
        raise InputError(f"{output} cannot be written: {reason}; take another name") from None
    try:
        with opened(path, locking=False if ours else None):
            pass
    except InputError as other:
        raise InputError(
            f"{output} exists and is not replaced: {other}; take another name, or remove it"
        ) from None


def _busy(path: Path) -> InputError:
    return InputError(
        f"output {str(path)!r} is in use by another run just now: take another name, or wait for "
        "its end"
    )
