"""Locks on files that are being written."""

from __future__ import annotations

import os
import sys
import time
from contextlib import suppress
from pathlib import Path

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

LOCKED_BYTE = 2**62  # position of the byte that Windows locks, which no file reaches
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
        Lock exclusively, or else share the lock with other readers; Windows shares none.
    """
    for _ in range(MAX_TRIES):
        try:
            if sys.platform == "win32":
                os.lseek(file, LOCKED_BYTE, os.SEEK_SET)
                msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
            else:
                fcntl.flock(file, (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            time.sleep(PAUSE)
        except OSError:  # a file system without locks
            return True
        else:
            return True
    return False


def unlock(file: int) -> None:
    """Release the lock, also for copies of the descriptor in forked processes."""
    with suppress(OSError):  # a file system without locks
        if sys.platform == "win32":
            os.lseek(file, LOCKED_BYTE, os.SEEK_SET)
            msvcrt.locking(file, msvcrt.LK_UNLCK, 1)
        else:
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
