"""Where each coordinate of each node stands in the vector q: free ones first, fixed ones after."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.scene import Body, Clamp, Connect, Node, Pin, Scene
from ancfsparse.system.state import SAME, State, carried_over

# A slope whose direction is within this of a coordinate axis can be clamped by numbering.
ALIGNED = 1e-14

# Share of the largest velocity by which two that must agree may differ: what is left of rounding.
ROUNDING = 1e-9

Places = NDArray[np.int32]


@dataclass(frozen=True)
class Numbering:
    """Places in q, and the reference state there.

    Attributes
    ----------
    n_free, n_all : int
        Free coordinates, and all of them.
    places : list of (n_rows, n_c) int32 arrays
        Per beam: place of each coordinate of each row (see `scene.bodies`; a row of a beam is a
        node); position first, then the slope r_x.
    q_ref : (n_all,) float
        Stress-free coordinates [m, 1].
    q, v : (n_all,) float
        Those at the start [m, 1], and velocities there [m/s, 1/s].
    """

    n_free: int
    n_all: int
    places: list[Places]
    q_ref: NDArray[np.float64]
    q: NDArray[np.float64]
    v: NDArray[np.float64]


def number(scene: Scene, kinds: Sequence[ElementKind], start: State | None = None) -> Numbering:
    """Give every coordinate of a scene its place.

    Held coordinates are fixed and joined positions shared by numbering; what cannot be done that
    way is left to `constraints`.

    Parameters
    ----------
    scene : Scene
        The beams and joints.
    kinds : sequence of ElementKind
        The element of each beam.
    start : State, optional
        Where to start; by default in the reference shape with the velocities of the beams.

    Raises
    ------
    InputError
        If an initial velocity moves a held point, or the start is of another scene.
    """
    raw: list[Places] = []
    index: dict[int, int] = {}
    n_raw = 0
    for beam, kind in zip(scene.beams, kinds, strict=True):
        index[id(beam)] = len(raw)
        raw.append(_raw(beam, len(kind.node_coordinates), n_raw))
        n_raw = int(raw[-1][-1, -1]) + 1

    def at(node: Node) -> Places:
        """Numbers of all rows of a node, (k, n_c)."""
        return raw[index[id(node.beam)]][node.beam.rows_of(node.index)]

    owner = _shared(scene, n_raw, at)
    held = np.zeros(n_raw, dtype=bool)
    for joint in scene.joints:
        if isinstance(joint, Pin) and not joint.as_constraint:
            held[_owners(owner, at(joint.node)[0, : scene.dim])] = True
        elif isinstance(joint, Clamp):
            rows = joint.node.beam.rows_of(joint.node.index)
            kind = kinds[index[id(joint.node.beam)]]
            for row, numbers in enumerate(at(joint.node), rows.start):
                held[_owners(owner, numbers[clamped(joint, row, kind)])] = True

    final, n_free, n_all = _ordered(owner, held)
    places = []
    while raw:  # one after the other, so that only one of them is there twice
        places.append(final[raw.pop(0)])
    del final, owner, held
    q_ref, v = np.empty(n_all), np.zeros(n_all)
    for beam, where in zip(scene.beams, places, strict=True):
        q_ref[where] = reference(beam, where.shape[1])
    q = q_ref
    if start is not None:
        q, v = carried_over(scene, start, places, q_ref)
        _hold_in_place(scene, places, q, q_ref, n_free)
        _hold_still(scene, places, v, n_free)
    elif any(beam.velocity is not None for beam in scene.beams):
        v[:] = np.nan  # not known yet
        for beam, where in zip(scene.beams, places, strict=True):
            _set_moving(beam, where, v)
        _hold_still(scene, places, v, n_free)
    return Numbering(n_free, n_all, places, q_ref, q, v)


def _raw(body: Body, n_c: int, start: int) -> Places:
    """Count the coordinates of a body from `start`, (n_rows, n_c), node by node."""
    node, dim = body.row_nodes, body.dim
    rows = np.arange(len(node), dtype=np.int32)
    begins = rows.copy()  # the first row of the node that the row belongs to
    begins[1:][node[1:] == node[:-1]] = 0
    begins = np.maximum.accumulate(begins)
    numbers = np.empty((len(node), n_c), dtype=np.int32)
    numbers[:, 0] = start + dim * node + (n_c - dim) * begins
    numbers[:, dim] = start + dim * (node + 1) + (n_c - dim) * rows
    for k in range(1, dim):
        numbers[:, k] = numbers[:, 0] + np.int32(k)
    for k in range(1, n_c - dim):
        numbers[:, dim + k] = numbers[:, dim] + np.int32(k)
    return numbers


def _shared(scene: Scene, n: int, at: Callable[[Node], Places]) -> Places | None:
    """Return for each raw number the lowest one that connections make it share a place with."""
    joints = [joint for joint in scene.joints if isinstance(joint, Connect)]
    if not joints:
        return None
    import scipy.sparse as sp
    from scipy.sparse.csgraph import connected_components

    one = np.concatenate([at(joint.a)[0, : scene.dim] for joint in joints])
    other = np.concatenate([at(joint.b)[0, : scene.dim] for joint in joints])
    graph = sp.coo_array((np.ones(len(one), dtype=bool), (one, other)), shape=(n, n))
    _, group = connected_components(graph, directed=False)
    _, lowest = np.unique(group, return_index=True)
    owner: Places = lowest.astype(np.int32)[group]
    return owner


def _owners(owner: Places | None, numbers: Places) -> Places:
    return numbers if owner is None else owner[numbers]


def _ordered(owner: Places | None, held: NDArray[np.bool_]) -> tuple[Places, int, int]:
    """Return the place of every raw number, free ones first, and how many are free and there."""
    free = ~held
    if owner is not None:
        own = owner == np.arange(len(owner), dtype=np.int32)
        free &= own
        held = held & own
    n_free, n_held = int(np.count_nonzero(free)), int(np.count_nonzero(held))
    final = np.cumsum(free, dtype=np.int32)
    final -= np.int32(1)
    final[held] = n_free + np.arange(n_held, dtype=np.int32)
    return final if owner is None else final[owner], n_free, n_free + n_held


def _set_moving(beam: Body, where: Places, v: NDArray[np.float64]) -> None:
    """Write the velocities of a beam, rest included, and refuse what another beam contradicts."""
    given = velocities(beam, where.shape[1])
    undefined = np.count_nonzero(~np.isfinite(given))
    if undefined:
        raise InputError(
            f"the initial velocity of {beam.name} is not a number for {undefined} of {given.size} "
            "coordinates: give a field that is defined beside the beam too, because slopes move "
            "with its derivative"
        )
    known, dim = v[where], beam.dim
    apart = np.abs(known - given)[:, :dim]  # only positions are shared; NaN is nothing known
    clash = np.argwhere(apart > ROUNDING * max(_largest(known[:, :dim]), _largest(given[:, :dim])))
    if len(clash):
        row, column = clash[0]
        more = f" ({len(clash)} coordinates in all)" if len(clash) > 1 else ""
        raise InputError(
            f"{_point(beam, row)} is connected to a beam whose initial velocity is another, "
            f"{given[row, column]:.6g} m/s against {known[row, column]:.6g} m/s along "
            f"{'xyz'[column]}{more}: give connected beams velocities that agree where they meet "
            "(none means at rest)"
        )
    v[where] = given


def _point(body: Body, row: int) -> Node:
    return Node(body, int(body.row_nodes[row]))


def _hold_in_place(
    scene: Scene,
    places: Sequence[Places],
    q: NDArray[np.float64],
    q_ref: NDArray[np.float64],
    n_free: int,
) -> None:
    """Set held coordinates to where joints hold them, which is where they are but for rounding."""
    apart = np.abs(q[n_free:] - q_ref[n_free:])
    if len(apart) and np.max(apart) > SAME * np.max(np.abs(q)):
        point, column = _found(scene, places, n_free + int(np.argmax(apart)))
        what, unit = ("position", " m") if column < scene.dim else ("slope", "")
        raise InputError(
            f"start has the {what} of {point!r} {np.max(apart):.3g}{unit} from where a joint of "
            "this scene holds it: leave out the joint, or start from a state that it allows"
        )
    q[n_free:] = q_ref[n_free:]


def _found(scene: Scene, places: Sequence[Places], place: int) -> tuple[Node, int]:
    """Return a node that has a coordinate, and the column of the coordinate in its row."""
    found = ((b, np.argwhere(w == place)) for b, w in zip(scene.beams, places, strict=True))
    body, (row, column) = next((body, at[0]) for body, at in found if len(at))
    return _point(body, row), int(column)


def _hold_still(
    scene: Scene, places: Sequence[Places], v: NDArray[np.float64], n_free: int
) -> None:
    """Set the velocity of held coordinates to zero, which it must be but for rounding."""
    held = v[n_free:]
    moving = np.flatnonzero(np.abs(held) > ROUNDING * speeds(scene, places, v)[n_free:])
    if len(moving):
        point, column = _found(scene, places, n_free + int(moving[0]))
        what, unit = ("position", "m/s") if column < scene.dim else ("slope", "1/s")
        raise InputError(
            f"the initial velocity moves {len(moving)} held coordinate"
            f"{'s, the first' if len(moving) > 1 else ','} of the {what} of {point} by "
            f"{held[moving[0]]:.6g} {unit}: give a velocity field that is zero at the joints"
        )
    held[:] = 0.0


def speeds(scene: Scene, places: Sequence[Places], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how fast coordinates move in a scene, (n_all,) [m/s, 1/s]: what rounding is beside.

    The largest velocity of a node for all positions, or what an element makes of the slopes' rates,
    since points between the nodes may move where no node does; for all slopes the largest of
    theirs, or what an element makes of that velocity.
    """
    straight = max(_largest(v[where[:, : scene.dim]]) for where in places)
    turning = max(_largest(v[where[:, scene.dim :]]) for where in places)
    shortest = min(float(beam.lengths.min()) for beam in scene.beams)
    out = np.full(len(v), max(turning, straight / shortest))
    for where in places:
        out[where[:, : scene.dim]] = max(straight, turning * shortest)
    return out


