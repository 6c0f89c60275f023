"""Checks of the arguments of contacts, and of bodies and obstacles where they begin."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.checks import check_moderate, check_positive
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene import bodies
from ancfsparse.scene.force_elements.fixed_ends import (
    MAX_START_DEPTH_RATIO,
    fixed_points,
    is_left_out,
)
from ancfsparse.scene.loads.attachment import check_coefficient
from ancfsparse.scene.sections.standard_sections import Circle, Tube

if TYPE_CHECKING:
    from ancfsparse.scene.bodies.elastic_body import ElasticBody
    from ancfsparse.scene.bodies.rigid_body import RigidBody
    from ancfsparse.scene.force_elements.contacts import Contact
    from ancfsparse.scene.force_elements.obstacles import Obstacle
    from ancfsparse.scene.joints.joint import Joint

MAX_ELEMENT_ANGLE = 0.5 * math.pi  # of an element around an obstacle [rad]


def check_restitution(body: ElasticBody, restitution: float | None) -> float:
    """Return a coefficient of restitution after checking it, 0 for none."""
    if restitution is None:
        return 0.0
    name = f"restitution of the contact of {body.name}"
    number = check_positive(name, restitution)
    if number > 1.0:
        raise InputError(
            f"{name} is the speed after an impact over the one before, at most 1, got {number:g}"
        )
    return number


def check_static_friction(
    body: ElasticBody, friction: float, static_friction: float | None, slip_speed: float | None
) -> float:
    """Return the coefficient of static friction after checking it, by default the kinetic one."""
    if static_friction is None:
        return float(friction)
    name = f"static_friction of the contact of {body.name}"
    number = check_coefficient(name, static_friction)
    if number < friction or friction == 0.0:
        raise InputError(
            f"{name} of {number:g} is for points that stick: friction=, for points that slide, "
            f"must be positive and at most as large, got {friction:g}"
        )
    if slip_speed is not None:
        raise InputError(f"{name} is for points that stick: leave slip_speed out")
    return number


def check_on(obstacle: Obstacle, on: object) -> RigidBody:
    """Return the body of an obstacle, or refuse it."""
    if not isinstance(on, bodies.RigidBody):
        raise InputError(
            f"on= of a contact needs a rigid body of this scene, got {format_value(on)}"
        )
    if on.n_vectors < obstacle.dim:
        raise InputError(
            f"the {obstacle.noun} is on {on.name}, a thin rod without rotation about its axis: "
            "give the body an inertia in place of the shape Rod"
        )
    if obstacle.spin.any():
        raise InputError(
            f"the {obstacle.noun} turns with {on.name}: leave its angular_velocity out and give "
            "that to the body, or drive its joint"
        )
    return on


def radius_of(body: ElasticBody, radius: float | None) -> float:
    """Return the radius of a body, by default half the diameter of its section."""
    if radius is not None:
        return check_moderate(f"radius of the contact of {body.name}", radius, "m")
    if isinstance(body.section, Circle | Tube):
        return 0.5 * body.section.diameter
    raise InputError(f"the section of {body.name} is not round: give contact the radius=")


def check_slip_speed(body: ElasticBody, slip_speed: float | None) -> float:
    """Return a slip speed after checking it, 0 for none."""
    if slip_speed is None:
        return 0.0
    return check_moderate(f"slip_speed of the contact of {body.name}", slip_speed, "m/s")


def check_reach(contact: Contact) -> None:
    """Refuse a body that would touch an obstacle from outside the grid of its distances."""
    reach = contact.obstacle.reach
    if contact.radius > reach:
        raise InputError(
            f"{contact.what}: the radius of {contact.radius:.6g} m is larger than {reach:.6g} m, "
            "the largest distance of its grid: give the obstacle a larger cell or spacing"
        )


def check_penetration(contact: Contact, joints: Iterable[Joint]) -> None:
    """Refuse a body that begins inside the obstacle.

    With a given stiffness, which can be soft, its axis alone must be outside.
    """
    points, radius = contact.points, contact.radius
    distances = contact.obstacle.distances(np.array([point.position for point in points]))
    fixed = fixed_points(contact, joints)
    distances[is_left_out(contact, fixed)] = np.inf
    k = int(np.argmin(distances))
    depth = radius - distances[k]
    limit = MAX_START_DEPTH_RATIO if contact.stiffness is None else 1.0
    if depth > limit * radius:
        raise InputError(
            f"{contact.what} begins with a penetration of {depth:.6g} m at {points[k]!r}, more "
            f"than {limit:.0%} of the radius of {radius:.6g} m: move one of them, give contact "
            "push_out=True, or, if a joint fixes it there, add the joint first"
        )


def check_elements(contact: Contact) -> None:
    """Refuse elements that are longer than a quarter of the circumference of an obstacle."""
    limit = 0.25 * contact.obstacle.circumference + MAX_ELEMENT_ANGLE * contact.radius
    longest = float(contact.body.lengths.max())
    if longest > limit:
        times = math.ceil(longest / limit)
        raise InputError(
            f"{contact.what}: an element of {longest:.6g} m is longer than a quarter of its "
            f"circumference, {limit:.6g} m: take at least {times} times as many elements, "
            f"{times * contact.body.n_elements}"
        )
