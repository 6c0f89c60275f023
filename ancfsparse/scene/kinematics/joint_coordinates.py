"""Joint coordinates: an angle, a distance, or a displacement along an axis.

A joint coordinate is a function h of two products of vectors A, B, C that are linear in q,

    x = A . B,   y = A . C,

so its derivatives, and the discrete gradient of the energy-momentum method, follow from h.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ancfsparse.array_types import Integers, Vector

if TYPE_CHECKING:
    from ancfsparse.scene.kinematics.linear_forms import LinearForm


# Functions h, in the order of ``h_of`` in coordinate_functions.pxi: atan2(y, x), sqrt(x) and x.
ANGLE, LENGTH, ALONG = range(3)


@dataclass(frozen=True)
class JointCoordinate:
    """A scalar function of the coordinates q.

    Attributes
    ----------
    kind : int
        `ANGLE` [rad], `LENGTH` [m] or `ALONG` [m].
    place : (m,) int32
        Indices of the coordinates.
    weight : (m, 9) float
        Their weights in the three components of A, B and C.
    constant : (9,) float
        Constant parts of these components.
    """

    kind: int
    place: Integers
    weight: Vector
    constant: Vector
    is_sliding: ClassVar[bool] = False

    @classmethod
    def of(cls, kind: int, vectors: Sequence[LinearForm]) -> JointCoordinate:
        """Build the coordinate from A, B and C, of which missing ones are zero."""
        used = sorted({k for vector in vectors for terms in vector.terms for k in terms})
        column = {k: i for i, k in enumerate(used)}
        weight, constant = np.zeros((len(used), 9)), np.zeros(9)
        for n, vector in enumerate(vectors):
            for d, terms in enumerate(vector.terms):
                constant[3 * n + d] = vector.constant[d]
                for k, w in terms.items():
                    weight[column[k], 3 * n + d] += w
        return cls(kind, np.array(used, dtype=np.int32), weight, constant)

    def placed(self, final: Integers) -> JointCoordinate:
        """Return the function of renumbered coordinates, of which several may coincide."""
        place, inverse = np.unique(final[self.place], return_inverse=True)
        weight = np.zeros((len(place), 9))
        np.add.at(weight, inverse, self.weight)
        return replace(self, place=place.astype(np.int32), weight=weight)

    @property
    def is_angle(self) -> bool:
        """True for an angle [rad], False for a length [m]."""
        return self.kind == ANGLE

    def values(self, q: Vector) -> Vector:
        """Return the values in states q (k, n_all), (k,) [rad or m]; angles are continuous."""
        x, y = self._products(self._vectors(q))
        if self.kind == LENGTH:
            return np.asarray(np.sqrt(x))
        return np.asarray(np.unwrap(np.arctan2(y, x)) if self.kind == ANGLE else x)

    def rates(self, q: Vector, v: Vector) -> Vector:
        """Return the rates in states and velocities (k, n_all), (k,) [rad/s or m/s]."""
        return np.asarray(np.einsum("ki,ki->k", self.gradients(q), v[:, self.place]))

    def gradients(self, q: Vector) -> Vector:
        """Return the derivatives by the coordinates in states q (k, n_all), (k, m)."""
        vectors = self._vectors(q)
        h_x, h_y = (slope[:, None] for slope in self._slopes(*self._products(vectors)))
        a, b, c = vectors[:, :3], vectors[:, 3:6], vectors[:, 6:]
        by_vectors = np.concatenate([h_x * b + h_y * c, h_x * a, h_y * a], axis=1)
        return np.asarray(by_vectors @ self.weight.T)

    def entries(self, q: Vector) -> tuple[Integers, Vector]:
        """Return the indices of the coordinates in a state, and the derivatives by them."""
        return self.place, self.gradients(q[None])[0]

    def reach(self) -> Integers:
        """Return the indices of coupled coordinates, one row, (1, m)."""
        return self.place[None]

    def push(self, out: Vector, q: Vector, factor: Vector) -> None:
        """Add the gradients in states q (k, n_all), times factors (k,), to `out`."""
        out[:, self.place] += factor[:, None] * self.gradients(q)

    def bending(self, q: Vector, v: Vector) -> float:
        """Return ``v . h_qq . v`` in a state (n_all,) [rad/s2 or m/s2]."""
        vectors = self._vectors(q[None])[0]
        rates = v[self.place] @ self.weight
        (a, b, c), (da, db, dc) = vectors.reshape(3, 3), rates.reshape(3, 3)
        x, y = (float(product[0]) for product in self._products(vectors[None]))
        dx, dy = float(a @ db + b @ da), float(a @ dc + c @ da)
        h_x, h_y = (float(slope[0]) for slope in self._slopes(np.array([x]), np.array([y])))
        h_xx = h_xy = h_yy = 0.0
        if self.kind == LENGTH:
            h_xx = -0.25 * x**-1.5
        elif self.kind == ANGLE:
            square = (x * x + y * y) ** 2
            h_xx, h_xy = 2.0 * x * y / square, (y * y - x * x) / square
            h_yy = -h_xx
        curvature = h_xx * dx * dx + 2.0 * h_xy * dx * dy + h_yy * dy * dy
        return curvature + 2.0 * float(da @ (h_x * db + h_y * dc))

    def size(self, q: Vector) -> float:
        """Return the magnitude of its summands, which determines the rounding error."""
        if self.kind == ANGLE:
            return 1.0
        part_of_a = np.abs(q[self.place]) @ np.abs(self.weight[:, :3])
        return float(np.sum(np.abs(self.constant[:3]) + part_of_a))

    def _vectors(self, q: Vector) -> Vector:
        return np.asarray(q[:, self.place] @ self.weight + self.constant)

    @staticmethod
    def _products(vectors: Vector) -> tuple[Vector, Vector]:
        a = vectors[:, :3]
        x, y = (np.einsum("ki,ki->k", a, other) for other in (vectors[:, 3:6], vectors[:, 6:]))
        return x, y

    def _slopes(self, x: Vector, y: Vector) -> tuple[Vector, Vector]:
        """Return the derivatives of h by x and y."""
        if self.kind == LENGTH:
            return 0.5 / np.sqrt(x), np.zeros_like(x)
        if self.kind == ANGLE:
            square = x * x + y * y
            return -y / square, x / square
        return np.ones_like(x), np.zeros_like(x)
