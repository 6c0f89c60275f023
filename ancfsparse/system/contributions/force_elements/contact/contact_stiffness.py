"""Stiffness of contacts that are given none, from data of the scene."""

from __future__ import annotations

import numpy as np

from ancfsparse.errors import InputError
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.force_elements.contacts import Contact
from ancfsparse.scene.force_elements.masses import PointMass
from ancfsparse.scene.loads.loads import DistributedForce, PointForce
from ancfsparse.scene.records.signal import Signal
from ancfsparse.scene.records.time_dependent import TimeDependentValue
from ancfsparse.system.contributions.force_elements.penetrations import (
    IMPACT_RATIO,
    REST_RATIO,
)
from ancfsparse.system.coordinates.discretization import Discretization

LOAD_FACTOR = 2.0  # largest pressure over its mean: 1.25 to 1.5 along a wire around a drum


def default_stiffness(system: Discretization, contact: Contact, number: int) -> float:
    """Return a stiffness for a body of a contact by known loads, tensions and speeds [N/m2].

    A line of the weight w per length sinks in by w/k at rest, one under the tension T around a
    round obstacle of radius R by T/(R k), and one of the mass mu per length that arrives with the
    speed v by v sqrt(mu/k).  One with the curvature kappa at the start and the bending stiffness EI
    springs back at a speed of about kappa sqrt(EI/mu).

    Raises
    ------
    InputError
        If there are neither loads, tensions nor speeds.
    """
    body, obstacle, radius = contact.bodies[number], contact.obstacle, contact.radii[number]
    gravity = float(np.linalg.norm(system.scene.gravity))
    stiffnesses = body.stiffnesses()
    mass = float(np.max(stiffnesses["mass_per_length"]))
    pressure = mass * gravity + sum(
        _bound(load) for load in system.external_loads if isinstance(load, DistributedForce)
    )
    if not obstacle.is_flat:
        pressure += _tension(system, body) / (obstacle.bend_radius + radius)
    gaps = obstacle.distances(body.positions) - radius
    squared_speed = 2.0 * gravity * float(np.max(gaps, initial=0.0))
    if body.velocity is not None:
        squared_speed += float(np.max(np.sum(body.velocity(body.positions) ** 2, axis=1)))
    squared_speed += _bending_stiffness(body) * _bent_curvature(body) ** 2 / mass
    stiffness = max(
        LOAD_FACTOR * pressure / (REST_RATIO * radius),
        mass * squared_speed / (IMPACT_RATIO * radius) ** 2,
    )
    if stiffness == 0.0:
        raise InputError(
            f"the stiffness of {contact.name_with((body,))} is needed: neither weight nor a known "
            "force, tension or speed presses them together. Give contact the stiffness= in N/m2"
        )
    return stiffness


def _bending_stiffness(body: ElasticBody) -> float:
    stiffnesses = body.stiffnesses()
    return max(stiffnesses[name] for name in stiffnesses if name.startswith("bending_stiffness"))


def _bent_curvature(body: ElasticBody) -> float:
    """Return the largest curvature by which straight elements are bent at the start [1/m]."""
    if body.kind.is_curved or body.kind.is_string:
        return 0.0
    ends = body.positions[body.row_nodes[body.ends]]
    chords = (ends[:, 1] - ends[:, 0]) / body.lengths[:, None]
    bends = body.ends[1:, 0] == body.ends[:-1, 1]  # elsewhere are hinges
    turns = np.linalg.norm(np.diff(chords, axis=0), axis=1)[bends]
    return float(np.max(2.0 * turns / (body.lengths[1:] + body.lengths[:-1])[bends], initial=0.0))


def _tension(system: Discretization, body: ElasticBody) -> float:
    """Return the tension of the body at the start plus all known point forces and weights [N]."""
    ends = body.positions[body.row_nodes[body.ends]]
    stretch = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / body.lengths - 1.0
    tension = body.stiffnesses()["axial_stiffness"] * np.maximum(stretch, 0.0)
    forces = [_bound(load) for load in system.external_loads if isinstance(load, PointForce)]
    masses = [each.mass for each in system.attachments if isinstance(each, PointMass)]
    for other in system.bodies:
        if isinstance(other, RigidBody):
            masses.append(other.mass)
        elif isinstance(other, ElasticBody):
            per_length = other.stiffnesses()["mass_per_length"]
            masses.append(float(np.sum(per_length * other.lengths)))
    weight = sum(masses) * float(np.linalg.norm(system.scene.gravity))
    return float(np.max(tension)) + sum(forces) + weight


def _bound(load: TimeDependentValue) -> float:
    """Return the largest magnitude of a load; zero for a function, which is not known."""
    if isinstance(load.value, Signal):
        return load.value.bound
    return 0.0 if callable(load.value) else float(np.linalg.norm(load.value))
