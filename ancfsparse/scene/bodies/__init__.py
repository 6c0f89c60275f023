"""Handles with coordinates: beams, meshes, rigid bodies, points."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.bodies.frame import Frame
    from ancfsparse.scene.bodies.rigid_body import RigidBody
    from ancfsparse.scene.bodies.rigid_shapes import RigidShape

__all__ = ["Frame", "RigidBody", "RigidShape"]

_MODULES = {
    "Frame": "frame",
    "RigidBody": "rigid_body",
    "RigidShape": "rigid_shapes",
}

__getattr__ = on_demand(__name__, _MODULES)
