"""Numbering of the coordinates in q: free ones first, then fixed, then prescribed ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Integers
from ancfsparse.errors import InputError
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.scene import Body, Point, Scene
from ancfsparse.scene.kinematics.rigid_motion import RigidMotion
from ancfsparse.system.coordinates.constraint_terms import Constraints
from ancfsparse.system.coordinates.joint_lowering import Lowering
from ancfsparse.system.coordinates.prescribed_motion import PrescribedMotions
from ancfsparse.system.coordinates.state import ROUNDING, State, transfer_state

AXES = ("r_x", "r_y", "r_z")
"""Vectors of a row, in the order of `Body.vectors`."""


@dataclass(frozen=True)
class Numbering:
    """Indices of the coordinates, constraints, and initial state of a scene.

    Attributes
    ----------
    n_free, n_all : int
        Numbers of free and of all coordinates.
    places : list of (n_rows, n_c) int32 arrays
        Indices of the coordinates of each row, per body (see `scene.bodies.body`; a row of a beam
        is a node): position first, then the slope r_x.
    constraints : Constraints
        Equations of the joints that numbering cannot represent.
    prescribed : Prescribed
        Prescribed motions of the last coordinates and the last equations.
    q_ref : (n_all,) float
        Stress-free coordinates [m, 1].
    q, v : (n_all,) float
        Initial coordinates [m, 1] and velocities [m/s, 1/s].
    """

    n_free: int
    n_all: int
    places: list[Integers]
    constraints: Constraints
    prescribed: PrescribedMotions
    q_ref: NDArray[np.float64]
    q: NDArray[np.float64]
    v: NDArray[np.float64]


def number_coordinates(
    scene: Scene, kinds: Sequence[ElementKind], start: State | None = None
) -> Numbering:
    """Assign indices to the coordinates of a scene.

    Joints are lowered to fixed or shared coordinates, and to equations otherwise.

    Parameters
    ----------
    scene : Scene
        The beams and joints.
    kinds : sequence of ElementKind
        Element type of each body.
    start : State, optional
        Initial state; by default the reference shape with the initial velocities of the bodies.

    Raises
    ------
    InputError
        If an initial velocity moves a constrained point, or the state is of another scene.
    """
    lowered = Lowering(scene, kinds)
    owner = lowered.owner()
    if lowered.on_lines and lowered.repeats(owner, _raw_reference(scene, lowered)):
        lowered = Lowering(scene, kinds, lines=False)
        owner = lowered.owner()
    fixed, driven = lowered.held(owner), lowered.driven(owner)
    if lowered.turned and _has_conflict(owner, fixed, driven):
        lowered = Lowering(scene, kinds, turns=False, lines=lowered.lines)
        owner = lowered.owner()
        fixed, driven = lowered.held(owner), lowered.driven(owner)
    final, n_free, n_all = _assign_indices(owner, fixed, driven)
    first_driven = n_all - len(driven)
    constraints = lowered.constraints(final, range(n_free, n_all))
    places, raw = [], lowered.raw
    while raw:  # one by one, so that only one table exists twice
        places.append(final[raw.pop(0)])
    del final, owner, fixed
    q_ref, v = np.empty(n_all), np.zeros(n_all)
    for beam, where in zip(scene.bodies, places, strict=True):
        q_ref[where] = reference_coordinates(beam)
    q = q_ref
    if start is not None:
        q, v = transfer_state(scene, start, places, q_ref)
        _fix_positions(scene, places, q, q_ref, slice(n_free, first_driven))
        _fix_velocities(scene, places, v, slice(n_free, first_driven))
    elif any(beam.velocity is not None for beam in scene.bodies):
        velocities = [initial_velocities(beam) for beam in scene.bodies]
        for where, values in zip(places, velocities, strict=True):
            v[where] = values
        scales = velocity_scales(scene, places, v)
        v[:] = np.nan  # not yet set
        for beam, where, values in zip(scene.bodies, places, velocities, strict=True):
            _set_velocities(beam, where, values, v, scales)
        _fix_velocities(scene, places, v, slice(n_free, first_driven))
    prescribed = PrescribedMotions(lowered.courses, lowered.rheonomic)
    return Numbering(n_free, n_all, places, constraints, prescribed, q_ref, q, v)


def _raw_reference(scene: Scene, lowered: Lowering) -> NDArray[np.float64]:
    q = np.empty(lowered.n_raw)
    for body, raw in zip(scene.bodies, lowered.raw, strict=True):
        q[raw] = reference_coordinates(body)
    return q


def _has_conflict(owner: Integers | None, held: NDArray[np.bool_], driven: Integers) -> bool:
    """Return True if joints fix or prescribe a coordinate twice, or leave none free."""
    free = ~held
    free[driven] = False
    if owner is not None:
        free &= owner == np.arange(len(owner), dtype=np.int32)
    return bool(held[driven].any()) or len(np.unique(driven)) < len(driven) or not free.any()


def _assign_indices(
    owner: Integers | None, held: NDArray[np.bool_], driven: Integers
) -> tuple[Integers, int, int]:
    """Return the index of every raw coordinate, and the numbers of free and of all indices.

    Free coordinates come first, then fixed, then prescribed ones.
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


