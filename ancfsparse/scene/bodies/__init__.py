"""Handles with coordinates: beams, meshes, rigid bodies, points."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.bodies.frame import Frame
    from ancfsparse.scene.bodies.rigid_body import RigidBody
    from ancfsparse.scene.bodies.rigid_shapes import Box, Cylinder, Rod, Sphere

__all__ = ["Box", "Cylinder", "Frame", "RigidBody", "Rod", "Sphere"]

_MODULES = {
    "Box": "rigid_shapes",
    "Cylinder": "rigid_shapes",
    "Frame": "frame",
    "RigidBody": "rigid_body",
    "Rod": "rigid_shapes",
    "Sphere": "rigid_shapes",
}

__getattr__ = on_demand(__name__, _MODULES)
