"""Obstacles of every shape under a cable, and their cores as points."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

import ancfsparse as ancf


def sphere(n, radius):
    """An octahedron whose edges are divided into n, with all vertices on a sphere."""
    corners = np.concatenate([np.eye(3), -np.eye(3)])
    vertices, numbers, triangles = [], {}, []

    def number(point):
        key = tuple(np.round(point, 9) + 0.0)
        if key not in numbers:
            numbers[key] = len(vertices)
            vertices.append(radius * point / np.linalg.norm(point))
        return numbers[key]

    for k in range(8):
        a, b, c = (corners[i + 3 * (k >> i & 1)] for i in range(3))
        if bin(k).count("1") % 2:
            b, c = c, b
        for i in range(n):
            for j in range(n - i):
                at = {
                    (p, q): a * (n - p - q) + b * p + c * q for p in (i, i + 1) for q in (j, j + 1)
                }
                triangles.append([number(at[p]) for p in ((i, j), (i + 1, j), (i, j + 1))])
                if i + j < n - 1:
                    triangles.append(
                        [number(at[p]) for p in ((i + 1, j), (i + 1, j + 1), (i, j + 1))]
                    )
    return np.array(vertices), np.array(triangles)


def hills(x):
    """Heights with slopes up to 0.6 [m]."""
    return 0.02 * np.sin(30.0 * x)


TURN = (np.cos(0.3), np.sin(0.3) / 3, np.sin(0.3) * 2 / 3, np.sin(0.3) * 2 / 3)
SHAPES = {
    "stadium": ancf.Capsule((-0.05, -0.06), (0.03, -0.08), 0.05),
    "rectangle": ancf.Block((0, 0), (0.12, 0.1), 0.01, 0.3),
    "sharp rectangle": ancf.Block((0, 0), (0.12, 0.1), orientation=0.3),
    "ring": ancf.Torus((0, 0), 0.06, 0.01),
    "capsule": ancf.Capsule((-0.05, -0.06, 0.01), (0.03, -0.08, -0.02), 0.05),
    "block": ancf.Block((0, 0, 0), (0.1, 0.1, 0.08), 0.01, TURN),
    "sharp block": ancf.Block((0, 0, 0.02), (0.1, 0.1, 0.08), orientation=TURN),
    "torus": ancf.Torus((0, 0, 0.01), 0.06, 0.015, (1, 0.2, 0.1)),
}
# Those whose orientation matters on a body.
ORIENTED = SHAPES | {
    "plane": ancf.HalfSpace((0, 0), (0.1, 1)),
    "floor": ancf.HalfSpace((0, 0, 0), (0.1, 1, 0.1)),
    "drum": ancf.Drum((0, 0, 0), 0.07, (0.1, 0.1, 1)),
    "mesh": ancf.TriangleMesh((0, 0, 0), *sphere(6, 0.07), cell=0.01),
    "profile": ancf.HeightField((-0.2, 0), hills(np.linspace(0, 0.4, 41)), 0.01),
}
LINE = np.linspace(-0.3, 0.3, 601)


@lru_cache
def lowered(obstacle, gap):
    """Return an obstacle that is moved along y to a distance below a line on the x axis."""
    dim = obstacle.dim
    line, up = np.outer(LINE, np.eye(dim)[0]), np.eye(dim)[1]

    def distance(height):
        return obstacle.distances(line + height * up).min()

    # From above, since there can be a hole.
    high = next(h for h in np.linspace(0.2, -0.2, 401) if distance(h - 1e-3) < gap)
    low = high - 1e-3
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if distance(middle) < gap else (low, middle)
    shift = -high * up
    ends = {
        n: tuple(np.array(getattr(obstacle, n)) + shift)
        for n in ("base", "end")
        if hasattr(obstacle, n)
    }
    return replace(obstacle, **ends)


def core_points(obstacle, n):
    """Points of the core, about n per length, (k, dim), by the definition of each shape."""
    base, unit = np.array(obstacle.base), np.linspace(0.0, 1.0, n)
    if isinstance(obstacle, ancf.Capsule):
        return base + np.outer(unit, np.array(obstacle.end) - base)
    if isinstance(obstacle, ancf.Torus):
        plane = np.eye(2)
        if obstacle.dim == 3:
            axis = np.array(obstacle.axis) / np.linalg.norm(obstacle.axis)
            plane = np.linalg.svd(axis[None])[2][1:]
        angles = 2.0 * np.pi * unit
        return base + obstacle.ring_radius * np.stack([np.cos(angles), np.sin(angles)], 1) @ plane
    half = 0.5 * np.array(obstacle.size) - obstacle.radius
    if obstacle.dim == 2:
        angle = obstacle.orientation
        columns = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    else:
        w, *v = obstacle.orientation
        skew = np.cross(np.eye(3), v)  # Rodrigues' formula
        columns = np.eye(3) + 2.0 * w * skew + 2.0 * skew @ skew
    grid = np.meshgrid(*(obstacle.dim * [np.linspace(-1.0, 1.0, n)]))
    return base + (np.stack([g.ravel() for g in grid], 1) * half) @ columns.T
