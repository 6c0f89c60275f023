"""Meshes, built from their records by array operations: edges are chained to lines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Indices, Integers, Vector
from ancfsparse.checks import check_count, check_finite
from ancfsparse.errors import InputError
from ancfsparse.scene.bodies.auto_element import stand_ins
from ancfsparse.scene.bodies.element_choice import (
    check_make,
    chosen_element,
    given_options,
    slack_string,
)
from ancfsparse.scene.bodies.mesh import Mesh, MeshSpec
from ancfsparse.scene.geometry.section_frames import along_principal_axes, section_frames
from ancfsparse.scene.meshing.initial_velocity import velocity_field
from ancfsparse.scene.meshing.node_edge_checks import check_graph
from ancfsparse.scene.meshing.straight_beam import check_element_memory

# Rotation of e_y over the rotation of the slope at a bend: in lines steeper than 60 degrees,
# sections with e_z near +z would rotate about their axes by more.
MAX_ROTATION_RATIO = 2.0
ROUNDING = 1e-9  # of the difference of two unit vectors
BYTES_PER_ELEMENT = 400.0  # of the arrays of an element


def build_mesh(record: MeshSpec, dim: int) -> Mesh:
    """Check the arguments of a mesh and build its handle, which is not yet part of a scene."""
    label, section, material = record.name, record.section, record.material
    stand_in, n_elements, automatic = stand_ins(record.element, record.n_elements, "thin", 1)
    if record.slack is not None:
        stand_in = slack_string(label, record.element, dim, record.slack)
    element, chosen, kind = chosen_element(label, stand_in, dim, given_options(record))
    check_make(label, kind, section, material)
    if not section.is_uniform:
        raise InputError(
            f"{label} cannot have a {type(section).__name__}, which follows one beam: give its "
            "edges one section, or take beams of add_beam"
        )
    angle = check_finite(f"smooth of {label}", record.smooth, "degrees")
    if not 0.0 <= angle <= 90.0:
        raise InputError(f"smooth of {label} must lie between 0 and 90 degrees, got {angle:.6g}")
    count = check_count(f"n_elements of {label}", n_elements)
    positions, given, lengths = check_graph(label, dim, record.nodes, record.edges)
    directions = (positions[given[:, 1]] - positions[given[:, 0]]) / lengths[:, None]
    # Half-edge 2 e is where edge e begins, 2 e + 1 where it ends; each points away from its node.
    at = given.ravel()
    outward = np.stack([directions, -directions], axis=1).reshape(-1, dim)
    partners = _partners(at, outward, 2.0 * np.sin(0.5 * np.radians(angle)))
    if count > 1:
        check_element_memory(label, count * len(given), BYTES_PER_ELEMENT)
        positions, given, partners = _divided(positions, given, partners, count)
        at, lengths = given.ravel(), np.repeat(lengths / count, count)
        directions = np.repeat(directions, count, axis=0)
    flipped = _find_reversed(len(given), partners)
    row_nodes, row_of = _rows(at, partners)
    slopes = _mean_slopes(len(row_nodes), row_of, directions, flipped)
    ends = row_of.reshape(-1, 2)
    vectors = slopes[:, None]
    if kind.section[1:]:
        vectors = along_principal_axes(_frames(label, slopes, ends, count), section)
    for table in (given, ends):
        table[flipped] = table[flipped, ::-1]
    return Mesh(
        name=label,
        element=element,
        options=chosen,
        kind=kind,
        section=section,
        material=material,
        positions=positions,
        velocity=velocity_field(label, record.velocity, positions),
        automatic=automatic,
        n_each=count,
        edges=given,
        flipped=flipped,
        lengths=lengths,
        row_nodes=row_nodes,
        ends=ends,
        vectors=vectors,
    )


def _frames(label: str, slopes: Vector, ends: Integers, n_each: int) -> Vector:
    """Return the unit vectors of the section of each row, (n_rows, dim, dim).

    Raises
    ------
    InputError
        If sections of one line have different orientations.
    """
    frames = section_frames(slopes)
    e_x, e_y = (np.linalg.norm(np.diff(frames[ends, k], axis=1)[:, 0], axis=1) for k in (0, 1))
    is_twisted = e_y > MAX_ROTATION_RATIO * e_x + ROUNDING
    if is_twisted.any():
        k = int(np.argmax(is_twisted)) // n_each
        raise InputError(
            f"{label} has a bend in a line that is too steep at edge {k}: its sections would have "
            "different orientations; give a smaller `smooth` for a hinge there, or "
            "weld beams by add_frame with `up`"
        )
    return frames


def _partners(at: Integers, outward: Vector, bend: float) -> tuple[Indices, Indices]:
    """Pair the half-edges that continue each other, straightest first.

    Parameters
    ----------
    at : (2 m,) int
        Node of each half-edge.
    outward : (2 m, dim) float
        Unit vectors away from that node.
    bend : float
        Length of the sum of two unit vectors from which they form a corner.

    Returns
    -------
    a, b : (k,) int
        Half-edges that continue each other; none appears twice.
    """
    order = np.argsort(at, kind="stable")
    node, out = at[order], outward[order]
    one, other, bends = [], [], []
    first = np.arange(len(order))
    step = 1
    while True:  # all pairs at a node: offset 1, 2, ... in the sorted list
        first = first[first + step < len(order)]
        first = first[node[first] == node[first + step]]
        if not len(first):
            break
        sums = np.linalg.norm(out[first] + out[first + step], axis=1)
        straight = sums < bend
        one.append(first[straight])
        other.append(first[straight] + step)
        bends.append(sums[straight])
        step += 1
    if not one:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    rank = np.argsort(np.concatenate(bends), kind="stable")
    a, b = order[np.concatenate(one)][rank], order[np.concatenate(other)][rank]
    return _matched(a, b, len(at))


def _divided(
    positions: Vector, edges: Integers, partners: tuple[Indices, Indices], k: int
) -> tuple[Vector, Integers, tuple[Indices, Indices]]:
    """Divide every edge into k that continue each other; new nodes come after the others."""
    m, n = len(edges), len(positions)
    tail, head = positions[edges[:, 0], None], positions[edges[:, 1], None]
    inner = tail + (np.arange(1, k) / k)[:, None] * (head - tail)
    numbers = np.arange(n, n + m * (k - 1), dtype=np.int32).reshape(m, k - 1)
    chains = np.hstack([edges[:, :1], numbers, edges[:, 1:]])
    pairs = np.stack([chains[:, :-1], chains[:, 1:]], axis=-1).reshape(-1, 2)
    a, b = (2 * (k * (half // 2) + (k - 1) * (half % 2)) + half % 2 for half in partners)
    before = (k * np.arange(m)[:, None] + np.arange(k - 1)).ravel()
    both = np.concatenate([a, 2 * before + 1]), np.concatenate([b, 2 * before + 2])
    return np.concatenate([positions, inner.reshape(-1, positions.shape[1])]), pairs, both


def _matched(a: Indices, b: Indices, n: int) -> tuple[Indices, Indices]:
    """Select pairs in order, without pairs that have a side in common with an earlier one.

    Each round selects all pairs that come first at both of their sides.
    """
    chosen_a, chosen_b = [a[:0]], [b[:0]]
    while len(a):
        best = np.full(n, len(a))
        for side in (a, b):
            np.minimum.at(best, side, np.arange(len(a)))
        rank = np.arange(len(a))
        chosen = (best[a] == rank) & (best[b] == rank)
        chosen_a.append(a[chosen])
        chosen_b.append(b[chosen])
        used = np.zeros(n, dtype=bool)
        used[a[chosen]] = used[b[chosen]] = True
        remaining = ~(used[a] | used[b])
        a, b = a[remaining], b[remaining]
    return np.concatenate(chosen_a), np.concatenate(chosen_b)


def _find_reversed(m: int, partners: tuple[Indices, Indices]) -> NDArray[np.bool_]:
    """Return the edges to be reversed so that every line has one direction, (m,) bool.

    A graph contains every edge as given (vertex 2 e) and reversed (2 e + 1); the vertex that leaves
    through a half-edge is connected to the one that enters through its partner.  A line is then two
    components, one for each direction; its first edge keeps its direction.
    """
    import scipy.sparse as sp
    from scipy.sparse.csgraph import connected_components

    a, b = partners
    # Leaving through half-edge h: as given if h is an end (odd).  Entering: as given if it is even.
    leaving_a, entering_b = a ^ 1, b
    leaving_b, entering_a = b ^ 1, a
    rows = np.concatenate([leaving_a, leaving_b])
    columns = np.concatenate([entering_b, entering_a])
    graph = sp.coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(2 * m, 2 * m))
    _, line = connected_components(graph, directed=False)
    first = np.unique(line, return_index=True)[1]
    is_reversed: NDArray[np.bool_] = first[line[0::2]] > first[line[1::2]]
    return is_reversed


def _rows(at: Integers, partners: tuple[Indices, Indices]) -> tuple[Integers, Integers]:
    """Return numbers of the slopes, node by node.

    Returns
    -------
    row_nodes : (n_rows,) int32
        Node of each slope, in ascending order.
    row_of : (2 m,) int32
        Slope of each half-edge, the same for partners.
    """
    a, b = partners
    owner = np.arange(len(at))
    owner[np.maximum(a, b)] = np.minimum(a, b)
    owners = np.flatnonzero(owner == np.arange(len(at)))
    owners = owners[np.argsort(at[owners], kind="stable")]
    number = np.empty(len(at), dtype=np.int32)
    number[owners] = np.arange(len(owners), dtype=np.int32)
    return at[owners], number[owner]


def _mean_slopes(
    n_rows: int, row_of: Integers, directions: Vector, flipped: NDArray[np.bool_]
) -> Vector:
    """Return the unit vector of each slope: the mean direction of its edges."""
    along = np.where(flipped[:, None], -directions, directions)
    slopes = np.empty((n_rows, directions.shape[1]))
    for d in range(directions.shape[1]):
        slopes[:, d] = np.bincount(row_of, np.repeat(along[:, d], 2), minlength=n_rows)
    slopes /= np.linalg.norm(slopes, axis=1)[:, None]
    return slopes
