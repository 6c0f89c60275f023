"""Sparsity pattern of the saddle point matrix, and positions of its entries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Indices
from ancfsparse.dispatch import compiled_module


@dataclass(frozen=True)
class Pattern:
    """Lower triangle by columns of the matrix over (free coordinates, multipliers).

    Attributes
    ----------
    indptr : (n + 1,) int64
        Start of each column, at its diagonal entry.
    indices : (n_values,) int32
        Rows, sorted within each column.
    """

    indptr: NDArray[np.int64]
    indices: NDArray[np.int32]

    @property
    def n(self) -> int:
        """Number of unknowns."""
        return len(self.indptr) - 1

    @property
    def n_values(self) -> int:
        """Number of stored entries, also the position for discarded values."""
        return len(self.indices)

    def slots(self, members: Indices) -> NDArray[np.int32]:
        """Return the positions of all pairs of the unknowns in a row.

        Parameters
        ----------
        members : (n_rows, k) int
            Coupled unknowns; negative ones are fixed, and their pairs are discarded.

        Returns
        -------
        (n_rows, k (k + 1) / 2) int32
            Lower triangle by rows.
        """
        rows = np.ascontiguousarray(members, dtype=np.int32)
        slots: NDArray[np.int32] = compiled_module("pattern").pair_slots(
            self.indptr, self.indices, rows
        )
        return slots


def build_pattern(n: int, cliques: Sequence[Indices]) -> Pattern:
    """Build the pattern from groups of coupled unknowns, with all diagonal entries.

    Parameters
    ----------
    n : int
        Number of unknowns.
    cliques : sequence of (n_rows, k) int arrays
        Coupled unknowns of each row; negative ones are ignored.
    """
    tables = [np.ascontiguousarray(table, dtype=np.int32) for table in cliques if len(table)]
    sizes = [np.full(len(table), table.shape[1], dtype=np.int32) for table in tables]
    start = np.zeros(1 + sum(len(table) for table in tables), dtype=np.int64)
    np.cumsum(np.concatenate([np.empty(0, np.int32), *sizes]), out=start[1:])
    flat = [table.ravel() for table in tables]
    member = flat[0] if len(flat) == 1 else np.concatenate([np.empty(0, np.int32), *flat])
    return Pattern(*compiled_module("pattern").lower_triangle(n, start, member))