def _largest(values: NDArray[np.float64]) -> float:
    return float(np.nanmax(np.abs(values), initial=0.0))


def clamped(joint: Clamp, row: int, kind: ElementKind) -> list[int]:
    """Coordinates of a row that a clamp fixes by numbering."""
    beam = joint.node.beam
    dim = beam.dim
    if joint.stretch == "fixed":
        return list(range(len(kind.node_coordinates)))
    if not kind.is_cable:
        return [column for vector in ("r_", *kind.section) for column in kind.columns(vector)]
    axis = along_axis(beam.axes_of(row)[0])
    across = [] if axis is None else [dim + d for d in range(dim) if d != axis]
    return list(range(dim)) + across


def along_axis(slope: NDArray[np.float64]) -> int | None:
    """Return the coordinate axis that a slope is parallel to, or None."""
    direction = np.abs(slope)
    axis = int(np.argmax(direction))
    return axis if np.all(np.delete(direction, axis) <= ALIGNED) else None


def reference(body: Body, n_coordinates: int) -> NDArray[np.float64]:
    """Return the stress-free coordinates of all rows, (n_rows, n_c) [m, 1]."""
    nodes, dim = body.row_nodes, body.dim
    q = np.empty((len(nodes), n_coordinates))
    q[:, :dim] = body.positions if len(nodes) == body.n_nodes else body.positions[nodes]
    vectors = body.vectors.reshape(len(body.vectors), -1)[:, : n_coordinates - dim]
    q[:, dim:] = 1.0  # what a planar beam has besides: the stretch of its section along z
    q[:, dim : dim + vectors.shape[1]] = vectors
    return q


def velocities(body: Body, n_coordinates: int) -> NDArray[np.float64]:
    """Return initial velocities of all rows, (n_rows, n_c) [m/s, 1/s].

    Slopes move with the derivative of the velocity field along their vector, a central difference
    of fourth order over a thousandth of an element: exact for rigid motions, and to twelve digits
    of the velocity per element for fields that the mesh can follow.
    """
    field = body.velocity
    nodes, dim = body.row_nodes, body.dim
    v = np.zeros((len(nodes), n_coordinates))
    if field is None:
        return v
    places = body.positions[nodes]
    v[:, :dim] = field(body.positions)[nodes]
    reach = 5e-4 * float(body.lengths.min())
    for k in range(body.vectors.shape[1]):
        columns = slice(dim * (k + 1), dim * (k + 2))
        if columns.stop > n_coordinates:
            break
        step = reach * body.vectors[:, k]
        near = field(places + step) - field(places - step)
        far = field(places + 2.0 * step) - field(places - 2.0 * step)
        v[:, columns] = (8.0 * near - far) / (12.0 * reach)
    return v
