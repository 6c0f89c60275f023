"""Checks of the arguments of contacts, and of bodies and obstacles where they begin."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.checks import check_moderate, check_positive
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene import bodies
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.force_elements.contact_points import (
    MAX_PARTS,
    POINTS_PER_PART,
    count_parts,
)
from ancfsparse.scene.force_elements.fixed_ends import (
    MAX_START_DEPTH_RATIO,
    fixed_points,
    is_left_out,
)
from ancfsparse.scene.loads.attachment import Attachment, Bodies, check_coefficient, names

if TYPE_CHECKING:
    from ancfsparse.scene.bodies.rigid_body import RigidBody
    from ancfsparse.scene.force_elements.contacts import Contact
    from ancfsparse.scene.force_elements.obstacles import Obstacle
    from ancfsparse.scene.joints.joint import Joint

MAX_ELEMENT_ANGLE = 0.5 * math.pi  # of an element around an obstacle [rad]


def check_bodies(side: object, own: Callable[[str, ElasticBody], object]) -> Bodies:
    """Return the bodies of one side of a contact after checking them."""
    if isinstance(side, ElasticBody):
        side = (side,)
    if not isinstance(side, list | tuple) or not side:
        raise InputError(
            "contact needs a beam or a mesh of this scene, or a list of them such as scene.beams, "
            f"got {format_value(side)}"
        )
    before = set()
    for each in side:
        if not isinstance(each, ElasticBody):
            raise InputError(
                f"contact needs a beam or a mesh of this scene, got {format_value(each)}"
            )
        own("a contact", each)
        if each in before:
            raise InputError(f"contact was given {each.name} twice: name each body once")
        before.add(each)
        if each.automatic:
            raise InputError(
                f"contact of {each.name} has its points inside elements: give element and "
                f"n_elements instead of 'auto' for {' and '.join(each.automatic)}"
            )
    return tuple(side)


def check_law(
    side: Bodies,
    friction: float,
    slip_speed: float | None,
    restitution: float | None,
    static_friction: float | None,
) -> dict[str, float]:
    """Return the coefficients and the slip speed of a contact after checking them."""
    of = f"of the contact of {names(side)}"
    return {
        "friction": check_coefficient(f"friction {of}", friction),
        "slip_speed": 0.0
        if slip_speed is None
        else _check_slip_speed(f"slip_speed {of}", friction, slip_speed),
        "restitution": 0.0
        if restitution is None
        else _check_restitution(f"restitution {of}", restitution),
        "static_friction": float(friction)
        if static_friction is None
        else _check_static_friction(of, friction, static_friction, slip_speed),
    }


def _check_slip_speed(name: str, friction: float, slip_speed: float) -> float:
    """Return the slip speed after checking it."""
    number = check_moderate(name, slip_speed, "m/s")
    if friction == 0.0:
        raise InputError(
            f"{name} of {number:g} m/s is for friction, and this contact has none: give it "
            "friction=, or leave slip_speed out"
        )
    return number


def _check_restitution(name: str, restitution: float) -> float:
    """Return a coefficient of restitution after checking it."""
    number = check_positive(name, restitution)
    if number > 1.0:
        raise InputError(
            f"{name} is the speed after an impact over the one before, at most 1, got {number:g}"
        )
    return number


def _check_static_friction(
    of: str, friction: float, static_friction: float, slip_speed: float | None
) -> float:
    """Return the coefficient of static friction after checking it."""
    name = f"static_friction {of}"
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
    if body.section.radius is None:
        raise InputError(f"the section of {body.name} is not round: give contact the radius=")
    return body.section.radius


def check_contact(contact: Contact, joints: Iterable[Joint], before: Iterable[Attachment]) -> None:
    """Refuse bodies that cannot touch an obstacle, begin inside it, or have a contact with it."""
    check_reach(contact)
    check_parts(contact)
    if not contact.separates:
        check_penetration(contact, joints)
    check_elements(contact)
    for each in before:
        if type(each) is type(contact) and each.on is contact.on:
            both = [body for body in contact.bodies if body in each.bodies]
            if both and each.obstacle.coincides_with(contact.obstacle):
                raise InputError(
                    f"{contact.name_with(both[:1])} was added before: leave one of them out"
                )


def check_reach(contact: Contact) -> None:
    """Refuse bodies that would touch an obstacle from outside the grid of its distances."""
    reach, radius = contact.obstacle.reach, max(contact.radii)
    if radius > reach:
        raise InputError(
            f"{contact.what}: the radius of {radius:.6g} m is larger than {reach:.6g} m, "
            "the largest distance of its grid: give the obstacle a larger cell or spacing"
        )


def check_penetration(contact: Contact, joints: Iterable[Joint]) -> None:
    """Refuse bodies that begin inside the obstacle.

    With a given stiffness, which can be soft, only their axes must be outside.
    """
    points, radii = contact.points, contact.per_point(contact.radii)
    distances = contact.obstacle.distances(np.array([point.position for point in points]))
    fixed = fixed_points(contact, joints)
    distances[is_left_out(contact, fixed)] = np.inf
    k = int(np.argmax((radii - distances) / radii))
    radius, depth = float(radii[k]), float(radii[k] - distances[k])
    limit = MAX_START_DEPTH_RATIO if contact.stiffness is None else 1.0
    if depth > limit * radius:
        raise InputError(
            f"{contact.what} begins with a penetration of {depth:.6g} m at {points[k]!r}, more "
            f"than {limit:.0%} of the radius of {radius:.6g} m: move one of them, give contact "
            "push_out=True, or, if a joint fixes it there, add the joint first"
        )


def check_parts(contact: Contact) -> None:
    """Refuse elements that require too many points for their radius."""
    for body, radius in zip(contact.bodies, contact.radii, strict=True):
        longest = float(body.lengths.max())
        n = count_parts(longest, radius, contact.obstacle)
        if n > MAX_PARTS:
            raise InputError(
                f"{contact.name_with((body,))}: with a radius of {radius:.6g} m an element of "
                f"{longest:.6g} m requires {POINTS_PER_PART * n} points, more than "
                f"{POINTS_PER_PART * MAX_PARTS}: take more elements or a larger radius"
            )


def check_elements(contact: Contact) -> None:
    """Refuse elements that are longer than a quarter of the circumference of an obstacle."""
    for body, radius in zip(contact.bodies, contact.radii, strict=True):
        limit = 0.25 * contact.obstacle.circumference + MAX_ELEMENT_ANGLE * radius
        longest = float(body.lengths.max())
        if longest > limit:
            times = math.ceil(longest / limit)
            raise InputError(
                f"{contact.name_with((body,))}: an element of {longest:.6g} m is longer than a "
                f"quarter of its circumference, {limit:.6g} m: take at least {times} times as many "
                f"elements, {times * body.n_elements}"
            )
