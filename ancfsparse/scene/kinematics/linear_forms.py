"""Terms of constraints: linear forms of the coordinates, and prescribed right-hand sides."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ancfsparse.array_types import Integers, Vector

if TYPE_CHECKING:
    from ancfsparse.scene.records.prescribed_motion import PrescribedMotion


COMPONENT_TOLERANCE = 1e-12  # of unit vectors that are equal
LINEAR = -1  # in place of the second coordinate of a linear term


class RheonomicTerm(NamedTuple):
    """The prescribed right-hand side of a rheonomic constraint ``g(q) = s(t)``.

    Attributes
    ----------
    motion : PrescribedMotion
        The prescribed motion.
    column : int
        Component of the motion.
    scale : callable, optional
        Maps its value and rates [m, m/s, m/s2], (k, 3), to s, s' and s''; the default is the
        identity.
    """

    motion: PrescribedMotion
    column: int
    scale: Callable[[Vector], Vector] | None = None


@dataclass(frozen=True)
class LinearForm:
    """A vector that is linear in coordinates: ``constant + sum of w q``, component by component.

    Attributes
    ----------
    terms : tuple of dict from int to float
        Weight of each coordinate, for every component.
    constant : (dim,) float
        Constant part.
    coordinates : (dim,) int or None
        The coordinates that are its components, if it is just these.
    """

    terms: tuple[dict[int, float], ...]
    constant: Vector
    coordinates: Integers | None = None

    @classmethod
    def fixed(cls, vector: Vector) -> LinearForm:
        """Return a constant vector."""
        return cls(tuple({} for _ in vector), np.asarray(vector, dtype=float))

    @classmethod
    def of(cls, vectors: Sequence[Integers], weights: Sequence[float]) -> LinearForm:
        """Return a weighted sum of vectors of coordinates."""
        used = [(v, w) for v, w in zip(vectors, weights, strict=True) if w != 0.0]
        dim = len(vectors[0])
        terms = tuple({int(v[d]): float(w) for v, w in used} for d in range(dim))
        alone = len(used) == 1 and used[0][1] == 1.0
        return cls(terms, np.zeros(dim), used[0][0] if alone else None)

    def rotated(self) -> LinearForm:
        """Return the vector rotated by +90 degrees in the plane."""
        x, y = self.terms
        constant = np.array([-self.constant[1], self.constant[0]])
        return LinearForm(({k: -w for k, w in y.items()}, x), constant)

    def component(self, along: Vector) -> Integers | None:
        """Return the coordinate (1,) that is the component along a unit vector, or None."""
        d = int(np.argmax(np.abs(along)))
        if self.coordinates is None or np.abs(np.delete(along, d)).max() > COMPONENT_TOLERANCE:
            return None
        return self.coordinates[[d]]

    def __sub__(self, other: LinearForm) -> LinearForm:
        """Return the difference of two vectors."""
        return linear_combination(self, 1.0, other, -1.0)


def linear_combination(one: LinearForm, a: float, other: LinearForm, b: float) -> LinearForm:
    """Return ``a one + b other``."""
    terms = []
    for first, second in zip(one.terms, other.terms, strict=True):
        weights = {k: a * w for k, w in first.items()}
        for k, w in second.items():
            weights[k] = weights.get(k, 0.0) + b * w
        terms.append(weights)
    return LinearForm(tuple(terms), a * one.constant + b * other.constant)
