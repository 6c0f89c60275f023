"""Where each coordinate of each node stands in the vector q: free ones first, fixed ones after."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from ancfsparse.errors import InputError
from ancfsparse.scene import Beam, Clamp, Connect, Node, Pin, Scene

# A slope whose direction is within this of a coordinate axis can be clamped by numbering.
ALIGNED = 1e-14


@dataclass(frozen=True)
class Numbering:
    """Places in q, and the reference state there.

    Attributes
    ----------
    n_free, n_all : int
        Free coordinates, and all of them.
    places : list of (n_nodes, n_c) int arrays
        Per beam: place of each nodal coordinate; position first, then the slope r_x.
    q, v : (n_all,) float
        Reference coordinates [m, 1] and initial velocities [m/s, 1/s].
    """

    n_free: int
    n_all: int
    places: list[NDArray[np.int64]]
    q: NDArray[np.float64]
    v: NDArray[np.float64]


def number(scene: Scene, coordinates_per_node: Sequence[int]) -> Numbering:
    """Give every coordinate of a scene its place.

    Held coordinates are fixed and joined positions shared by numbering; what cannot be said that
    way is left to `constraints`.

    Parameters
    ----------
    scene : Scene
        The beams and joints.
    coordinates_per_node : sequence of int
        For each beam.

    Raises
    ------
    InputError
        If an initial velocity moves a held point.
    """
    sizes = [b.n_nodes * c for b, c in zip(scene.beams, coordinates_per_node, strict=True)]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    raw = [
        start + np.arange(size).reshape(beam.n_nodes, -1)
        for start, size, beam in zip(starts, sizes, scene.beams, strict=False)
    ]
    index = {id(beam): k for k, beam in enumerate(scene.beams)}

    def at(node: Node) -> NDArray[np.int64]:
        numbers: NDArray[np.int64] = raw[index[id(node.beam)]][node.index]
        return numbers

    owner = _shared(scene, int(starts[-1]), at)
    held = np.zeros(starts[-1], dtype=bool)
    for joint in scene.joints:
        if isinstance(joint, Pin) and not joint.as_constraint:
            held[owner[at(joint.node)[: scene.dim]]] = True
        elif isinstance(joint, Clamp):
            held[owner[at(joint.node)[clamped(joint)]]] = True

    is_owner = owner == np.arange(starts[-1])
    free, fixed = np.flatnonzero(is_owner & ~held), np.flatnonzero(is_owner & held)
    final = np.empty(starts[-1], dtype=np.int64)
    final[free] = np.arange(len(free))
    final[fixed] = len(free) + np.arange(len(fixed))
    final = final[owner]

    places = [final[numbers] for numbers in raw]
    n_all = len(free) + len(fixed)
    q, v = np.zeros(n_all), np.zeros(n_all)
    for beam, where in zip(scene.beams, places, strict=True):
        q[where] = reference(beam, where.shape[1])
        if beam.velocity is not None:
            v[where] = velocities(beam, where.shape[1])
    moving = np.flatnonzero(
        np.abs(v[len(free) :]) > 1e-9 * max(1.0, float(np.abs(v).max(initial=0.0)))
    )
    if len(moving):
        raise InputError(
            f"the initial velocity moves {len(moving)} held coordinates, the first by "
            f"{v[len(free) + moving[0]]:.6g} m/s: give a velocity field that is zero at the joints"
        )
    v[len(free) :] = 0.0
    return Numbering(len(free), n_all, places, q, v)


def _shared(scene: Scene, n: int, at: Callable[[Node], NDArray[np.int64]]) -> NDArray[np.int64]:
    """Return for each raw number the lowest one that connections make it share a place with."""
    joints = [joint for joint in scene.joints if isinstance(joint, Connect)]
    if not joints:
        return np.arange(n)
    one = np.concatenate([at(joint.a)[: scene.dim] for joint in joints])
    other = np.concatenate([at(joint.b)[: scene.dim] for joint in joints])
    graph = sp.coo_array((np.ones(len(one), dtype=bool), (one, other)), shape=(n, n))
    _, group = connected_components(graph, directed=False)
    _, lowest = np.unique(group, return_index=True)
    owner: NDArray[np.int64] = lowest[group]
    return owner


def clamped(joint: Clamp) -> list[int]:
    """Nodal coordinates that a clamp fixes by numbering."""
    beam = joint.node.beam
    dim = beam.dim
    if beam.element == "thick":
        return list(range(12 if dim == 3 else 7))
    if joint.stretch == "fixed":
        return list(range(2 * dim))
    axis = along_axis(beam)
    across = [] if axis is None else [dim + d for d in range(dim) if d != axis]
    return list(range(dim)) + across


def along_axis(beam: Beam) -> int | None:
    """Return the coordinate axis that a beam is parallel to, or None."""
    direction = np.abs(beam.axes[0])
    axis = int(np.argmax(direction))
    return axis if np.all(np.delete(direction, axis) <= ALIGNED) else None


def reference(beam: Beam, n_coordinates: int) -> NDArray[np.float64]:
    """Return the straight, stress-free nodal coordinates of a beam, (n_nodes, n_c) [m, 1]."""
    q = np.empty((beam.n_nodes, n_coordinates))
    q[:, : beam.dim] = beam.positions
    q[:, beam.dim :] = np.append(beam.axes.ravel(), 1.0)[: n_coordinates - beam.dim]
    return q


def velocities(beam: Beam, n_coordinates: int) -> NDArray[np.float64]:
    """Return initial nodal velocities, (n_nodes, n_c) [m/s, 1/s].

    Slopes move with the derivative of the velocity field along their vector, a central difference
    over a thousandth of an element: exact for rigid motions.
    """
    field = beam.velocity
    assert field is not None
    v = np.zeros((beam.n_nodes, n_coordinates))
    v[:, : beam.dim] = field(beam.positions)
    reach = 1e-3 * beam.length / beam.n_elements
    for k, axis in enumerate(beam.axes):
        columns = slice(beam.dim * (k + 1), beam.dim * (k + 2))
        if columns.stop > n_coordinates:
            break
        ahead, behind = beam.positions + reach * axis, beam.positions - reach * axis
        v[:, columns] = (field(ahead) - field(behind)) / (2.0 * reach)
    return v
