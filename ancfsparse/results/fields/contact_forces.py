"""Forces of contacts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.force_elements.beam_contacts import BeamContact
from ancfsparse.scene.force_elements.contacts import Contact
from ancfsparse.system.contributions.force_elements.beam_contact.beam_contacts import (
    BeamContactContribution,
)
from ancfsparse.system.contributions.force_elements.contact.contacts import ContactContribution
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


@dataclass(frozen=True, eq=False)
class BeamContactForce(ForceOfStates):
    """Forces of two bodies on each other, or of one on itself.

    Attributes
    ----------
    force : ndarray, shape (k, dim)
        Resultant force on the first body [N], zero for one that touches itself.
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
    if not isinstance(contact, Contact | BeamContact):
        raise InputError(
            f"contact_force needs what scene.contact(...) returned, got {format_value(contact)}"
        )
    kinds = ContactContribution, BeamContactContribution
    contributions = (each for each in system.contributions if isinstance(each, kinds))
    contribution = next((each for each in contributions if each.contact is contact), None)
    if contribution is None:
        raise foreign_handle("the contact", "attachments[0]")
    table = np.asarray(states.q), np.asarray(states.v), states.history
    if isinstance(contribution, BeamContactContribution):
        return BeamContactForce(*contribution.forces(*table))
    contact = contribution.contact
    forces = contribution.forces(*table)
    per_length = forces / contact.weights[:, None]
    return ContactForce(
        np.array([contact.body.arc(point) for point in contact.points]),
        np.linalg.norm(per_length[:, 0], axis=2),
        per_length[:, 1],
        forces.sum(axis=(1, 2)),
    )
