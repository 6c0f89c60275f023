"""The instruction sets that modules are compiled for, and their processor flags.

`meson.build` runs this file to find the sets of this machine, so it imports nothing of the package.
"""

import platform
from pathlib import Path

_V3 = frozenset("avx avx2 bmi1 bmi2 f16c fma movbe".split())
FAMILIES = {
    "x86_64": {
        "x86_64": frozenset[str](),
        "x86_64_v3": _V3,
        "x86_64_v4": _V3 | frozenset("avx512f avx512bw avx512cd avx512dq avx512vl".split()),
    },
    "aarch64": {"aarch64": frozenset[str]()},
}
"""Instruction sets of each family of processors, from narrow to wide; the first, named like the
family, runs on all of them.  The values are the required processor flags by their names in Linux.
"""

_OTHER_NAMES = {"amd64": "x86_64", "arm64": "aarch64"}  # in Windows and macOS


def processor_family() -> str:
    """Return the family of this processor by its name in Linux."""
    machine = platform.machine().lower()
    return _OTHER_NAMES.get(machine, machine)


REQUIRED_FLAGS = FAMILIES.get(processor_family(), {})
"""The instruction sets of this family."""


def cpu_flags() -> frozenset[str]:
    """Return the flags of this processor; none if the system, as macOS and Windows, lists none."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="ignore")
    except OSError:
        return frozenset()
    for line in text.splitlines():
        if line.startswith("flags"):
            return frozenset(line.partition(":")[2].split())
    return frozenset()


def supported_sets(flags: frozenset[str]) -> tuple[str, ...]:
    """Return the sets that a processor with these flags supports, from narrow to wide."""
    return tuple(name for name, needed in REQUIRED_FLAGS.items() if needed <= flags)


if __name__ == "__main__":
    print(*supported_sets(cpu_flags()))
