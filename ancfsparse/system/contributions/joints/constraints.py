"""Constraint equations of `system.coordinates.constraint_terms`, and their multiplier forces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Indices, Integers, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.scene.kinematics.linear_forms import LINEAR
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import (
    Compiled,
    Contribution,
    matrix_unknowns,
    offsets_of,
)
from ancfsparse.system.coordinates.discretization import Discretization

if TYPE_CHECKING:
    from ancfsparse.system.coordinates.constraint_terms import Constraints


class ConstraintContribution(Contribution):
    """The constraint equations of a system."""

    def __init__(self, system: Discretization) -> None:
        self._n_free, self._constraints = system.n_free, system.constraints
        self._massive = _terms_with_mass(system.constraints)

    def cliques(self) -> list[Indices]:
        """Return the unknowns of each term, (n_terms, 3), and of each equation with a mass, (1, k).

        The unknowns of a term are its multiplier and its one or two coordinates.
        """
        c = self._constraints
        row, i, j = (np.array(x, dtype=np.int32) for x in (c.row, c.i, c.j))
        coordinates = (matrix_unknowns(x, self._n_free) for x in (i, j))
        terms = np.stack([self._n_free + row, *coordinates], axis=1)
        return [terms, *self._with_mass()]

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled constraints."""
        c = self._constraints
        # Pairs by rows: (row, row), (i, row), (i, i), (j, row), (j, i), (j, j).
        pairs = pattern.slots(self.cliques()[0])
        integers = {name: np.array(getattr(c, name), dtype=np.int32) for name in ("row", "i", "j")}
        reals = {
            name: np.array(getattr(c, name), float) for name in ("coefficient", "about", "offset")
        }
        slots = {"slot_i": pairs[:, 1], "slot_j": pairs[:, 3], "slot_ij": pairs[:, 4]}
        copies = {name: column.copy() for name, column in slots.items()}
        arrays, masses = integers | reals | copies, self._masses(pattern)
        made: Compiled = compiled_module("constraints").Constraints(arrays, masses)
        return made

    def _with_mass(self) -> list[Indices]:
        return [
            matrix_unknowns(places[None].copy(), self._n_free) for _, places, _, _ in self._massive
        ]

    def _masses(self, pattern: Pattern) -> dict[str, Integers | Vector]:
        """Return terms, gradients and matrix positions of the equations with a mass."""
        none = np.empty(0, dtype=np.int32)
        terms, places, own, other = (
            (list(each) for each in zip(*self._massive, strict=True))
            if self._massive
            else ([], [], [], [])
        )
        slots = [pattern.slots(each).ravel() for each in self._with_mass()]
        rows = [self._constraints.row[each[0]] for each in terms]
        masses = [self._constraints.mass[row] for row in rows]
        flat = {"term": terms, "own": own, "other": other, "slot": slots}
        starts = {"first_term": terms, "first_place": places, "first_slot": slots}
        return {
            **{name: np.concatenate([none, *each]).astype(np.int32) for name, each in flat.items()},
            **{name: offsets_of(tables) for name, tables in starts.items()},
            "mass": np.array(masses, dtype=float),
        }


def _terms_with_mass(
    constraints: Constraints,
) -> list[tuple[Integers, Integers, Integers, Integers]]:
    """Return the terms and coordinates of each equation with a mass, and the factors of its terms.

    The second factor is -1 in linear terms.
    """
    c, equations = constraints, []
    row, i, j = (np.array(x, dtype=np.int32) for x in (c.row, c.i, c.j))
    order = np.argsort(row, kind="stable").astype(np.int32)
    begins = np.searchsorted(row[order], np.arange(len(c.offset) + 1))
    for k in np.flatnonzero(c.mass):
        terms = order[begins[k] : begins[k + 1]]
        both = np.concatenate([i[terms], j[terms][j[terms] != LINEAR]])
        places = np.unique(both).astype(np.int32)
        own, other = (np.searchsorted(places, x[terms]).astype(np.int32) for x in (i, j))
        equations.append((terms, places, own, np.where(j[terms] == LINEAR, -1, other)))
    return equations


def of(system: Discretization) -> list[ConstraintContribution]:
    """Return the constraints of a system."""
    return [ConstraintContribution(system)]
