"""Bodies that beams touch, each the set of points within a radius of its core."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.force_elements.obstacles.basic_obstacles import Ball, Drum, HalfSpace
    from ancfsparse.scene.force_elements.obstacles.obstacle import Obstacle
    from ancfsparse.scene.force_elements.obstacles.obstacle_types import OBSTACLE_TYPES
    from ancfsparse.scene.force_elements.obstacles.solid_obstacles import Block, Capsule, Torus

__all__ = [
    "OBSTACLE_TYPES",
    "Ball",
    "Block",
    "Capsule",
    "Drum",
    "HalfSpace",
    "Obstacle",
    "Torus",
]

__getattr__ = on_demand(
    __name__,
    {
        "basic_obstacles": "Ball Drum HalfSpace",
        "obstacle": "Obstacle",
        "obstacle_types": "OBSTACLE_TYPES",
        "solid_obstacles": "Block Capsule Torus",
    },
)
