"""Straight beams as rigid rods: which may be, and the rod with the same mass and inertia."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.scene import Beam, Scene
from ancfsparse.scene.bodies.beam import BeamSpec
from ancfsparse.scene.bodies.rigid_shapes import Rod
from ancfsparse.scene.force_elements.masses import PointMass
from ancfsparse.scene.geometry.section_frames import section_axes
from ancfsparse.scene.joints.connect import Connect
from ancfsparse.scene.joints.distance import Distance, RigidRod
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.joints.pin import Pin
from ancfsparse.scene.joints.prescribed_point import PrescribedPoint
from ancfsparse.scene.loads.loads import PointMoment
from ancfsparse.scene.mechanisms.winch import Winch
from ancfsparse.scene.methods.add_rigid_bodies import BodySpec
from ancfsparse.scene.records.record import BodyRef, PointRef

Vector = NDArray[np.float64]

# What a straight beam without stress is given by; anything else is left to elements.
CURVED = "curve", "length", "tension", "slack", "twist", "eigenstrain", "eigencurvature", "nodes"
# Joints that hold points and leave directions free: they bend no rod between its ends.
HINGES: tuple[type[Joint], ...] = (Pin, Connect, PrescribedPoint, Distance, RigidRod, Winch)
# Share by which a velocity may stretch a rod: rounding.
ROUNDING = 1e-9


def rod_of(beam: Beam) -> BodySpec:
    """Return the record of a rigid rod in place of a beam.

    Raises
    ------
    InputError
        If the initial velocities of the beam bend or stretch it.
    """
    ends = beam.positions[[0, -1]]
    along = (ends[1] - ends[0]) / beam.length
    mass = float(np.mean(beam.stiffnesses()["mass_per_length"])) * beam.length
    velocity = angular = None
    if beam.velocity is not None:
        points = np.array([ends[0], ends.mean(axis=0), ends[1]])
        speeds = np.asarray(beam.velocity(points))
        apart = speeds[2] - speeds[0]
        bent = speeds[1] - 0.5 * (speeds[0] + speeds[2])
        if max(np.linalg.norm(bent), abs(apart @ along)) > ROUNDING * np.abs(speeds).max():
            raise InputError(f"the initial velocities of {beam.name} bend or stretch it")
        velocity = tuple(speeds[0].tolist())
        angular = _spin(along, apart / beam.length)
    return BodySpec(
        shape=Rod(beam.length),
        position=tuple(ends[0].tolist()),
        mass=mass,
        orientation=_turned(along, beam.name),
        velocity=velocity,
        angular_velocity=angular,
        name=beam.name,
    )


def _spin(along: Vector, apart: Vector) -> float | tuple[float, ...]:
    """Return the angular velocity across a rod whose ends move apart by so much of its length."""
    if len(along) == 2:
        return float(along[0] * apart[1] - along[1] * apart[0])
    return tuple(np.cross(along, apart).tolist())


def _turned(along: Vector, name: str) -> float | Vector:
    """Return the orientation of a body whose x axis is along a unit vector."""
    if len(along) == 2:
        return float(np.arctan2(along[1], along[0]))
    return np.asarray(section_axes(along, None, name).T)


def possible(scene: Scene) -> list[str]:
    """Return the open beams that may be rods: straight, held and loaded as points at their ends.

    What a weld or another joint of directions passes on bends a beam by forces of others.  A mesh
    that was given stays, and a rod has none.
    """
    found = {
        beam.name: beam
        for beam in scene.beams
        if isinstance(beam, Beam) and {"element", "n_elements"} <= set(beam.automatic)
    }
    out: set[str] = set()

    def note(reference: BodyRef) -> BodyRef:
        whole = not isinstance(reference, PointRef) and reference.body in found
        if whole or (isinstance(reference, PointRef) and reference.body in found and _inside(
                found[reference.body], reference)):  # fmt: skip
            out.add(reference.body)
        return reference

    for record in scene.records:
        if isinstance(record, BeamSpec) and record.name in found:
            if any(record.given[name] is not None for name in CURVED):
                out.add(record.name)
        else:
            record.moved(note)
    bending = (joint.nodes for joint in scene.joints if not isinstance(joint, HINGES))
    out |= {node.beam.name for nodes in bending for node in nodes}
    out |= {load.node.beam.name for load in scene.loads if isinstance(load, PointMoment)}
    turned = (thing for thing in scene.attachments if isinstance(thing, PointMass))
    out |= {thing.node.beam.name for thing in turned if np.any(thing.inertia)}
    return [name for name in found if name not in out]


def _inside(beam: Beam, point: PointRef) -> bool:
    """Whether a point is no end of a beam."""
    return point.xi != 0.0 or point.index not in (0, beam.n_elements)
