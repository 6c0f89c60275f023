"""Memory and processors that are available."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from ancfsparse.errors import InputError, MessageTemplate

if sys.platform != "win32":
    import resource

GIGABYTE = 1e9

# To ask how much memory is free takes longer than to take this much [bytes].
MIN_CHECKED = 1e6


def available_memory() -> float | None:
    """Return the memory that is free for this process [bytes], None where it is unknown."""
    free = []
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            found = next((each for each in lines if each.startswith("MemAvailable")), None)
        if found is not None:
            free.append(1024.0 * int(found.split()[1]))
        free += _left_to_process()
        group = Path("/sys/fs/cgroup")
        most = (group / "memory.max").read_text(encoding="ascii").strip()
        if most != "max":
            used = int((group / "memory.current").read_text(encoding="ascii"))
            free.append(float(int(most) - used))
    except (OSError, ValueError):
        pass  # not a Linux machine, or one without control groups
    return min(free) if free else None


def count_processors() -> int:
    """Return how many processors this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _left_to_process() -> list[float]:
    """Return what a limit on the addresses of this process, as ulimit -v sets, leaves [bytes]."""
    if sys.platform != "linux":
        return []
    most = resource.getrlimit(resource.RLIMIT_AS)[0]
    if most == resource.RLIM_INFINITY:
        return []
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    return [float(most - pages * resource.getpagesize())]


def check_memory(what: str, needed: float, advice: str | MessageTemplate) -> None:
    """Refuse what cannot fit in memory, before any of it is taken.

    Parameters
    ----------
    what : str
        What needs it, for the message.
    needed : float
        How much [bytes].
    advice : str or Sentence
        What to try.

    Raises
    ------
    InputError
        With how much would be needed and how much is there.
    """
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
