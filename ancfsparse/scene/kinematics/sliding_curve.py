"""Constraints of a point that slides along the axis of a beam.

With d = p - r(s*) from the nearest point of the axis to a point p, the equations are n . d = 0 for
the normals n of the axis at s*.  s* is not an unknown: d is normal to r', so the variation of s*
does not contribute to the gradient ``n . (dp - S(s*) dq)``.  The axis has a continuous tangent, so
the gradient is continuous where the point passes from one element to the next.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ancfsparse.array_types import Integers, Vector
from ancfsparse.kernels.hermite import position_weights, slope_weights

SEARCH_POINTS = 4  # per element
MAX_NEWTON_STEPS = 60


@dataclass(frozen=True)
class SlidingCurve:
    """The axis of a beam and a point that slides along it.

    Attributes
    ----------
    ends : (n_e, 4, dim) int32
        Indices of the position and slope of both ends of every element.
    lengths : (n_e,) float
        Lengths of the elements [m].
    point : (dim, p) int32
        Indices of the coordinates of the point.
    weights : (p,) float
        Weights of these coordinates.
    lateral : (dim,) float
        Direction normal to the axis that makes the normals unique in space.
    """

    ends: Integers
    lengths: Vector
    point: Integers
    weights: Vector
    lateral: Vector

    def placed(self, final: Integers) -> SlidingCurve:
        """Return the same with renumbered coordinates."""
        return replace(self, ends=final[self.ends], point=final[self.point])

    @property
    def arcs(self) -> Vector:
        """Arc coordinates of the ends of the elements, (n_e + 1,) [m]."""
        return np.concatenate([[0.0], np.cumsum(self.lengths)])

    def nearest(self, q: Vector) -> float:
        """Return the arc coordinate of the nearest point of the axis [m]."""
        p, arcs = q[self.point] @ self.weights, self.arcs
        xi = np.arange(SEARCH_POINTS + 1) / SEARCH_POINTS
        weights = position_weights(xi[None, :], self.lengths[:, None])
        distance = np.linalg.norm(np.einsum("exi,eid->exd", weights, q[self.ends]) - p, axis=2)
        e, k = np.unravel_index(int(np.argmin(distance)), distance.shape)
        s = float(arcs[e] + xi[k] * self.lengths[e])
        for _ in range(MAX_NEWTON_STEPS):
            _, r, slope, bend = self.at(q, s)
            residual = float(slope @ (p - r))
            square = float(slope @ slope)
            change = residual / max(square - float(bend @ (p - r)), 0.1 * square)
            limit = 0.5 * float(self.lengths.min())
            s += float(np.clip(change, -limit, limit))
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
        """Return the element at an arc coordinate, beyond an end the last one, and xi in it."""
        e = int(np.clip(np.searchsorted(self.arcs, s, side="right") - 1, 0, len(self.lengths) - 1))
        return e, (s - float(self.arcs[e])) / float(self.lengths[e])

    def normals(self, slope: Vector) -> Vector:
        """Return the normals, (dim - 1, dim), as ``normals_of`` in _sliding_joints.pyx does."""
        t = slope / np.linalg.norm(slope)
        if len(t) == 2:
            return np.array([[-t[1], t[0]]])
        one = self.lateral - (self.lateral @ t) * t
        one /= np.linalg.norm(one)
        return np.array([one, np.cross(t, one)])


@dataclass(frozen=True)
class CurveOffset:
    """The offset of a point from the axis along one of the normals, a term of an equation.

    Attributes
    ----------
    curve : SlidingCurve
        The axis and the point.
    k : int
        Number of the normal.
    """

    curve: SlidingCurve
    k: int
    is_angle: ClassVar[bool] = False
    is_sliding: ClassVar[bool] = True

    @property
    def place(self) -> Integers:
        """Indices of all coordinates that it may depend on."""
        return np.unique(np.concatenate([self.curve.ends.ravel(), self.curve.point.ravel()]))

    def placed(self, final: Integers) -> CurveOffset:
        """Return the same with renumbered coordinates."""
        return CurveOffset(self.curve.placed(final), self.k)

    def entries(self, q: Vector) -> tuple[Integers, Vector]:
        """Return the indices of the coordinates in a state, and the derivatives by them."""
        curve = self.curve
        s = curve.nearest(q)
        e, _, slope, _ = curve.at(q, s)
        normal = curve.normals(slope)[self.k]
        axis_weights = position_weights(curve.element(s)[1], curve.lengths[e])
        indices = np.concatenate([curve.point.T.ravel(), curve.ends[e].ravel()])
        weights = np.concatenate([curve.weights, -axis_weights])
        return indices, np.outer(weights, normal).ravel()

    def push(self, out: Vector, q: Vector, factor: Vector) -> None:
        """Add the gradients in states q (k, n_all), times factors (k,), to `out`."""
        for row, state, scale in zip(out, q, factor, strict=True):
            indices, values = self.entries(state)
            np.add.at(row, indices, scale * values)

    def bending(self, q: Vector, v: Vector) -> float:
        """Return ``v . h_qq . v`` in a state where the point is on the axis [m/s2]."""
        curve = self.curve
        s = curve.nearest(q)
        e, _, slope, bend = curve.at(q, s)
        normal = curve.normals(slope)[self.k]
        xi, length = curve.element(s)[1], float(curve.lengths[e])
        difference = (
            v[curve.point] @ curve.weights - position_weights(xi, length) @ v[curve.ends[e]]
        )
        along = float(slope @ difference) / float(slope @ slope)
        turning = float(normal @ (slope_weights(xi, length) @ v[curve.ends[e]]))
        return -2.0 * turning * along - float(normal @ bend) * along**2

    def size(self, q: Vector) -> float:
        """Return the magnitude of its summands, which determines the rounding error [m]."""
        return float(np.max(np.abs(q[self.curve.ends])) + np.max(np.abs(q[self.curve.point])))

    def reach(self) -> Integers:
        """Return the indices of coupled coordinates, (n_e, p dim + 4 dim), a row per element."""
        n = len(self.curve.ends)
        point = np.broadcast_to(self.curve.point.T.ravel(), (n, self.curve.point.size))
        return np.concatenate([point, self.curve.ends.reshape(n, -1)], axis=1).astype(np.int32)
