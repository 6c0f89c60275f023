"""Penetrations at the start: the part of an assembly that moves bodies apart."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.system import System
from ancfsparse.system.contributions.interface import limit_length, sum_of

if TYPE_CHECKING:
    from ancfsparse.system.assembly.assembly_protocol import CompiledAssembly

MAX_DEPTH_RATIO = 0.01  # penetration that is left, over the radius
# Growth of the stiffness of the contacts after a correction that leaves more than half of the
# largest penetration.  The stiffness begins with the mass of the bodies, so that free ones move
# as a whole and only constrained ones deform.  With a large stiffness from the start a cable across
# another one rotates by radians, to fit points of the overlap at all depths.
GROWTH = 10.0
SLOW_RATIO = 0.5  # penetrations after and before a correction
MAX_STIFFNESS_RATIO = 1e3  # of the contacts over the bodies, beyond which only rounding changes


class Separation:
    """The contacts of a system that move bodies apart.

    Parameters
    ----------
    system : System
        The system, with an assembly of its own for the contacts with ``push_out=True``.
    """

    def __init__(self, system: System) -> None:
        self._system = system
        pairs = zip(system.contributions, system.parts, strict=True)
        chosen = [(term, part) for term, part in pairs if term.separates]
        self._terms = [term for term, _ in chosen]
        self._factor, self._depth = 0.0, np.inf  # of their stiffness; at the last correction
        self._is_full = True  # whether that was not shortened
        self._assembly: CompiledAssembly = compiled_module("assembly").Assembly(
            system.n_free,
            system.n_all,
            system.loads.n_amplitudes,
            system.pattern.indptr,
            [part for _, part in chosen],
        )

    def __bool__(self) -> bool:
        """Return whether there are any."""
        return bool(self._terms)

    def deepest(self, q: Vector) -> tuple[float, float, str, str]:
        """Return the penetration that is largest over its radius, see `deepest_point`."""
        points = (term.deepest_point(q) for term in self._terms)
        return max(points, key=lambda each: each[0] / each[1], default=(0.0, 1.0, "", ""))

    def is_done(self, q: Vector) -> bool:
        """Return whether all penetrations are small."""
        depth, radius, *_ = self.deepest(q)
        return depth <= MAX_DEPTH_RATIO * radius

    def linearize(self, q: Vector, mass: Vector, stiff: Vector) -> tuple[Vector, Vector, Any]:
        """Return forces and matrix of the pressures, stiffer where corrections are slow.

        Parameters
        ----------
        q : (n_all,) float
            Coordinates.
        mass, stiff : (n_free,) float
            Diagonals of the mass matrix, and of the matrix that the pressures are added to.

        Returns
        -------
        force : (n_free,) float
            Forces of the pressures.
        values : (n_values,) float
            Their stiffness on the pattern.
        coupling : sparse or None
            That between elements.
        """
        n = self._system.n_free
        force = self._assembly.force(q)[:n]
        values = self._assembly.material(0.0, 1.0, q)
        stiffness = values[self._system.pattern.indptr[:n]]
        touched, depth = stiffness > 0.0, self.deepest(q)[0]
        if touched.any() and self._factor == 0.0:
            self._factor = float(np.max(mass[touched]) / np.max(stiffness))
        elif touched.any() and self._is_full and depth > SLOW_RATIO * self._depth:
            largest = MAX_STIFFNESS_RATIO * float(np.max(stiff[touched]) / np.max(stiffness))
            self._factor = min(GROWTH * self._factor, max(largest, self._factor))
        self._depth = depth
        coupling = sum_of(term.material_coupling(q) for term in self._terms)
        if coupling is not None:
            coupling = self._factor * coupling[:n, :n]
        return self._factor * force, self._factor * values, coupling

    def limit_length(self, q: Vector, dq: Vector, length: float) -> float:
        """Return the part of a motion in which no bodies pass through each other, or 0."""
        length = limit_length(self._terms, q, dq, length)
        self._is_full = length == 1.0
        return length
