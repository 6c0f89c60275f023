"""Seed of a matrix whose pattern follows the contacts of elements with each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ancfsparse.array_types import Indices, Integers
from ancfsparse.dispatch import compiled_module
from ancfsparse.seeds.complete.sparse_seed import SparseSeed


class TouchingPairs(Protocol):
    """Pairs of elements that touch, of one contact (_beam_contacts.pyx)."""

    @property
    def coupling(self) -> object:
        """Structure "ancf_coupling"."""

    @property
    def coupled_pairs(self) -> Integers:
        """Pairs of elements that the matrix couples now, (k, 2)."""


class CoupledSeed(SparseSeed):
    """A complete seed whose compiled callers factor the blocks of touching elements as well.

    When the pairs of touching elements have changed, their entries are added to the pattern, and
    it is ordered again, before the next factorization.  Python callers, whose matrices have no
    such blocks, factor and solve without them.

    Parameters
    ----------
    indptr, indices, n_positive, threads
        As of `SparseSeed`, without touching elements.
    couplings : sequence of (TouchingPairs, (n, k) int array)
        For each contact, its pairs, and the unknowns of each element; negative ones are fixed.

    Attributes
    ----------
    compiled : compiled object
        ``factor`` and ``solve`` with these blocks.
    """

    def __init__(
        self,
        indptr: Indices,
        indices: Indices,
        n_positive: int,
        threads: int,
        couplings: Sequence[tuple[TouchingPairs, Indices]],
    ) -> None:
        super().__init__(indptr, indices, n_positive, threads)
        self._couplings, self._threads = couplings, threads
        self.on_renewal = lambda _: None
        self._present: SparseSeed = self
        self.compiled = compiled_module("coupled").Coupled(
            self.renew, super().capsule, [pairs.coupling for pairs, _ in couplings], len(indices)
        )

    @property
    def capsule(self) -> object:
        """The structure ``ancf_seed`` for compiled callers."""
        return self.compiled.capsule

    @property
    def error(self) -> BaseException | None:
        """Error in a call from compiled code, if any."""
        error: BaseException | None = self.compiled.error
        return super().error if error is None else error

    def renew(self) -> None:
        """Order a seed for the present pairs."""
        self.renewals += 1
        row, column = (
            np.concatenate(each).astype(np.int32)
            for each in zip(*(_entries(*each) for each in self._couplings), strict=True)
        )
        if not len(row):
            self.compiled.take(super().capsule)
            self._take(self)
            return
        indptr, indices, slot, slot_of_block = compiled_module("coupled").grow_pattern(
            *self._pattern, row, column
        )
        seed = SparseSeed(indptr, indices, self.n_positive, self._threads, briefly=True)
        self.compiled.take(seed.capsule, seed, slot, slot_of_block, len(indices))
        self._take(seed)

    def _take(self, seed: SparseSeed) -> None:
        if self._present is not self:
            self._present.release()
        self._present = seed
        self.on_renewal(seed)


def _entries(pairs: TouchingPairs, unknowns: Indices) -> tuple[Indices, Indices]:
    """Return rows and columns of the blocks of all pairs, block by block."""
    one, other = np.moveaxis(unknowns[pairs.coupled_pairs], 1, 0)
    size = unknowns.shape[1]
    return np.repeat(one.ravel(), size), np.repeat(other, size, axis=0).ravel()
