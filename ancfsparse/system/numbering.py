"""Where each coordinate of each node stands in the vector q: free ones first, fixed ones after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.scene import Body, Node, Scene
from ancfsparse.scene.functions import RigidMotion
from ancfsparse.system.constraints import Constraints
from ancfsparse.system.lowering import Lowering
from ancfsparse.system.prescribed import Prescribed
from ancfsparse.system.state import SAME, State, carried_over

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
    constraints : Constraints
        The equations of joints that numbering cannot make.
    prescribed : Prescribed
        What the last coordinates and the last equations follow.
    q_ref : (n_all,) float
        Stress-free coordinates [m, 1].
    q, v : (n_all,) float
        Those at the start [m, 1], and velocities there [m/s, 1/s].
    """

    n_free: int
    n_all: int
    places: list[Places]
    constraints: Constraints
    prescribed: Prescribed
    q_ref: NDArray[np.float64]
    q: NDArray[np.float64]
    v: NDArray[np.float64]


def number(scene: Scene, kinds: Sequence[ElementKind], start: State | None = None) -> Numbering:
    """Give every coordinate of a scene its place.

    Joints lower themselves to coordinates that are fixed or shared, and to equations for what
    cannot be done that way.

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
    lowered = Lowering(scene, kinds)
    owner = lowered.owner()
    held = lowered.held(owner)
    driven = lowered.driven(owner)
    final, n_free, n_all = _ordered(owner, held, driven)
    n_still = n_all - len(driven)
    constraints = lowered.constraints(final, range(n_free, n_still))
    places, raw = [], lowered.raw
    while raw:  # one after the other, so that only one of them is there twice
        places.append(final[raw.pop(0)])
    del final, owner, held
    q_ref, v = np.empty(n_all), np.zeros(n_all)
    for beam, where in zip(scene.bodies, places, strict=True):
        q_ref[where] = reference(beam, where.shape[1])
    q = q_ref
    if start is not None:
        q, v = carried_over(scene, start, places, q_ref)
        _hold_in_place(scene, places, q, q_ref, slice(n_free, n_still))
        _hold_still(scene, places, v, slice(n_free, n_still))
    elif any(beam.velocity is not None for beam in scene.bodies):
        v[:] = np.nan  # not known yet
        for beam, where in zip(scene.bodies, places, strict=True):
            _set_moving(beam, where, v)
        _hold_still(scene, places, v, slice(n_free, n_still))
    prescribed = Prescribed(lowered.courses, lowered.led)
    return Numbering(n_free, n_all, places, constraints, prescribed, q_ref, q, v)


def _ordered(
    owner: Places | None, held: NDArray[np.bool_], driven: Places
) -> tuple[Places, int, int]:
    """Return the place of every raw number, and how many are free and there.

    Free ones come first, then held ones, and last those that are driven.
    """
    free = ~held
    free[driven] = False
    if owner is not None:
        own = owner == np.arange(len(owner), dtype=np.int32)
        free &= own
        held = held & own
    n_free, n_held = int(np.count_nonzero(free)), int(np.count_nonzero(held))
    n_still = n_free + n_held
    final = np.cumsum(free, dtype=np.int32)
    final -= np.int32(1)
    final[held] = n_free + np.arange(n_held, dtype=np.int32)
    final[driven] = n_still + np.arange(len(driven), dtype=np.int32)
    return final if owner is None else final[owner], n_free, n_still + len(driven)


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
    held: slice,
) -> None:
    """Set held coordinates to where joints hold them, which is where they are but for rounding."""
    apart = np.abs(q[held] - q_ref[held])
    if len(apart) and np.max(apart) > SAME * np.max(np.abs(q)):
        point, column = _found(scene, places, held.start + int(np.argmax(apart)))
        what, unit = ("position", " m") if column < scene.dim else ("slope", "")
        raise InputError(
            f"start has the {what} of {point!r} {np.max(apart):.3g}{unit} from where a joint of "
            "this scene holds it: leave out the joint, or start from a state that it allows"
        )
    q[held] = q_ref[held]


def _found(scene: Scene, places: Sequence[Places], place: int) -> tuple[Node, int]:
    """Return a node that has a coordinate, and the column of the coordinate in its row."""
    found = ((b, np.argwhere(w == place)) for b, w in zip(scene.bodies, places, strict=True))
    body, (row, column) = next((body, at[0]) for body, at in found if len(at))
    return _point(body, row), int(column)


def _hold_still(
    scene: Scene, places: Sequence[Places], v: NDArray[np.float64], still: slice
) -> None:
    """Set the velocity of held coordinates to zero, which it must be but for rounding."""
    held = v[still]
    moving = np.flatnonzero(np.abs(held) > ROUNDING * speeds(scene, places, v)[still])
    if len(moving):
        point, column = _found(scene, places, still.start + int(moving[0]))
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
    shortest = min(beam.shortest for beam in scene.bodies)
    out = np.full(len(v), max(turning, straight / shortest))
    for where in places:
        out[where[:, : scene.dim]] = max(straight, turning * shortest)
    return out


def _largest(values: NDArray[np.float64]) -> float:
    return float(np.nanmax(np.abs(values), initial=0.0))


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

    Slopes move with the derivative of the velocity field along their vector.  Where it is no
    `RigidMotion`, that is a central difference of fourth order over a thousandth of an element:
    exact for rigid motions, and to twelve digits of the velocity per element for fields that the
    mesh can follow.
    """
    field = body.velocity
    nodes, dim = body.row_nodes, body.dim
    v = np.zeros((len(nodes), n_coordinates))
    if field is None:
        return v
    places = body.positions[nodes]
    v[:, :dim] = field(body.positions)[nodes]
    if isinstance(field, RigidMotion):
        turned = field.turned(np.broadcast_to(body.vectors, (len(nodes), *body.vectors.shape[1:])))
        width = min(turned.shape[1] * dim, n_coordinates - dim)
        v[:, dim : dim + width] = turned.reshape(len(nodes), -1)[:, :width]
        return v
    reach = 5e-4 * body.shortest
    for k in range(body.vectors.shape[1]):
        columns = slice(dim * (k + 1), dim * (k + 2))
        if columns.stop > n_coordinates:
            break
        step = reach * body.vectors[:, k]
        near = field(places + step) - field(places - step)
        far = field(places + 2.0 * step) - field(places - 2.0 * step)
        v[:, columns] = (8.0 * near - far) / (12.0 * reach)
    return v
