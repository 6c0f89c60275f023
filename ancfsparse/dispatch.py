"""Choice of instruction set: every module is compiled for each, this machine runs the widest."""

import os
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from ancfsparse.errors import InputError
from ancfsparse.instruction_sets import REQUIRED_FLAGS, cpu_flags, runnable_sets
from ancfsparse.openmp import short_spin_waits

ENVIRONMENT_VARIABLE = "ANCFSPARSE_INSTRUCTION_SET"
FOR_EVERY_MACHINE = "for every machine with `pip install -Csetup-args=-Dinstruction_sets=all .`"


@cache
def built_instruction_sets() -> tuple[str, ...]:
    """Return the instruction sets this installation was compiled for, from narrow to wide."""
    return tuple(name for name in REQUIRED_FLAGS if find_spec(_module("assembly", name)))


@cache
def available_instruction_sets() -> tuple[str, ...]:
    """Return the sets of this installation that this machine can run, from narrow to wide."""
    can_run = runnable_sets(cpu_flags())
    return tuple(name for name in built_instruction_sets() if name in can_run)


def instruction_set() -> str:
    """Return the set in use: the widest, or what ``ANCFSPARSE_INSTRUCTION_SET`` asks for.

    Raises
    ------
    InputError
        If the variable names an unknown set, one this machine cannot run or one this installation
        does not have; or if it has none that this machine can run.
    """
    wanted = os.environ.get(ENVIRONMENT_VARIABLE)
    if not wanted:
        if not available_instruction_sets():
            raise InputError(_unusable(built_instruction_sets()))
        return available_instruction_sets()[-1]
    if wanted not in REQUIRED_FLAGS:
        names = ", ".join(REQUIRED_FLAGS)
        raise InputError(f"{ENVIRONMENT_VARIABLE}={wanted!r} is not one of {names}.")
    if wanted not in runnable_sets(cpu_flags()):
        raise InputError(
            f"{ENVIRONMENT_VARIABLE}={wanted!r} asks for instructions this machine lacks "
            f"({_missing(wanted)}); it can run {', '.join(runnable_sets(cpu_flags()))}."
        )
    if wanted not in built_instruction_sets():
        raise InputError(
            f"{ENVIRONMENT_VARIABLE}={wanted!r} asks for a set this installation was not compiled "
            f"for; it has {', '.join(built_instruction_sets())}. Build it {FOR_EVERY_MACHINE}."
        )
    return wanted


def compiled_module(name: str, instruction_set_name: str | None = None) -> ModuleType:
    """Import a compiled module, ``ancfsparse.compiled.<name>_<set>``.

    Parameters
    ----------
    name : str
        Module as `meson.build` lists it: a kernel such as ``"l2t2"`` or a compiled loop.
    instruction_set_name : str, optional
        One of `available_instruction_sets`; by default the one in use.
    """
    return _loaded(_module(name, instruction_set_name or instruction_set()))


def _module(name: str, instruction_set_name: str) -> str:
    return f"ancfsparse.compiled.{name}_{instruction_set_name}"


def _unusable(built: tuple[str, ...]) -> str:
    """Return why none of the sets of this installation will do."""
    if not built:
        return "ancfsparse has no compiled modules here: build them with `make setup`"
    return (
        f"ancfsparse was compiled for {', '.join(built)} only, and this machine lacks "
        f"{_missing(built[0])}: build it again on this machine, or {FOR_EVERY_MACHINE}"
    )


def _missing(instruction_set_name: str) -> str:
    return ", ".join(sorted(REQUIRED_FLAGS[instruction_set_name] - cpu_flags()))


@cache
def _loaded(module: str) -> ModuleType:
    with short_spin_waits():
        return import_module(module)
