"""Point masses and rotary inertias: constant entries of the mass matrix."""

from __future__ import annotations

from typing import Any

import numpy as np

from ancfsparse.array_types import Indices
from ancfsparse.dispatch import compiled_module
from ancfsparse.scene.force_elements.masses import PointMass
from ancfsparse.scene.kinematics.rigid_motion import second_moments
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import Compiled, Contribution, matrix_unknowns
from ancfsparse.system.coordinates.discretization import Discretization

Entries = dict[tuple[int, int], float]


class MassContribution(Contribution):
    """Constant entries of the lower triangle of the mass matrix, by row and column."""

    def __init__(self, n_free: int, entries: Entries) -> None:
        self._n_free = n_free
        self._pairs = np.array(list(entries), dtype=np.int32).reshape(-1, 2)
        self._value = np.array(list(entries.values()))

    def cliques(self) -> list[Indices]:
        """Return the two coordinates of each entry."""
        return [matrix_unknowns(self._pairs.copy(), self._n_free)]

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled masses."""
        slots = pattern.slots(*self.cliques())  # (i, i), (j, i), (j, j)
        row, column = (np.ascontiguousarray(each) for each in self._pairs.T)
        slot = np.where(row == column, slots[:, 0], slots[:, 1])
        made: Compiled = compiled_module("masses").Masses(
            row, column, np.ascontiguousarray(slot), self._value
        )
        return made


def add_lower_triangle(entries: Entries, places: Any, values: Any) -> None:
    """Add the lower triangle of a small matrix at the given indices."""
    for a, i in enumerate(places.tolist()):
        for b, j in enumerate(places[: a + 1].tolist()):
            pair = (max(i, j), min(i, j))
            entries[pair] = entries.get(pair, 0.0) + float(values[a, b])


def _add_inertia(entries: Entries, system: Discretization, mass: PointMass) -> None:
    """Add the rotary inertia of a node: 1/2 sum of P_kl r_k'.r_l', P = integral x x^T."""
    places, kind = system.place(mass.node), system.kind_of(mass.node.beam)
    names = ["r_x", "r_y", "r_z"]
    if system.dim == 3:
        spread = second_moments(mass.inertia)
    else:  # any division of the moment of inertia among the rotating vectors is equivalent
        names = [name for name in names[:2] if name in kind.section]
        spread = np.eye(len(names)) * mass.inertia[0, 0] / len(names)
    vectors = np.array([places[kind.columns(name)] for name in names])
    for direction in vectors.T:
        add_lower_triangle(entries, direction, spread)


def of(system: Discretization) -> list[MassContribution]:
    """Return the point masses of a system."""
    found = [each for each in system.scene.attachments if isinstance(each, PointMass)]
    entries: Entries = {}
    for each in found:
        places, weights = system.point(each.node)
        for row in places:
            add_lower_triangle(entries, row, each.mass * np.outer(weights, weights))
        if each.inertia.any():
            _add_inertia(entries, system, each)
    return [MassContribution(system.n_free, entries)] if found else []
