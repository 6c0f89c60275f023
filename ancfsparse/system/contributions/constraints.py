"""Constraint equations, see `system.constraints`, and the forces of their multipliers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.dispatch import compiled
from ancfsparse.system.contributions.interface import Compiled, Contribution, unknowns
from ancfsparse.system.pattern import Pattern, Unknowns

if TYPE_CHECKING:
    from ancfsparse.system.system import System


class Constraints(Contribution):
    """The equations of a system that multipliers hold."""

    def __init__(self, system: System) -> None:
        self._n_free, self._constraints = system.n_free, system.constraints

    def cliques(self) -> list[Unknowns]:
        """Return for each term its equation and the one or two coordinates in it, (n_terms, 3)."""
        c = self._constraints
        row, i, j = (np.array(x, dtype=np.int32) for x in (c.row, c.i, c.j))
        coordinates = (unknowns(x, self._n_free) for x in (i, j))
        return [np.stack([self._n_free + row, *coordinates], axis=1)]

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled constraints."""
        c = self._constraints
        # Pairs by rows: (row, row), (i, row), (i, i), (j, row), (j, i), (j, j).
        pairs = pattern.slots(*self.cliques())
        integers = {name: np.array(getattr(c, name), dtype=np.int32) for name in ("row", "i", "j")}
        reals = {
            name: np.array(getattr(c, name), float) for name in ("coefficient", "about", "offset")
        }
        slots = {"slot_i": pairs[:, 1], "slot_j": pairs[:, 3], "slot_ij": pairs[:, 4]}
        copies = {name: column.copy() for name, column in slots.items()}
        made: Compiled = compiled("constraints").Constraints(integers | reals | copies)
        return made


def of(system: System) -> list[Constraints]:
    """Return the constraints of a system."""
    return [Constraints(system)]
