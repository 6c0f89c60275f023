"""Scenes in space that move in a plane, as planar scenes: fewer coordinates, the same motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, LoadError
from ancfsparse.plans.models.plane import ROUNDING, LeavesPlaneError, Plane, Projected, plane_of
from ancfsparse.scene import Scene
from ancfsparse.scene.bodies.beam import Beam, BeamSpec
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.joints.connect import ConnectSpec
from ancfsparse.scene.joints.pin import PinSpec
from ancfsparse.scene.records.record import Record
from ancfsparse.scene.records.signal import ScaledSignal, Signal, Sum
from ancfsparse.scene.records.signals import Table
from ancfsparse.scene.sections.cross_section import principal_axes
from ancfsparse.scene.sections.standard_sections import Circle, Rectangle, Section
from ancfsparse.scene.sections.taper import AnySection, Taper

Vector = NDArray[np.float64]

# Arguments of calls that are positions, vectors, and normals of the plane.
POSITIONS = {("rod", "anchor"), ("drive", "position"), ("spring", "b")}
VECTORS = {
    ("point_force", "value"),
    ("distributed_force", "value"),
    ("changing_gravity", "value"),
}
NORMALS = {("point_moment", "value"), ("revolute", "axis")}
# Calls whose arguments are the same in the plane.
PLAIN = {"distance", "connect", "pin", "clamp"}


@dataclass(frozen=True, eq=False)
class InPlane:
    """A scene in space as a planar one, and how the two correspond.

    Attributes
    ----------
    scene : Scene
        The planar scene; its beams and meshes have the same names.
    plane : Plane
        Where it lies in space: the planar position x is ``plane.place(x)``, a planar vector v is
        ``plane.lift(v)``.
    """

    scene: Scene
    plane: Plane

    def counterpart(self, handle: Any) -> Any:
        """Return the handle in the planar scene for a beam, a mesh or a point of the other."""
        return self.scene.counterpart(handle)


def planar(scene: Scene) -> InPlane | None:
    """Rebuild a scene that moves in a plane as a planar scene.

    The plane may be any in space.  Geometry, gravity, loads, what joints hold, and initial
    velocities must lie in it to rounding (1e-13 of their size); the motion is then the same.

    Parameters
    ----------
    scene : Scene
        A scene in space.

    Returns
    -------
    InPlane or None
        None if the scene is planar already, if anything leaves the plane, or if it has what is not
        looked at: rigid bodies, joints but `pin`, `clamp`, `connect`, `revolute`, `rod`, `distance`
        and `drive`, forces that are functions of the motion, loads that follow, thick beams whose
        sections are not along the plane, point masses with inertias, and elements of your own.

    Notes
    -----
    Functions of time are projected into the plane: a run in which one leaves it fails.  The motion
    in space stays in the plane as far as the plane is stable there, which statics and modes tell:
    a beam that buckles sideways leaves it after any disturbance.
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
    return InPlane(flat, plane)


def _handles(scene: Scene) -> list[Any]:
    """Return all handles in the order of the calls that made them."""
    every = [*scene.bodies, *scene.joints, *scene.loads, *scene.attachments]
    number = {id(record): k for k, record in enumerate(scene.records)}
    return sorted(every, key=lambda handle: number[id(scene.record_of(handle))])


def _plane(scene: Scene) -> Plane:
    """Find the plane that positions, constant vectors and the numbers of signals lie in."""
    points, vectors = [], [np.zeros((0, 3))]
    for body in scene.bodies:
        points.append(body.positions)
        if body.velocity is not None:
            vectors.append(body.velocity(body.positions))
    for record in scene.records:
        for name, value in record.given.items():
            if (record.method, name) in VECTORS:
                vectors += _numbers(value)
            elif (record.method, name) in NORMALS:
                # A normal fixes the plane as two vectors at right angles to it do.
                vectors += [_two_across(each) for each in _numbers(value)]
            elif (record.method, name) in POSITIONS and not callable(value) and value is not None:
                points += [np.atleast_2d(value)] if np.ndim(value) else []
    if not points:
        raise LeavesPlaneError
    return plane_of(np.concatenate(points), np.concatenate(vectors), scene.gravity)


def _numbers(value: Any) -> list[Vector]:
    """Return the vectors that a value or a signal is made of, each (k, 3)."""
    if isinstance(value, Sum):
        parts = [each for part in value.parts for each in _numbers(part)]
        return [*parts, *_numbers(value.constant)]
    if isinstance(value, Table):
        return _numbers(value.values)
    if isinstance(value, ScaledSignal):
        return _numbers(value.largest)
    if value is None or callable(value) or isinstance(value, Signal):
        return []
    found = np.atleast_2d(np.asarray(value, dtype=float))
    return [found] if found.shape[1] == 3 else []


