"""Strains and curvatures of the axis, forces and moments in sections."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.checks import check_reals
from ancfsparse.errors import InputError
from ancfsparse.kernels.fields import Points, axes, spread
from ancfsparse.kernels.fields import curvature as turn_of
from ancfsparse.messages import format_value
from ancfsparse.results.data.interpolation import Array
from ancfsparse.results.data.stored_tables import Readable
from ancfsparse.results.fields.energy_balance import BLOCK
from ancfsparse.scene import ElasticBody, Mesh, Point
from ancfsparse.scene.bodies.beam import NODE_SNAP
from ancfsparse.system.recovery.element_end_forces import end_forces
from ancfsparse.system.system import System
from ancfsparse.system_memory import check_memory

# Numbers that an evaluation keeps at a time for each coordinate of an element.
WORK = 32

Where = ArrayLike | Sequence[Point] | None


@dataclass(frozen=True, eq=False)
class SectionForce:
    """What the part of a beam beyond a section, at larger s, puts on the part before it.

    Shapes: k saved states (an `Equilibrium` has no such axis), p points.

    Attributes
    ----------
    N : ndarray, shape (k, p)
        Axial force, positive in tension [N].
    Q : ndarray, shape (k, p) or (k, p, 2) or (k, p, 3)
        Shear force [N]: in the plane along the normal, 90 degrees to the left of the axis; of a
        thick beam in space along e_y and e_z of the section, which all edges of a line of a mesh
        have from the first of them; of a cable in space, which has no such
        axes, as a vector in space at right angles to the axis.
    M : ndarray, of the shape of `Q`
        Bending moment [N m]: in the plane counterclockwise; of a thick beam in space about e_y and
        e_z; of a cable in space as a vector in space.
    T : ndarray, shape (k, p), or None
        Torsion [N m]; None where the element has none: in the plane and in cables.
    force : ndarray, shape (k, p, dim)
        All of the force, in space [N].
    moment : ndarray, shape (k, p) in the plane or (k, p, 3)
        All of the moment, in space [N m].

    Notes
    -----
    The axis of a cable is its slope; that of a thick beam is normal to its section.

    Forces and moments are those that elements put on their nodes, damping included, and inside an
    element what balances them.  So they balance reactions and loads at nodes to the accuracy of the
    solution, on every mesh.  Loads along an element and its inertia act on its nodes too: with w of
    them per length and elements of length h, a force is off by up to w h / 2, but in the middle of
    an element not at all if w is uniform; a moment by up to w h^2 / 12, at the Gauss points,
    (1 -+ 1 / sqrt(3)) h / 2 from the first end of an element, by h^3 in cables.
    """

    N: Array
    Q: Array
    M: Array
    T: Array | None
    force: Array
    moment: Array

    def at(self, state: int) -> SectionForce:
        """Give those of one saved state, without the axis of states."""
        torsion = None if self.T is None else self.T[state]
        parts = self.N[state], self.Q[state], self.M[state], torsion
        return SectionForce(*parts, self.force[state], self.moment[state])


def section_force(
    system: System,
    q: Readable,
    v: Readable,
    t: Readable,
    body: ElasticBody,
    s: Where = None,
) -> SectionForce:
    """Evaluate forces and moments in sections.

    Parameters
    ----------
    system : System
        The system the states belong to.
    q, v : table, shape (k, n)
        Coordinates and their rates, which are read where the body is damped.
    t : table, shape (k,)
        Times, which are read where the shape of the body without stress changes [s].
    body : Beam or Mesh
        One of its bodies.
    s : float, array_like of shape (p,), or sequence of Point, optional
        Where, see `Trajectory.strain`.

    Returns
    -------
    SectionForce
        For every state and point.
    """
    body, where = _where(system, body, s)
    kind = system.kind_of(body)
    elements, first, at = np.unique(where.elements, return_index=True, return_inverse=True)

    def evaluate(points: Points, rates: Array, rows: slice) -> tuple[Array, Array, Array]:
        ends, times = points.ends, np.asarray(t[rows])
        each = end_forces(body, kind, elements, ends[:, first], rates[:, first], times)[:, at]
        force = spread(kind, each, "r")[:, :, 1]
        moment = np.cross(spread(kind, ends, "r")[:, :, 1] - points.r, force)
        for name in kind.vectors[1:]:
            turned = np.cross(spread(kind, ends, name), spread(kind, each, name))
            moment += turned[:, :, 1]
        return force, moment, axes(points)

    force, moment, frames = _evaluated(system, body, where, q, v, evaluate)
    inside = np.einsum("kpij,kpj->kpi", frames, force), np.einsum("kpij,kpj->kpi", frames, moment)
    normal, torsion = inside[0][..., 0], None
    # Along an edge that was turned round, the other part is the one beyond.
    turn = where.direction[:, None]
    force, moment = turn * force[..., : kind.dim], turn * moment
    if kind.dim == 2:
        moment = moment[..., 2]
        shear, bending = inside[0][..., 1], moment
    elif kind.is_cable:
        shear = turn * (force * turn - normal[..., None] * frames[:, :, 0])
        bending = moment
    else:
        shear, bending, torsion = inside[0][..., 1:], inside[1][..., 1:], inside[1][..., 0]
    return SectionForce(normal, shear, bending, torsion, force, moment)


def axial_forces(system: System, q: Array, v: Array, t: Array) -> list[Array]:
    """Return the axial force in the middle of every element of every body, each (k, n_e) [N]."""
    beams = (body for body in system.bodies if isinstance(body, ElasticBody))
    return [section_force(system, q, v, t, body).N for body in beams]


def strain(system: System, q: Readable, body: ElasticBody, s: Where = None) -> Array:
    """Evaluate the stretch of the axis beyond 1; parameters as in `section_force`.

    Returns
    -------
    ndarray, shape (k, p)
        Elongation per length without stress, |r'| - 1 [-]; where that shape is curved, less the
        value in it, which is not exactly zero inside elements.
    """

    def evaluate(points: Points, rates: Array, rows: slice) -> tuple[Array]:
        return (np.linalg.norm(points.r_x, axis=-1) - 1.0,)

    body, where = _where(system, body, s)
    values = _evaluated(system, body, where, q, q, evaluate)[0]
    if body.kind.is_curved:
        rest = system.q_ref[None]
        values = values - _evaluated(system, body, where, rest, rest, evaluate)[0]
    return values


def curvature(system: System, q: Readable, body: ElasticBody, s: Where = None) -> Array:
    """Evaluate how sections turn along the axis; parameters as in `section_force`.

    Returns
    -------
    ndarray, shape (k, p) in the plane or (k, p, 3)
        Turn per length of the reference shape [1/m], see `Trajectory.curvature`.
    """
    body, where = _where(system, body, s)
    turns = _evaluated(system, body, where, q, q, lambda points, *_: (turn_of(points),))[0]
    turns = where.direction[:, None] * turns
    return turns[..., 2] if body.dim == 2 else turns


@dataclass(frozen=True)
class _Where:
    """Points on a body: elements, places in them, and whether s runs along the element or back."""

    elements: NDArray[np.intp]
    xi: Array
    direction: Array


def _where(system: System, body: ElasticBody, s: Where) -> tuple[ElasticBody, _Where]:
    """Return the body of the run, and the points on it."""
    if not isinstance(body, ElasticBody):
        raise InputError(f"a beam or a mesh of the run is needed, got {format_value(body)}")
    listed: Any = [s] if isinstance(s, Point) else s
    if isinstance(listed, Sequence) and any(isinstance(each, Point) for each in listed):
        listed = [system.own(each) if isinstance(each, Point) else each for each in listed]
    own: Any = system.own(body)
    if not own.n_elements:
        raise InputError(
            f"{body.name} is a rigid rod in this run, which has no strains and no forces in "
            "sections: ask for them in the plan, or give the beam an element"
        )
    return own, _points_on(own, listed)


def _points_on(body: ElasticBody, listed: Where) -> _Where:
    forward = np.ones(body.n_elements)
    if isinstance(body, Mesh):
        forward[body.flipped] = -1.0
    if listed is None:
        elements = np.arange(body.n_elements)
        return _Where(elements, np.full(len(elements), 0.5), forward)
    if isinstance(listed, Sequence) and any(isinstance(each, Point) for each in listed):
        places = [_of_point(body, each) for each in listed]
        elements = np.array([e for e, _ in places], dtype=np.intp)
        return _Where(elements, np.array([xi for _, xi in places]), forward[elements])
    if isinstance(body, Mesh):
        raise InputError(
            f"s on {body.name} must be points on its edges, such as [mesh.at(edge, s)], or left "
            f"out for the middle of every edge, got {format_value(listed)}"
        )
    return _along(body, listed, forward)


def _of_point(body: ElasticBody, point: object) -> tuple[int, float]:
    """Return element and place of a point; at a node of a beam, those of the element beyond."""
    if not isinstance(point, Point) or point.beam is not body:
        raise InputError(f"s must be points of {body.name}, got {format_value(point)}")
    if point.xi:
        return point.index, point.xi
    if isinstance(body, Mesh):
        raise InputError(
            f"{point!r} is the end of edges whose forces differ: take a point inside an edge, "
            f"such as mesh.at(edge, 1e-6 * length)"
        )
    last = point.index == body.n_elements
    return point.index - last, float(last)


def _along(beam: ElasticBody, s: object, forward: Array) -> _Where:
    """Find the elements at arc coordinates."""
    arcs = np.atleast_1d(check_reals(f"s on {beam.name}", s, "arc coordinates in m"))
    if arcs.ndim != 1 or not len(arcs):
        raise InputError(
            f"s on {beam.name} must be a list of one or more arc coordinates, got {format_value(s)}"
        )
    nodes = np.concatenate([[0.0], np.cumsum(beam.lengths)])
    slack = NODE_SNAP * beam.lengths.min()
    outside = ~((arcs >= -slack) & (arcs <= nodes[-1] + slack))
    if outside.any():
        raise InputError(
            f"s = {arcs[outside][0]:.6g} m lies outside {beam.name}: it runs from 0 to "
            f"{nodes[-1]:.6g} m"
        )
    elements = np.searchsorted(nodes[1:-1], arcs + slack, side="right")
    xi = np.clip((arcs - nodes[elements]) / beam.lengths[elements], 0.0, 1.0)
    return _Where(elements, xi, forward[elements])


def _evaluated(
    system: System,
    body: ElasticBody,
    where: _Where,
    q: Readable,
    v: Readable,
    evaluate: Callable[[Points, Array, slice], tuple[Array, ...]],
) -> list[Array]:
    """Evaluate what depends on elements, some states at a time, and join the states."""
    kind, states = system.kind_of(body), q.shape[0]
    places = system.elements(body)[where.elements]
    check_memory(
        "values at so many points",
        8.0 * states * len(places) * 24,
        "fewer points, or a run with a larger save_every",
    )
    step = max(1, BLOCK // max(1, WORK * places.size))
    lengths = body.lengths[where.elements]
    parts = []
    for i in range(0, states, step):
        rows = slice(i, i + step)
        points = Points(kind, np.asarray(q[rows, places]), where.xi, lengths)
        rates = np.asarray(v[rows, places]) if body.strains_damped else np.zeros_like(points.ends)
        parts.append(evaluate(points, rates, rows))
    return [np.concatenate(each) for each in zip(*parts, strict=True)]
