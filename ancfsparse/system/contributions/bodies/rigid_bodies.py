"""Masses of rigid bodies: constant entries of the mass matrix, equal in every direction."""

from __future__ import annotations

import numpy as np

from ancfsparse.system.contributions.bodies.masses import (
    Entries,
    MassContribution,
    add_lower_triangle,
)
from ancfsparse.system.coordinates.discretization import Discretization


def of(system: Discretization) -> list[MassContribution]:
    """Return the masses of the rigid bodies of a system."""
    entries: Entries = {}
    for body, places in zip(system.scene.bodies, system.places, strict=True):
        if body.masses is not None:
            vectors = [places[0, body.kind.columns(name)] for name in body.kind.vectors]
            for direction in np.array(vectors).T:
                add_lower_triangle(entries, direction, body.masses)
    return [MassContribution(system.n_free, entries)]
