"""Recognise singular configurations in the steps of a motion that has crossed them.

Multipliers have a pole there, or are lost in rounding, so some values are far from their smooth
neighbours.
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.errors import RedundantConstraintsWarning
from ancfsparse.results.data.interpolation import interpolate_cubic
from ancfsparse.solve.initial_conditions.redundant_constraints import count_near_dependent
from ancfsparse.system import System

N_INTERVALS = 32  # intervals between two steps at whose ends the rank is determined
# Independence of constraints at the farther end of a step over the nearer: without this bound,
# Andrews' mechanism seems to become singular.
MAX_DISTANCE_RATIO = 4.0
FRACTIONS = np.linspace(0.0, 1.0, N_INTERVALS + 1)[:, None]
MAX_EXAMINED = 16  # steps of a motion that are examined
# Steps before an examined one in which an earlier configuration is sought: without, the time in the
# warning about one linkage in 10 s is that of a later passage.
MAX_EARLIER_STEPS = 1024
MIN_OUTLIER_RATIO = 10.0  # second difference of a multiplier over its neighbours
NEIGHBOUR_DISTANCES = (3, 4)  # steps to these neighbours
MIN_ENERGY_RATIO = 1e-6  # such a difference over the largest of all multipliers, in energy


class RankDeficiency:
    """Search for singular configurations in the motions of one scene.

    Parameters
    ----------
    system : System
        The moving system.
    sizes : (m,) float or None
        Sizes of the terms of the equations [m]; None for no search.

    Attributes
    ----------
    time : float or None
        Time of the first one in the last motion that shows it [s].
    """

    def __init__(self, system: System, sizes: Vector | None) -> None:
        self._system, self._sizes = system, sizes
        self.time: float | None = None
        self._bodies = any(body.masses is not None for body in system.scene.bodies)
        self._remaining = MAX_EXAMINED  # steps to examine in this motion
        self._last: tuple[Vector, ...] | None = None

    def begin(self) -> None:
        """Begin another motion."""
        self._remaining, self._last = MAX_EXAMINED, None

    def examine(self, t: Vector, q: Vector, v: Vector, lam: Vector) -> None:
        """Examine equal steps from t[0] on, which continue the last call."""
        if not self._remaining or not self._bodies or self._sizes is None:
            return
        tables: tuple[Vector, ...] = t, q, v, lam
        if self._last is not None:
            tables = tuple(np.concatenate(pair) for pair in zip(self._last, tables, strict=True))
        t, q, v, lam = tables
        # The last steps are examined with those to come.
        self._last = tuple(
            table[-2 * (NEIGHBOUR_DISTANCES[-1] + 1) : -1].copy() for table in tables
        )
        for k in _outliers(lam * self._sizes)[: self._remaining]:
            self._remaining -= 1
            for step in (slice(k - 1, k + 1), slice(k, k + 2)):
                time = self._singular_time(t[step], q[step], v[step])
                if time is not None:
                    before = self._earlier(t[: k + 1], q[: k + 1], v[: k + 1])
                    self.time, self._remaining = time if before is None else before, 0
                    return

    def warn(self) -> None:
        """Warn that the estimated error may be too small because of a singular configuration.

        Warns
        -----
        RedundantConstraintsWarning
            With its time.
        """
        if self.time is not None:
            warnings.warn(
                f"constraints became dependent near t = {self.time:.6g} s, where explicit methods "
                "lose their order: from then on the error is estimated by the differences of three "
                "motions, and may be larger.  Compare GeneralizedAlpha(0.9), at a higher cost",
                RedundantConstraintsWarning,
                stacklevel=6,
            )

    def _earlier(self, t: Vector, q: Vector, v: Vector) -> float | None:
        """Return the first singular time in some steps, whose multipliers do not show it [s]."""
        first = self._dependent(self._system.q0, 0.0)
        for k in range(max(0, len(t) - MAX_EARLIER_STEPS), len(t) - 1):
            step = slice(k, k + 2)
            near = N_INTERVALS * self._turn(
                interpolate_cubic(FRACTIONS, t[k + 1] - t[k], *q[step], *v[step])
            )
            if max(self._dependent(end, near) for end in q[step]) > first:
                time = self._singular_time(t[step], q[step], v[step])
                if time is not None:
                    return time
        return None

    def _singular_time(self, t: Vector, q: Vector, v: Vector) -> float | None:
        """Return when more constraints than at the start are dependent between two states [s]."""
        states = interpolate_cubic(FRACTIONS, t[1] - t[0], *q, *v)
        turn = self._turn(states)
        # Constraints that are dependent at both ends are so by the shape of the mechanism.
        first = self._dependent(self._system.q0, turn)
        if all(self._dependent(end, MAX_DISTANCE_RATIO * turn) > first for end in q):
            return None
        is_singular = [self._dependent(x, turn) > first for x in states]
        if not any(is_singular):
            return None
        return float(t[0] + FRACTIONS[is_singular].mean() * (t[1] - t[0]))

    def _turn(self, states: Vector) -> float:
        """Return the largest rotation of a vector from one state to the next [rad]."""
        slopes = np.ones(states.shape[1], dtype=bool)
        slopes[self._system.positions] = False
        return float(np.max(np.abs(np.diff(states[:, slopes], axis=0)), initial=0.0))

    def _dependent(self, q: Vector, ratio: float) -> int:
        return count_near_dependent(self._system, q, ratio)


def _outliers(energy: Vector) -> NDArray[np.intp]:
    """Return the steps at which a multiplier is far from its values before and after."""
    margin = NEIGHBOUR_DISTANCES[-1]
    bend = np.abs(np.diff(energy, 2, axis=0))  # from the second row on
    n = len(bend) - 2 * margin
    if n <= 0:
        return np.zeros(0, dtype=np.intp)
    middle = bend[margin : margin + n]
    around = [
        bend[margin + shift : margin + shift + n]
        for away in NEIGHBOUR_DISTANCES
        for shift in (away, -away)
    ]
    is_large = middle > MIN_ENERGY_RATIO * np.max(np.abs(energy))
    out = (middle > MIN_OUTLIER_RATIO * np.max(around, axis=0)) & is_large
    return np.flatnonzero(out.any(axis=1)) + margin + 1
