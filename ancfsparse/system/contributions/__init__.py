"""Everything that adds to the equations of motion: one file each."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any

from ancfsparse.system.contributions.interface import Contribution

if TYPE_CHECKING:
    from ancfsparse.system.system import System

NAMES: dict[str, Callable[[Any], bool]] = {
    "elements": lambda system: bool(system.scene.beams),
    "bodies": lambda system: any(body.masses is not None for body in system.scene.bodies),
    "loads": lambda system: bool(system.loads.place),
    "moments": lambda system: bool(system.loads.moment_place),
    "followers": lambda system: bool(system.loads.followers),
    "constraints": lambda system: system.n_multipliers > 0,
    "couplings": lambda system: any(not m.is_track for *_, m in system.constraints.measures),
    "tracks": lambda system: any(m.is_track for *_, m in system.constraints.measures),
}
"""Modules of this folder, and which systems need them; what is attached to a scene names its own.

The function ``of`` of each takes a system and returns its parts.
"""


def contributions_of(system: System) -> list[Contribution]:
    """Return what adds to the equations of a numbered scene, in the order in which it is added."""
    own = [name for name, is_needed in NAMES.items() if is_needed(system)]
    names = dict.fromkeys([*own, *(each.contribution for each in system.scene.attached)])
    if system.loads.gravity_column:
        names["changing_gravity"] = None
    for name in ("changing_gravity", "rotating"):  # act on the masses of all others
        if name in names:
            names[name] = names.pop(name)
    modules = (import_module(f"{__name__}.{name}") for name in names)
    return [part for module in modules for part in module.of(system)]
