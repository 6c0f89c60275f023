"""The interface of a motion for plots and tables."""

from __future__ import annotations

from typing import Protocol

from ancfsparse.array_types import Vector
from ancfsparse.results.fields.energy_balance import Energy
from ancfsparse.system.system import System

UNITS = {
    "position": "m",
    "velocity": "m/s",
    "acceleration": "m/s2",
    "slope": "-",
    "reaction": "N",
}
"""Quantities of a point over time, which are methods of a `Motion`, and their units."""


class Motion(Protocol):
    """A motion at k times; it has a method for each of `UNITS`."""

    @property
    def system(self) -> System:
        """The discrete system."""
        ...

    @property
    def t(self) -> Vector:
        """Times, (k,) [s]."""
        ...

    @property
    def q(self) -> Vector:
        """Coordinates, (k, n)."""
        ...

    @property
    def v(self) -> Vector:
        """Their rates, (k, n)."""
        ...

    @property
    def a(self) -> Vector:
        """Their second rates, (k, n)."""
        ...

    @property
    def internal(self) -> Vector:
        """Internal variables, (k, h)."""
        ...

    @property
    def energy(self) -> Energy:
        """The energy balance."""
        ...
