"""Points on the axis of a beam that they slide along: how far they are off, and along what.

With d = p - r(s*) from the nearest point of the axis to a point p, the equations are n . d = 0 for
normals n of the axis there.  s* is no unknown: as d is at a right angle to r', it adds nothing to
the gradient ``n . (dp - S(s*) dq)``.  The axis has a continuous tangent, so the gradient does not
jump where the point passes from one element to the next.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ancfsparse.kernels.hermite import position_weights, slope_weights

Vector = NDArray[np.float64]
Integers = NDArray[np.int32]

# Places at which an element is looked at for the nearest one, and corrections from there.
LOOKS, MOST = 4, 60


@dataclass(frozen=True)
class SlidingCurve:
    """The axis of a beam and a point on it.

    Attributes
    ----------
    ends : (n_e, 4, dim) int32
        Per element the coordinates of position and slope of both ends.
    lengths : (n_e,) float
        Of the elements [m].
    point : (dim, p) int32
        Coordinates of the point.
    weights : (p,) float
        Their weights.
    lateral : (dim,) float
        In space a direction across the axis, that makes the normals unique.
    """

    ends: Integers
    lengths: Vector
    point: Integers
    weights: Vector
    lateral: Vector

    def placed(self, final: Integers) -> SlidingCurve:
        """Return it with other numbers of coordinates."""
        return replace(self, ends=final[self.ends], point=final[self.point])

    @property
    def arcs(self) -> Vector:
        """Where elements begin, and the end, (n_e + 1,) [m]."""
        return np.concatenate([[0.0], np.cumsum(self.lengths)])

    def nearest(self, q: Vector) -> float:
        """Return the arc coordinate of the point of the axis that is nearest [m]."""
        p, arcs = q[self.point] @ self.weights, self.arcs
        xi = np.arange(LOOKS + 1) / LOOKS
        scaled = position_weights(xi[None, :], self.lengths[:, None])
        apart = np.linalg.norm(np.einsum("exi,eid->exd", scaled, q[self.ends]) - p, axis=2)
        e, k = np.unravel_index(int(np.argmin(apart)), apart.shape)
        s = float(arcs[e] + xi[k] * self.lengths[e])
        for _ in range(MOST):
            _, r, slope, bend = self.at(q, s)
            away = float(slope @ (p - r))
            square = float(slope @ slope)
            change = away / max(square - float(bend @ (p - r)), 0.1 * square)
            reach = 0.5 * float(self.lengths.min())
            s += float(np.clip(change, -reach, reach))
            if abs(change) <= 4.0 * np.finfo(float).eps * arcs[-1]:
                break
        return s

    def at(self, q: Vector, s: float) -> tuple[int, Vector, Vector, Vector]:
        """Return element, position, slope and its derivative at an arc coordinate."""
        e, xi = self.element(s)
        length, ends = float(self.lengths[e]), q[self.ends[e]]
        bend = np.array([12 * xi - 6, length * (6 * xi - 4), 6 - 12 * xi, length * (6 * xi - 2)])
        return (
            e,
            position_weights(xi, length) @ ends,
            slope_weights(xi, length) @ ends,
            bend / length**2 @ ends,
        )

    def element(self, s: float) -> tuple[int, float]:
        """Return the element at an arc coordinate, beyond the ends the last, and xi in it."""
        e = int(np.clip(np.searchsorted(self.arcs, s, side="right") - 1, 0, len(self.lengths) - 1))
        return e, (s - float(self.arcs[e])) / float(self.lengths[e])

    def normals(self, slope: Vector) -> Vector:
        """Return the normals of the axis, (dim - 1, dim), as ``normals_of`` in _tracks.pyx."""
        t = slope / np.linalg.norm(slope)
        if len(t) == 2:
            return np.array([[-t[1], t[0]]])
        one = self.lateral - (self.lateral @ t) * t
        one /= np.linalg.norm(one)
        return np.array([one, np.cross(t, one)])


@dataclass(frozen=True)
class CurveOffset:
    """How far a point is off its track along one of the normals, as a term of an equation.

    Attributes
    ----------
    curve : SlidingCurve
        The axis and the point.
    k : int
        The normal.
    """

    track: SlidingCurve
    k: int
    is_angle: ClassVar[bool] = False
    is_sliding: ClassVar[bool] = True

    @property
    def place(self) -> Integers:
        """All coordinates that it may depend on."""
        return np.unique(np.concatenate([self.track.ends.ravel(), self.track.point.ravel()]))

    def placed(self, final: Integers) -> CurveOffset:
        """Return it with other numbers of coordinates."""
        return CurveOffset(self.track.placed(final), self.k)

    def entries(self, q: Vector) -> tuple[Integers, Vector]:
        """Return the coordinates that it depends on in a state, and its derivatives by them."""
        track = self.track
        s = track.nearest(q)
        e, _, slope, _ = track.at(q, s)
        normal = track.normals(slope)[self.k]
        here = position_weights(track.element(s)[1], track.lengths[e])
        places = np.concatenate([track.point.T.ravel(), track.ends[e].ravel()])
        weights = np.concatenate([track.weights, -here])
        return places, np.outer(weights, normal).ravel()

    def push(self, out: Vector, q: Vector, factor: Vector) -> None:
        """Add its gradients in states q (k, n_all), times a factor of each (k,), to `out`."""
        for row, state, each in zip(out, q, factor, strict=True):
            places, values = self.entries(state)
            np.add.at(row, places, each * values)

    def bending(self, q: Vector, v: Vector) -> float:
        """Return ``v . h_qq . v`` in a state where the point is on the axis [m/s2]."""
        track = self.track
        s = track.nearest(q)
        e, _, slope, bend = track.at(q, s)
        normal = track.normals(slope)[self.k]
        xi, length = track.element(s)[1], float(track.lengths[e])
        apart = v[track.point] @ track.weights - position_weights(xi, length) @ v[track.ends[e]]
        along = float(slope @ apart) / float(slope @ slope)
        turning = float(normal @ (slope_weights(xi, length) @ v[track.ends[e]]))
        return -2.0 * turning * along - float(normal @ bend) * along**2

    def size(self, q: Vector) -> float:
        """Return the size of the terms that it is added up from [m]."""
        return float(np.max(np.abs(q[self.track.ends])) + np.max(np.abs(q[self.track.point])))

    def reach(self) -> Integers:
        """Return which coordinates meet in it, a row for each element, (n_e, p dim + 4 dim)."""
        n = len(self.track.ends)
        point = np.broadcast_to(self.track.point.T.ravel(), (n, self.track.point.size))
        return np.concatenate([point, self.track.ends.reshape(n, -1)], axis=1).astype(np.int32)
