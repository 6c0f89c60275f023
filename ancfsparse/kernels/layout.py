"""Packing of elements into the SIMD blocks of `kernel_abi.h`."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.errors import InputError
from ancfsparse.kernels.element_kind import REFERENCE, ElementKind

MIN_SHARED_BLOCKS = 256  # for shared tables
MIN_RUN_LENGTH = 8  # mean number of successive blocks with equal tables, for shared tables


def _no_numbers() -> NDArray[np.int32]:
    return np.empty(0, dtype=np.int32)


@dataclass(frozen=True)
class Layout:
    """Arrays of one kernel call, for blocks of one element per SIMD lane.

    Attributes
    ----------
    gather : (n_tables, n, lanes) int32
        Indices of the coordinates in ``q`` and ``a``; one table per block, see `table_of`.
    scatter : (n_tables, n_out, lanes) int32
        Indices in ``out`` to which results are added.
    set_of : (n_blocks,) int32
        Parameter set of each block; its bitwise complement if the elements of the block are a
        chain, in which each element begins at the last node of the previous one.
    parameters : (n_sets, n_derived, lanes) float64
        Derived parameters; blocks with equal parameters share one set.
    table_of : (n_blocks,) int32
        Tables of each block; empty if every block has its own.
    base, scatter_base : (n_blocks,) int32
        Offsets of a block to the indices in its tables of `gather` and `scatter`; empty likewise.
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

    def compress(self) -> Layout:
        """Return a layout in which blocks share tables that differ by an offset; overwrites tables.

        Along a chain each block repeats the previous one with an offset: its tables, most of the
        memory of the elements, become two numbers.  A small layout, or one with few equal blocks,
        is returned unchanged.
        """
        n_blocks = len(self.set_of)
        if n_blocks < MIN_SHARED_BLOCKS:
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
        if len(runs) * MIN_RUN_LENGTH > n_blocks:
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


def pack(kind: ElementKind, indices: ArrayLike, scatter: ArrayLike, base: ArrayLike) -> Layout:
    """Arrange elements of one kind in blocks.

    Parameters
    ----------
    kind : ElementKind
        Element type, with its lanes and parameters.
    indices : (n_elements, n) int
        Index of every coordinate in the vector of the system.
    scatter : (n_elements, n_out) int
        Index in the output of every result of the kernel.
    base : (n_elements, n_base) float
        Base parameters in the order of ``kind.parameters``.

    Returns
    -------
    Layout
        The last block is padded with copies of the last element, with zero parameters except the
        length, a stress-free shape and constants inside strains.

    Raises
    ------
    InputError
        If the tables differ in the number of elements, an index is invalid, or a length is not
        positive.
    """
    lanes, length = kind.lanes, kind.parameters.index("length")
    indices, scatter = _check_indices(indices, "indices"), _check_indices(scatter, "scatter")
    base = np.asarray(base, dtype=np.float64)
    n = len(indices)
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
    block_base = pad(kind, base)
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
    gather, out = _blocks(indices, lanes), _blocks(scatter, lanes)
    is_chain = _are_chains(gather)
    if out.shape == gather.shape:
        is_chain &= _are_chains(out)
    return Layout(
        gather=gather,
        scatter=out,
        set_of=np.where(is_chain, ~set_of, set_of),
        parameters=np.ascontiguousarray(sets.transpose(0, 2, 1)),
    )


def pad(kind: ElementKind, base: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return base parameters of complete blocks, the last one padded as by `pack`."""
    fill = np.repeat(base[len(base) - 1 :], -len(base) % kind.lanes, axis=0)
    weights = [
        not name.startswith(("length", REFERENCE)) and kind.own.get(name) != "ratios"
        for name in kind.parameters
    ]
    fill[:, weights] = 0.0
    return np.concatenate([base, fill])


def _check_indices(values: ArrayLike, name: str) -> NDArray[np.int32]:
    array = np.asarray(values)
    if array.ndim != 2 or not np.issubdtype(array.dtype, np.integer):
        raise InputError(f"{name} must be a table of whole numbers with one row per element.")
    if array.size and (array.min() < 0 or array.max() > np.iinfo(np.int32).max):
        raise InputError(f"{name} must lie between 0 and {np.iinfo(np.int32).max}.")
    return array.astype(np.int32, copy=False)


def _blocks(rows: NDArray[np.int32], lanes: int) -> NDArray[np.int32]:
    """Distribute rows over lanes; the last row is repeated in an incomplete block."""
    n_full, rest = divmod(len(rows), lanes)
    blocks = np.empty((n_full + (rest > 0), rows.shape[1], lanes), dtype=np.int32)
    full = rows[: n_full * lanes].reshape(n_full, lanes, rows.shape[1])
    blocks[:n_full] = full.transpose(0, 2, 1)
    if rest:
        blocks[-1] = rows[-1][:, None]
        blocks[-1, :, :rest] = rows[n_full * lanes :].T
    return blocks


def _are_chains(blocks: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Return True for blocks in which the second node of every lane is the first of the next."""
    half = blocks.shape[1] // 2
    same: NDArray[np.bool_] = (blocks[:, half:, :-1] == blocks[:, :half, 1:]).all(axis=(1, 2))
    return same


def _distinct(rows: NDArray[Any]) -> tuple[NDArray[np.intp], NDArray[np.int32]]:
    """Return the first row of every kind, and the kind of every row."""
    starts = np.ones(len(rows), dtype=bool)
    starts[1:] = (rows[1:] != rows[:-1]).any(axis=1)
    runs = np.flatnonzero(starts)
    keys = rows[runs].view(np.dtype((np.void, rows.shape[1] * rows.itemsize))).ravel()
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    kind = inverse[np.cumsum(starts) - 1] if len(rows) else np.empty(0)
    return runs[first], kind.astype(np.int32)
