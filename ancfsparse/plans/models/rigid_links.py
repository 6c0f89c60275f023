"""Rigid rods in place of straight beams, with the same mass and inertia."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.scene import Beam, Scene
from ancfsparse.scene.bodies.beam import BeamSpec
from ancfsparse.scene.bodies.rigid_shapes import Rod
from ancfsparse.scene.force_elements.masses import PointMass
from ancfsparse.scene.geometry.section_frames import section_axes
from ancfsparse.scene.loads.loads import PointMoment
from ancfsparse.scene.methods.add_rigid_bodies import BodySpec
from ancfsparse.scene.records.record import BodyRef, PointRef, Record

# Arguments of beams that are not straight and stress-free.
CURVED = "curve", "length", "tension", "slack", "twist", "eigenstrain", "eigencurvature", "nodes"
ROUNDING = 1e-9  # of strains, rotations [rad], and rates of strain over the largest velocity


def references(records: Iterable[Record]) -> list[BodyRef]:
    """Return all references of records to bodies and their points."""
    out: list[BodyRef] = []

    def note(reference: BodyRef) -> BodyRef:
        out.append(reference)
        return reference

    for record in records:
        record.moved(note)
    return out


def rigid_rod(beam: Beam) -> Record:
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
        relative = speeds[2] - speeds[0]
        bent = speeds[1] - 0.5 * (speeds[0] + speeds[2])
        if max(np.linalg.norm(bent), abs(relative @ along)) > ROUNDING * np.abs(speeds).max():
            raise InputError(f"the initial velocities of {beam.name} bend or stretch it")
        velocity = tuple(speeds[0].tolist())
        angular = _angular_velocity(along, relative / beam.length)
    record: Record = BodySpec(
        shape=Rod(beam.length),
        position=tuple(ends[0].tolist()),
        mass=mass,
        orientation=_orientation(along, beam.name),
        velocity=velocity,
        angular_velocity=angular,
        name=beam.name,
    )
    return record


def _angular_velocity(along: Vector, relative: Vector) -> float | tuple[float, ...]:
    """Return the angular velocity of a rod, from the velocity difference over its length."""
    if len(along) == 2:
        return float(along[0] * relative[1] - along[1] * relative[0])
    return tuple(np.cross(along, relative).tolist())


def _orientation(along: Vector, name: str) -> float | Vector:
    """Return the orientation of a body with its x axis along a unit vector."""
    if len(along) == 2:
        return float(np.arctan2(along[1], along[0]))
    return np.asarray(section_axes(along, None, name).T)


def rigid_candidates(scene: Scene) -> list[str]:
    """Return the automatic beams that may be rods: straight, hinged and loaded at the ends only.

    A weld or another joint of directions transmits bending moments of other bodies.  A specified
    mesh is kept, and a rod has none.
    """
    beams = {
        beam.name: beam
        for beam in scene.beams
        if isinstance(beam, Beam) and {"element", "n_elements"} <= set(beam.automatic)
    }
    excluded: set[str] = set()
    others = []
    for record in scene.records:
        if not (isinstance(record, BeamSpec) and record.name in beams):
            others.append(record)
        elif any(record.given[name] is not None for name in CURVED):
            excluded.add(record.name)
    for each in references(others):
        if beam := beams.get(each.body):
            ends = 0, beam.n_elements
            if not (isinstance(each, PointRef) and each.xi == 0.0 and each.index in ends):
                excluded.add(each.body)
    bending = (joint.nodes for joint in scene.joints if joint.constrains_directions)
    excluded |= {node.beam.name for nodes in bending for node in nodes}
    excluded |= {load.node.beam.name for load in scene.loads if isinstance(load, PointMoment)}
    masses = (each for each in scene.attachments if isinstance(each, PointMass))
    excluded |= {mass.node.beam.name for mass in masses if np.any(mass.inertia)}
    return [name for name in beams if name not in excluded]
