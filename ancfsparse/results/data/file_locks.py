"""Locks on files that are being written; on Windows HDF5 alone locks."""

from __future__ import annotations

import os
import time
from contextlib import suppress
from pathlib import Path

try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]

# Whether HDF5 has to lock a file that is written.
LOCKED_BY_HDF5 = fcntl is None

# Looks at a lock are short, and may meet: how often one is tried again, and how long after [s].
TRIES, PAUSE = 5, 0.02


def locked(file: int, *, alone: bool) -> bool:
    """Lock an open file, and return whether nobody else has a lock against it.

    Parameters
    ----------
    file : int
        Its descriptor; closing it takes the lock off.
    alone : bool
        Whether nobody else may have a lock, or only none for writing.
    """
    if fcntl is None:
        return True
    for _ in range(TRIES):
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
    """Take the lock off, also for copies of the descriptor in forked processes."""
    if fcntl is not None:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(file, fcntl.LOCK_UN)


def in_use(path: Path) -> bool:
    """Whether a file is being written.

    Raises
    ------
    OSError
        If it cannot be opened.
    """
    file = os.open(path, os.O_RDONLY)
    try:
        return not locked(file, alone=False)
    finally:
        os.close(file)
