"""What the process of a study has taken."""

from __future__ import annotations

from pathlib import Path


def peak_memory() -> int:
    """Return the largest resident memory of this process so far [bytes].

    ``ru_maxrss`` would do, but for a child process Linux starts it at what the parent had.
    """
    status = Path("/proc/self/status")
    if status.exists():
        for line in status.read_text(encoding="utf-8").splitlines():
            if line.startswith("VmHWM:"):
                return 1024 * int(line.split()[1])
    import resource

    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
