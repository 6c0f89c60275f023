"""Selection of the contributions that a system needs; the modules of the others are not loaded."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from ancfsparse.system.contributions.interface import Contribution
from ancfsparse.system.coordinates.discretization import Discretization

PACKAGE = __name__.rpartition(".")[0]
CONDITIONS: dict[str, Callable[[Discretization], bool]] = {
    "bodies.elements": lambda system: bool(system.scene.beams),
    "bodies.rigid_bodies": lambda system: any(
        body.masses is not None for body in system.scene.bodies
    ),
    "applied.nodal_loads": lambda system: bool(system.loads.place),
    "applied.moments": lambda system: bool(system.loads.moment_place),
    "applied.follower_forces": lambda system: bool(system.loads.followers),
    "joints.constraints": lambda system: system.n_multipliers > 0,
    "joints.joint_coordinate_constraints": lambda system: any(
        not m.is_sliding for *_, m in system.constraints.measures
    ),
    "joints.sliding_joints": lambda system: any(
        m.is_sliding for *_, m in system.constraints.measures
    ),
    "bodies.time_dependent_gravity": lambda system: bool(system.loads.gravity_column),
}
"""Modules of this package and which systems need them; attachments of a scene name their own."""
ON_ALL_MASSES = ("bodies.time_dependent_gravity", "bodies.rotating_frame")
"""Modules that act on the masses of all others, so that they come last."""


def contributions_of(system: Discretization) -> list[Contribution]:
    """Return the contributions of a system in the order of assembly.

    The function ``of`` of each module takes the system and returns its contributions.
    """
    needed = [name for name, is_needed in CONDITIONS.items() if is_needed(system)]
    names = dict.fromkeys([*needed, *(each.contribution for each in system.attachments)])
    ordered = [name for name in names if name not in ON_ALL_MASSES]
    ordered += [name for name in ON_ALL_MASSES if name in names]
    modules = (import_module(f"{PACKAGE}.{name}") for name in ordered)
    return [part for module in modules for part in module.of(system)]
