"""Stiffness of contacts that are given none, from data of the scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.scene.bodies.body import Body
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.force_elements.beam_contacts import BeamContact
from ancfsparse.scene.force_elements.contacts import Contact
from ancfsparse.scene.force_elements.masses import PointMass
from ancfsparse.scene.loads.loads import DistributedForce, PointForce
from ancfsparse.scene.records.signal import Signal
from ancfsparse.scene.records.time_dependent import TimeDependentValue
from ancfsparse.system.contributions.force_elements.penetrations import (
    DEPTH_RATIO,
    impact_ratio,
)
from ancfsparse.system.coordinates.discretization import Discretization

LOAD_FACTOR = 2.0  # largest pressure over its mean: 1.25 to 1.5 along a wire around a drum
# Factor of the speed after a level fall, for the speed in an impact and for its concentration where
# the impact is not damped.  Ends of cables that whip arrive 1.8 to 4.5 times as fast, and a single
# point sinks in by 1.1 to 3.6 times v sqrt(mu/k), since it stops more than its share of the length;
# the product reaches 6.9 in 15 scenes with deep penetrations.  With 3 ten of 600 random cables sink
# in by 1 to 2.3 DEPTH_RATIO, also with steps a 64th as long; with 5 two of 1000, by up to 1.13.
SPEED_FACTOR = 5.0
# Energy of a crossing over the energy of the length which bending waves reach: with 1.5 cables sink
# in by up to 1.4 DEPTH_RATIO.
CROSSING_FACTOR = 4.0
# Arc along which a turning obstacle can increase the tension; three turns with a friction of .5
# would ask for 12 000 times the stiffness [rad].
MAX_ARC = 2.0 * math.pi
ROUNDING = 1e-12  # of strains and angles that follow from positions [-]


def default_stiffness(system: Discretization, contact: Contact, number: int) -> float:
    """Return a stiffness for a body of a contact by known loads, tensions and speeds [N/m2].

    A line of the weight w per length sinks in by w/k at rest, one under the tension T around a
    round obstacle of radius R by T/(R k), and one of the mass mu per length that arrives with the
    speed v by v sqrt(mu/k).  One with the curvature kappa at the start and the bending stiffness EI
    springs back at a speed of about kappa sqrt(EI/mu).  A turning obstacle increases the tension
    along the angle phi of its arc by up to exp(friction phi).

    Raises
    ------
    InputError
        If there are neither loads, tensions nor speeds.
    """
    body, radius = contact.bodies[number], contact.radii[number]
    pressure, inertia = _known_actions(system, contact, number)
    stiffness = max(
        pressure / (DEPTH_RATIO * radius),
        inertia / (impact_ratio(contact.restitution) * radius) ** 2,
    )
    return _check_known(stiffness, contact.name_with((body,)))


def known_depth(system: Discretization, contact: Contact) -> float:
    """Return the penetration by the same loads and speeds, with the given stiffness [m]."""
    assert contact.stiffness is not None
    actions = [_known_actions(system, contact, k) for k in range(len(contact.bodies))]
    impact = max(math.sqrt(inertia / contact.stiffness) for _, inertia in actions)
    return max(known_depth_at_rest(system, contact), impact)


def known_depth_at_rest(system: Discretization, contact: Contact) -> float:
    """Return the penetration by the same loads at rest, with the given stiffness [m]."""
    assert contact.stiffness is not None
    actions = (_known_actions(system, contact, k) for k in range(len(contact.bodies)))
    return max(pressure for pressure, _ in actions) / contact.stiffness


def _known_actions(system: Discretization, contact: Contact, number: int) -> tuple[float, float]:
    """Return bounds of the pressure at rest, and of mass per length times squared speed, [N/m]."""
    body, obstacle, radius = contact.bodies[number], contact.obstacle, contact.radii[number]
    gravity = float(np.linalg.norm(system.scene.gravity))
    mass = _mass_per_length(body)
    pressure = mass * gravity + _distributed_load(system)
    gaps = obstacle.distances(body.positions) - radius
    if not obstacle.is_flat:
        weight = gravity * sum(_mass(each) for each in system.bodies)
        tension = _initial_tension(body) + _point_load(system) + weight
        bend_radius = obstacle.bend_radius + radius
        if np.any(obstacle.spin):
            arc = min(_length_near(body, gaps, radius) / bend_radius, MAX_ARC)
            tension *= math.exp(contact.friction * arc)
        pressure += tension / bend_radius
    squared_speed = 2.0 * gravity * float(np.max(gaps, initial=0.0))
    if body.velocity is not None:
        squared_speed += float(np.max(np.sum(body.velocity(body.positions) ** 2, axis=1)))
    squared_speed += _squared_release_speed(body)
    if not contact.restitution:
        squared_speed *= SPEED_FACTOR**2
    return LOAD_FACTOR * pressure, mass * squared_speed


def default_stiffness_between(system: Discretization, contact: BeamContact) -> float:
    """Return a stiffness for bodies that touch each other by known loads, tensions, speeds [N/m2].

    Lines side by side under the pressure p sink in by p/k.  Two that cross at a right angle, with
    axes at the distance d, press with ``(4/3) sqrt(2 d) k e^(3/2)`` and store
    ``(8/15) sqrt(2 d) k e^(5/2)``.  A crossing is assumed to bear the weight of a line over
    the extent of a body, and all known forces and tensions.  A body that arrives with the speed v
    is decelerated over the length that bending waves reach within 3 e/v, the duration of the
    impact; the mass is the reduced one of both sides.

    Raises
    ------
    InputError
        If there are neither loads, tensions nor speeds.
    """
    radius, bodies = min(contact.radii), contact.bodies
    rest, distance = DEPTH_RATIO * radius, 2.0 * radius
    impact = impact_ratio(contact.restitution) * radius
    gravity = np.array(system.scene.gravity)
    size = float(np.linalg.norm(gravity))
    load = _point_load(system) + max(_initial_tension(body) for body in bodies)
    pressure = _distributed_load(system) + size * max(_mass_per_length(body) for body in bodies)
    crossing = load + max(
        (_distributed_load(system) + size * _mass_per_length(body)) * _extent(body)
        for body in bodies
    )
    stiffness = max(
        LOAD_FACTOR * (pressure + load / distance) / rest,
        LOAD_FACTOR * 0.75 * crossing / (math.sqrt(2.0 * distance) * rest**1.5),
    )
    potentials = np.concatenate([body.positions for body in bodies]) @ gravity
    squared_speed = (
        2.0 * max(float(np.ptp(potentials)) - size * distance, 0.0)
        + _squared_difference_of_speeds(bodies)
        + max(_squared_release_speed(body) for body in bodies)
    )
    if squared_speed > 0.0:
        time = 3.0 * impact / math.sqrt(squared_speed)
        line = _reduced_mass(contact, _mass_per_length)
        mass = _reduced_mass(
            contact, lambda body: _mass_per_length(body) * _moved_length(body, time)
        )
        if not contact.restitution:
            mass *= CROSSING_FACTOR
        stiffness = max(
            stiffness,
            line * squared_speed / impact**2,
            1.875 * 0.5 * mass * squared_speed / (math.sqrt(2.0 * distance) * impact**2.5),
        )
    return _check_known(stiffness, contact.what)


def _length_near(body: ElasticBody, gaps: Vector, limit: float) -> float:
    """Return the length of the elements both of whose ends have a smaller gap than a limit [m]."""
    return float(body.lengths @ (gaps[body.row_nodes[body.ends]] < limit).all(axis=1))


def _check_known(stiffness: float, what: str) -> float:
    """Return a stiffness, or refuse one that nothing known requires."""
    if stiffness == 0.0:
        raise InputError(
            f"the stiffness of {what} is needed: neither weight nor a known "
            "force, tension or speed presses them together. Give contact the stiffness= in N/m2"
        )
    return stiffness


def _reduced_mass(contact: BeamContact, mass: Callable[[ElasticBody], float]) -> float:
    """Return the reduced mass of the heaviest bodies of both sides."""
    sides = contact.one, contact.other
    return 1.0 / sum(1.0 / max(mass(body) for body in side) for side in sides)


def _moved_length(body: ElasticBody, time: float) -> float:
    """Return the length that a force at a point accelerates within a time [m].

    A long beam moves at F sqrt(t) / sqrt(2 pi sqrt(EI mu^3)) below a force F.
    """
    frequency = math.sqrt(_bending_stiffness(body) / _mass_per_length(body))  # times length^2
    wave = math.sqrt(2.0 * math.pi * time * frequency)
    return min(_extent(body), max(float(np.mean(body.lengths)), wave))


def _extent(body: ElasticBody) -> float:
    """Return the diagonal of the box around a body [m]."""
    return float(np.linalg.norm(np.ptp(body.positions, axis=0)))


def _squared_release_speed(body: ElasticBody) -> float:
    """Return the squared speed at which a straight beam that is bent at the start springs back."""
    return _bending_stiffness(body) * _bent_curvature(body) ** 2 / _mass_per_length(body)


def _squared_difference_of_speeds(bodies: Sequence[ElasticBody]) -> float:
    """Return the squared largest difference of initial velocities, [m2/s2]."""
    velocities = [
        np.zeros((1, body.dim)) if body.velocity is None else body.velocity(body.positions)
        for body in bodies
    ]
    return float(np.sum(np.ptp(np.concatenate(velocities), axis=0) ** 2))


def _mass_per_length(body: ElasticBody) -> float:
    return float(np.max(body.masses_per_length))


def _bending_stiffness(body: ElasticBody) -> float:
    stiffnesses = body.stiffnesses()
    return max(
        (
            float(np.max(stiffnesses[name]))
            for name in stiffnesses
            if name.startswith("bending_stiffness")
        ),
        default=0.0,
    )


def _bent_curvature(body: ElasticBody) -> float:
    """Return the largest curvature by which straight elements are bent at the start [1/m]."""
    if body.kind.is_curved or body.kind.is_string:
        return 0.0
    ends = body.positions[body.row_nodes[body.ends]]
    chords = (ends[:, 1] - ends[:, 0]) / body.lengths[:, None]
    bends = body.ends[1:, 0] == body.ends[:-1, 1]  # elsewhere are hinges
    turns = np.linalg.norm(np.diff(chords, axis=0), axis=1)[bends]
    turns[turns < ROUNDING] = 0.0
    return float(np.max(2.0 * turns / (body.lengths[1:] + body.lengths[:-1])[bends], initial=0.0))


def _initial_tension(body: ElasticBody) -> float:
    """Return the largest tension at the start [N]."""
    ends = body.positions[body.row_nodes[body.ends]]
    stretch = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / body.lengths - 1.0
    stretch[stretch < ROUNDING] = 0.0
    return float(np.max(body.stiffnesses()["axial_stiffness"] * stretch))


def _distributed_load(system: Discretization) -> float:
    """Return the sum of all known forces per length [N/m]."""
    return sum(_bound(load) for load in system.external_loads if isinstance(load, DistributedForce))


def _point_load(system: Discretization) -> float:
    """Return the sum of all known point forces, and the weights of masses and rigid bodies [N]."""
    forces = [_bound(load) for load in system.external_loads if isinstance(load, PointForce)]
    masses = [each.mass for each in system.attachments if isinstance(each, PointMass)]
    masses += [body.mass for body in system.bodies if isinstance(body, RigidBody)]
    return sum(forces) + sum(masses) * float(np.linalg.norm(system.scene.gravity))


def _mass(body: Body) -> float:
    """Return the mass of a beam or a mesh, and zero for others [kg]."""
    return body.total_mass if isinstance(body, ElasticBody) else 0.0


def _bound(load: TimeDependentValue) -> float:
    """Return the largest magnitude of a load; zero for a function, which is not known."""
    if isinstance(load.value, Signal):
        return load.value.bound
    return 0.0 if callable(load.value) else float(np.linalg.norm(load.value))
