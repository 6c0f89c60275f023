"""Machine and versions of a study, for its JSON."""

from __future__ import annotations

import importlib.metadata
import platform

from ancfsparse.dispatch import instruction_set
from ancfsparse.errors import InputError
from benchmarks.other_codes import sundials

PACKAGES = ("numpy", "scipy", "exudyn", "pyelastica", "mujoco")


def environment() -> dict[str, str]:
    """Return instruction set, machine and versions of the compared programs."""
    found = {"instruction_set": instruction_set(), "machine": platform.machine()}
    found["python"] = platform.python_version()
    for name in PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    try:
        found["sundials"] = sundials.load().VERSION
    except InputError:
        found["sundials"] = "not installed"
    return found
