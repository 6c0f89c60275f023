"""States of a motion at the times asked for, taken from its steps, and how far two differ."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.solve.stepping import interpolation
from ancfsparse.system import System

Vector = NDArray[np.float64]


@dataclass
class SampledStates:
    """States at the times asked for.

    Attributes
    ----------
    t : (k,) float
        Times [s].
    q, v, a : (k, n_all) float
        Coordinates and their rates.
    lam : (k, m) float
        Multipliers.
    rows : int
        How many of them are there by now.
    """

    t: Vector
    q: Vector
    v: Vector
    a: Vector
    lam: Vector
    rows: int = field(default=0)

    @classmethod
    def empty(cls, t: Vector, n: int, m: int) -> SampledStates:
        """Return room for states with so many coordinates and multipliers."""
        q, v, a, lam = (np.empty((len(t), width)) for width in (n, n, n, m))
        return cls(t, q, v, a, lam)

    def begin(self, q: Vector, v: Vector, a: Vector, lam: Vector) -> None:
        """Take the first state."""
        for table, row in zip((self.q, self.v, self.a, self.lam), (q, v, a, lam), strict=True):
            table[0] = row
        self.rows = 1

    def fill(
        self,
        t: Vector,
        q: Vector,
        v: Vector,
        a: Vector,
        lam: Vector,
        *,
        resolved: bool = False,
    ) -> slice:
        """Interpolate the states asked for in (t[0], t[-1]] from accepted steps.

        Coordinates and velocities are cubic Hermite polynomials between steps; accelerations and
        multipliers are linear.  Of equal steps that resolve all vibrations, coordinates and
        velocities are polynomials through several steps.  Returns the rows that were filled.
        """
        span = slice(self.rows, int(np.searchsorted(self.t, t[-1], side="right")))
        if span.start >= span.stop:
            return span
        k = np.clip(np.searchsorted(t, self.t[span], side="left") - 1, 0, len(t) - 2)
        h = t[k + 1] - t[k]
        share = np.clip((self.t[span] - t[k]) / h, 0.0, 1.0)
        s, ends = share[:, None], (q[k], q[k + 1], v[k], v[k + 1], a[k], a[k + 1])
        if resolved:
            step = float(t[-1] - t[0]) / (len(t) - 1)
            self.q[span], self.v[span] = interpolation.smooth(share, k, step, q, v, a)
        else:
            self.q[span] = interpolation.cubic(s, h[:, None], *ends[:4])
            self.v[span] = interpolation.cubic(s, h[:, None], *ends[2:])
        self.a[span] = (1.0 - s) * a[k] + s * a[k + 1]
        self.lam[span] = (1.0 - s) * lam[k] + s * lam[k + 1]
        self.rows = span.stop
        return span

    def extrapolated(self, coarse: SampledStates, weight: float) -> SampledStates:
        """Return these states and so many times what they are off from those of another run."""
        pairs = ((self.q, coarse.q), (self.v, coarse.v), (self.a, coarse.a), (self.lam, coarse.lam))
        q, v, a, lam = (x + weight * (x - y) for x, y in pairs)
        return SampledStates(self.t, q, v, a, lam, self.rows)


# Rounding of a motion over that of one step and the root of their number, at most; and the share of
# its way after which a motion is under way.
ROUNDING, UNDER_WAY = 100.0, 0.01


def largest_place(system: System) -> float:
    """Return the largest coordinate of a node at the start, which positions are rounded by [m]."""
    return float(np.max(np.abs(system.q0[system.positions])))


def distance(system: System, one: SampledStates, other: SampledStates) -> float:
    """Return the largest distance of a node from itself in another motion [m]."""
    return float(np.max(_distances(system, one.q, other.q), initial=0.0))


def grew_from_rounding(
    system: System, one: SampledStates, other: SampledStates, steps: int
) -> bool:
    """Whether two runs differ by rounding alone when their motion is already under way.

    Errors of steps begin with the motion, unless loads change suddenly later on.
    """
    apart = _distances(system, one.q, other.q)
    way = _distances(system, one.q, np.broadcast_to(one.q[:1], one.q.shape))
    rounding = ROUNDING * np.finfo(float).eps * math.sqrt(steps) * largest_place(system)
    return bool(np.any(apart[way > UNDER_WAY * np.max(way)] <= rounding))


def _distances(system: System, one: Vector, other: Vector) -> Vector:
    """Return the largest distance of a node from itself in another motion, (k,) [m]."""
    pairs = zip(one[:, None], other[:, None], strict=True)
    squares = [max(np.max(np.sum(x**2, axis=1)) for x in moves(system, *pair)) for pair in pairs]
    return np.sqrt(squares)


def moves(system: System, one: Vector, other: Vector) -> Iterator[Vector]:
    """Yield how far nodes are apart in the coordinates of two motions, (n, dim) at a time [m].

    A rigid body turns about its node, so points on its axes count too, at its size from the origin.
    """
    where = system.positions.reshape(-1, system.dim)
    rigid = [each for each in system.scene.bodies if not isinstance(each, ElasticBody)]
    frames = [(system.rows(body.node(0))[0], body.size) for body in rigid]
    for a, b in zip(one, other, strict=True):
        yield a[where] - b[where]
        for rows, size in frames:
            origin, *axes = (a[rows] - b[rows]).reshape(-1, system.dim)
            reach = size * np.array(axes)
            yield np.concatenate([origin + reach, origin - reach])
