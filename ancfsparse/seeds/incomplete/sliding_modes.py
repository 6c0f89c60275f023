"""Modes along which cables slide: a deflation space for incomplete seeds in long steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Integers
from ancfsparse.seeds.complete.sparse_seed import SparseSeed

# Coupling of cables that cross at right angles is about a hundredth of that of parallel ones.
MIN_COSINE = 0.3  # of the angle between cables that are coupled in the coarse matrix
DIRECTION_BYTES = 16  # of a direction scaled by the matrix


class Slides(NamedTuple):
    """Points of cables that can slide along their axes.

    Attributes
    ----------
    unknown : (k, 3) int32
        Unknowns of the position of each point.
    mode : (k,) int32
        Its cable, numbered from 0.
    direction : (k, 3) float32
        Of the cable at the point, of length one.
    """

    unknown: Integers
    mode: Integers
    direction: NDArray[np.float32]


@dataclass(frozen=True)
class SlidingModes:
    """Sliding modes of a factor, and the coarse matrix between modes that are nearly parallel.

    Attributes
    ----------
    triple, mode, direction
        As in `Slides`, for each direction of a triple in a mode, by triples.
    block, row, column, place : (n_terms,) int32
        Terms of the coarse matrix: a block of the matrix between two directions, and the index of
        the entry to which it is added.
    factor : SparseSeed
        Complete factor of the coarse matrix.
    """

    triple: Integers
    mode: Integers
    direction: NDArray[np.float32]
    block: Integers
    row: Integers
    column: Integers
    place: Integers
    factor: SparseSeed

    @property
    def nbytes(self) -> float:
        """Memory [bytes]."""
        per_mode = DIRECTION_BYTES + self.direction.itemsize * 3 + 2 * self.mode.itemsize
        return per_mode * len(self.mode) + 16.0 * len(self.block) + self.factor.nbytes

    @classmethod
    def from_matrix(
        cls, slides: Slides, unknown: Integers, start: Integers, row: Integers
    ) -> SlidingModes:
        """Return the coupling of modes in the blocks of a matrix.

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
        # Blocks between triples with modes, those on the diagonal first.
        first = np.searchsorted(triple, np.arange(n + 1)).astype(np.int32)
        counts = np.diff(first)
        column_of = np.repeat(np.arange(n, dtype=np.int32), np.diff(start))
        below = np.flatnonzero((counts[row] > 0) & (counts[column_of] > 0))
        blocks = np.concatenate([np.flatnonzero(counts), n + below])
        of_row = np.concatenate([np.flatnonzero(counts), row[below]])
        of_column = np.concatenate([np.flatnonzero(counts), column_of[below]])
        terms = []
        for i in range(int(counts.max())):
            for j in range(int(counts.max())):
                both = np.flatnonzero((i < counts[of_row]) & (j < counts[of_column]))
                a, b = first[of_row[both]] + i, first[of_column[both]] + j
                is_parallel = np.abs(np.sum(direction[a] * direction[b], axis=1)) > MIN_COSINE
                # Two directions of one triple occur twice, and add to one entry.
                once = (of_row[both] != of_column[both]) | (i < j)
                coupled = (mode[a] == mode[b]) | (is_parallel & once)
                terms.append(np.stack([blocks[both][coupled], a[coupled], b[coupled]]))
        block, left, right = np.concatenate(terms, axis=1).astype(np.int32)
        modes = int(mode.max()) + 1
        low, high = np.minimum(mode[left], mode[right]), np.maximum(mode[left], mode[right])
        key = low.astype(np.int64) * modes + high
        entries, place = np.unique(key, return_inverse=True)
        indptr = np.searchsorted(entries, modes * np.arange(modes + 1, dtype=np.int64))
        factor = SparseSeed(indptr, (entries % modes).astype(np.int32), modes)
        return cls(triple, mode, direction, block, left, right, place.astype(np.int32), factor)
