"""Reduction of scenes in space that move in a plane to planar scenes with fewer coordinates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError, LoadError
from ancfsparse.plans.models.plane import (
    ROUNDING,
    LeavesPlaneError,
    PlanarFunction,
    Plane,
    find_plane,
)
from ancfsparse.scene import Scene
from ancfsparse.scene.bodies.beam import Beam, BeamSpec
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.joints.connect import ConnectSpec
from ancfsparse.scene.joints.pin import PinSpec
from ancfsparse.scene.records.record import BodyRef, Record
from ancfsparse.scene.records.signal import ScaledSignal, Signal, Sum
from ancfsparse.scene.records.signals import Table
from ancfsparse.scene.sections.cross_section import AnySection, principal_axes
from ancfsparse.scene.sections.standard_sections import Circle, Rectangle, Section
from ancfsparse.scene.sections.taper import Taper

# Arguments of methods of Scene, as `Plane.project` takes them: positions, vectors, and normals.
PROJECTIONS = {
    ("rod", "anchor"): "put",
    ("drive", "position"): "put",
    ("spring", "b"): "put",
    ("drive", "rate"): "into",
    ("drive", "second_rate"): "into",
    ("point_force", "value"): "into",
    ("distributed_force", "value"): "into",
    ("changing_gravity", "value"): "into",
    ("point_moment", "value"): "across",
    ("revolute", "axis"): "across",
}
# Methods with no other arguments that depend on the plane.
PROJECTED = {method for method, _ in PROJECTIONS} | {
    "distance",
    "connect",
    "pin",
    "clamp",
    "add_mass",
}
SPATIAL_ARGUMENTS = {"follow", "inertia"}  # for which loads and masses have no planar form


@dataclass(frozen=True, eq=False)
class PlanarScene:
    """Planar form of a scene in space.

    Attributes
    ----------
    scene : Scene
        The planar scene; its beams and meshes have the same names.
    plane : Plane
        Its plane: the planar position x is ``plane.place(x)`` in space, a planar vector v is
        ``plane.lift(v)``.
    """

    scene: Scene
    plane: Plane

    def counterpart(self, handle: Any) -> Any:
        """Return the handle in the planar scene of a beam, a mesh or a point in space."""
        return self.scene.counterpart(handle)


def reduce_to_plane(scene: Scene) -> PlanarScene | None:
    """Rebuild a scene in space that moves in a plane as a planar scene.

    The plane is arbitrary.  Geometry, gravity, loads, joints and initial velocities must lie in it
    to rounding (1e-13 of their size); the motion is then the same.

    Returns
    -------
    PlanarScene or None
        None if the scene is planar already, if anything leaves the plane, or if it has a part
        without a planar form here: rigid bodies, joints other than `pin`, `clamp`, `connect`,
        `revolute`, `rod`, `distance` and `drive`, forces that are functions of the motion, follower
        loads, thick beams with sections not aligned with the plane, point masses with inertias, and
        elements built outside the package.

    Notes
    -----
    Functions of time are projected into the plane; a run in which one leaves it fails.  The motion
    in space stays in the plane if it is stable there: a beam that buckles sideways leaves the plane
    after any disturbance.
    """
    if scene.dim != 3:
        return None
    try:
        plane = _plane(scene)
        records = [_record(scene, handle, plane) for handle in _handles(scene)]
        flat = Scene(gravity=plane.into(scene.gravity))
        for record in records:
            record.build(flat)
    except (LeavesPlaneError, InputError, LoadError):
        return None
    return PlanarScene(flat, plane)


def _handles(scene: Scene) -> list[Any]:
    """Return all handles in the order of their creation."""
    every = [*scene.bodies, *scene.joints, *scene.loads, *scene.attachments]
    number = {id(record): k for k, record in enumerate(scene.records)}
    return sorted(every, key=lambda handle: number[id(scene.record_of(handle))])


def _plane(scene: Scene) -> Plane:
    """Return the plane of positions, constant vectors and coefficients of signals."""
    points, vectors = [], [np.zeros((0, 3))]
    for body in scene.bodies:
        points.append(body.positions)
        if body.velocity is not None:
            vectors.append(body.velocity(body.positions))
    for record in scene.records:
        for name, value in record.given.items():
            how = PROJECTIONS.get((record.method, name))
            if how == "into" and record.method != "drive":  # whose positions give the rates
                vectors += _coefficients(value)
            elif how == "across":
                # A normal determines the plane by two vectors perpendicular to it.
                vectors += [_perpendicular_pair(each) for each in _coefficients(value)]
            elif how == "put" and not callable(value) and value is not None:
                points += [np.atleast_2d(value)] if np.ndim(value) else []
    if not points:
        raise LeavesPlaneError
    return find_plane(np.concatenate(points), np.concatenate(vectors), scene.gravity)


def _coefficients(value: Any) -> list[Vector]:
    """Return the vectors in a value or a signal, each (k, 3)."""
    if isinstance(value, Sum):
        parts = [each for part in value.parts for each in _coefficients(part)]
        return [*parts, *_coefficients(value.constant)]
    if isinstance(value, Table):
        return _coefficients(value.values)
    if isinstance(value, ScaledSignal):
        return _coefficients(value.largest)
    if value is None or callable(value) or isinstance(value, Signal):
        return []
    vectors = np.atleast_2d(np.asarray(value, dtype=float))
    return [vectors] if vectors.shape[1] == 3 else []


def _perpendicular_pair(normals: Vector) -> Vector:
    """Return two vectors perpendicular to each normal."""
    pairs = [np.zeros((0, 3))]
    for normal in normals:
        if normal.any():
            least = np.eye(3)[np.argmin(np.abs(normal))]
            one = np.cross(normal, least)
            pairs += [one[None], np.cross(normal, one)[None]]
    return np.concatenate(pairs)


def _record(scene: Scene, handle: Any, plane: Plane) -> Record:
    """Return the record of a handle for the planar scene."""
    record = scene.record_of(handle)
    if record.method in RECORDS:
        return RECORDS[record.method](record, handle, plane)
    if record.method not in PROJECTED:
        raise LeavesPlaneError
    given = record.given
    if any(given.get(name) not in (None, False) for name in SPATIAL_ARGUMENTS):
        raise LeavesPlaneError
    changes = {}
    for name, value in given.items():
        how = PROJECTIONS.get((record.method, name))
        if how and value is not None and not isinstance(value, BodyRef):
            changes[name] = plane.project(value, how)
    return cast(Record, replace(cast(Any, record), **changes))


def _beam(record: Any, beam: Beam, plane: Plane) -> Record:
    """Return the record of a straight beam, or of one through points."""
    curved = record.curve is not None and not isinstance(record.curve, np.ndarray | tuple)
    strained = record.eigenstrain is not None or record.eigencurvature is not None
    if curved or strained or record.twist is not None or callable(record.up):
        raise LeavesPlaneError
    if not isinstance(beam.section, Taper) and principal_axes(beam.section)[0]:
        raise LeavesPlaneError
    rotated = beam.kind.section[1:] and not _has_normal_as_z(beam, plane)
    return cast(
        BeamSpec,
        replace(
            record,
            **_elastic(record, beam, plane),
            start=None if record.start is None else _data(plane.put(record.start)),
            end=None if record.end is None else _data(plane.put(record.end)),
            curve=None if record.curve is None else plane.put(record.curve),
            section=_rotate_section(beam.section) if rotated else beam.section,
            up=None,
        ),
    )


def _has_normal_as_z(beam: Beam, plane: Plane) -> bool:
    """Return True if e_z of the sections is along the normal, False if e_y is."""
    for axis in (2, 1):
        try:
            plane.across(beam.frames[:, axis])
        except LeavesPlaneError:
            continue
        return axis == 2
    raise LeavesPlaneError


def _rotate_section(section: AnySection) -> AnySection:
    """Return a section rotated by a right angle about the axis."""
    if isinstance(section, Circle):
        return section
    if isinstance(section, Rectangle):
        return Rectangle(width=section.height, height=section.width)
    if isinstance(section, Section):
        return replace(section, inertia_y=section.inertia_z, inertia_z=section.inertia_y)
    raise LeavesPlaneError


def _mesh(record: Any, mesh: ElasticBody, plane: Plane) -> Record:
    """Return the record of a mesh of strings or cables."""
    if mesh.kind.section[1:]:
        raise LeavesPlaneError
    given = _elastic(record, mesh, plane)
    return cast(Record, replace(record, **given, nodes=plane.put(record.nodes)))


def _elastic(record: Any, body: ElasticBody, plane: Plane) -> dict[str, Any]:
    """Return the common arguments of beams and meshes; check that they lie in the plane."""
    if not isinstance(record.element, str):
        raise LeavesPlaneError
    plane.put(body.positions)
    velocity = record.velocity
    if callable(velocity):
        here = plane.into(velocity(body.positions.copy()))
        if body.kind.section[1:]:  # sections extend out of the plane
            off_plane = velocity(body.positions + body.shortest * plane.normal)
            if np.abs(plane.into(off_plane) - here).max() > ROUNDING * np.abs(here).max():
                raise LeavesPlaneError
        return {"velocity": PlanarFunction(velocity, plane, "into", lifted=True)}
    return {"velocity": None if velocity is None else _data(plane.into(velocity))}


def _data(vector: Vector) -> tuple[float, ...]:
    return tuple(vector.tolist())


def _revolute(record: Any, joint: Any, plane: Plane) -> Record:
    """Return the record of a hinge about the normal: a shared or a fixed position."""
    plane.across(record.axis)
    return PinSpec(record.a) if record.b is None else ConnectSpec(record.a, record.b)


RECORDS: dict[str, Callable[[Any, Any, Plane], Record]] = {
    "add_beam": _beam,
    "add_mesh": _mesh,
    "revolute": _revolute,
}
