"""Motions as glTF files with animation, for Blender and browsers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ancfsparse.array_types import Vector
from ancfsparse.file_names import check_target
from ancfsparse.results.data.selected_columns import Readable
from ancfsparse.results.export.gltf_file import GltfFile
from ancfsparse.results.geometry.body_outlines import RigidOutline
from ancfsparse.results.geometry.deformed_shape import (
    read_rows,
    spread_rows,
    trace_elements,
    trace_slopes,
)
from ancfsparse.results.geometry.obstacle_outlines import trace_obstacle
from ancfsparse.results.geometry.obstacle_surfaces import make_obstacle_surface
from ancfsparse.results.geometry.scene_outline import BodyAxis, Outline
from ancfsparse.results.geometry.tubes import (
    ROPE,
    SOLID,
    TubeSurface,
    find_frame,
    join_rings,
    make_lines,
    pad_points,
)
from ancfsparse.results.geometry.wireframe import make_wireframe
from ancfsparse.results.plotting.canvas import axis_limits, upright_components
from ancfsparse.results.plotting.traced_scene import TracedScene, clip_lines, trace_scene

MAX_STATES = 501  # as in reports
SIDES = 12  # vertices of a ring
MAX_BEND = 0.6  # rad between the ends of a piece, whose middle is then 4.5 % thinner
MAX_PIECES = 16  # of an element
MAX_RINGS = 12  # of an element
TOTAL_RINGS = 2400  # of all elements
LINE_RADIUS = 0.01  # radius of the lines of rigid bodies, over the extent of the body
ROPE_RADIUS = 0.002  # radius of ropes and springs, over the extent of the scene
COLOURS = {
    "beam": (0.028, 0.159, 0.347),  # linear RGB
    "body": (0.768, 0.366, 0.107),
    "rope": (0.133, 0.133, 0.133),
    "obstacle": (0.604, 0.604, 0.604),
}
TURNS = {
    0: (0.0, 0.0, np.sin(np.pi / 4), np.cos(np.pi / 4)),
    1: (0.0, 0.0, 0.0, 1.0),
    2: (-np.sin(np.pi / 4), 0.0, 0.0, np.cos(np.pi / 4)),
}
"""Quaternion that turns an axis of space to y, which is upwards in the format."""


def write_gltf(outline: Outline, times: Vector, states: Readable, path: str | Path) -> Path:
    """Write coordinates (k, n) at times (k,) [s]; see `Trajectory.to_gltf`."""
    target = check_target("a glTF file", path, (".glb",))
    rows = spread_rows(times, MAX_STATES)
    q, t = np.asarray(read_rows(states, rows)[:]), times[rows]
    file = GltfFile(t)
    up = upright_components(outline.gravity)[2] if outline.dim == 3 else 1
    root = file.add_node(name="scene", rotation=list(TURNS[up]))
    colours = {name: file.add_material(name, colour) for name, colour in COLOURS.items()}
    count = sum(len(part.lengths) for part in outline.parts)
    rings = int(np.clip(TOTAL_RINGS // max(count, 1), 2, MAX_RINGS))
    for part in outline.parts:
        _add_tube(file, root, colours["beam"], q, part, rings)
    for solid in outline.solids:
        _add_solid(file, root, colours["body"], q, solid)
    scene = trace_scene(outline, q, t)
    _add_links(file, root, colours["rope"], scene, q)
    _add_obstacles(file, root, colours["obstacle"], scene)
    file.write(target)
    return target


def _add_tube(
    file: GltfFile, root: int, material: int, q: Vector, part: BodyAxis, rings: int
) -> None:
    """Add a beam or a mesh, whose axis in each piece of an element is a Bézier cubic.

    A vertex has four joints: the control points of its piece.  Those at the ends have the places,
    directions and stretches of the axis there; the inner ones are children of them, at a third of
    the piece.  The weights are Bernstein polynomials, so that the axis is exact.
    """
    pieces, n_elements = _count_pieces(q, part), len(part.lengths)
    node, chosen = _number_nodes(part, pieces)
    points, slopes = (
        pad_points(trace(q, part, pieces)).reshape(len(q), -1, 3)[:, chosen]
        for trace in (trace_elements, trace_slopes)
    )
    stretch = np.linalg.norm(slopes, axis=2)
    turns, scales = _turn(slopes / stretch[..., None]), np.ones_like(points)
    scales[..., 0] = stretch
    joints = []
    for k in range(len(chosen)):
        joints.append(file.add_node(root))
        file.move(joints[-1], "translation", points[:, k])
        file.move(joints[-1], "rotation", turns[:, k])
        file.move(joints[-1], "scale", scales[:, k])
    ends = np.stack([node[:, :-1], node[:, 1:]], axis=-1).reshape(-1, 2)
    for pair, third in zip(ends, np.repeat(part.lengths / (3.0 * pieces), pieces), strict=True):
        for k, along in zip(pair, (third, -third), strict=True):
            joints.append(file.add_node(joints[k], translation=[float(along), 0.0, 0.0]))
    inner = len(chosen) + np.arange(ends.size).reshape(-1, 2)
    control = np.column_stack([ends[:, 0], inner, ends[:, 1]])
    skin = file.add_skin(joints, root)

    s = np.linspace(0.0, 1.0, max(2, rings // pieces) + 1)
    bernstein = np.stack([(1 - s) ** 3, 3 * s * (1 - s) ** 2, 3 * s**2 * (1 - s), s**3], axis=1)
    index = np.arange(len(control) * len(s)).reshape(n_elements, pieces, len(s))
    strips = np.stack([index[..., :-1], index[..., 1:]], axis=-1).reshape(-1, 2)
    tips = part.places[:, [0, part.places.shape[1] // 2]].reshape(2 * n_elements, -1)
    _, tip, counts = np.unique(tips, axis=0, return_inverse=True, return_counts=True)
    free = counts[tip].reshape(n_elements, 2) == 1
    # Ends are closed by a second ring without radius.
    first, last = index[free[:, 0], 0, 0], index[free[:, 1], -1, -1]
    ring = np.concatenate([np.arange(index.size), first, last])
    cap = np.repeat([0.0, -1.0, 1.0], [index.size, len(first), len(last)])
    extra = index.size + np.arange(len(first) + len(last))
    closing = np.column_stack(
        [np.append(extra[: len(first)], last), np.append(first, extra[len(first) :])]
    )
    angles = 2.0 * np.pi * np.arange(SIDES) / SIDES
    around = np.stack([np.zeros(SIDES), np.cos(angles), np.sin(angles)], axis=1)
    is_cap = (cap != 0.0)[:, None, None]
    normals = np.where(is_cap, cap[:, None, None] * (1.0, 0.0, 0.0), around)
    vertices = np.where(is_cap, 0.0, part.radius * around) + np.zeros_like(normals)
    mesh = file.add_mesh(
        material,
        vertices.reshape(-1, 3),
        join_rings(np.concatenate([strips, closing]), SIDES),
        NORMAL=normals.reshape(-1, 3),
        JOINTS_0=np.repeat(np.repeat(control, len(s), axis=0)[ring], SIDES, axis=0),
        WEIGHTS_0=np.repeat(np.tile(bernstein, (len(control), 1))[ring], SIDES, axis=0),
    )
    file.add_node(name=part.name, mesh=mesh, skin=skin)


def _count_pieces(q: Vector, part: BodyAxis) -> int:
    """Return the pieces of an element, each of which bends by a small angle."""
    if part.places.shape[1] == 2:  # a string
        return 1
    slopes = trace_slopes(q, part, 8)
    slopes /= np.linalg.norm(slopes, axis=3, keepdims=True)
    cosines = np.clip((slopes[:, :, 1:] * slopes[:, :, :-1]).sum(axis=3), -1.0, 1.0)
    bend = float(np.arccos(cosines).sum(axis=2).max())
    return int(np.clip(np.ceil(bend / MAX_BEND), 1, MAX_PIECES))


def _number_nodes(part: BodyAxis, pieces: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the nodes of all pieces (n_elements, pieces + 1), and a point of each node.

    The ends of elements that have the same coordinates are one node.
    """
    n = len(part.lengths)
    number = np.arange(n * (pieces + 1)).reshape(n, pieces + 1)
    if part.places.shape[1] == 4:
        tips = number[:, [0, -1]].ravel()
        _, first, same = np.unique(
            part.places.reshape(2 * n, -1), axis=0, return_index=True, return_inverse=True
        )
        number[:, [0, -1]] = tips[first][same.reshape(n, 2)]
    chosen, node = np.unique(number, return_inverse=True)
    return node.reshape(number.shape), chosen


