"""Modes along which cables slide: a coarse space for incomplete seeds in long steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.seeds.complete.sparse_seed import SparseSeed

# Cosine of the angle up to which cables are coupled in the coarse matrix: those that cross at right
# angles are some hundred times less than those side by side.
PARALLEL = 0.3

# Bytes of a way in the scale of the matrix.
TRIPLE_BYTES = 16

Numbers = NDArray[np.int32]


class Slides(NamedTuple):
    """Points of cables, each of which can slide along itself.

    Attributes
    ----------
    unknown : (k, 3) int32
        Unknowns of the position of each point.
    mode : (k,) int32
        Its cable, numbered from 0.
    direction : (k, 3) float32
        Of the cable at the point, of length one.
    """

    unknown: Numbers
    mode: Numbers
    direction: NDArray[np.float32]


@dataclass(frozen=True)
class SlidingModes:
    """The modes of a factor, and the coarse matrix between those that run side by side.

    Attributes
    ----------
    triple, mode, direction
        As in `Slides`, for each way of a triple in a mode, by triples.
    block, row, column, place : (n_terms,) int32
        Terms of the coarse matrix: a block of the matrix between two ways, and where it is added.
    factor : SparseSeed
        Complete factor of the coarse matrix.
    """

    triple: Numbers
    mode: Numbers
    direction: NDArray[np.float32]
    block: Numbers
    row: Numbers
    column: Numbers
    place: Numbers
    factor: SparseSeed

    @property
    def nbytes(self) -> float:
        """Memory of all of it [bytes]."""
        ways = TRIPLE_BYTES + self.direction.itemsize * 3 + 2 * self.mode.itemsize
        return ways * len(self.mode) + 16.0 * len(self.block) + self.factor.nbytes

    @classmethod
    def of(cls, slides: Slides, unknown: Numbers, start: Numbers, row: Numbers) -> SlidingModes:
        """Find out which ways meet in blocks of a matrix.

        Parameters
        ----------
        slides : Slides
            The modes.
        unknown : (n_triples, 3) int32
            Unknowns of each triple in order of elimination.
        start, row : integer arrays
            Blocks below the diagonal by columns, and their rows.
        """
        there = np.flatnonzero(unknown[:, 0] >= 0).astype(np.int32)
        triples = np.empty(int(unknown.max()) + 1, dtype=np.int32)
        triples[unknown[there, 0]] = there
        by_triple = np.argsort(triples[slides.unknown[:, 0]], kind="stable")
        triple = triples[slides.unknown[by_triple, 0]]
        mode, direction = slides.mode[by_triple], slides.direction[by_triple]
        n = len(unknown)
        row = row[: start[-1]]
        # Blocks between triples that have ways, those on the diagonal first.
        first = np.searchsorted(triple, np.arange(n + 1)).astype(np.int32)
        ways = np.diff(first)
        column_of = np.repeat(np.arange(n, dtype=np.int32), np.diff(start))
        below = np.flatnonzero((ways[row] > 0) & (ways[column_of] > 0))
        blocks = np.concatenate([np.flatnonzero(ways), n + below])
        of_row = np.concatenate([np.flatnonzero(ways), row[below]])
        of_column = np.concatenate([np.flatnonzero(ways), column_of[below]])
        found = []
        for i in range(int(ways.max())):
            for j in range(int(ways.max())):
                both = np.flatnonzero((i < ways[of_row]) & (j < ways[of_column]))
                a, b = first[of_row[both]] + i, first[of_column[both]] + j
                along = np.abs(np.sum(direction[a] * direction[b], axis=1)) > PARALLEL
                # Two ways of one triple are met twice, and add to one entry.
                once = (of_row[both] != of_column[both]) | (i < j)
                kept = (mode[a] == mode[b]) | (along & once)
                found.append(np.stack([blocks[both][kept], a[kept], b[kept]]))
        block, left, right = np.concatenate(found, axis=1).astype(np.int32)
        modes = int(mode.max()) + 1
        low, high = np.minimum(mode[left], mode[right]), np.maximum(mode[left], mode[right])
        key = low.astype(np.int64) * modes + high
        entries, place = np.unique(key, return_inverse=True)
        indptr = np.searchsorted(entries, modes * np.arange(modes + 1, dtype=np.int64))
        factor = SparseSeed(indptr, (entries % modes).astype(np.int32), modes)
        return cls(triple, mode, direction, block, left, right, place.astype(np.int32), factor)
