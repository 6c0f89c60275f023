"""Selection of the instruction set: every module is compiled for each, the widest one is used."""

import os
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from ancfsparse.errors import InputError
from ancfsparse.instruction_sets import REQUIRED_FLAGS, cpu_flags, supported_sets

ENVIRONMENT_VARIABLE = "ANCFSPARSE_INSTRUCTION_SET"
FOR_EVERY_MACHINE = "for every machine with `pip install -Csetup-args=-Dinstruction_sets=all .`"


@cache
def built_instruction_sets() -> tuple[str, ...]:
    """Return the instruction sets of this installation, from narrow to wide."""
    return tuple(name for name in REQUIRED_FLAGS if find_spec(_module("assembly", name)))


@cache
def available_instruction_sets() -> tuple[str, ...]:
    """Return the sets of this installation that this processor supports, from narrow to wide."""
    supported = supported_sets(cpu_flags())
    return tuple(name for name in built_instruction_sets() if name in supported)


def instruction_set() -> str:
    """Return the set in use: the widest, or that of ``ANCFSPARSE_INSTRUCTION_SET``.

    Raises
    ------
    InputError
        If the variable names a set that is unknown, not supported by this processor or not part of
        this installation; or if this processor supports none of the installed sets.
    """
    requested = os.environ.get(ENVIRONMENT_VARIABLE)
    if not requested:
        if not available_instruction_sets():
            raise InputError(_unusable(built_instruction_sets()))
        return available_instruction_sets()[-1]
    if requested not in REQUIRED_FLAGS:
        names = ", ".join(REQUIRED_FLAGS)
        raise InputError(f"{ENVIRONMENT_VARIABLE}={requested!r} is not one of {names}.")
    if requested not in supported_sets(cpu_flags()):
        raise InputError(
            f"{ENVIRONMENT_VARIABLE}={requested!r} requires instructions that this processor lacks "
            f"({_missing(requested)}); it supports {', '.join(supported_sets(cpu_flags()))}."
        )
    if requested not in built_instruction_sets():
        raise InputError(
            f"{ENVIRONMENT_VARIABLE}={requested!r} is not part of this installation, "
            f"which has {', '.join(built_instruction_sets())}. Build it {FOR_EVERY_MACHINE}."
        )
    return requested


def compiled_module(name: str, instruction_set_name: str | None = None) -> ModuleType:
    """Import a compiled module, ``ancfsparse.compiled.<name>_<set>``.

    Parameters
    ----------
    name : str
        Module as `meson.build` lists it: a kernel such as ``"l2t2"`` or a compiled loop.
    instruction_set_name : str, optional
        One of `available_instruction_sets`; by default the one in use.
    """
    return import_module(_module(name, instruction_set_name or instruction_set()))


def common_module(name: str) -> ModuleType:
    """Import a module that is compiled once for all instruction sets, as ``order``."""
    return import_module(f"ancfsparse.compiled.{name}")


def _module(name: str, instruction_set_name: str) -> str:
    return f"ancfsparse.compiled.{name}_{instruction_set_name}"


def _unusable(built: tuple[str, ...]) -> str:
    """Return the reason why no set of this installation is supported."""
    if not built:
        return "ancfsparse has no compiled modules here: build them with `make setup`"
    return (
        f"ancfsparse was compiled for {', '.join(built)} only, and this processor lacks "
        f"{_missing(built[0])}: build it again on this machine, or {FOR_EVERY_MACHINE}"
    )


def _missing(instruction_set_name: str) -> str:
    return ", ".join(sorted(REQUIRED_FLAGS[instruction_set_name] - cpu_flags()))