def _turn(tangents: Vector) -> Vector:
    """Return the rotations (k, n, 4) of x to tangents (k, n, 3), continuous in both indices."""
    frame = find_frame(tangents)
    first, second, start = frame
    turns = np.empty((*tangents.shape[:2], 4))
    turns[..., :3], turns[..., 3] = np.cross(start, tangents), 1.0 + tangents @ start
    base = Rotation.from_matrix(np.column_stack([start, first, second]))
    every = Rotation.from_quat(turns.reshape(-1, 4)) * base
    return np.asarray(every.as_quat().reshape(turns.shape))


def _add_solid(file: GltfFile, root: int, material: int, q: Vector, solid: RigidOutline) -> None:
    """Add a rigid body, whose lines are thin tubes where it has no surface."""
    drawn = make_wireframe(solid)
    points, facets = pad_points(drawn.weights[:, 1:]), drawn.facets
    if not len(facets):
        radius = LINE_RADIUS * float(np.ptp(points, axis=0).max())
        surface = TubeSurface(make_lines(points[drawn.edges][None], SOLID, radius), SIDES)
        points, facets = surface.trace(0)[0], surface.facets
    body = file.add_node(root, name=solid.name, mesh=file.add_mesh(material, points, facets))
    vectors = pad_points(np.asarray(q[:, solid.places]))
    file.move(body, "translation", vectors[:, 0])
    if vectors.shape[1] == 2:  # a rod without section
        length = np.linalg.norm(vectors[:, 1:], axis=2, keepdims=True)
        file.move(body, "rotation", _turn(vectors[:, 1:] / length)[:, 0])
        return
    axes = np.tile(np.eye(3), (len(q), 1, 1))
    axes[:, : vectors.shape[1] - 1] = vectors[:, 1:]
    turns = Rotation.from_matrix(axes.transpose(0, 2, 1)).as_quat()
    signs = np.sign(np.sum(turns[1:] * turns[:-1], axis=1))
    turns[1:] *= np.cumprod(signs)[:, None]  # of both signs the one near the last state
    file.move(body, "rotation", turns)


