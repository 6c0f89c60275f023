"""Forces of contacts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene import ElasticBody, Point
from ancfsparse.scene.force_elements.beam_contacts import BeamContact
from ancfsparse.scene.force_elements.contacts import Contact
from ancfsparse.scene.loads.attachment import ContactLaw
from ancfsparse.system.coordinates.coordinates import foreign_handle
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.system import System


@dataclass(frozen=True, eq=False)
class ForceOfStates:
    """Forces in k states, arrays with a leading axis of length k except for arc coordinates."""

    def at(self, k: int) -> Self:
        """Return the forces of one state, without the first axis."""
        return replace(
            self, **{name: values[k] for name, values in vars(self).items() if name != "s"}
        )


@dataclass(frozen=True, eq=False)
class ContactForce(ForceOfStates):
    """Force of an obstacle on bodies at quadrature points, or of all contacts on one body.

    Attributes
    ----------
    s : ndarray, shape (n,)
        Arc coordinates of the points, from the start of each body, or of the midpoints of the
        elements [m].
    pressure : ndarray, shape (k, n)
        Normal force per length [N/m].
    friction : ndarray, shape (k, n, dim)
        Friction on the bodies per length [N/m].
    force : ndarray, shape (k, dim)
        Resultant force on all bodies [N].
    """

    s: Vector
    pressure: Vector
    friction: Vector
    force: Vector


@dataclass(frozen=True, eq=False)
class BeamContactForce(ForceOfStates):
    """Forces of bodies on each other, or on themselves.

    Attributes
    ----------
    force : ndarray, shape (k, dim)
        Resultant force on the bodies of the first side [N], zero if both sides are equal.
    size : ndarray, shape (k,)
        Sum of the sizes of the normal forces between all pairs of points [N].
    friction : ndarray, shape (k,)
        Sum of the sizes of the friction between them [N].
    penetration : ndarray, shape (k,)
        Largest penetration [m].
    """

    force: Vector
    size: Vector
    friction: Vector
    penetration: Vector


def contact_force(
    system: System, contact: object, states: StateHistory
) -> ContactForce | BeamContactForce:
    """Return the forces of a contact, see `Solution.contact_force`."""
    if isinstance(contact, ElasticBody):
        return force_on_elements(system, contact, states)
    if not isinstance(contact, ContactLaw):
        raise InputError(
            "contact_force needs what scene.contact(...) returned, or a beam or a mesh, got "
            f"{format_value(contact)}"
        )
    contributions: list[Any] = [each for each in system.contributions if each.is_contact]
    contribution = next((each for each in contributions if each.contact is contact), None)
    if contribution is None:
        raise foreign_handle("the contact", "attachments[0]")
    forces = contribution.forces(np.asarray(states.q), np.asarray(states.v), states.internal)
    return RESULTS[type(contact)](contact, forces)


def _obstacle_force(contact: Contact, forces: Vector) -> ContactForce:
    """Return the forces of an obstacle from those on quadrature points, (k, 2, n, dim) [N]."""
    per_length = forces / contact.weights[:, None]
    return ContactForce(
        np.array([point.beam.arc(point) for point in contact.points]),
        np.linalg.norm(per_length[:, 0], axis=2),
        per_length[:, 1],
        forces.sum(axis=(1, 2)),
    )


RESULTS: dict[type, Callable[[Any, Any], ContactForce | BeamContactForce]] = {
    Contact: _obstacle_force,
    BeamContact: lambda _, forces: BeamContactForce(*forces),
}
"""Functions of a contact and the forces of its contribution, by the kind of contact."""


def force_on_elements(system: System, of: ElasticBody, states: StateHistory) -> ContactForce:
    """Return the forces of all contacts on a body, as mean values of its elements."""
    body: Any = system.resolve(of)
    q, v, history = np.asarray(states.q), np.asarray(states.v), states.internal
    k, n, dim = len(q), len(system.elements(body)), system.scene.dim
    sizes, normal, friction = np.zeros((k, n)), np.zeros((k, n, dim)), np.zeros((k, n, dim))
    contributions: list[Any] = [each for each in system.contributions if each.is_contact]
    for each in contributions:
        if body not in each.contact.bodies:
            continue
        first = each.contact.starts[each.contact.bodies.index(body)]
        for row in range(k):
            own_history = None if history is None else history[row]
            for elements, force, along in each.forces_on_elements(q[row], v[row], own_history):
                here = (elements >= first) & (elements < first + n)
                own = elements[here] - first
                np.add.at(sizes[row], own, np.linalg.norm(force[here], axis=1))
                np.add.at(normal[row], own, force[here])
                np.add.at(friction[row], own, along[here])
    return ContactForce(
        np.array([body.arc(Point(body, e, 0.5)) for e in range(n)]),
        sizes / body.lengths,
        friction / body.lengths[:, None],
        (normal + friction).sum(axis=1),
    )
