"""Available memory and processors."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from ancfsparse.errors import InputError, MessageTemplate

if sys.platform != "win32":
    import resource

GIGABYTE = 1e9  # bytes
MIN_CHECKED = 1e6  # bytes; below, a query of the free memory costs more than the allocation


def available_memory() -> float | None:
    """Return the free memory of this process [bytes], None if it is unknown."""
    free = []
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            line = next((each for each in lines if each.startswith("MemAvailable")), None)
        if line is not None:
            free.append(1024.0 * int(line.split()[1]))
        free += _address_space()
        group = Path("/sys/fs/cgroup")
        limit = (group / "memory.max").read_text(encoding="ascii").strip()
        if limit != "max":
            used = int((group / "memory.current").read_text(encoding="ascii"))
            free.append(float(int(limit) - used))
    except (OSError, ValueError):
        pass  # not a Linux machine, or one without control groups
    return min(free) if free else None


def count_processors() -> int:
    """Return the number of processors available to this process."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _address_space() -> list[float]:
    """Return the free address space of this process under a limit of ulimit -v [bytes]."""
    if sys.platform != "linux":
        return []
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit == resource.RLIM_INFINITY:
        return []
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    return [float(limit - pages * resource.getpagesize())]


def check_memory(what: str, needed: float, advice: str | MessageTemplate) -> None:
    """Refuse data, `what`, that need more bytes than are free; `advice` says how to need less."""
    free = available_memory() if needed > MIN_CHECKED else None
    if free is not None and needed > free:
        raise InputError(
            "{what} would need about {needed:.3g} GB, more than there is: {free:.3g} GB of memory "
            "are free; try {advice}",
            what=what,
            needed=needed / GIGABYTE,
            free=max(free, 0.0) / GIGABYTE,
            advice=advice,
        )
