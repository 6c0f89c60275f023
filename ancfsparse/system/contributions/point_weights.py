"""Points of bodies as flat arrays: position = sum of weights q[indices], per direction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
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
        point = cache(system.point)  # the points of a body are in many sums
        start = [0]
        place: list[Integers] = [np.empty((system.dim, 0), dtype=np.int32)]
        weight: list[Vector] = [np.empty(0)]
        for terms in sums:
            parts = [(factor, point(node)) for factor, node in terms]
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

    def groups(self, largest: int, n_all: int) -> tuple[Integers, ...]:
        """Divide the sums into groups of at most `largest` with the same coordinates.

        Returns
        -------
        first : (g + 1,) int32
            First sum of each group, which are consecutive, and the end.
        term : (g + 1,) int32
            Row of the first coordinate of each group, and the end.
        place : (k, dim) int32
            Coordinates of the groups, in the order of the first sum of each.
        in_row : (g,) int32
            1 for sums of four vectors (x, y, z) in consecutive places, if four numbers can be
            read from the n_all coordinates at each.
        """
        sizes = np.diff(self.start)
        owner = np.repeat(np.arange(len(sizes)), sizes)
        joins = np.diff(sizes, prepend=0) == 0  # sums of as many coordinates as the one before
        before = np.arange(len(owner)) - sizes[owner]
        equal = joins[owner] & (self.place == self.place[:, before]).all(axis=0)
        starts = ~np.logical_and.reduceat(equal, self.start[:-1])
        order = np.arange(len(sizes))
        starts |= (order - np.maximum.accumulate(np.where(starts, order, 0))) % largest == 0
        first = np.flatnonzero(starts)
        term = np.cumsum([0, *sizes[first]], dtype=np.int32)
        place = np.ascontiguousarray(self.place[:, starts[owner]].T)
        in_row = (sizes[first] == 4) & (place.shape[1] == 3)
        consecutive = (np.diff(place, axis=1) == 1).all(axis=1) & (place[:, 0] < n_all - 3)
        in_row &= np.logical_and.reduceat(consecutive, term[:-1])
        return (
            np.append(first, len(sizes)).astype(np.int32),
            term,
            place,
            in_row.astype(np.int32),
        )

    def alike(self, groups: tuple[Integers, ...], numbers: Sequence[Vector]) -> Integers:
        """Return the first of the consecutive groups that are like each one, (g,) int32.

        Alike are groups of three sums of four vectors in space whose weights and numbers are equal
        and whose coordinates are in places at equal distances. Other groups have -1.

        Parameters
        ----------
        groups : tuple of arrays
            As `groups` returns them.
        numbers : sequence of (n,) float
            Numbers of each sum.
        """
        first, term, place, in_row = groups
        like = np.full(len(in_row), -1, dtype=np.int32)
        chosen = np.flatnonzero((in_row != 0) & (np.diff(first) == 3))
        sums = first[chosen][:, None] + np.arange(3)
        weights = self.weight[self.start[sums][:, :, None] + np.arange(4)]
        own = np.concatenate([weights, np.stack(numbers, axis=-1)[sums]], axis=2)
        places = place[term[chosen][:, None] + np.arange(4), 0]
        joins = np.zeros(len(chosen), dtype=bool)
        joins[1:] = (np.diff(chosen) == 1) & (own[1:] == own[:-1]).all(axis=(1, 2))
        joins[2:] &= (np.diff(places, 2, axis=0) == 0).all(axis=1)
        own_number = np.where(joins, 0, np.arange(len(chosen)))
        like[chosen] = chosen[np.maximum.accumulate(own_number)]
        return like

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
