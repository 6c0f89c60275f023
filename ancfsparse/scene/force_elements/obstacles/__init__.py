"""Obstacles that beams touch, each the set of points within a radius of its core."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.scene.force_elements.obstacles.basic_obstacles import (
        Ball as Ball,
        Drum as Drum,
        HalfSpace as HalfSpace,
    )
    from ancfsparse.scene.force_elements.obstacles.closed_surfaces import (
        check_closed as check_closed,
    )
    from ancfsparse.scene.force_elements.obstacles.distance_grids import (
        fit_spline as fit_spline,
        interpolate as interpolate,
        sampled_core as sampled_core,
        smallest_bend as smallest_bend,
    )
    from ancfsparse.scene.force_elements.obstacles.obstacle import Obstacle as Obstacle
    from ancfsparse.scene.force_elements.obstacles.obstacle_types import (
        OBSTACLE_TYPES as OBSTACLE_TYPES,
    )
    from ancfsparse.scene.force_elements.obstacles.sampled_obstacles import (
        HeightField as HeightField,
        SampledObstacle as SampledObstacle,
        TriangleMesh as TriangleMesh,
    )
    from ancfsparse.scene.force_elements.obstacles.solid_obstacles import (
        Block as Block,
        Capsule as Capsule,
        Torus as Torus,
    )
    from ancfsparse.scene.force_elements.obstacles.surface_distances import (
        distances_to_surface as distances_to_surface,
        winding_numbers as winding_numbers,
    )

__getattr__ = on_demand(
    __name__,
    {
        "basic_obstacles": "Ball Drum HalfSpace",
        "closed_surfaces": "check_closed",
        "distance_grids": "fit_spline interpolate sampled_core smallest_bend",
        "obstacle": "Obstacle",
        "obstacle_types": "OBSTACLE_TYPES",
        "sampled_obstacles": "HeightField SampledObstacle TriangleMesh",
        "solid_obstacles": "Block Capsule Torus",
        "surface_distances": "distances_to_surface winding_numbers",
    },
)
