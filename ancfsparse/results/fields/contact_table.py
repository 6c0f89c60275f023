"""Table of the places that touch in one state."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.results.data.interpolation import interpolate
from ancfsparse.scene import Point
from ancfsparse.scene.force_elements.beam_contacts import BeamContact
from ancfsparse.scene.force_elements.contacts import Contact
from ancfsparse.system.contributions.force_elements.beam_contact.beam_contacts import (
    BeamContactContribution,
)
from ancfsparse.system.contributions.force_elements.contact.contacts import ContactContribution
from ancfsparse.system.system import System

HEADINGS = "normal force [N]", "friction [N]", "sliding [m/s]", "penetration [m]"


@dataclass(frozen=True, eq=False)
class Touch:
    """A stretch of a body on an obstacle, or two elements that touch.

    Attributes
    ----------
    contact : Contact or BeamContact
        The contact, as ``scene.contact`` returned it.
    points : tuple of two Point
        First and last quadrature point of the stretch, or the points of the elements where they
        press most.
    normal_force, friction : float
        Sums of the sizes of the forces [N].
    sliding_speed : float
        Largest relative speed along the surface, of two elements that at their points [m/s].
    penetration : float
        Largest penetration [m].
    """

    contact: Contact | BeamContact
    points: tuple[Point, Point]
    normal_force: float
    friction: float
    sliding_speed: float
    penetration: float

    @property
    def where(self) -> str:
        """The location, as text."""
        return self.contact.describe_touch(*self.points)


class ContactTable(tuple[Touch, ...]):
    """All places that touch in one state, a tuple of `Touch`; printed as a table.

    Attributes
    ----------
    notes : list of str
        Sentences on the parts that contacts leave out.
    """

    notes: list[str]

    def __repr__(self) -> str:
        """Return a line of headings and one of each place."""
        if not self:
            return "\n".join(["no contacts", *self.notes])
        width = max(len(each.where) for each in self)
        lines = ["  ".join(["where".ljust(width), *HEADINGS])]
        for each in self:
            values = each.normal_force, each.friction, each.sliding_speed, each.penetration
            columns = (
                f"{value:{len(title)}.4g}" for value, title in zip(values, HEADINGS, strict=True)
            )
            lines.append("  ".join([each.where.ljust(width), *columns]))
        return "\n".join([*lines, *self.notes])


def contact_table(
    system: System, q: Vector, v: Vector, history: Vector | None = None
) -> ContactTable:
    """Return the places that touch in a state with coordinates q and velocities v, (n_all,)."""
    touches: list[Touch] = []
    for each in system.contributions:
        if each.is_contact:
            touches += TOUCHES[type(each)](system, each, q, v, history)
    table = ContactTable(touches)
    table.notes = [note for each in system.attachments for note in each.notes(system.joints)]
    return table


def _stretches(
    system: System, contribution: ContactContribution, q: Vector, v: Vector, history: Vector | None
) -> Iterator[Touch]:
    """Yield the stretches of consecutive quadrature points that touch an obstacle."""
    contact, points = contribution.contact, contribution.contact.points
    rows = None if history is None else history[None]
    sizes = np.linalg.norm(contribution.forces(q[None], v[None], rows)[0], axis=2)
    velocities, depths = contribution.motion(q, v)
    speeds = np.linalg.norm(velocities, axis=1)
    owner = contact.per_point(range(1, 1 + len(contact.bodies)))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], owner * (depths > 0.0), [0]])))
    for begin, end in pairwise(edges.tolist()):
        if depths[begin] <= 0.0:
            continue  # a gap
        normal, friction = sizes[:, begin:end].sum(axis=1).tolist()
        yield Touch(
            contact,
            (points[begin], points[end - 1]),
            normal,
            friction,
            float(speeds[begin:end].max()),
            float(depths[begin:end].max()),
        )


def _pairs(
    system: System,
    contribution: BeamContactContribution,
    q: Vector,
    v: Vector,
    history: Vector | None,
) -> Iterator[Touch]:
    """Yield the pairs of elements that touch."""
    contact = contribution.contact
    elements, positions, forces, depths = contribution.compiled.touches(q, v)
    sizes = np.linalg.norm(forces, axis=1)
    friction = np.linalg.norm(contribution.friction(q, v, history), axis=1)
    # Each place is there twice, integrated along either axis.
    order = np.argsort(elements, axis=1)
    elements = np.take_along_axis(elements, order, axis=1)
    positions = np.take_along_axis(positions, order, axis=1)
    _, pair = np.unique(elements, axis=0, return_inverse=True)
    for rows in (np.flatnonzero(pair == k) for k in range(pair.max(initial=-1) + 1)):
        largest = rows[np.argmax(sizes[rows])]
        one, other = (
            contact.point(int(e), float(xi))
            for e, xi in zip(elements[largest], positions[largest], strict=True)
        )
        normal = forces[largest] / sizes[largest]
        velocity = interpolate(system.point(one), v) - interpolate(system.point(other), v)
        yield Touch(
            contact,
            (one, other),
            float(sizes[rows].sum()),
            float(friction[rows].sum()),
            float(np.linalg.norm(velocity - (normal @ velocity) * normal)),
            float(depths[rows].max()),
        )


TOUCHES: dict[type, Callable[..., Iterator[Touch]]] = {
    ContactContribution: _stretches,
    BeamContactContribution: _pairs,
}
"""Functions that yield the places that touch, by the kind of contribution."""