def _set_velocities(
    beam: Body,
    where: Integers,
    values: NDArray[np.float64],
    v: NDArray[np.float64],
    scales: NDArray[np.float64],
) -> None:
    """Set the velocities of a beam, and refuse those that contradict a connected beam."""
    undefined = np.count_nonzero(~np.isfinite(values))
    if undefined:
        raise InputError(
            f"the initial velocity of {beam.name} is not a number for {undefined} of {values.size} "
            "coordinates: give a field that is also defined next to the beam, because slopes move "
            "with its derivative"
        )
    r = beam.kind.columns("r")  # only positions are shared; NaN: not yet set
    before, now = v[where][:, r], values[:, r]
    conflicts = np.argwhere(np.abs(before - now) > ROUNDING * scales[where][:, r])
    if len(conflicts):
        row, column = conflicts[0]
        n = len(conflicts)
        more = f" ({n} coordinates in total)" if n > 1 else ""
        raise InputError(
            f"{_point(beam, row)} is connected to a beam with another initial velocity, "
            f"{now[row, column]:.6g} m/s against {before[row, column]:.6g} m/s along "
            f"{'xyz'[column]}{more}: give connected beams equal velocities at their connections "
            "(none: at rest)"
        )
    v[where] = values


def _point(body: Body, row: int) -> Point:
    return Point(body, int(body.row_nodes[row]))


def _fix_positions(
    scene: Scene,
    places: Sequence[Integers],
    q: NDArray[np.float64],
    q_ref: NDArray[np.float64],
    fixed: slice,
) -> None:
    """Set fixed coordinates to their reference values, after a check up to rounding errors."""
    distance = np.abs(q[fixed] - q_ref[fixed])
    if len(distance) and np.max(distance) > ROUNDING * np.max(np.abs(q)):
        point, is_place = _locate(scene, places, fixed.start + int(np.argmax(distance)))
        what, unit = ("position", " m") if is_place else ("slope", "")
        raise InputError(
            f"start has the {what} of {point!r} {np.max(distance):.3g}{unit} from where a joint of "
            "this scene holds it: leave out the joint, or start from a state that it allows"
        )
    q[fixed] = q_ref[fixed]


def _locate(scene: Scene, places: Sequence[Integers], place: int) -> tuple[Point, bool]:
    """Return a node that has a coordinate, and whether that is one of its position."""
    found = ((b, np.argwhere(w == place)) for b, w in zip(scene.bodies, places, strict=True))
    body, (row, column) = next((body, at[0]) for body, at in found if len(at))
    return _point(body, row), body.kind.vector_of(column) == "r"