def _two_across(normals: Vector) -> Vector:
    """Return two vectors at right angles to each normal."""
    found = [np.zeros((0, 3))]
    for normal in normals:
        if normal.any():
            least = np.eye(3)[np.argmin(np.abs(normal))]
            one = np.cross(normal, least)
            found += [one[None], np.cross(normal, one)[None]]
    return np.concatenate(found)


def _record(scene: Scene, handle: Any, plane: Plane) -> Record:
    """Return the record of a handle for the planar scene."""
    record = scene.record_of(handle)
    if record.method in PLAIN:
        return record
    if record.method not in RECORDS:
        raise LeavesPlaneError
    return RECORDS[record.method](record, handle, plane)


def _beam(record: Any, beam: Beam, plane: Plane) -> Record:
    """Return the record of a beam, straight, along points, slack or taut."""
    curved = record.curve is not None and not isinstance(record.curve, np.ndarray | tuple)
    strained = record.eigenstrain is not None or record.eigencurvature is not None
    if curved or strained or record.twist is not None or callable(record.up):
        raise LeavesPlaneError
    if not isinstance(beam.section, Taper) and principal_axes(beam.section)[0]:
        raise LeavesPlaneError
    turned = beam.kind.section[1:] and not _aligned(beam, plane)
    return cast(
        BeamSpec,
        replace(
            record,
            **_elastic(record, beam, plane),
            start=None if record.start is None else _data(plane.put(record.start)),
            end=None if record.end is None else _data(plane.put(record.end)),
            curve=None if record.curve is None else plane.put(record.curve),
            section=_turned(beam.section) if turned else beam.section,
            up=None,
        ),
    )


def _aligned(beam: Beam, plane: Plane) -> bool:
    """Whether e_z of a thick beam is along the normal; if not, e_y must be."""
    for axis in (2, 1):
        try:
            plane.across(beam.frames[:, axis])
        except LeavesPlaneError:
            continue
        return axis == 2
    raise LeavesPlaneError


def _turned(section: AnySection) -> AnySection:
    """Return a section turned by a right angle about its axis."""
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
    """Return what beams and meshes have in common; check where they lie."""
    if not isinstance(record.element, str):
        raise LeavesPlaneError
    plane.put(body.positions)
    velocity = record.velocity
    if callable(velocity):
        here = plane.into(velocity(body.positions.copy()))
        if body.kind.section[1:]:  # the velocity beside the plane moves its sections
            beside = velocity(body.positions + body.shortest * plane.normal)
            if np.abs(plane.into(beside) - here).max() > ROUNDING * np.abs(here).max():
                raise LeavesPlaneError
        return {"velocity": Projected(velocity, plane, "into", lifted=True)}
    return {"velocity": None if velocity is None else _data(plane.into(velocity))}


def _data(vector: Vector) -> tuple[float, ...]:
    return tuple(vector.tolist())


def _load(record: Any, load: Any, plane: Plane) -> Record:
    """Return the record of a force, or of gravity that changes."""
    if record.given.get("follow"):
        raise LeavesPlaneError
    return cast(Record, replace(record, value=plane.project(record.value, "into")))


def _moment(record: Any, load: Any, plane: Plane) -> Record:
    """Return the record of a moment, which must be about the normal."""
    if record.follow:
        raise LeavesPlaneError
    return cast(Record, replace(record, value=plane.project(record.value, "across")))


def _revolute(record: Any, joint: Any, plane: Plane) -> Record:
    """Return a hinge about the normal as what the plane has: a shared or a held position."""
    plane.across(record.axis)
    return PinSpec(record.a) if record.b is None else ConnectSpec(record.a, record.b)


def _rod(record: Any, joint: Any, plane: Plane) -> Record:
    """Return the record of a rod to a point in space."""
    return cast(Record, replace(record, anchor=_data(plane.put(record.anchor))))


def _drive(record: Any, joint: Any, plane: Plane) -> Record:
    """Return the record of a driven node; its rates are functions if there are any."""
    rates = {
        name: None if value is None else plane.project(value, "into")
        for name, value in (("rate", record.rate), ("second_rate", record.second_rate))
    }
    return cast(Record, replace(record, position=plane.project(record.position, "put"), **rates))


def _spring(record: Any, spring: Any, plane: Plane) -> Record:
    """Return the record of a spring between points, or to one in space."""
    if isinstance(record.b, tuple):
        return cast(Record, replace(record, b=_data(plane.put(record.b))))
    return cast(Record, record)


def _mass(record: Any, mass: Any, plane: Plane) -> Record:
    """Return the record of a point mass without inertia."""
    if record.inertia is not None:
        raise LeavesPlaneError
    return cast(Record, record)


RECORDS: dict[str, Callable[[Any, Any, Plane], Record]] = {
    "add_beam": _beam,
    "add_mesh": _mesh,
    "point_force": _load,
    "distributed_force": _load,
    "changing_gravity": _load,
    "point_moment": _moment,
    "revolute": _revolute,
    "rod": _rod,
    "drive": _drive,
    "spring": _spring,
    "add_mass": _mass,
}
