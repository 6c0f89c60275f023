"""Forces of contacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.force_elements.contacts import Contact
from ancfsparse.system.contributions.force_elements.contact.contacts import ContactContribution
from ancfsparse.system.coordinates.coordinates import foreign_handle
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.system import System


@dataclass(frozen=True, eq=False)
class ContactForce:
    """Force of an obstacle on a body, at the quadrature points of the body.

    Attributes
    ----------
    s : ndarray, shape (n,)
        Arc coordinates of the points [m].
    pressure : ndarray, shape (k, n)
        Normal force per length [N/m].
    friction : ndarray, shape (k, n, dim)
        Friction on the body per length [N/m].
    force : ndarray, shape (k, dim)
        Resultant force on the body [N].
    """

    s: Vector
    pressure: Vector
    friction: Vector
    force: Vector

    def at(self, k: int) -> ContactForce:
        """Return the forces of one state, without the first axis."""
        return ContactForce(self.s, self.pressure[k], self.friction[k], self.force[k])


def contact_force(system: System, contact: object, states: StateHistory) -> ContactForce:
    """Return the forces of a contact, see `Solution.contact_force`."""
    if not isinstance(contact, Contact):
        raise InputError(
            f"contact_force needs what scene.contact(...) returned, got {format_value(contact)}"
        )
    contributions = (each for each in system.contributions if isinstance(each, ContactContribution))
    contribution = next((each for each in contributions if each.contact is contact), None)
    if contribution is None:
        raise foreign_handle("the contact", "attachments[0]")
    forces = contribution.forces(np.asarray(states.q), np.asarray(states.v))
    per_length = forces / contact.weights[:, None]
    return ContactForce(
        np.array([contact.body.arc(point) for point in contact.points]),
        np.linalg.norm(per_length[:, 0], axis=2),
        per_length[:, 1],
        forces.sum(axis=(1, 2)),
    )
