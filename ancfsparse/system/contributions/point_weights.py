"""Points of bodies as flat arrays: position = sum of weights q[indices], per direction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ancfsparse.array_types import Indices, Integers, Vector
from ancfsparse.scene import Point
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import matrix_unknowns
from ancfsparse.system.coordinates.discretization import Discretization


@dataclass(frozen=True)
class PointSums:
    """Weighted sums of coordinates, such as points or differences of points.

    Attributes
    ----------
    start : (n + 1,) int32
        Index of the first coordinate of each point.
    place : (dim, m) int32
        Indices in q, by direction.
    weight : (m,) float
        Weights, equal for all directions.
    """

    start: Integers
    place: Integers
    weight: Vector

    @classmethod
    def of(cls, system: Discretization, sums: Sequence[Sequence[tuple[float, Point]]]) -> PointSums:
        """Form sums of points with factors, with common coordinates combined."""
        start = [0]
        place: list[Integers] = [np.empty((system.dim, 0), dtype=np.int32)]
        weight: list[Vector] = [np.empty(0)]
        for terms in sums:
            parts = [(factor, system.point(node)) for factor, node in terms]
            where = np.concatenate([places for _, (places, _) in parts], axis=1)
            weights = np.concatenate([factor * each for factor, (_, each) in parts])
            _, first, own = np.unique(where[0], return_index=True, return_inverse=True)
            place.append(where[:, first])
            weight.append(np.bincount(own, weights).astype(np.float64))
            start.append(start[-1] + len(first))
        return cls(
            np.array(start, dtype=np.int32),
            np.concatenate(place, axis=1).astype(np.int32),
            np.concatenate(weight),
        )

    def cliques(self, n_free: int, together: bool = False) -> list[Indices]:
        """Return the unknowns of each sum, or of all together, (1, dim p)."""
        starts = self.start[[0, -1]] if together else self.start
        return [
            matrix_unknowns(np.array(self.place[:, begin:end].T.reshape(1, -1)), n_free)
            for begin, end in pairwise(starts)
        ]

    def slots(self, pattern: Pattern, n_free: int, together: bool = False) -> Integers:
        """Return the positions of the pairs of each sum in the matrix."""
        tables = (pattern.slots(each).ravel() for each in self.cliques(n_free, together))
        return np.concatenate([np.empty(0, dtype=np.int32), *tables])
