"""Buckling loads and shapes."""

from __future__ import annotations

from dataclasses import dataclass

from ancfsparse.results.data.interpolation import Array
from ancfsparse.results.solutions.mode_shapes import ModeShapes
from ancfsparse.system.coordinates.state import State
from ancfsparse.system.system import System


@dataclass(frozen=True, eq=False, repr=False)
class Buckling(ModeShapes):
    """Buckling load factors of a scene, in ascending order.

    Parameters
    ----------
    system : System
        The discrete system.
    about : State
        State of linearisation.
    factors : ndarray, shape (k,)
        Load factors of all loads of the scene, including gravity [-].
    shapes : ndarray, shape (k, n_all)
        Motions of the coordinates, m for positions and dimensionless for slopes, with the modal
        mass ``x.M x`` of 1 kg m2.
    """

    system: System
    about: State
    factors: Array
    shapes: Array

    def __repr__(self) -> str:
        """Summarise the loads in one line."""
        if not len(self):
            return "Buckling: none under these loads"
        first = ", ".join(f"{each:.6g}" for each in self.factors[:6])
        return f"Buckling: at {first}{', ...' * (len(self) > 6)} times the loads"

    def _name(self, mode: int) -> str:
        """Return the index and the load factor of a mode."""
        return f"buckling {mode % len(self)}, {self.factors[mode]:.4g} times the loads"
