"""Lines of the obstacles that bodies touch."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.results.geometry.body_outlines import PACKED, RigidOutline, make_solid
from ancfsparse.results.geometry.core_outlines import CIRCLE_PIECES, trace_circle, trace_core
from ancfsparse.scene import Body
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.force_elements.contacts import Contact
from ancfsparse.scene.force_elements.obstacles import (
    OBSTACLE_TYPES,
    Ball,
    Drum,
    HalfSpace,
    Obstacle,
    SampledObstacle,
)
from ancfsparse.system.system import System

if TYPE_CHECKING:
    import h5py

AXIAL_LINES = 8  # of a drum, a divisor of `CIRCLE_PIECES`
MIN_LENGTH_RATIO = 1.0  # length of a drum, over its radius
HATCH_RATIO = 0.025  # spacing and depth of hatching strokes, over the extent of the picture
GRID_RATIO = 0.1  # spacing of the grid in a plane, over the extent of the picture
MAX_LINES = 3000  # of a mesh or a height field, more are left out evenly
MOVING_EXTENT = 2.0  # half extent of a plane or a drum on a body, over its size or radius
MAX_ENLARGEMENT = 3.0  # extent of a picture with a drum or a ball, over that of the bodies


def collect_obstacles(system: System, of: Body | None = None) -> list[Obstacle]:
    """Return the fixed obstacles of a system, or those that one of its bodies touches."""
    contacts = (each for each in system.attachments if isinstance(each, Contact) and not each.on)
    return list(
        dict.fromkeys(each.obstacle for each in contacts if of is None or of in each.bodies)
    )


def make_moving_obstacles(system: System, of: Body | None = None) -> list[RigidOutline]:
    """Return the obstacles on rigid bodies, or those on one of them."""
    contacts = (each for each in system.attachments if isinstance(each, Contact))
    moving = {(each.obstacle, each.on): each for each in contacts if each.on}
    outlines = []
    for (_, body), contact in moving.items():
        if body is not None and of in (None, body):
            outlines.append(_make_moving(system, contact, body))
    return outlines


def _make_moving(system: System, contact: Contact, body: RigidBody) -> RigidOutline:
    """Return an obstacle on a rigid body: a ball, or else its lines at the start."""
    obstacle, frame = contact.obstacle, make_solid(system, body, [])
    if obstacle.is_alike:
        centre = contact.base_point.offsets or (0.0,) * body.n_vectors
        reach = np.full(3, obstacle.radius)
        return RigidOutline(body.name, "sphere", frame.places, reach, np.array([centre]))
    extent = MOVING_EXTENT * max(body.size, obstacle.radius)
    box = np.array(obstacle.base) + np.array([[-extent], [extent]])
    arms = trace_obstacle(obstacle, box, box).reshape(-1, obstacle.dim) - body.positions[0]
    return RigidOutline(body.name, "lines", frame.places, np.zeros(3), arms @ body.vectors[0].T)


def write_obstacles(group: h5py.Group, obstacles: Iterable[Obstacle]) -> None:
    """Write obstacles to a group, as JSON."""
    if values := [[type(each).__name__, vars(each)] for each in obstacles]:
        text = np.frombuffer(json.dumps(values).encode(), np.uint8)
        group.create_dataset("obstacles", data=text, **PACKED)


def read_obstacles(group: h5py.Group) -> list[Obstacle]:
    """Read obstacles; none from a file of an early version.

    Raises
    ------
    LookupError, TypeError, ValueError
        If the table is damaged.
    """
    if "obstacles" not in group:
        return []
    values = json.loads(bytes(group["obstacles"][:]))
    return [OBSTACLE_TYPES[name](**arguments) for name, arguments in values]


def enlarge_box(box: Vector, obstacles: Iterable[Obstacle]) -> Vector:
    """Return the box of the bodies (2, dim) [m], with drums and balls that leave them visible."""
    result, limit = box, MAX_ENLARGEMENT * float(np.ptp(box, axis=0).max())
    for obstacle in obstacles:
        if not isinstance(obstacle, HalfSpace):
            lines = trace_obstacle(obstacle, box, box)
            low, high = lines.min(axis=(0, 1)), lines.max(axis=(0, 1))
            if np.max(np.maximum(high, box[1]) - np.minimum(low, box[0])) <= limit:
                result = np.stack([np.minimum(low, result[0]), np.maximum(high, result[1])])
    return result


def trace_obstacle(obstacle: Obstacle, box: Vector, limits: Vector, t: float = 0.0) -> Vector:
    """Return the ends of the lines of an obstacle at time t [s], shape (n, 2, dim) [m].

    Drums have the length of the box of the bodies (2, dim) [m] along their axis; the lines of
    planes continue beyond the limits of the picture (2, dim) [m].
    """
    if isinstance(obstacle, HalfSpace):
        return _trace_plane(obstacle, limits)
    centre, radius, dim = np.array(obstacle.base), obstacle.radius, obstacle.dim
    if isinstance(obstacle, Ball):
        pairs = [np.delete(np.eye(dim), k, axis=0) for k in range(3)] if dim == 3 else [np.eye(2)]
        return np.concatenate([trace_circle(centre, radius * pair) for pair in pairs])
    if isinstance(obstacle, SampledObstacle):
        every = obstacle.lines
        return np.asarray(every[:: 1 + len(every) // MAX_LINES])
    if not isinstance(obstacle, Drum):
        return trace_core(obstacle)
    centres, pair = centre[None], np.eye(2)
    if obstacle.axis is not None:
        ends = trace_drum_axis(obstacle, box)
        centres = np.stack([ends[0], ends.mean(axis=0), ends[1]])
        pair = tangents_of((ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0]))
    circles = np.stack([trace_circle(each, radius * pair) for each in centres])
    lines = [*circles]
    if len(centres) > 1:
        points = circles[:, :: CIRCLE_PIECES // AXIAL_LINES, 0]
        lines.append(np.stack([points[0], points[-1]], axis=1))
    if obstacle.angular_velocity:
        angle = obstacle.angular_velocity * t
        spoke = radius * np.array([np.cos(angle), np.sin(angle)]) @ pair
        lines.append(np.stack([centres, centres + spoke], axis=1))
    return np.concatenate(lines)


def trace_drum_axis(drum: Drum, box: Vector) -> Vector:
    """Return the ends of the axis of a drum in space, through the box of the bodies, (2, 3)."""
    along = np.array(drum.axis) / np.linalg.norm(drum.axis or 1.0)
    middle = float((box.mean(axis=0) - drum.base) @ along)
    half = 0.5 * max(float(np.ptp(box, axis=0) @ np.abs(along)), MIN_LENGTH_RATIO * drum.radius)
    return np.asarray(drum.base + np.outer([middle - half, middle + half], along))


def _trace_plane(obstacle: HalfSpace, limits: Vector) -> Vector:
    """Return a line with strokes behind it, in space a grid."""
    normal, middle = obstacle.normal_vector, limits.mean(axis=0)
    origin = middle - (middle - obstacle.base) @ normal * normal
    size, reach = np.ptp(limits, axis=0).max(), np.linalg.norm(np.ptp(limits, axis=0))
    tangents = tangents_of(normal)
    spacing = (HATCH_RATIO if obstacle.dim == 2 else GRID_RATIO) * size
    steps = spacing * np.arange(-np.ceil(reach / spacing), np.ceil(reach / spacing) + 1.0)
    if obstacle.dim == 2:
        starts = origin + np.outer(steps, tangents[0])
        strokes = np.stack([starts, starts - spacing * (normal + tangents[0])], axis=1)
        return np.concatenate([starts[None, [0, -1]], strokes])
    lines = []
    for along, across in (tangents, tangents[::-1]):
        starts = origin + np.outer(steps, across)
        lines.append(np.stack([starts - reach * along, starts + reach * along], axis=1))
    return np.concatenate(lines)


def tangents_of(normal: Vector) -> Vector:
    """Return the unit vectors normal to a unit vector, which follows them in a right-hand basis."""
    if len(normal) == 2:
        return np.array([[normal[1], -normal[0]]])
    first = np.eye(3)[np.argmin(np.abs(normal))]
    first = first - first @ normal * normal
    first = first / np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])
