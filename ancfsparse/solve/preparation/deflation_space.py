"""Coarse modes of a scene: motions of large parts that hardly strain it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.scene import Mesh
from ancfsparse.seeds import Slides
from ancfsparse.system import System

if TYPE_CHECKING:
    import scipy.sparse as sp

Vector = NDArray[np.float64]
Numbers = NDArray[np.integer[Any]]

# Nodes of a box at most, and boxes; large scenes have larger boxes, so that the matrix of the modes
# stays small.
IN_BOX, BOXES = 64, 64
# Elements that a wave must run through in a step: lattices ask for modes at 100, and not at 26.
REACH = 40.0


class CoarseModes:
    """Sliding of each cable along itself, and affine motions of boxes of nodes.

    A cable that slides through those that cross it is held by their bending alone; a box that turns
    or shears, by little more.  Modes are taken at the present coordinates, so turns stay turns.

    Parameters
    ----------
    system : System
        The scene.
    """

    def __init__(self, system: System) -> None:
        dim = system.dim
        self._n, self._dim = system.n_free, dim
        # Of each row: position, tangent, line.
        positions = system.vectors("r")
        self._rows = np.concatenate(positions)
        self._tangents = _Tangents(system)
        self._line = _lines(system)
        # All slopes, and the node and box of each.
        slopes, owner = [], []
        for name in ("r_x", "r_y", "r_z"):
            for table, position in zip(system.vectors(name), positions, strict=True):
                if table.shape[1] == dim:
                    slopes.append(table)
                    owner.append(position[:, 0])
        self._slopes = np.concatenate(slopes) if slopes else np.empty((0, dim), dtype=np.int32)
        heads, index = np.unique(self._rows[:, 0], return_index=True)
        self._nodes = self._rows[index]
        self._box = boxes(system.q0[self._nodes])
        owners = np.concatenate(owner) if owner else np.empty(0, dtype=np.int32)
        self._slope_box = self._box[np.searchsorted(heads, owners)]

    def at(self, q: Vector) -> sp.csc_array:
        """Return the modes in columns at coordinates ``q (n_all,)``, those that move anything."""
        import scipy.sparse as sp

        modes = sp.csc_array(sp.hstack([self._sliding(q), self._affine(q)]))
        return modes[:, np.flatnonzero(np.diff(modes.indptr))]

    def _columns(self, entries: list[tuple[Numbers, Numbers, Vector]], width: int) -> sp.csc_array:
        """Return a matrix of entries (place, column, value), without those of what is fixed."""
        import scipy.sparse as sp

        places, columns, values = (np.concatenate(part) for part in zip(*entries, strict=True))
        kept = (places < self._n) & (values != 0.0)
        return sp.csc_array((values[kept], (places[kept], columns[kept])), shape=(self._n, width))

    def _sliding(self, q: Vector) -> sp.csc_array:
        """Move each line along its slopes."""
        tangents = self._tangents.at(q)
        entries: list[tuple[Numbers, Numbers, Vector]] = []
        for k in range(self._dim):
            entries.append((self._rows[:, k], self._line, tangents[:, k]))
        return self._columns(entries, int(self._line.max()) + 1)

    def _affine(self, q: Vector) -> sp.csc_array:
        """Move each box, and turn, stretch and shear it with its slopes."""
        dim, box, x = self._dim, self._box, q[self._nodes]
        count = np.bincount(box)
        sums = np.stack([np.bincount(box, c) for c in x.T], axis=1)
        apart = x - (sums / count[:, None])[box]
        size = np.sqrt(np.bincount(box, np.sum(apart**2, axis=1)) / count)
        size[size == 0.0] = 1.0
        apart /= size[box, None]
        tilts = q[self._slopes] / size[self._slope_box, None]
        width = dim * (dim + 1)
        entries: list[tuple[Numbers, Numbers, Vector]] = []
        for k in range(dim):
            first = width * box + k * (dim + 1)
            entries.append((self._nodes[:, k], first, np.ones(len(x))))
            first_of_slope = width * self._slope_box + k * (dim + 1)
            for j in range(dim):
                entries.append((self._nodes[:, k], first + j + 1, apart[:, j]))
                entries.append((self._slopes[:, k], first_of_slope + j + 1, tilts[:, j]))
        return self._columns(entries, width * len(count))


def slides_of(system: System, dt: float = np.inf) -> Slides | None:
    """Return the points of all cables that can slide along themselves, and directions at the start.

    A cable that is held at a point cannot.  Where waves run through a few elements in a step of
    ``dt`` [s], sliding is not needed, and the result is None.
    """
    speeds = [np.sqrt(b.material.youngs_modulus / b.material.density) for b in system.scene.beams]
    if (
        dt * max(c / b.lengths.min() for c, b in zip(speeds, system.scene.beams, strict=True))
        < REACH
    ):
        return None
    dim, at = system.dim, np.concatenate(system.vectors("r"))
    tangent = _Tangents(system).at(system.q0)
    line = _lines(system)
    held = np.zeros(int(line.max()) + 1, dtype=bool)
    held[line[(at >= system.n_free).any(axis=1)]] = True
    number, free = np.cumsum(~held, dtype=np.int32) - np.int32(1), ~held[line]
    unknown = np.full((int(free.sum()), 3), -1, dtype=np.int32)
    direction = np.zeros(unknown.shape, dtype=np.float32)
    unknown[:, :dim] = at[free]
    direction[:, :dim] = tangent[free]
    return Slides(unknown, number[line[free]], direction)


class _Tangents:
    """Directions of the axis at all rows: slopes, or of strings those of an element at the row."""

    def __init__(self, system: System) -> None:
        pairs = zip(system.scene.bodies, system.vectors("r"), system.vectors("r_x"), strict=True)
        plus, minus = [], []
        for body, positions, slopes in pairs:
            tail, head = slopes, np.full_like(slopes, -1)
            if body.kind.is_string:
                tail, head = np.empty_like(positions), np.empty_like(positions)
                for rows in body.ends.T:
                    tail[rows], head[rows] = (positions[each] for each in body.ends.T[::-1])
            plus.append(tail)
            minus.append(head)
        self._plus, self._minus = np.concatenate(plus), np.concatenate(minus)

    def at(self, q: Vector) -> Vector:
        """Return unit vectors (n_rows, dim) at coordinates ``q (n_all,)``."""
        out = q[self._plus] - np.where(self._minus >= 0, q[self._minus], 0.0)
        return np.asarray(out / np.linalg.norm(out, axis=1, keepdims=True))


def _lines(system: System) -> Numbers:
    """Return the line of every row of all bodies: a beam is one, a mesh has its own."""
    lines, total = [], 0
    for body, table in zip(system.scene.bodies, system.places, strict=True):
        own = body.lines if isinstance(body, Mesh) else np.zeros(len(table), dtype=np.int64)
        lines.append(total + own)
        total += int(own.max()) + 1
    return np.concatenate(lines)


def boxes(places: Vector) -> Numbers:
    """Halve points ``(n, dim)`` across their longest side, and halves; return the box of each."""
    most = max(IN_BOX, len(places) // BOXES)
    box, parts, done = np.empty(len(places), dtype=np.int64), [np.arange(len(places))], 0
    while parts:
        part = parts.pop()
        if len(part) <= most:
            box[part] = done
            done += 1
            continue
        along = int(np.argmax(np.ptp(places[part], axis=0)))
        order = part[np.argsort(places[part, along], kind="stable")]
        parts += [order[: len(order) // 2], order[len(order) // 2 :]]
    return box
