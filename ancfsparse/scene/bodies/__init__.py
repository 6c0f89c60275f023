"""Handles with coordinates: beams, meshes, rigid bodies, points."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.bodies.frame import Frame
    from ancfsparse.scene.bodies.rigid_body import RigidBody
    from ancfsparse.scene.bodies.rigid_shapes import RigidShape
    from ancfsparse.scene.bodies.section_offsets import checked_offsets, offsets_of
    from ancfsparse.scene.bodies.strained_reference import strained_ends

__all__ = ["Frame", "RigidBody", "RigidShape", "checked_offsets", "offsets_of", "strained_ends"]

__getattr__ = on_demand(
    __name__,
    {
        "frame": "Frame",
        "rigid_body": "RigidBody",
        "rigid_shapes": "RigidShape",
        "section_offsets": "checked_offsets offsets_of",
        "strained_reference": "strained_ends",
    },
)