def _fix_velocities(
    scene: Scene, places: Sequence[Integers], v: NDArray[np.float64], still: slice
) -> None:
    """Set the velocity of fixed coordinates to zero, after a check up to rounding errors."""
    held = v[still]
    moving = np.flatnonzero(np.abs(held) > ROUNDING * velocity_scales(scene, places, v)[still])
    if len(moving):
        point, is_place = _locate(scene, places, still.start + int(moving[0]))
        what, unit = ("position", "m/s") if is_place else ("slope", "1/s")
        raise InputError(
            f"the initial velocity moves {len(moving)} held coordinate"
            f"{'s, the first' if len(moving) > 1 else ','} of the {what} of {point} by "
            f"{held[moving[0]]:.6g} {unit}: give a velocity that the joints allow there"
        )
    held[:] = 0.0


def velocity_scales(
    scene: Scene, places: Sequence[Integers], v: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the velocity scale of each coordinate, (n_all,) [m/s, 1/s], for rounding errors.

    For positions it is the largest nodal velocity, or the product of the largest rate of a slope
    and the shortest element, because points between fixed nodes can move; for slopes the largest
    rate, or the largest velocity over the length of the shortest element.
    """
    slopes = np.ones(len(v), dtype=bool)
    for body, where in zip(scene.bodies, places, strict=True):
        slopes[where[:, body.kind.columns("r")]] = False
    position_rate, slope_rate = _largest(v[~slopes]), _largest(v[slopes])
    shortest = min(body.shortest for body in scene.bodies)
    out = np.full(len(v), max(slope_rate, position_rate / shortest))
    out[~slopes] = max(position_rate, slope_rate * shortest)
    return out


def _largest(values: NDArray[np.float64]) -> float:
    return float(np.nanmax(np.abs(values), initial=0.0))


def reference_coordinates(body: Body) -> NDArray[np.float64]:
    """Return the stress-free coordinates of all rows, (n_rows, n_c) [m, 1]."""
    nodes, kind = body.row_nodes, body.kind
    q = np.empty((len(nodes), len(kind.node_coordinates)))
    q[:, kind.columns("r")] = (
        body.positions if len(nodes) == body.n_nodes else body.positions[nodes]
    )
    for name in kind.vectors[1:]:
        k = AXES.index(name)
        # A planar beam also has the stretch of its section along z.
        q[:, kind.columns(name)] = body.vectors[:, k] if k < body.vectors.shape[1] else 1.0
    return q


def initial_velocities(body: Body) -> NDArray[np.float64]:
    """Return initial velocities of all rows, (n_rows, n_c) [m/s, 1/s].

    Rates of slopes are derivatives of the velocity field along their vector.  For fields other than
    a `RigidMotion` they are central differences of fourth order over a thousandth of an element:
    exact for rigid motions, and accurate to twelve digits for fields that the mesh can resolve.
    """
    field = body.velocity
    nodes, kind = body.row_nodes, body.kind
    v = np.zeros((len(nodes), len(kind.node_coordinates)))
    if field is None:
        return v
    places = body.positions[nodes]
    v[:, kind.columns("r")] = field(body.positions)[nodes]
    rates = (
        field.rates(np.broadcast_to(body.vectors, (len(nodes), *body.vectors.shape[1:])))
        if isinstance(field, RigidMotion)
        else None
    )
    reach = 5e-4 * body.shortest
    for k, name in enumerate(AXES[: body.vectors.shape[1]]):
        if name not in kind.vectors:
            continue
        if rates is not None:
            v[:, kind.columns(name)] = rates[:, k]
            continue
        step = reach * body.vectors[:, k]
        near = field(places + step) - field(places - step)
        far = field(places + 2.0 * step) - field(places - 2.0 * step)
        v[:, kind.columns(name)] = (8.0 * near - far) / (12.0 * reach)
    return v
