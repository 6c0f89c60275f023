"""Pack elements into the blocks of `kernel_abi.h`."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import REFERENCE, ElementKind

# Blocks from which tables are shared, if so many of them in a row are alike on average.
MANY_BLOCKS, ALIKE = 256, 8


def _no_numbers() -> NDArray[np.int32]:
    return np.empty(0, dtype=np.int32)


@dataclass(frozen=True)
class Layout:
    """Arrays one kernel call takes, for blocks of as many elements as a vector has lanes.

    Attributes
    ----------
    gather : (n_tables, n, lanes) int32
        Places in ``q`` and ``a`` of the coordinates; one table for each block, see `table_of`.
    scatter : (n_tables, n_out, lanes) int32
        Places in ``out`` to which results are added.
    set_of : (n_blocks,) int32
        Which set of parameters each block uses; the bitwise complement of it if the elements of the
        block are a chain, each beginning with the node the one before ends with.
    parameters : (n_sets, n_derived, lanes) float64
        Derived parameters; blocks with equal parameters share one set.
    table_of : (n_blocks,) int32
        Which tables each block uses; empty if every block has its own.
    base, scatter_base : (n_blocks,) int32
        What a block adds to the places in its tables of `gather` and of `scatter`; empty likewise.
    """

    gather: NDArray[np.int32]
    scatter: NDArray[np.int32]
    set_of: NDArray[np.int32]
    parameters: NDArray[np.float64]
    table_of: NDArray[np.int32] = field(default_factory=_no_numbers)
    base: NDArray[np.int32] = field(default_factory=_no_numbers)
    scatter_base: NDArray[np.int32] = field(default_factory=_no_numbers)

    @property
    def nbytes(self) -> int:
        """Bytes of all arrays."""
        tables = self.gather.nbytes + self.scatter.nbytes + self.parameters.nbytes
        blocks = self.table_of.nbytes + self.base.nbytes + self.scatter_base.nbytes
        return tables + blocks + self.set_of.nbytes

    def compressed(self) -> Layout:
        """Let blocks share tables that differ by a shift; the tables here are written to.

        Along a chain each block repeats the one before, some places on: its tables, most of the
        memory of the elements, become two numbers.  A layout that is small, or where next to no
        blocks are alike, stays as it is.
        """
        n_blocks = len(self.set_of)
        if n_blocks < MANY_BLOCKS:
            return self
        base = self.gather.min(axis=(1, 2))
        scatter_base = self.scatter.min(axis=(1, 2))
        self.gather[...] -= base[:, None, None]
        self.scatter[...] -= scatter_base[:, None, None]
        flat = self.gather.reshape(n_blocks, -1), self.scatter.reshape(n_blocks, -1)
        starts = np.ones(n_blocks, dtype=bool)
        starts[1:] = False
        for part in flat:
            starts[1:] |= (part[1:] != part[:-1]).any(axis=1)
        runs = np.flatnonzero(starts)
        if len(runs) * ALIKE > n_blocks:
            self.gather[...] += base[:, None, None]
            self.scatter[...] += scatter_base[:, None, None]
            return self
        first, kind = _distinct(np.hstack([part[runs] for part in flat]))
        return replace(
            self,
            gather=self.gather[runs[first]],
            scatter=self.scatter[runs[first]],
            table_of=kind[np.cumsum(starts) - 1],
            base=base,
            scatter_base=scatter_base,
        )


def pack(kind: ElementKind, places: ArrayLike, scatter: ArrayLike, base: ArrayLike) -> Layout:
    """Arrange elements of one kind in blocks.

    Parameters
    ----------
    kind : ElementKind
        What the elements are; gives lanes, parameters and how to derive them.
    places : (n_elements, n) int
        Place of every coordinate in the vector of the system.
    scatter : (n_elements, n_out) int
        Place in the output of every number the kernel adds.
    base : (n_elements, n_base) float
        Base parameters in the order of ``kind.parameters``.

    Returns
    -------
    Layout
        The last block is filled up with copies of the last element whose parameters, except the
        length, a shape free of strain and constants inside strains, are zero.

    Raises
    ------
    InputError
        If the tables disagree about the number of elements, a place cannot be one, or a length is
        not positive.
    """
    lanes, length = kind.lanes, kind.parameters.index("length")
    places, scatter = _places(places, "places"), _places(scatter, "scatter")
    base = np.asarray(base, dtype=np.float64)
    n = len(places)
    if base.shape != (n, len(kind.parameters)) or len(scatter) != n:
        raise InputError(
            f"{n} elements of kind {kind.name} need as many rows of scatter, not {len(scatter)}, "
            f"and base parameters of shape ({n}, {len(kind.parameters)}), not {base.shape}."
        )
    if not (base[:, length] > 0).all():
        worst = int(np.argmin(base[:, length]))
        raise InputError(
            f"Element {worst} has length {base[worst, length]:g}; it must be positive."
        )
    block_base = filled(kind, base)
    n_blocks = len(block_base) // lanes
    flat = block_base.reshape(n_blocks, lanes * base.shape[1])
    first, set_of = _distinct(flat)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        derived = kind.prepare(flat[first].reshape(len(first) * lanes, base.shape[1]))
    if not np.isfinite(derived).all():
        raise InputError(
            f"{n} elements of lengths {base[:, length].min():g} to {base[:, length].max():g} m "
            "have parameters beyond the range of floating-point numbers: check the units of "
            "positions, section and material"
        )
    sets = derived.reshape(len(first), lanes, derived.shape[1])
    gather, out = _blocks(places, lanes), _blocks(scatter, lanes)
    chained = _chained(gather)
    if out.shape == gather.shape:
        chained &= _chained(out)
    return Layout(
        gather=gather,
        scatter=out,
        set_of=np.where(chained, ~set_of, set_of),
        parameters=np.ascontiguousarray(sets.transpose(0, 2, 1)),
    )


def filled(kind: ElementKind, base: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return base parameters of whole blocks, the last one filled up as `pack` does."""
    fill = np.repeat(base[len(base) - 1 :], -len(base) % kind.lanes, axis=0)
    weights = [
        not name.startswith(("length", REFERENCE)) and kind.own.get(name) != "ratios"
        for name in kind.parameters
    ]
    fill[:, weights] = 0.0
    return np.concatenate([base, fill])


