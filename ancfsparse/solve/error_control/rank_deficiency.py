"""Places where constraints lose rank, recognised in the steps of a motion that has crossed them.

Multipliers have a pole there, or are lost in rounding: between smooth values stand some that are
far from them.
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import RedundantConstraintsWarning
from ancfsparse.solve.initial_conditions.redundant_constraints import count_near_dependent
from ancfsparse.solve.stepping import interpolation
from ancfsparse.system import System

Vector = NDArray[np.float64]

# States between two steps at which the rank is looked at, and how much more independent constraints
# are at the farther end of a step.
BETWEEN, FAR = 32, 4.0
SHARES = np.linspace(0.0, 1.0, BETWEEN + 1)[:, None]
# Steps of a motion in which it is looked at, at most.
MOST_LOOKS = 16
# Steps before one that shows a place in which an earlier one is sought.
MOST_STEPS = 1024
# Second differences of multipliers that stand out, over those some steps away; and their least
# size, in energy, beside the largest of all multipliers.
OUT, AWAY, LEAST = 10.0, (3, 4), 1e-6


class RankDeficiency:
    """Looks for such places in the steps of motions of one scene.

    Parameters
    ----------
    system : System
        What moves.
    sizes : (m,) float or None
        Sizes of the terms of the equations [m]; None where nothing is looked for.

    Attributes
    ----------
    time : float or None
        Where constraints first came to depend on one another in the last motion that shows it [s].
    """

    def __init__(self, system: System, sizes: Vector | None) -> None:
        self._system, self._sizes = system, sizes
        self.time: float | None = None
        self._bodies = any(body.masses is not None for body in system.scene.bodies)
        self._looks = MOST_LOOKS  # that are left in this motion
        self._last: tuple[Vector, ...] | None = None

    def begin(self) -> None:
        """Begin with another motion."""
        self._looks, self._last = MOST_LOOKS, None

    def look(self, t: Vector, q: Vector, v: Vector, lam: Vector) -> None:
        """Look at equal steps from t[0] on, which go on from those of the last call."""
        if not self._looks or not self._bodies or self._sizes is None:
            return
        tables: tuple[Vector, ...] = t, q, v, lam
        if self._last is not None:
            tables = tuple(np.concatenate(pair) for pair in zip(self._last, tables, strict=True))
        t, q, v, lam = tables
        # The last steps are looked at with those to come.
        self._last = tuple(table[-2 * (AWAY[-1] + 1) : -1].copy() for table in tables)
        for k in _outliers(lam * self._sizes)[: self._looks]:
            self._looks -= 1
            for step in (slice(k - 1, k + 1), slice(k, k + 2)):
                place = self._place(t[step], q[step], v[step])
                if place is not None:
                    before = self._earlier(t[: k + 1], q[: k + 1], v[: k + 1])
                    self.time, self._looks = place if before is None else before, 0
                    return

    def warn(self) -> None:
        """Warn that the estimated error may be too small, if there was such a place.

        Warns
        -----
        RedundantConstraintsWarning
            With its time.
        """
        if self.time is not None:
            warnings.warn(
                f"constraints came to depend on one another near t = {self.time:.6g} s, where "
                "explicit methods lose their order: from then on the error is estimated by the "
                "distances of three motions, and may be larger.  GeneralizedAlpha(0.9) takes "
                "shorter steps there, at a higher cost",
                RedundantConstraintsWarning,
                stacklevel=6,
            )

    def _earlier(self, t: Vector, q: Vector, v: Vector) -> float | None:
        """Return the first place in the last of some steps, which multipliers stepped over [s]."""
        first = self._dependent(self._system.q0, 0.0)
        for k in range(max(0, len(t) - MOST_STEPS), len(t) - 1):
            step = slice(k, k + 2)
            near = BETWEEN * self._turn(
                interpolation.interpolate_cubic(SHARES, t[k + 1] - t[k], *q[step], *v[step])
            )
            if max(self._dependent(end, near) for end in q[step]) > first:
                place = self._place(t[step], q[step], v[step])
                if place is not None:
                    return place
        return None

    def _place(self, t: Vector, q: Vector, v: Vector) -> float | None:
        """Return when more constraints than at the start are dependent between two states [s]."""
        states = interpolation.interpolate_cubic(SHARES, t[1] - t[0], *q, *v)
        turn = self._turn(states)
        # Constraints that are so at both ends are so for longer, by the shape of the mechanism.
        first = self._dependent(self._system.q0, turn)
        if all(self._dependent(end, FAR * turn) > first for end in q):
            return None
        lost = [self._dependent(x, turn) > first for x in states]
        return float(t[0] + SHARES[lost].mean() * (t[1] - t[0])) if any(lost) else None

    def _turn(self, states: Vector) -> float:
        """Return by how much vectors turn from one state to the next, the most."""
        slopes = np.ones(states.shape[1], dtype=bool)
        slopes[self._system.positions] = False
        return float(np.max(np.abs(np.diff(states[:, slopes], axis=0)), initial=0.0))

    def _dependent(self, q: Vector, share: float) -> int:
        return count_near_dependent(self._system, q, share)


def _outliers(energy: Vector) -> NDArray[np.intp]:
    """Return at which steps a multiplier is far from those before and after."""
    far = AWAY[-1]
    bend = np.abs(np.diff(energy, 2, axis=0))  # of the second row on
    n = len(bend) - 2 * far
    if n <= 0:
        return np.zeros(0, dtype=np.intp)
    middle = bend[far : far + n]
    around = [bend[far + shift : far + shift + n] for away in AWAY for shift in (away, -away)]
    out = (middle > OUT * np.max(around, axis=0)) & (middle > LEAST * np.max(np.abs(energy)))
    return np.flatnonzero(out.any(axis=1)) + far + 1
