"""Choice of instruction set: every module is compiled for each, this machine runs the widest."""

import os
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType

from ancfsparse.errors import InputError
from ancfsparse.openmp import brief_waits

ENVIRONMENT_VARIABLE = "ANCFSPARSE_INSTRUCTION_SET"

_V3 = frozenset("avx avx2 bmi1 bmi2 f16c fma movbe".split())
REQUIRED_FLAGS = {
    "x86_64": frozenset[str](),
    "x86_64_v3": _V3,
    "x86_64_v4": _V3 | frozenset("avx512f avx512bw avx512cd avx512dq avx512vl".split()),
}
"""Processor flags each set needs, as Linux names them, from narrow to wide."""


def _cpu_flags() -> frozenset[str]:
    """Return the flags of this processor; none where the system does not tell."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="ignore")
    except OSError:
        return frozenset()
    for line in text.splitlines():
        if line.startswith("flags"):
            return frozenset(line.partition(":")[2].split())
    return frozenset()


@cache
def available_instruction_sets() -> tuple[str, ...]:
    """Return the instruction sets this machine can run, from narrow to wide."""
    flags = _cpu_flags()
    return tuple(name for name, needed in REQUIRED_FLAGS.items() if needed <= flags)


def instruction_set() -> str:
    """Return the set in use: the widest, or what ``ANCFSPARSE_INSTRUCTION_SET`` asks for.

    Raises
    ------
    InputError
        If the variable names an unknown set or one this machine cannot run.
    """
    wanted = os.environ.get(ENVIRONMENT_VARIABLE)
    if not wanted:
        return available_instruction_sets()[-1]
    if wanted not in REQUIRED_FLAGS:
        names = ", ".join(REQUIRED_FLAGS)
        raise InputError(f"{ENVIRONMENT_VARIABLE}={wanted!r} is not one of {names}.")
    if wanted not in available_instruction_sets():
        missing = ", ".join(sorted(REQUIRED_FLAGS[wanted] - _cpu_flags()))
        raise InputError(
            f"{ENVIRONMENT_VARIABLE}={wanted!r} asks for instructions this machine lacks "
            f"({missing}); it can run {', '.join(available_instruction_sets())}."
        )
    return wanted


def compiled(name: str, instruction_set_name: str | None = None) -> ModuleType:
    """Import a compiled module, ``ancfsparse.compiled.<name>_<set>``.

    Parameters
    ----------
    name : str
        Module as `meson.build` lists it: a kernel such as ``"l2t2"`` or a compiled loop.
    instruction_set_name : str, optional
        One of `available_instruction_sets`; by default the one in use.
    """
    return _loaded(f"ancfsparse.compiled.{name}_{instruction_set_name or instruction_set()}")


@cache
def _loaded(module: str) -> ModuleType:
    with brief_waits():
        return import_module(module)
