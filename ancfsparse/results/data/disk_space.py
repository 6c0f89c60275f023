"""Allocation of disk space before a library writes that cannot handle a full disk."""

from __future__ import annotations

import errno
import os
import shutil
from pathlib import Path


def allocate_disk(path: Path, begin: int, length: int) -> None:
    """Allocate bytes of a file from a position on, or raise the OSError of the system."""
    if not hasattr(os, "posix_fallocate"):  # only on Linux: check the free space
        if shutil.disk_usage(path.parent).free < length:
            raise OSError(errno.ENOSPC, "")
        return
    with path.open("r+b") as file:
        size = os.fstat(file.fileno()).st_size
        try:
            os.posix_fallocate(file.fileno(), begin, length)
        except OSError:
            os.ftruncate(file.fileno(), size)
            raise
