"""Surfaces of the obstacles that have a simple one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.results.geometry.body_outlines import RigidOutline
from ancfsparse.results.geometry.obstacle_outlines import tangents_of, trace_drum_axis
from ancfsparse.results.geometry.tubes import pad_points
from ancfsparse.results.geometry.wireframe import make_wireframe
from ancfsparse.scene.force_elements.obstacles import Ball, Drum, Obstacle, TriangleMesh

UNUSED = np.zeros((0, 0), np.int32)  # coordinates: fixed obstacles have none
INSET = 0.995  # of the surface, over the radius, so that its lines are seen


def make_obstacle_surface(
    obstacle: Obstacle, box: Vector
) -> tuple[Vector, NDArray[np.int64]] | None:
    """Return points (n, 3) [m] and triangles (m, 3) of a ball, a drum or a mesh of triangles.

    Drums have the length of the box of the bodies (2, dim) [m] along their axis, as their lines.
    Other obstacles are drawn by lines alone.
    """
    if isinstance(obstacle, TriangleMesh):
        return np.add(obstacle.vertices, obstacle.base), np.array(obstacle.triangles)
    if not isinstance(obstacle, (Ball, Drum)):
        return None
    reach, axes = np.full(3, INSET * obstacle.radius), np.eye(obstacle.dim)
    centre, form = np.array(obstacle.base), "sphere"
    if isinstance(obstacle, Drum) and obstacle.axis is not None:
        ends = trace_drum_axis(obstacle, box)
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        reach[2] = 0.5 * float(np.linalg.norm(ends[1] - ends[0]))
        centre, axes, form = ends.mean(axis=0), np.stack([*tangents_of(along), along]), "cylinder z"
    drawn = make_wireframe(
        RigidOutline(obstacle.noun, form, UNUSED, reach, np.zeros((1, obstacle.dim)))
    )
    return pad_points(drawn.weights[:, 1:] @ axes + centre), drawn.facets
