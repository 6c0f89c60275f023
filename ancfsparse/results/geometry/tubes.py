"""Tubes around the axes of beams and meshes: points that move, rings around them, surfaces."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.results.geometry.deformed_shape import trace_elements
from ancfsparse.results.geometry.scene_outline import BodyAxis

MAX_PIECES = 8  # straight pieces of an element
ROPE = -1.0  # in place of an element: a rope, spring or distance
SOLID = -2.0  # an edge of a rigid body
TOTAL_PIECES = 1600  # straight pieces of all elements
N_DIRECTIONS = 200  # among which that is searched from which no tangent is opposite


@dataclass(frozen=True, eq=False)
class Tubes:
    """Tubes around lines.

    Attributes
    ----------
    points : ndarray, shape (k, n_points, dim)
        Points of all lines in k states [m].
    rings : ndarray, shape (n_rings, 6)
        For each ring its point, the points before and after it, which determine its direction, its
        element (`ROPE` or `SOLID` for others), its radius [m], and -1 or 1 for the closed end of a
        tube, else 0.
    strips : ndarray, shape (n_strips, 2)
        Pairs of rings between which there is a surface.
    """

    points: Vector
    rings: Vector
    strips: Vector


def count_pieces(parts: list[BodyAxis]) -> int:
    """Return the number of pieces per element."""
    count = sum(len(part.lengths) for part in parts)
    return int(np.clip(TOTAL_PIECES // max(count, 1), 1, MAX_PIECES))


def make_tubes(q: Vector, part: BodyAxis, pieces: int) -> Tubes:
    """Return the tubes of a beam or a mesh for coordinates q (k, n).

    The ends of elements at a common node are one point.  Where two elements meet, the tube goes
    on smoothly; where more meet, as in a net, or only one, it has the direction of the element.
    """
    lines = trace_elements(q, part, pieces)
    n_elements = len(part.lengths)
    ends = part.places[:, [0, part.places.shape[1] // 2]].reshape(2 * n_elements, -1)
    _, first, node = np.unique(ends, axis=0, return_index=True, return_inverse=True)
    node = node.reshape(-1)
    element, side = first // 2, first % 2
    nodes = lines[:, element, np.where(side == 0, 0, pieces)]
    inner = lines[:, :, 1:-1].reshape(len(lines), n_elements * (pieces - 1), lines.shape[3])
    numbers = len(first) + np.arange(n_elements * (pieces - 1)).reshape(n_elements, pieces - 1)
    pairs = node.reshape(-1, 2)
    chains = np.column_stack([pairs[:, :1], numbers, pairs[:, 1:]])

    # The point beyond each end: of the other element at a node of two, or else the node itself.
    outer, adjacent = node.copy(), chains[:, [1, -2]].reshape(-1)
    counts = np.bincount(node)
    order = np.argsort(node, kind="stable")
    two = order[counts[node[order]] == 2].reshape(-1, 2)
    outer[two] = adjacent[two[:, ::-1]]
    beyond = outer.reshape(-1, 2)

    extended = np.column_stack([beyond[:, :1], chains, beyond[:, 1:]])
    rings = np.zeros((n_elements, pieces + 1, 6))
    rings[..., 0], rings[..., 1], rings[..., 2] = chains, extended[:, :-2], extended[:, 2:]
    rings[..., 3], rings[..., 4] = np.arange(n_elements)[:, None], part.radius
    index = np.arange(rings[..., 0].size).reshape(n_elements, pieces + 1)
    strips = np.stack([index[:, :-1], index[:, 1:]], axis=-1).reshape(-1, 2)

    free = counts[pairs] == 1
    return _close(
        np.concatenate([nodes, inner], axis=1), rings.reshape(-1, 6), strips,
        index[free[:, 0], 0], index[free[:, 1], -1],
    )  # fmt: skip


def make_lines(ends: Vector, kind: float, radius: float = 0.0) -> Tubes:
    """Return straight tubes between ends (k, n, 2, dim) [m]; of no radius [m] they are thin."""
    n = ends.shape[1]
    pairs = np.arange(2 * n).reshape(n, 2)
    rings = np.zeros((n, 2, 6))
    rings[..., 0], rings[..., 1], rings[..., 2] = pairs, pairs[:, :1], pairs[:, 1:]
    rings[..., 3], rings[..., 4] = kind, radius
    points = ends.reshape(len(ends), 2 * n, ends.shape[3])
    closed = pairs if radius else pairs[:0]
    return _close(points, rings.reshape(-1, 6), pairs.copy(), closed[:, 0], closed[:, 1])


def _close(
    points: Vector,
    rings: Vector,
    strips: NDArray[np.intp],
    first: NDArray[np.intp],
    last: NDArray[np.intp],
) -> Tubes:
    """Close tubes at their first and last rings, by a second ring there without radius."""
    rows = np.concatenate([first, last])
    caps = rings[rows]
    caps[:, 5] = np.repeat([-1.0, 1.0], [len(first), len(last)])
    closing = np.column_stack([rows, len(rings) + np.arange(len(rows))])
    closing[: len(first)] = closing[: len(first), ::-1]  # with the outer side outside
    return Tubes(points, np.concatenate([rings, caps]), np.concatenate([strips, closing]))


def join_tubes(every: list[Tubes]) -> Tubes:
    """Return several sets of tubes as one."""
    points, rings, strips = [], [], []
    n_points = n_rings = n_elements = 0
    for each in every:
        moved = each.rings.copy()
        moved[:, :3] += n_points
        moved[moved[:, 3] >= 0, 3] += n_elements
        points.append(each.points)
        rings.append(moved)
        strips.append(each.strips + n_rings)
        n_points, n_rings = n_points + each.points.shape[1], n_rings + len(moved)
        n_elements += int(each.rings[:, 3].max(initial=-1.0)) + 1
    return Tubes(np.concatenate(points, axis=1), np.concatenate(rings), np.concatenate(strips))


def join_rings(strips: NDArray[np.int64], sides: int) -> NDArray[np.int64]:
    """Return the triangles (n, 3) between pairs of rings (m, 2) with some vertices each."""
    side = np.arange(sides)
    after = (side + 1) % sides
    first, second = (sides * strips.T)[..., None]
    a, b, c, d = first + side, first + after, second + side, second + after
    pairs = np.stack([np.stack([a, d, c], axis=-1), np.stack([a, b, d], axis=-1)], axis=2)
    return pairs.reshape(-1, 3)


class TubeSurface:
    """Surface of tubes, whose vertices are on circles around the rings.

    Parameters
    ----------
    tubes : Tubes
        The tubes.
    sides : int
        Vertices of a circle.
    """

    def __init__(self, tubes: Tubes, sides: int) -> None:
        self.tubes, self.sides = tubes, sides

    @property
    def elements(self) -> Vector:
        """Element of each vertex, or the kind of its line."""
        return np.repeat(self.tubes.rings[:, 3], self.sides)

    @property
    def facets(self) -> NDArray[np.int64]:
        """Vertices of the triangles, (n, 3), counterclockwise seen from outside."""
        return join_rings(self.tubes.strips.astype(int), self.sides)

    def trace(self, state: int) -> tuple[Vector, Vector]:
        """Return vertices (n, 3) [m] and their normals (n, 3) [-] in one state."""
        rings, along = self.tubes.rings, self._tangents(slice(state, state + 1))[0]
        pair, start = self._frame[:2], self._frame[2]
        angles = 2.0 * np.pi * np.arange(self.sides) / self.sides
        around = np.stack([np.cos(angles), np.sin(angles)], axis=1) @ pair
        # The rotation from a common direction to the tangent turns its normals too.
        ratio = along @ around.T / (1.0 + along @ start)[:, None]
        normals = around - ratio[..., None] * (start + along)[:, None]
        centres = pad_points(self.tubes.points[state])[rings[:, 0].astype(int)]
        closed = rings[:, 5] != 0.0
        size = np.where(closed, 0.0, rings[:, 4])
        vertices = centres[:, None] + size[:, None, None] * normals
        normals[closed] = (rings[closed, 5, None] * along[closed])[:, None]
        return vertices.reshape(-1, 3), normals.reshape(-1, 3)

    @cached_property
    def _frame(self) -> Vector:
        states = range(len(self.tubes.points))
        return find_frame(self._tangents(slice(k, k + 1))[0] for k in states)

    def _tangents(self, states: slice) -> Vector:
        """Return the directions of the rings in some states, (j, n_rings, 3) [-]."""
        points = pad_points(self.tubes.points[states])
        before, after = self.tubes.rings[:, 1:3].T.astype(int)
        along = points[:, after] - points[:, before]
        size = np.linalg.norm(along, axis=2, keepdims=True)
        return np.where(size > 0.0, along / np.where(size > 0.0, size, 1.0), np.eye(3)[0])


def pad_points(points: Vector) -> Vector:
    """Return points with three components."""
    return np.pad(points, [*[(0, 0)] * (points.ndim - 1), (0, 3 - points.shape[-1])])


def find_frame(tangents: Iterable[Vector]) -> Vector:
    """Return two normals and a direction that is far from opposite to all tangents, (3, 3) [-].

    The smallest rotation from this direction to a tangent is a continuous function of it; it is
    singular at the opposite direction.
    """
    k = np.arange(N_DIRECTIONS) + 0.5  # points of a spiral on the unit sphere
    height, turn = 1.0 - 2.0 * k / N_DIRECTIONS, np.pi * (1.0 + np.sqrt(5.0)) * k
    width = np.sqrt(1.0 - height**2)
    every = np.stack([width * np.cos(turn), width * np.sin(turn), height], axis=1)
    cosine = np.ones(N_DIRECTIONS)
    for some in tangents:
        cosine = np.minimum(cosine, (every @ some.T).min(axis=1, initial=1.0))
    best = every[np.argmax(cosine)]
    first = np.cross(best, np.eye(3)[np.argmin(np.abs(best))])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(best, first), best])
