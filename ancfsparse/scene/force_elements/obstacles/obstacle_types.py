"""Classes of obstacles, by their names in files and messages."""

from ancfsparse.scene.force_elements.obstacles.basic_obstacles import Ball, Drum, HalfSpace
from ancfsparse.scene.force_elements.obstacles.obstacle import Obstacle
from ancfsparse.scene.force_elements.obstacles.sampled_obstacles import HeightField, TriangleMesh
from ancfsparse.scene.force_elements.obstacles.solid_obstacles import Block, Capsule, Torus

OBSTACLE_TYPES: dict[str, type[Obstacle]] = {
    kind.__name__: kind
    for kind in (HalfSpace, Drum, Ball, Capsule, Block, Torus, TriangleMesh, HeightField)
}
