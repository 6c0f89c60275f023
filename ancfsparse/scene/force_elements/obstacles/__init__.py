"""Obstacles that beams touch, each the set of points within a radius of its core."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.force_elements.obstacles.basic_obstacles import Ball, Drum, HalfSpace
    from ancfsparse.scene.force_elements.obstacles.distance_grids import (
        fit_spline,
        interpolate,
        sampled_core,
        smallest_bend,
    )
    from ancfsparse.scene.force_elements.obstacles.obstacle import Obstacle
    from ancfsparse.scene.force_elements.obstacles.obstacle_types import OBSTACLE_TYPES
    from ancfsparse.scene.force_elements.obstacles.sampled_obstacles import (
        HeightField,
        SampledObstacle,
        TriangleMesh,
    )
    from ancfsparse.scene.force_elements.obstacles.solid_obstacles import Block, Capsule, Torus
    from ancfsparse.scene.force_elements.obstacles.surface_distances import (
        distances_to_surface,
        winding_numbers,
    )

__all__ = [
    "OBSTACLE_TYPES",
    "Ball",
    "Block",
    "Capsule",
    "Drum",
    "HalfSpace",
    "HeightField",
    "Obstacle",
    "SampledObstacle",
    "Torus",
    "TriangleMesh",
    "distances_to_surface",
    "fit_spline",
    "interpolate",
    "sampled_core",
    "smallest_bend",
    "winding_numbers",
]

__getattr__ = on_demand(
    __name__,
    {
        "basic_obstacles": "Ball Drum HalfSpace",
        "distance_grids": "fit_spline interpolate sampled_core smallest_bend",
        "obstacle": "Obstacle",
        "obstacle_types": "OBSTACLE_TYPES",
        "sampled_obstacles": "HeightField SampledObstacle TriangleMesh",
        "solid_obstacles": "Block Capsule Torus",
        "surface_distances": "distances_to_surface winding_numbers",
    },
)
