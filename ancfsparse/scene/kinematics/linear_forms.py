"""Vectors that are linear in the coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Coordinates = NDArray[np.int32]  # numbers given by a constraint builder

# A direction whose components are within this of those of a vector of a frame is that vector.
ALIGNED = 1e-12


@dataclass(frozen=True)
class LinearForm:
    """A vector that is linear in coordinates: ``constant + sum of w q``, component by component.

    Attributes
    ----------
    terms : tuple of dict from int to float
        Per component the weight of each coordinate.
    constant : (dim,) float
        The part that is fixed in space.
    whole : (dim,) int or None
        The coordinates that it consists of, if it is just these.
    """

    terms: tuple[dict[int, float], ...]
    constant: Vector
    whole: Coordinates | None = None

    @classmethod
    def fixed(cls, vector: Vector) -> LinearForm:
        """Return a vector that stays as it is."""
        return cls(tuple({} for _ in vector), np.asarray(vector, dtype=float))

    @classmethod
    def of(cls, vectors: Sequence[Coordinates], weights: Sequence[float]) -> LinearForm:
        """Return a weighted sum of vectors of coordinates."""
        used = [(v, w) for v, w in zip(vectors, weights, strict=True) if w != 0.0]
        dim = len(vectors[0])
        terms = tuple({int(v[d]): float(w) for v, w in used} for d in range(dim))
        alone = len(used) == 1 and used[0][1] == 1.0
        return cls(terms, np.zeros(dim), used[0][0] if alone else None)

    def turned(self) -> LinearForm:
        """Return the vector rotated by +90 degrees in the plane."""
        x, y = self.terms
        constant = np.array([-self.constant[1], self.constant[0]])
        return LinearForm(({k: -w for k, w in y.items()}, x), constant)

    def component(self, along: Vector) -> Coordinates | None:
        """Return the coordinate (1,) that is the component along a unit vector; None if none is."""
        d = int(np.argmax(np.abs(along)))
        if self.whole is None or np.abs(np.delete(along, d)).max() > ALIGNED:
            return None
        return self.whole[[d]]

    def __sub__(self, other: LinearForm) -> LinearForm:
        """Return the difference of two."""
        terms = []
        for mine, its in zip(self.terms, other.terms, strict=True):
            both = dict(mine)
            for k, w in its.items():
                both[k] = both.get(k, 0.0) - w
            terms.append(both)
        return LinearForm(tuple(terms), self.constant - other.constant)


def _mixed(one: LinearForm, a: float, other: LinearForm, b: float) -> LinearForm:
    terms = []
    for mine, its in zip(one.terms, other.terms, strict=True):
        both = {k: a * w for k, w in mine.items()}
        for k, w in its.items():
            both[k] = both.get(k, 0.0) + b * w
        terms.append(both)
    return LinearForm(tuple(terms), a * one.constant + b * other.constant)
