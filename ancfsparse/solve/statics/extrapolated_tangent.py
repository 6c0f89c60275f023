"""The stiffness of slender bodies on their way to equilibrium."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState

Vector = NDArray[np.float64]


class Tangent:
    """The stiffness of one state after another, with the stress that corrections should have made.

    A slender body hardly stretches, but along the straight line of a large correction it does, by
    the square of the turn, and a tangent with that stress misleads the next correction.  So the
    stress is extrapolated from the last state without that square (Magisano, Leonetti and Garcea
    2017).  Strains are squares of coordinates, nearly: what is linear in a correction follows from
    its two ends and its middle.

    Parameters
    ----------
    balance : Balance
        The equations.
    """

    def __init__(self, balance: EquilibriumEquations) -> None:
        self._balance = balance
        # Large arrays that are made again cost more than what is written into them.
        n = balance.system.pattern.n_values + 1
        self._values, self._work, self._middle, self._stress, self._last = np.empty((5, n))
        self._q: Vector | None = None

    def exact(self, state: StaticState, load: float) -> Vector:
        """Return the values of the tangent stiffness."""
        return self._balance.stiffness(state, load, self._values)

    def extrapolated(self, state: StaticState, load: float) -> Vector:
        """Return those with the stress extrapolated from the last state that was asked for."""
        balance, work = self._balance, self._work
        stress = balance.stress_stiffness(state.q, self._stress, work)
        if balance.plain:  # `work` holds the rest of it
            values = self._values[: len(stress)]
            np.add(stress, work[: len(stress)], out=values)
        else:
            values = self.exact(state, load)
        if self._q is not None:
            middle = balance.stress_stiffness(0.5 * (self._q + state.q), self._middle, work)
            middle *= 4.0
            values += middle
            last = self._last[: len(stress)]
            last += stress
            last *= 2.0
            values -= last
        self._q = state.q
        self._stress, self._last = self._last, self._stress
        return values
