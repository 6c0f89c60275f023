"""Locks on files that are being written; on Windows only those of HDF5."""

from __future__ import annotations

import os
import time
from contextlib import suppress
from pathlib import Path

try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]

HDF5_LOCKS = fcntl is None  # HDF5 must lock files itself
# Checks by several processes are short and may coincide.
MAX_TRIES = 5  # attempts to lock a file
PAUSE = 0.02  # s, between attempts


def try_lock(file: int, *, alone: bool) -> bool:
    """Lock an open file; return False if another process holds a conflicting lock.

    Parameters
    ----------
    file : int
        Its descriptor; closing it releases the lock.
    alone : bool
        Lock exclusively, or else share the lock with other readers.
    """
    if fcntl is None:
        return True
    for _ in range(MAX_TRIES):
        try:
            fcntl.flock(file, (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | fcntl.LOCK_NB)
        except BlockingIOError:
            time.sleep(PAUSE)
        except OSError:  # a file system without locks
            return True
        else:
            return True
    return False


def unlock(file: int) -> None:
    """Release the lock, also for copies of the descriptor in forked processes."""
    if fcntl is not None:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(file, fcntl.LOCK_UN)


def is_locked(path: Path) -> bool:
    """Return True while a file is being written.

    Raises
    ------
    OSError
        If it cannot be opened.
    """
    file = os.open(path, os.O_RDONLY)
    try:
        return not try_lock(file, alone=False)
    finally:
        os.close(file)
