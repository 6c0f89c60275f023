"""States of a motion at given times, interpolated from its steps, and their differences."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.results.data.interpolation import interpolate_cubic
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.solve.stepping import interpolation
from ancfsparse.system import System


@dataclass
class SampledStates:
    """States at given times.

    Attributes
    ----------
    t : (k,) float
        Times [s].
    q, v, a : (k, n_all) float
        Coordinates and their rates.
    lam : (k, m) float
        Multipliers.
    history : (k, h) float
        History variables.
    rows : int
        Number of states that are known.
    """

    t: Vector
    q: Vector
    v: Vector
    a: Vector
    lam: Vector
    history: Vector
    rows: int = field(default=0)

    @classmethod
    def empty(cls, t: Vector, n: int, m: int, h: int = 0) -> SampledStates:
        """Return empty states with numbers of coordinates, multipliers and history variables."""
        q, v, a, lam, history = (np.empty((len(t), width)) for width in (n, n, n, m, h))
        return cls(t, q, v, a, lam, history)

    @property
    def tables(self) -> tuple[Vector, Vector, Vector, Vector, Vector]:
        """The states without their times."""
        return self.q, self.v, self.a, self.lam, self.history

    def begin(self, *state: Vector) -> None:
        """Set the first state, with its history variables if there are any."""
        for table, row in zip(self.tables, state, strict=False):
            table[0] = row
        self.rows = 1

    def fill(
        self,
        t: Vector,
        q: Vector,
        v: Vector,
        a: Vector,
        lam: Vector,
        history: Vector | None = None,
        *,
        resolved: bool = False,
        has_means: bool = False,
    ) -> slice:
        """Interpolate the states in (t[0], t[-1]] from accepted steps; return their rows.

        Coordinates and velocities are cubic Hermite polynomials between steps; accelerations,
        multipliers and history variables are linear.  If equal steps resolve all vibrations,
        coordinates and velocities are polynomials through several steps.  Accelerations and
        multipliers may be means over the step before, except at the start of the motion: then they
        are linear between the middles of steps.
        """
        span = slice(self.rows, int(np.searchsorted(self.t, t[-1], side="right")))
        if span.start >= span.stop:
            return span
        k = np.clip(np.searchsorted(t, self.t[span], side="left") - 1, 0, len(t) - 2)
        h = t[k + 1] - t[k]
        fraction = np.clip((self.t[span] - t[k]) / h, 0.0, 1.0)
        s, ends = fraction[:, None], (q[k], q[k + 1], v[k], v[k + 1], a[k], a[k + 1])
        if resolved:
            step = float(t[-1] - t[0]) / (len(t) - 1)
            self.q[span], self.v[span] = interpolation.interpolate_smooth(
                fraction, k, step, q, v, a
            )
        else:
            self.q[span] = interpolate_cubic(s, h[:, None], *ends[:4])
            self.v[span] = interpolate_cubic(s, h[:, None], *ends[2:])
        of_means = s + 0.5 if has_means else s
        if has_means and t[0] == self.t[0]:
            of_means[k == 0] = 2.0 * s[k == 0]
        weights = of_means, of_means, s
        for table, rows, x in zip(self.tables[2:], (a, lam, history), weights, strict=True):
            if rows is not None:
                table[span] = (1.0 - x) * rows[k] + x * rows[k + 1]
        self.rows = span.stop
        return span

    def extrapolated(self, coarse: SampledStates, weight: float) -> SampledStates:
        """Return these states plus a multiple of their difference from those of another run."""
        pairs = zip(self.tables, coarse.tables, strict=True)
        q, v, a, lam, history = (x + weight * (x - y) for x, y in pairs)
        return SampledStates(self.t, q, v, a, lam, history, self.rows)


MAX_STEPS_AT_ONCE = 1000  # steps between two interpolations
MAX_COORDINATES_AT_ONCE = 4_000_000  # coordinates of all of them
MAX_ROUNDING_UNITS = 100.0  # of a motion, over that of a step and the root of the number of steps
MIN_MOTION_RATIO = 0.01  # of the largest displacement, from which a motion has begun


def steps_at_once(n: int) -> int:
    """Return a number of steps with n coordinates that are taken before their interpolation."""
    return max(1, min(MAX_STEPS_AT_ONCE, MAX_COORDINATES_AT_ONCE // n))


def largest_coordinate(system: System) -> float:
    """Return the largest coordinate of a node at the start, the scale of rounding [m]."""
    return float(np.max(np.abs(system.q0[system.positions])))


def distance(system: System, one: SampledStates, other: SampledStates) -> float:
    """Return the largest distance of a node between two motions [m]."""
    return float(np.max(distances(system, one.q, other.q), initial=0.0))


def differs_by_rounding(
    system: System, one: SampledStates, other: SampledStates, steps: int
) -> bool:
    """Return whether two runs differ by rounding alone after the motion has begun.

    Errors of steps begin with the motion, unless loads change suddenly later.
    """
    difference = distances(system, one.q, other.q)
    displacement = distances(system, one.q, np.broadcast_to(one.q[:1], one.q.shape))
    rounding = (
        MAX_ROUNDING_UNITS * np.finfo(float).eps * math.sqrt(steps) * largest_coordinate(system)
    )
    has_begun = displacement > MIN_MOTION_RATIO * np.max(displacement)
    return bool(np.any(difference[has_begun] <= rounding))


def distances(system: System, one: Vector, other: Vector) -> Vector:
    """Return the largest distance of a node between two motions at each time, (k,) [m]."""
    squares = [np.sum(x**2, axis=2).max(axis=1) for x in nodal_differences(system, one, other)]
    return np.asarray(np.sqrt(np.concatenate(squares)))


def nodal_differences(system: System, one: Vector, other: Vector) -> Iterator[Vector]:
    """Yield the differences of nodal positions of two motions at successive times, (k, n, dim) [m].

    A rigid body rotates about its node, so points on its axes at its radius of gyration count too.
    """
    positions = system.positions.reshape(-1, system.dim)
    rigid = [body for body in system.scene.bodies if not isinstance(body, ElasticBody)]
    frames = [(system.rows(body.node(0))[0], body.size) for body in rigid]
    for a, b in _blocks(one, other):
        parts = [a[:, positions] - b[:, positions]]
        for rows, size in frames:
            frame = (a[:, rows] - b[:, rows]).reshape(len(a), -1, system.dim)
            origin, reach = frame[:, :1], size * frame[:, 1:]
            parts += [origin + reach, origin - reach]
        yield np.concatenate(parts, axis=1)


def slope_differences(system: System, one: Vector, other: Vector) -> Iterator[Vector]:
    """Yield the largest difference of a slope between two motions at each time, (k,) [m].

    One table for each slope of each body, weighted by the root of its mass over that of positions.
    """
    mass = np.zeros(system.n_all)
    mass[: system.n_free] = system.mass_diagonal
    for places, kind in zip(system.places, system.kinds, strict=True):
        of_positions = np.max(mass[places[:, kind.columns("r")]])
        for name in kind.vectors[1:] if of_positions > 0.0 else ():
            slopes = places[:, kind.columns(name)]
            weights = np.sqrt(mass[slopes] / of_positions)
            weighted = (weights * (a[:, slopes] - b[:, slopes]) for a, b in _blocks(one, other))
            yield np.concatenate([np.linalg.norm(x, axis=2).max(axis=1) for x in weighted])


def _blocks(one: Vector, other: Vector) -> Iterator[tuple[Vector, Vector]]:
    """Yield states of two motions at successive times, as many as are interpolated at once."""
    rows = steps_at_once(one.shape[1])
    for k in range(0, len(one), rows):
        yield one[k : k + rows], other[k : k + rows]
