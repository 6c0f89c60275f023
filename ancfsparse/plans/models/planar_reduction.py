"""Reduction of scenes in space that move in a plane to planar scenes with fewer coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError, LoadError
from ancfsparse.scene import Scene
from ancfsparse.scene.records.plane import LeavesPlaneError, Plane, find_plane
from ancfsparse.scene.records.signal import Signal, Sum


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
        whose record has no planar form (`Record.project`), such as a rigid body, a follower load, a
        thick beam with sections not aligned with the plane, or a user-defined element.

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
        every = (*scene.bodies, *scene.joints, *scene.loads, *scene.attachments)
        handles = {id(scene.record_of(handle)): handle for handle in every}
        records = [record.project(handles[id(record)], plane) for record in scene.records]
        flat = Scene(gravity=plane.into(scene.gravity))
        for record in records:
            record.build(flat)
    except (LeavesPlaneError, InputError, LoadError):
        return None
    return PlanarScene(flat, plane)


def _plane(scene: Scene) -> Plane:
    """Return the plane of positions, constant vectors and coefficients of signals."""
    points, vectors = [], [np.zeros((0, 3))]
    for body in scene.bodies:
        points.append(body.positions)
        if body.velocity is not None:
            vectors.append(body.velocity(body.positions))
    for record in scene.records:
        for name, form in (record.planar or {}).items():
            value = getattr(record, name)
            if form == "into":
                vectors += _coefficients(value)
            elif form == "across":
                # A normal determines the plane by two vectors perpendicular to it.
                vectors += [_perpendicular_pair(each) for each in _coefficients(value)]
            elif form == "put" and not callable(value) and np.ndim(value):
                points.append(np.atleast_2d(value))
    if not points:
        raise LeavesPlaneError
    return find_plane(np.concatenate(points), np.concatenate(vectors), scene.gravity)


def _coefficients(value: Any) -> list[Vector]:
    """Return the vectors in a value or a signal, each (k, 3)."""
    if isinstance(value, Sum):
        parts = [each for part in value.parts for each in _coefficients(part)]
        return [*parts, *_coefficients(value.constant)]
    if isinstance(value, Signal):
        return _coefficients(getattr(value, value.coefficient)) if value.coefficient else []
    if value is None or callable(value):
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
