"""Tubes around the axes of beams and meshes: points that move, and rings around them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.results.geometry.deformed_shape import trace_elements
from ancfsparse.results.geometry.scene_outline import BodyAxis

MAX_PIECES = 8  # straight pieces of an element
ROPE = -1.0  # in place of an element: a rope, spring or distance
SOLID = -2.0  # an edge of a rigid body
TOTAL_PIECES = 1600  # straight pieces of all elements


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

    # Ends of tubes are closed by a second ring without radius.
    free = counts[pairs] == 1
    rows = np.concatenate([index[free[:, 0], 0], index[free[:, 1], -1]])
    caps = rings.reshape(-1, 6)[rows]
    caps[:, 5] = np.repeat([-1.0, 1.0], free.sum(axis=0))
    closing = np.column_stack([rows, index.size + np.arange(len(rows))])
    starts = free[:, 0].sum()
    closing[:starts] = closing[:starts, ::-1]  # with the outer side outside
    return Tubes(
        np.concatenate([nodes, inner], axis=1),
        np.concatenate([rings.reshape(-1, 6), caps]),
        np.concatenate([strips, closing]),
    )


def make_lines(ends: Vector, kind: float, radius: float = 0.0) -> Tubes:
    """Return straight tubes between ends (k, n, 2, dim) [m]; of no radius [m] they are thin."""
    n = ends.shape[1]
    pairs = np.arange(2 * n).reshape(n, 2)
    rings = np.zeros((n, 2, 6))
    rings[..., 0], rings[..., 1], rings[..., 2] = pairs, pairs[:, :1], pairs[:, 1:]
    rings[..., 3], rings[..., 4] = kind, radius
    return Tubes(ends.reshape(len(ends), 2 * n, ends.shape[3]), rings.reshape(-1, 6), pairs.copy())


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
