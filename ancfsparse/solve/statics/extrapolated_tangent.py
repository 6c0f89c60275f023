"""Tangent stiffness of slender bodies with extrapolated stress."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState


class ExtrapolatedTangent:
    """Tangent stiffness of successive states, with the stress that corrections should have caused.

    A slender body hardly stretches, but along the straight line of a large correction it does, by
    the square of the rotation, and a tangent with that stress misleads the next correction.  So the
    stress is extrapolated from the last state without that square (Magisano, Leonetti and Garcea
    2017).  Strains are nearly quadratic in the coordinates, so the part that is linear in a
    correction follows from its ends and its midpoint.

    Parameters
    ----------
    equations : EquilibriumEquations
        The equations.
    """

    def __init__(self, equations: EquilibriumEquations) -> None:
        self._equations = equations
        # Allocating large arrays again would cost more than writing to them.
        n = equations.system.pattern.n_values + 1
        self._values, self._work, self._middle, self._stress, self._last = np.empty((5, n))
        self._q: Vector | None = None

    def exact(self, state: StaticState, load: float) -> Vector:
        """Return the values of the tangent stiffness."""
        return self._equations.stiffness(state, load, self._values)

    def extrapolated(self, state: StaticState, load: float) -> Vector:
        """Return those values with stress extrapolated from the state of the last call."""
        equations, work = self._equations, self._work
        stress = equations.stress_stiffness(state.q, self._stress, work)
        if equations.plain:  # `work` is the material stiffness
            values = self._values[: len(stress)]
            np.add(stress, work[: len(stress)], out=values)
        else:
            values = self.exact(state, load)
        if self._q is not None:
            middle = equations.stress_stiffness(0.5 * (self._q + state.q), self._middle, work)
            middle *= 4.0
            values += middle
            last = self._last[: len(stress)]
            last += stress
            last *= 2.0
            values -= last
        self._q = state.q
        self._stress, self._last = self._last, self._stress
        return values
