"""Buckling loads and shapes."""

from __future__ import annotations

from dataclasses import dataclass

from ancfsparse.array_types import Vector
from ancfsparse.results.solutions.mode_shapes import ModeShapes


@dataclass(frozen=True, eq=False, repr=False)
class Buckling(ModeShapes):
    """Buckling load factors of a scene, in ascending order.

    Parameters
    ----------
    system, about, shapes
        As in `ModeShapes`.
    factors : ndarray, shape (k,)
        Load factors of all loads of the scene, including gravity [-].
    """

    factors: Vector

    def __repr__(self) -> str:
        """Summarise the loads in one line."""
        if not len(self):
            return "Buckling: none under these loads"
        return f"Buckling: at {self._first(self.factors)} times the loads"

    def _name(self, mode: int) -> str:
        """Return the index and the load factor of a mode."""
        return f"buckling {mode % len(self)}, {self.factors[mode]:.4g} times the loads"