def _add_links(file: GltfFile, root: int, material: int, scene: TracedScene, q: Vector) -> None:
    """Add ropes, springs and distances as cylinders that change their length."""
    links = scene.outline.links
    if not len(links):
        return
    ends = pad_points(links.ends(q))
    radius = ROPE_RADIUS * float(np.ptp(scene.frame, axis=0).max())
    unit = np.array([[[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]]])
    surface = TubeSurface(make_lines(unit, ROPE, radius), SIDES)
    vertices, normals = surface.trace(0)
    mesh = file.add_mesh(material, vertices, surface.facets, NORMAL=normals)
    along = ends[:, :, 1] - ends[:, :, 0]
    lengths = np.linalg.norm(along, axis=2)
    turns = _turn(along / np.maximum(lengths, np.finfo(float).tiny)[..., None])
    for k in range(len(links)):
        rope = file.add_node(root, name=f"rope {k}", mesh=mesh)
        file.move(rope, "translation", ends[:, k, 0])
        file.move(rope, "rotation", turns[:, k])
        scales = np.ones((len(q), 3))
        scales[:, 0] = lengths[:, k]
        file.move(rope, "scale", scales)


def _add_obstacles(file: GltfFile, root: int, material: int, scene: TracedScene) -> None:
    """Add surfaces of obstacles as they are at first, or else their lines."""
    limits = axis_limits(scene.frame)
    for obstacle in scene.outline.obstacles:
        surface = make_obstacle_surface(obstacle, scene.box)
        if surface is None:
            lines = clip_lines(trace_obstacle(obstacle, scene.box, limits), *limits)
            points = pad_points(lines[~np.isnan(lines).any(axis=(1, 2))]).reshape(-1, 3)
            surface = points, np.arange(len(points)).reshape(-1, 2)
        if len(surface[1]):
            mesh = file.add_mesh(material, *surface)
            file.add_node(root, name=obstacle.noun, mesh=mesh)