def _places(values: ArrayLike, name: str) -> NDArray[np.int32]:
    array = np.asarray(values)
    if array.ndim != 2 or not np.issubdtype(array.dtype, np.integer):
        raise InputError(f"{name} must be a table of whole numbers with one row per element.")
    if array.size and (array.min() < 0 or array.max() > np.iinfo(np.int32).max):
        raise InputError(f"{name} must lie between 0 and {np.iinfo(np.int32).max}.")
    return array.astype(np.int32, copy=False)


def _blocks(rows: NDArray[np.int32], lanes: int) -> NDArray[np.int32]:
    """Deal rows out to lanes, the last one again where there are not enough of them."""
    n_full, rest = divmod(len(rows), lanes)
    blocks = np.empty((n_full + (rest > 0), rows.shape[1], lanes), dtype=np.int32)
    full = rows[: n_full * lanes].reshape(n_full, lanes, rows.shape[1])
    blocks[:n_full] = full.transpose(0, 2, 1)
    if rest:
        blocks[-1] = rows[-1][:, None]
        blocks[-1, :, :rest] = rows[n_full * lanes :].T
    return blocks


def _chained(blocks: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Whether in a block the second node of every lane is the first node of the next."""
    half = blocks.shape[1] // 2
    same: NDArray[np.bool_] = (blocks[:, half:, :-1] == blocks[:, :half, 1:]).all(axis=(1, 2))
    return same


def _distinct(rows: NDArray[Any]) -> tuple[NDArray[np.intp], NDArray[np.int32]]:
    """First row of every kind, and the kind of every row."""
    starts = np.ones(len(rows), dtype=bool)
    starts[1:] = (rows[1:] != rows[:-1]).any(axis=1)
    runs = np.flatnonzero(starts)
    keys = rows[runs].view(np.dtype((np.void, rows.shape[1] * rows.itemsize))).ravel()
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    kind = inverse[np.cumsum(starts) - 1] if len(rows) else np.empty(0)
    return runs[first], kind.astype(np.int32)
