"""Everything that adds to the equations of motion: one file each, and its name in `NAMES`."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from ancfsparse.system.contributions.interface import Contribution

if TYPE_CHECKING:
    from ancfsparse.system.system import System

NAMES = (
    "elements",
    "loads",
    "moments",
    "constraints",
)
"""Modules of this folder; the function ``of`` of each takes a system and returns a part or None."""


def contributions_of(system: System) -> list[Contribution]:
    """Return what adds to the equations of a numbered scene, in the order in which it is added."""
    modules = (import_module(f"{__name__}.{name}") for name in NAMES)
    return [part for part in (module.of(system) for module in modules) if part is not None]
