"""Deflation space of a scene: motions of large parts with little strain energy."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Indices, Vector
from ancfsparse.seeds import Slides
from ancfsparse.system import System

if TYPE_CHECKING:
    import scipy.sparse as sp


MIN_BOX_NODES = 64  # nodes of a box
MAX_BOXES = 64  # boxes, so that the matrix of the modes stays small
# Lattices need these modes at 100 elements per step, and not at 26.
MIN_ELEMENTS_PER_STEP = 40.0  # elements that an axial wave passes in a step


class DeflationModes:
    """Sliding of each cable along itself, and affine motions of boxes of nodes.

    A cable that slides through those that cross it is restrained by their bending alone, a box that
    rotates or shears by little more.  Modes follow the present coordinates, and so rotations.

    Parameters
    ----------
    system : System
        The scene.
    """

    def __init__(self, system: System) -> None:
        dim = system.dim
        self._n, self._dim = system.n_free, dim
        # Position, tangent and line of each nodal frame.
        positions = system.vectors("r")
        self._rows = np.concatenate(positions)
        self._tangents = _Tangents(system)
        self._line = _line_numbers(system)
        # All slopes, with the node and the box of each.
        slopes, owner = [], []
        for name in ("r_x", "r_y", "r_z"):
            for table, position in zip(system.vectors(name), positions, strict=True):
                if table.shape[1] == dim:
                    slopes.append(table)
                    owner.append(position[:, 0])
        self._slopes = np.concatenate(slopes) if slopes else np.empty((0, dim), dtype=np.int32)
        heads, index = np.unique(self._rows[:, 0], return_index=True)
        self._nodes = self._rows[index]
        self._box = divide_into_boxes(system.q0[self._nodes])
        owners = np.concatenate(owner) if owner else np.empty(0, dtype=np.int32)
        self._slope_box = self._box[np.searchsorted(heads, owners)]

    def at(self, q: Vector) -> sp.csc_array:
        """Return the nonzero modes in columns at coordinates ``q (n_all,)``."""
        import scipy.sparse as sp

        modes = sp.csc_array(sp.hstack([self._sliding(q), self._affine(q)]))
        return modes[:, np.flatnonzero(np.diff(modes.indptr))]

    def _columns(self, entries: list[tuple[Indices, Indices, Vector]], width: int) -> sp.csc_array:
        """Return the matrix of entries (index, column, value) of free coordinates."""
        import scipy.sparse as sp

        indices, columns, values = (np.concatenate(part) for part in zip(*entries, strict=True))
        free = (indices < self._n) & (values != 0.0)
        return sp.csc_array((values[free], (indices[free], columns[free])), shape=(self._n, width))

    def _sliding(self, q: Vector) -> sp.csc_array:
        """Return the displacement of each line along its tangents."""
        tangents = self._tangents.at(q)
        entries: list[tuple[Indices, Indices, Vector]] = []
        for k in range(self._dim):
            entries.append((self._rows[:, k], self._line, tangents[:, k]))
        return self._columns(entries, int(self._line.max()) + 1)

    def _affine(self, q: Vector) -> sp.csc_array:
        """Return translation, rotation, stretch and shear of each box, with its slopes."""
        dim, box, x = self._dim, self._box, q[self._nodes]
        count = np.bincount(box)
        sums = np.stack([np.bincount(box, c) for c in x.T], axis=1)
        offset = x - (sums / count[:, None])[box]
        size = np.sqrt(np.bincount(box, np.sum(offset**2, axis=1)) / count)
        size[size == 0.0] = 1.0
        offset /= size[box, None]
        tilts = q[self._slopes] / size[self._slope_box, None]
        width = dim * (dim + 1)
        entries: list[tuple[Indices, Indices, Vector]] = []
        for k in range(dim):
            first = width * box + k * (dim + 1)
            entries.append((self._nodes[:, k], first, np.ones(len(x))))
            first_of_slope = width * self._slope_box + k * (dim + 1)
            for j in range(dim):
                entries.append((self._nodes[:, k], first + j + 1, offset[:, j]))
                entries.append((self._slopes[:, k], first_of_slope + j + 1, tilts[:, j]))
        return self._columns(entries, width * len(count))


def sliding_points(system: System, dt: float = np.inf) -> Slides | None:
    """Return the points of all cables that can slide along themselves, and their tangents.

    A cable with a constrained point cannot.  The result is None if axial waves pass only a few
    elements in a step of ``dt`` [s], for then sliding is resolved.
    """
    speeds = [np.sqrt(b.material.youngs_modulus / b.material.density) for b in system.scene.beams]
    if (
        dt * max(c / b.lengths.min() for c, b in zip(speeds, system.scene.beams, strict=True))
        < MIN_ELEMENTS_PER_STEP
    ):
        return None
    dim, indices = system.dim, np.concatenate(system.vectors("r"))
    tangent = _Tangents(system).at(system.q0)
    line = _line_numbers(system)
    is_fixed = np.zeros(int(line.max()) + 1, dtype=bool)
    is_fixed[line[(indices >= system.n_free).any(axis=1)]] = True
    number, free = np.cumsum(~is_fixed, dtype=np.int32) - np.int32(1), ~is_fixed[line]
    unknown = np.full((int(free.sum()), 3), -1, dtype=np.int32)
    direction = np.zeros(unknown.shape, dtype=np.float32)
    unknown[:, :dim] = indices[free]
    direction[:, :dim] = tangent[free]
    return Slides(unknown, number[line[free]], direction)


class _Tangents:
    """Tangents at all nodal frames: slopes, or for strings the direction of an adjacent element."""

    def __init__(self, system: System) -> None:
        pairs = zip(system.scene.bodies, system.vectors("r"), system.vectors("r_x"), strict=True)
        plus, minus = [], []
        for body, positions, slopes in pairs:
            tail, head = slopes, np.full_like(slopes, -1)
            if body.kind.is_string:
                tail, head = np.empty_like(positions), np.empty_like(positions)
                for rows in body.ends.T:
                    tail[rows], head[rows] = (positions[end] for end in body.ends.T[::-1])
            plus.append(tail)
            minus.append(head)
        self._plus, self._minus = np.concatenate(plus), np.concatenate(minus)

    def at(self, q: Vector) -> Vector:
        """Return unit vectors (n_rows, dim) at coordinates ``q (n_all,)``."""
        out = q[self._plus] - np.where(self._minus >= 0, q[self._minus], 0.0)
        return np.asarray(out / np.linalg.norm(out, axis=1, keepdims=True))


def _line_numbers(system: System) -> Indices:
    """Return the line of every nodal frame: one for a beam, the lines of a mesh."""
    lines, total = [], 0
    for body in system.scene.bodies:
        lines.append(total + body.lines)
        total += int(body.lines.max()) + 1
    return np.concatenate(lines)


def divide_into_boxes(positions: Vector) -> Indices:
    """Bisect points ``(n, dim)`` across the longest side; return the box of each."""
    largest = max(MIN_BOX_NODES, len(positions) // MAX_BOXES)
    box, parts, n = np.empty(len(positions), dtype=np.int64), [np.arange(len(positions))], 0
    while parts:
        part = parts.pop()
        if len(part) <= largest:
            box[part] = n
            n += 1
            continue
        axis = int(np.argmax(np.ptp(positions[part], axis=0)))
        order = part[np.argsort(positions[part, axis], kind="stable")]
        parts += [order[: len(order) // 2], order[len(order) // 2 :]]
    return box
