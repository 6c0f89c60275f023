"""Everything that adds to the equations of motion: one module each."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any

from ancfsparse.system.contributions.interface import Contribution

if TYPE_CHECKING:
    from ancfsparse.system.system import System

NAMES: dict[str, Callable[[Any], bool]] = {
    "bodies.elements": lambda system: bool(system.scene.beams),
    "bodies.rigid_bodies": lambda system: any(
        body.masses is not None for body in system.scene.bodies
    ),
    "applied.nodal_loads": lambda system: bool(system.loads.place),
    "applied.moments": lambda system: bool(system.loads.moment_place),
    "applied.follower_forces": lambda system: bool(system.loads.followers),
    "joints.constraints": lambda system: system.n_multipliers > 0,
    "joints.joint_coordinate_constraints": lambda system: any(
        not m.is_track for *_, m in system.constraints.measures
    ),
    "joints.sliding_joints": lambda system: any(
        m.is_track for *_, m in system.constraints.measures
    ),
}
"""Modules of these folders, and which systems need them; what is attached to a scene names its own.

The function ``of`` of each takes a system and returns its parts.
"""


def contributions_of(system: System) -> list[Contribution]:
    """Return what adds to the equations of a numbered scene, in the order in which it is added."""
    own = [name for name, is_needed in NAMES.items() if is_needed(system)]
    names = dict.fromkeys([*own, *(each.contribution for each in system.scene.attached)])
    if system.loads.gravity_column:
        names["bodies.time_dependent_gravity"] = None
    for name in (
        "bodies.time_dependent_gravity",
        "bodies.rotating_frame",
    ):  # act on the masses of all others
        if name in names:
            names[name] = names.pop(name)
    modules = (import_module(f"{__name__}.{name}") for name in names)
    return [part for module in modules for part in module.of(system)]
