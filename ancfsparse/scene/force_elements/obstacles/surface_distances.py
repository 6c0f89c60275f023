"""Distances from surfaces of triangles, and winding numbers."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from ancfsparse.array_types import Indices, Vector

# Samples of the surface per node, whose triangles are tried for the closest one.  By vertices of
# more triangles distances are off by .003 of a cell; with 8 by .006, and with 4 by .05.
NEAREST = 16
CHUNK = 100_000  # points at a time
ASIDE = 6.18e-7, 3.82e-7  # shift of columns over the spacing of a grid


def simplex_distances(points: Vector, corners: Vector) -> Vector:
    """Return the distances of points (n, dim) from a triangle each, (n, 3, dim), (n,) [m].

    In the plane triangles are segments, with two equal corners.
    """
    best = np.full(len(points), np.inf)
    for i in range(3):
        start, along = corners[:, i], corners[:, (i + 1) % 3] - corners[:, i]
        square = np.maximum(np.sum(along * along, axis=1), np.finfo(float).tiny)
        part = np.clip(np.sum((points - start) * along, axis=1) / square, 0.0, 1.0)
        foot = start + part[:, None] * along
        best = np.minimum(best, np.linalg.norm(points - foot, axis=1))
    if points.shape[1] == 2:
        return best
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(normal, axis=1)
    is_over = size > 0.0
    for i in range(3):
        along = corners[:, (i + 1) % 3] - corners[:, i]
        is_over &= np.sum(np.cross(normal, along) * (points - corners[:, i]), axis=1) >= 0.0
    height = np.abs(np.sum(normal * (points - corners[:, 0]), axis=1))
    height /= np.where(size > 0.0, size, 1.0)
    return np.where(is_over, np.minimum(best, height), best)


def distances_to_surface(axes: list[Vector], corners: Vector, band: float) -> Vector:
    """Return the distances of the nodes of a grid from triangles (m, 3, dim), of its shape [m].

    Within a band around the surface [m] they are exact for nodes whose closest triangle owns one
    of the NEAREST samples, half a cell apart.  Beyond, the distance is the one of the closest node
    in the band plus the distance from that node.
    """
    cell = axes[0][1] - axes[0][0]
    low = np.array([axis[0] for axis in axes])
    samples, owners = _sample(corners, 0.5 * cell)
    is_far = np.ones([len(axis) for axis in axes], dtype=bool)
    nearest_nodes = np.round((samples - low) / cell).astype(int)
    is_far[tuple(np.clip(nearest_nodes, 0, np.array(is_far.shape) - 1).T)] = False
    is_far = distance_transform_edt(is_far, sampling=cell) > band + cell
    beyond, closest = distance_transform_edt(is_far, sampling=cell, return_indices=True)
    band_nodes = np.argwhere(~is_far)
    tree, k = cKDTree(samples), min(NEAREST, len(samples))
    distances = np.zeros(is_far.shape)
    for start in range(0, len(band_nodes), CHUNK):
        part = band_nodes[start : start + CHUNK]
        points = low + cell * part
        nearest = owners[tree.query(points, k=k)[1]].reshape(len(part), k)
        columns = [simplex_distances(points, corners[column]) for column in nearest.T]
        distances[tuple(part.T)] = np.min(columns, axis=0)
    return np.asarray(distances[tuple(closest)] + beyond)


def _sample(corners: Vector, spacing: float) -> tuple[Vector, Indices]:
    """Return points of triangles at most a spacing apart, and the triangle of each."""
    edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    pieces = np.maximum(np.ceil(edges / spacing), 1.0).astype(int)
    samples, owners = [], []
    for n in np.unique(pieces):
        own = np.flatnonzero(pieces == n)
        i, j = (each.ravel() for each in np.meshgrid(np.arange(n + 1), np.arange(n + 1)))
        inner = i + j <= n
        weights = np.stack([i, j, n - i - j], axis=1)[inner] / n
        samples.append(
            np.einsum("wk,tkd->twd", weights, corners[own]).reshape(-1, corners.shape[2])
        )
        owners.append(np.repeat(own, len(weights)))
    return np.concatenate(samples), np.concatenate(owners)


def winding_numbers(axes: list[Vector], vertices: Vector, triangles: Indices) -> Vector:
    """Return how often a closed surface winds around the nodes of a grid, of its shape.

    They are sums of +1 or -1 over the triangles above a node.  On which side of a common edge a
    column is follows from the same numbers for both triangles, so no column passes between them.
    """
    z, cell = axes[2], axes[0][1] - axes[0][0]
    # Columns avoid vertices, which are often in planes of nodes.
    x, y = axes[0] + ASIDE[0] * cell, axes[1] + ASIDE[1] * cell
    crossings = np.zeros((len(x), len(y), len(z) + 1))
    for triangle in triangles:
        corners = vertices[triangle]
        low, high = corners.min(axis=0), corners.max(axis=0)
        columns = [
            slice(np.searchsorted(axis, low[c]), np.searchsorted(axis, high[c], "right"))
            for c, axis in enumerate((x, y))
        ]
        here = np.stack(np.meshgrid(x[columns[0]], y[columns[1]], indexing="ij"), axis=-1)
        if not here.size:
            continue
        sides = [_side(vertices, triangle[i], triangle[(i + 1) % 3], here) for i in range(3)]
        is_left = (sides[0] > 0) & (sides[1] > 0) & (sides[2] > 0)
        is_right = (sides[0] < 0) & (sides[1] < 0) & (sides[2] < 0)
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        hit = np.argwhere(is_left | is_right)
        if not len(hit) or normal[2] == 0.0:
            continue
        i, j = hit.T
        height = corners[0, 2] - ((here[i, j] - corners[0, :2]) @ normal[:2]) / normal[2]
        level = np.searchsorted(z, height)
        turn = np.where(is_left[i, j], 1.0, -1.0)
        np.add.at(crossings, (columns[0].start + i, columns[1].start + j, level), turn)
    above = np.cumsum(crossings[:, :, ::-1], axis=2)[:, :, ::-1]
    return np.asarray(above[:, :, 1:])


def _side(vertices: Vector, tail: int, head: int, points: Vector) -> Vector:
    """Return 1 for points left of an edge seen from above, -1 for others, (...)."""
    first, second = vertices[min(tail, head)], vertices[max(tail, head)]
    along, arm = second[:2] - first[:2], points - first[:2]
    turn = np.where(along[0] * arm[..., 1] - along[1] * arm[..., 0] >= 0.0, 1.0, -1.0)
    return turn if tail < head else -turn
