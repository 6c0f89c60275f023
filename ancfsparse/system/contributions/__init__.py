"""Everything that adds to the equations of motion: one file each."""

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
"""Modules of this folder that every scene may need; what is attached to a scene names its own.

The function ``of`` of each takes a system and returns its parts.
"""


def contributions_of(system: System) -> list[Contribution]:
    """Return what adds to the equations of a numbered scene, in the order in which it is added."""
    names = dict.fromkeys((*NAMES, *(each.contribution for each in system.scene.attached)))
    modules = (import_module(f"{__name__}.{name}") for name in names)
    return [part for module in modules for part in module.of(system)]
