"""Force and moment of a joint from its multipliers, or from the residual without it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ancfsparse.array_types import Integers, Vector
from ancfsparse.errors import SingularSceneError
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.scene import Point, Scene
from ancfsparse.scene.geometry.section_frames import normals
from ancfsparse.scene.joints.frame_vectors import direction
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.kinematics.joint_coordinates import JointCoordinate
from ancfsparse.scene.kinematics.linear_forms import LINEAR, RheonomicTerm
from ancfsparse.scene.kinematics.sliding_curve import CurveOffset
from ancfsparse.scene.records.prescribed_motion import PrescribedMotion
from ancfsparse.system.coordinates.coordinates import foreign_handle
from ancfsparse.system.coordinates.joint_lowering import Lowering
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.system import System


@dataclass
class JointRecorder:
    """The `Builder` that records the lowering of one joint.

    Attributes
    ----------
    lowering : Lowering
        The lowering of all joints, with the coordinates.
    equations : list of (terms, about, measures)
        Its equations, with raw indices of `lowering`.
    numbers : bool
        True if it fixes, prescribes or shares coordinates.
    held : list of (k,) int
        Coordinates that it fixes or prescribes.
    shares : bool
        True if it shares coordinates.
    turns, lines : bool
        Allow prescribed angles and sliding joints by numbering.
    """

    lowering: Lowering
    turns: bool = True
    lines: bool = True
    equations: list[tuple[Any, Any, Any]] = field(default_factory=list)
    numbers: bool = False
    held: list[Integers] = field(default_factory=list)
    shares: bool = False

    def kind(self, node: Point) -> ElementKind:
        """Return the element at a node."""
        return self.lowering.kind(node)

    def rows(self, node: Point) -> Integers:
        """Return the coordinates of all rows of a node."""
        return self.lowering.rows(node)

    def position(self, node: Point) -> Integers:
        """Return the coordinates of the position of a node."""
        return self.lowering.position(node)

    def ends(self, node: Point) -> Integers:
        """Return the coordinates of all rows that a point depends on."""
        return self.lowering.ends(node)

    def point(self, node: Point) -> tuple[Integers, Vector]:
        """Return coordinates and weights of a point."""
        return self.lowering.point(node)

    def fix(self, coordinates: Integers) -> None:
        """Record fixed coordinates."""
        self.numbers = True
        self.held.append(coordinates.ravel())

    def hold(self, coordinates: Integers) -> None:
        """Record fixed coordinates."""
        self.fix(coordinates)

    def drive(self, coordinates: Integers, course: PrescribedMotion) -> None:
        """Record prescribed coordinates."""
        self.numbers = True
        self.held.append(coordinates.ravel())

    def share(self, one: Integers, other: Integers) -> None:
        """Record shared coordinates."""
        self.numbers = self.shares = True

    def equation(
        self,
        label: str,
        offset: float,
        *terms: tuple[float, int, int],
        about: Sequence[float] = (),
        size: float = 0.0,
        rheonomic: RheonomicTerm | None = None,
        mass: float = 0.0,
        measures: Sequence[tuple[float, JointCoordinate | CurveOffset]] = (),
    ) -> None:
        """Record an equation."""
        self.equations.append((list(terms), list(about) or [0.0] * len(terms), measures))


def joint_force(
    system: System, joint: Joint, states: StateHistory
) -> tuple[Vector, Vector, Vector]:
    """Return force and moment of a joint on its first side, and its axes.

    Parameters
    ----------
    system : System
        The system.
    joint : Joint
        A joint of its scene.
    states : StateHistory
        States of the system.

    Returns
    -------
    force : (k, dim) float
        Force [N].
    moment : (k,) or (k, 3) float
        Moment about the point of the first side [N m], a scalar in the plane.
    axes : (k, dim, dim) float
        Axes of the joint as rows, which rotate with its second side; NaN if that has none.

    Raises
    ------
    InputError
        If it does not belong to the scene.
    SingularSceneError
        If other joints fix the same coordinates, so that their forces cannot be separated.
    """
    if not any(joint is each for each in system.joints):
        raise foreign_handle("the joint", "joints[0]")
    lowering = Lowering(_scene_with(system, system.joints), system.kinds)
    by_numbers = not system.rows_of(joint)
    record = JointRecorder(lowering, turns=by_numbers, lines=by_numbers)
    joint.lower(record)
    q = _raw_coordinates(lowering, system, states.q)
    a, _b = joint.sides
    if not record.numbers:
        forces = _forces_from_multipliers(record, q, states.lam[:, system.rows_of(joint)])
        wrench = _resultant(a, q, forces, lowering)
    else:
        wrench = _forces_from_residual(system, joint, record, q, states)
    return *wrench, _axes(lowering, joint, q)


def _raw_coordinates(lowering: Lowering, system: System, q: Vector) -> Vector:
    """Return coordinates by the raw indices of a lowering."""
    out = np.empty((len(q), lowering.n_raw))
    for raw, places in zip(lowering.raw, system.places, strict=True):
        out[:, raw] = q[:, places]
    return out


def _forces_from_multipliers(record: JointRecorder, q: Vector, lam: Vector) -> Vector:
    """Return ``-phi_q^T lam`` of the equations of a joint, (k, n_raw)."""
    out = np.zeros_like(q)
    for (terms, about, measures), multiplier in zip(record.equations, lam.T, strict=True):
        for (c, i, j), origin in zip(terms, about, strict=True):
            if j == LINEAR:
                out[:, i] -= c * multiplier
            else:
                out[:, i] -= c * (q[:, j] - origin) * multiplier
                out[:, j] -= c * (q[:, i] - origin) * multiplier
        for factor, measure in measures:
            measure.push(out, q, -factor * multiplier)
    return out


def _forces_from_residual(
    system: System, joint: Joint, record: JointRecorder, q: Vector, states: StateHistory
) -> tuple[Vector, Vector]:
    """Return the resultant of the residual of one side without the joint."""
    cut, lowering = _system_without(system, joint), record.lowering
    a, b = joint.sides
    if b is None and not record.shares and not record.equations:
        # It fixes single coordinates to the ground, and its forces act only on these.
        fixed, free = np.concatenate(record.held), np.empty(lowering.n_raw, dtype=bool)
        for raw, places in zip(lowering.raw, cut.places, strict=True):
            free[raw] = places < cut.n_free
        if free[fixed].all():
            forces = np.zeros_like(q)
            forces[:, fixed] = _raw_coordinates(
                lowering, cut, _missing_forces(system, cut, states)
            )[:, fixed]
            return _resultant(a, q, forces, lowering)
    side = next((n for n in (a, b) if n and np.all(cut.rows(n) < cut.n_free)), None)
    if side is None:
        raise SingularSceneError(
            f"the force of the {joint.label} is not determined: other joints also fix its "
            "coordinates; join one of its points elsewhere than at the origin of a "
            "body, or make a pin by as_constraint=True"
        )
    forces = _raw_coordinates(lowering, cut, _missing_forces(system, cut, states))
    force, moment = _resultant(side, q, forces, lowering)
    if side is a:
        return force, moment
    arm = _position(lowering, side, q) - _position(lowering, a, q)
    return -force, -(moment + _cross(arm, force))


def _system_without(system: System, joint: Joint) -> System:
    """Return the system without one joint."""
    scene = _scene_with(system, [each for each in system.joints if each is not joint])
    return type(system)(scene, system.state(system.t0, system.q0, system.v0))


def _scene_with(system: System, joints: Sequence[Joint]) -> Scene:
    """Return the scene at construction of the system, with some of its joints."""
    scene: Scene = object.__new__(type(system.scene))
    then = {"bodies": list(system.bodies), "joints": list(joints)}
    scene.__dict__.update(system.scene.__dict__ | then)
    return scene


def _missing_forces(system: System, cut: System, states: StateHistory) -> Vector:
    """Return the residual of states of a system without a joint, (k, n_all of `cut`)."""
    q, v, a = (np.zeros((len(states.t), cut.n_all)) for _ in range(3))
    for there, here in zip(system.places, cut.places, strict=True):
        for new, old in ((q, states.q), (v, states.v), (a, states.a)):
            new[:, here] = old[:, there]
    number = {source: k for k, source in enumerate(system.constraints.source)}
    lam = np.zeros((len(states.t), cut.n_multipliers))
    for k, source in enumerate(cut.constraints.source):
        if source in number:  # others keep bodies with shared vectors rigid: internal forces
            lam[:, k] = states.lam[:, number[source]]
    amplitudes, out = cut.loads.amplitudes(states.t), np.empty_like(q)
    for k in range(len(out)):
        cut.set_history(states.internal[k])
        rest = cut.assembly.residual(q[k], v[k], a[k], lam[k], cut.dead_load, amplitudes[k])
        out[k] = rest[0]
    return out


def _resultant(node: Point, q: Vector, forces: Vector, lowering: Lowering) -> tuple[Vector, Vector]:
    """Return the resultant force and moment of generalized forces about a point."""
    kind, rows = lowering.kind(node), lowering.ends(node)
    where = _position(lowering, node, q)
    # The rows of one node share its position.
    positions = np.unique(rows[:, kind.columns("r")], axis=0)
    force = np.sum([forces[:, each] for each in positions], axis=0)
    moment = np.sum([_cross(q[:, each] - where, forces[:, each]) for each in positions], axis=0)
    for row in rows:
        for name in kind.vectors[1:]:
            places = row[kind.columns(name)]
            if len(places) == node.beam.dim:  # not the stretch of a planar section
                moment = moment + _cross(q[:, places], forces[:, places])
    return force, moment


def _position(lowering: Lowering, node: Point, q: Vector) -> Vector:
    places, weights = lowering.point(node)
    return np.asarray(q[:, places] @ weights)


def _cross(one: Vector, other: Vector) -> Vector:
    """Return cross products (k, 3), in the plane their normal component (k,)."""
    if one.shape[1] == 2:
        return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    return np.cross(one, other)


def _axes(lowering: Lowering, joint: Joint, q: Vector) -> Vector:
    """Return the axes of a joint, (k, dim, dim); NaN if there are none."""
    dim = joint.nodes[0].beam.dim
    first = np.eye(dim)[0] if joint.axis is None else joint.axis
    rest = np.array([first, *normals(first)])
    b = joint.sides[1]
    if b is None:
        return np.broadcast_to(rest, (len(q), dim, dim))
    if not all(b.spans(each) for each in rest):
        return np.full((len(q), dim, dim), np.nan)
    out = np.empty((len(q), dim, dim))
    for k, each in enumerate(rest):
        found = direction(lowering, b, each)
        for d, terms in enumerate(found.terms):
            out[:, k, d] = found.constant[d] + sum(w * q[:, i] for i, w in terms.items())
    return np.asarray(out / np.linalg.norm(out, axis=2, keepdims=True))
