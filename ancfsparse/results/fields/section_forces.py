"""Strain and curvature of the axis, section forces and moments."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_reals
from ancfsparse.errors import InputError
from ancfsparse.kernels.fields import Points, axes, curvature as element_curvature, spread
from ancfsparse.messages import format_value
from ancfsparse.results.data.selected_columns import Readable
from ancfsparse.results.fields.energy_balance import BLOCK_SIZE
from ancfsparse.scene import ElasticBody, Point
from ancfsparse.scene.bodies.beam import NODE_TOLERANCE
from ancfsparse.system.recovery.element_end_forces import element_end_forces
from ancfsparse.system.system import System
from ancfsparse.system_memory import check_memory

WORK_ENTRIES = 32  # temporary numbers for each coordinate of an element

SectionPoints = ArrayLike | Sequence[Point] | None


@dataclass(frozen=True, eq=False)
class SectionForce:
    """Force and moment of the part of a beam at larger s on the part before the section.

    Shapes: k saved states (an `Equilibrium` has no such axis), p points.

    Attributes
    ----------
    N : ndarray, shape (k, p)
        Axial force, positive in tension [N].
    Q : ndarray, shape (k, p) or (k, p, 2) or (k, p, 3)
        Shear force [N]: in the plane along the normal, 90 degrees to the left of the axis; of a
        thick beam in space along e_y and e_z of the section (of the first edge, along a line of a
        mesh); of a cable in space, which has no section axes, as a vector normal to the axis.
    M : ndarray, of the shape of `Q`
        Bending moment [N m]: in the plane counterclockwise; of a thick beam in space about e_y and
        e_z; of a cable in space as a vector in space.
    T : ndarray, shape (k, p), or None
        Torsion [N m]; None where the element has none: in the plane and in cables.
    force : ndarray, shape (k, p, dim)
        Total force, in space [N].
    moment : ndarray, shape (k, p) in the plane or (k, p, 3)
        Total moment, in space [N m].

    Notes
    -----
    The axis of a cable is its slope; that of a thick beam is normal to its section.

    Forces and moments are the nodal forces of the elements, including damping, and inside an
    element those in equilibrium with them.  They balance reactions and nodal loads to the accuracy
    of the solution on every mesh.  Distributed loads and inertia act on the nodes too: for a load w
    per length and elements of length h, the error of a force is at most w h / 2, and zero in the
    middle of an element for uniform w; the error of a moment is at most w h^2 / 12, and of order
    h^3 in cables at the Gauss points, (1 -+ 1 / sqrt(3)) h / 2 from the first end of an element.
    """

    N: Vector
    Q: Vector
    M: Vector
    T: Vector | None
    force: Vector
    moment: Vector

    def at(self, state: int) -> SectionForce:
        """Return section forces of one saved state, without the axis of states."""
        torsion = None if self.T is None else self.T[state]
        parts = self.N[state], self.Q[state], self.M[state], torsion
        return SectionForce(*parts, self.force[state], self.moment[state])


def section_force(
    system: System,
    q: Readable,
    v: Readable,
    t: Readable,
    body: ElasticBody,
    s: SectionPoints = None,
) -> SectionForce:
    """Evaluate section forces and moments for every state and point; see `Trajectory.strain`.

    Coordinates q and velocities v are tables (k, n); the latter are read if the body is damped, and
    times t (k,) [s] if its stress-free shape changes.
    """
    body, where = locate_points(system, body, s)
    kind = system.kind_of(body)
    elements, first, at = np.unique(where.elements, return_index=True, return_inverse=True)

    def evaluate(points: Points, rates: Vector, rows: slice) -> tuple[Vector, Vector, Vector]:
        ends, times = points.ends, np.asarray(t[rows])
        each = element_end_forces(body, kind, elements, ends[:, first], rates[:, first], times)[
            :, at
        ]
        force = spread(kind, each, "r")[:, :, 1]
        moment = np.cross(spread(kind, ends, "r")[:, :, 1] - points.r, force)
        for name in kind.vectors[1:]:
            moments = np.cross(spread(kind, ends, name), spread(kind, each, name))
            moment += moments[:, :, 1]
        return force, moment, axes(points)

    force, moment, frames = _evaluate(system, body, where, q, v, evaluate)
    inside = np.einsum("kpij,kpj->kpi", frames, force), np.einsum("kpij,kpj->kpi", frames, moment)
    normal, torsion = inside[0][..., 0], None
    # Along a reversed edge the roles of both parts are exchanged.
    sign = where.direction[:, None]
    force, moment = sign * force[..., : kind.dim], sign * moment
    if kind.dim == 2:
        moment = moment[..., 2]
        shear, bending = inside[0][..., 1], moment
    elif kind.is_cable:
        shear = sign * (force * sign - normal[..., None] * frames[:, :, 0])
        bending = moment
    else:
        shear, bending, torsion = inside[0][..., 1:], inside[1][..., 1:], inside[1][..., 0]
    return SectionForce(normal, shear, bending, torsion, force, moment)


def axial_forces(system: System, q: Vector, v: Vector, t: Vector) -> list[Vector]:
    """Return the axial force in the middle of every element of every body, each (k, n_e) [N]."""
    beams = (body for body in system.bodies if isinstance(body, ElasticBody))
    return [section_force(system, q, v, t, body).N for body in beams]


def strain(system: System, q: Readable, body: ElasticBody, s: SectionPoints = None) -> Vector:
    """Evaluate the strain of the axis; parameters as in `section_force`.

    Returns
    -------
    ndarray, shape (k, p)
        Elongation per stress-free length, |r'| - 1 [-]; for curved beams relative to the
        stress-free shape, in which |r'| is not exactly 1 inside elements.
    """

    def evaluate(points: Points, rates: Vector, rows: slice) -> tuple[Vector]:
        return (np.linalg.norm(points.r_x, axis=-1) - 1.0,)

    body, where = locate_points(system, body, s)
    values = _evaluate(system, body, where, q, q, evaluate)[0]
    if body.kind.is_curved:
        rest = system.q_ref[None]
        values = values - _evaluate(system, body, where, rest, rest, evaluate)[0]
    return values


def curvature(system: System, q: Readable, body: ElasticBody, s: SectionPoints = None) -> Vector:
    """Evaluate the rotation of sections along the axis; parameters as in `section_force`.

    Returns
    -------
    ndarray, shape (k, p) in the plane or (k, p, 3)
        Rotation per length of the reference shape [1/m], see `Trajectory.curvature`.
    """
    body, where = locate_points(system, body, s)
    curvatures = _evaluate(
        system, body, where, q, q, lambda points, *_: (element_curvature(points),)
    )[0]
    curvatures = where.direction[:, None] * curvatures
    return curvatures[..., 2] if body.dim == 2 else curvatures


@dataclass(frozen=True)
class _ElementPoints:
    """Points on a body: elements, relative positions, and 1 or -1 for the direction of s."""

    elements: NDArray[np.intp]
    xi: Vector
    direction: Vector


def locate_points(
    system: System, body: ElasticBody, s: SectionPoints
) -> tuple[ElasticBody, _ElementPoints]:
    """Return a body of the run, and points on it."""
    if not isinstance(body, ElasticBody):
        raise InputError(f"a beam or a mesh of the run is needed, got {format_value(body)}")
    listed: Any = [s] if isinstance(s, Point) else s
    if isinstance(listed, Sequence) and any(isinstance(each, Point) for each in listed):
        listed = [system.resolve(each) if isinstance(each, Point) else each for each in listed]
    own: Any = system.resolve(body)
    if not own.n_elements:
        raise InputError(
            f"{body.name} is a rigid rod in this run, which has no strains and no section "
            "forces: request them in the plan, or give the beam an element"
        )
    return own, _points_on(own, listed)


def _points_on(body: ElasticBody, listed: SectionPoints) -> _ElementPoints:
    forward = body.directions
    if listed is None:
        elements = np.arange(body.n_elements)
        return _ElementPoints(elements, np.full(len(elements), 0.5), forward)
    if isinstance(listed, Sequence) and any(isinstance(each, Point) for each in listed):
        places = [_locate_point(body, each) for each in listed]
        elements = np.array([e for e, _ in places], dtype=np.intp)
        return _ElementPoints(elements, np.array([xi for _, xi in places]), forward[elements])
    if body.branches:
        raise InputError(
            f"s on {body.name} must be points on its edges, such as [mesh.at(edge, s)], or left "
            f"out for the middle of every edge, got {format_value(listed)}"
        )
    return _locate_arcs(body, listed, forward)


def _locate_point(body: ElasticBody, point: object) -> tuple[int, float]:
    """Return element and relative position of a point; at a node the element beyond it."""
    if not isinstance(point, Point) or point.beam is not body:
        raise InputError(f"s must be points of {body.name}, got {format_value(point)}")
    if point.xi:
        return point.index, point.xi
    if body.branches:
        raise InputError(
            f"{point!r} is the end of edges whose forces differ: take a point inside an edge, "
            f"such as mesh.at(edge, 1e-6 * length)"
        )
    last = point.index == body.n_elements
    return point.index - last, float(last)


def _locate_arcs(beam: ElasticBody, s: object, forward: Vector) -> _ElementPoints:
    """Return the elements at arc coordinates."""
    arcs = np.atleast_1d(check_reals(f"s on {beam.name}", s, "arc coordinates in m"))
    if arcs.ndim != 1 or not len(arcs):
        raise InputError(
            f"s on {beam.name} must be a list of one or more arc coordinates, got {format_value(s)}"
        )
    nodes = np.concatenate([[0.0], np.cumsum(beam.lengths)])
    slack = NODE_TOLERANCE * beam.lengths.min()
    outside = ~((arcs >= -slack) & (arcs <= nodes[-1] + slack))
    if outside.any():
        raise InputError(
            f"s = {arcs[outside][0]:.6g} m lies outside {beam.name}: it runs from 0 to "
            f"{nodes[-1]:.6g} m"
        )
    elements = np.searchsorted(nodes[1:-1], arcs + slack, side="right")
    xi = np.clip((arcs - nodes[elements]) / beam.lengths[elements], 0.0, 1.0)
    return _ElementPoints(elements, xi, forward[elements])


def _evaluate(
    system: System,
    body: ElasticBody,
    where: _ElementPoints,
    q: Readable,
    v: Readable,
    evaluate: Callable[[Points, Vector, slice], tuple[Vector, ...]],
) -> list[Vector]:
    """Evaluate a function of elements in blocks of states, and join the states."""
    kind, states = system.kind_of(body), q.shape[0]
    places = system.elements(body)[where.elements]
    check_memory(
        "values at these points",
        8.0 * states * len(places) * 24,
        "fewer points, or a run with a larger save_every",
    )
    step = max(1, BLOCK_SIZE // max(1, WORK_ENTRIES * places.size))
    lengths = body.lengths[where.elements]
    parts = []
    for i in range(0, states, step):
        rows = slice(i, i + step)
        points = Points(kind, np.asarray(q[rows, places]), where.xi, lengths)
        rates = np.asarray(v[rows, places]) if body.strains_damped else np.zeros_like(points.ends)
        parts.append(evaluate(points, rates, rows))
    return [np.concatenate(each) for each in zip(*parts, strict=True)]
