"""Derivatives of forces without a potential, whose matrices are not symmetric, by differences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled
from ancfsparse.system import State, System
from ancfsparse.system.pattern import Unknowns

if TYPE_CHECKING:
    import scipy.sparse as sp

    from ancfsparse.system.equations import Assembly

Vector = NDArray[np.float64]

# Share of a size over which a force is differentiated, the cube root of rounding.
SHARE = 6e-6


def unsymmetric_parts(
    system: System, state: State, amplitudes: Vector, rate: float
) -> tuple[sp.csr_array, sp.csr_array]:
    """Return what the matrices of stiffness and damping of a system lack, over free coordinates.

    The matrix of a force without a potential contains the symmetric part of its derivatives at
    most.

    Parameters
    ----------
    system : System
        The forces.
    state : State
        Where; velocities are taken as zero.
    amplitudes : (n_amplitudes,) float
        Of the loads there.
    rate : float
        Of the motions of interest, by which sizes of velocities follow from those of
        displacements [1/s].

    Returns
    -------
    stiffness, damping : (n_free, n_free) sparse
        Without entries where all forces have a potential [N/m, N, N m], [N s/m, N s, N m s].
    """
    import scipy.sparse as sp

    n = system.n_free
    pairs = zip(system.contributions, system.assembly.contributions, strict=True)
    chosen = [(each, made) for each, made in pairs if not each.conservative]
    if not chosen:
        none = sp.csr_array((n, n))
        return none, none
    assembly: Assembly = compiled("assembly").Assembly(
        n,
        system.n_all,
        system.loads.n_amplitudes,
        system.pattern.indptr,
        [made for _, made in chosen],
    )
    entries = _entries([table for each, _ in chosen for table in each.cliques()], n)
    columns = _groups(entries)
    none, lam = np.zeros(system.n_all), np.zeros(system.n_multipliers)
    small = SHARE * _sizes(system)

    def force(q: Vector, v: Vector) -> Vector:
        return np.array(assembly.residual(q, v, none, lam, none, amplitudes)[0])[:n]

    def derivative(by_velocity: bool) -> sp.csr_array:
        steps = small * rate if by_velocity else small
        rows, values = entries.indices, np.zeros(entries.nnz)
        column_of = np.repeat(np.arange(n), np.diff(entries.indptr))
        for group in range(int(columns.max(initial=-1)) + 1):
            moved = np.zeros(system.n_all)
            moved[:n] = np.where(columns == group, steps[:n], 0.0)
            if by_velocity:
                change = force(state.q, moved) - force(state.q, -moved)
            else:
                change = force(state.q + moved, none) - force(state.q - moved, none)
            mine = columns[column_of] == group
            values[mine] = change[rows[mine]] / (2.0 * steps[column_of[mine]])
        matrix = sp.csc_array((values, rows, entries.indptr), shape=(n, n))
        own = assembly.matrix(
            0.0,
            0.0 if by_velocity else 1.0,
            state.q,
            lam,
            amplitudes,
            damping_factor=1.0 if by_velocity else 0.0,
            v=none,
        )
        return (matrix - _whole(system, own)).tocsr()

    found = derivative(False), derivative(True)
    assembly.check()
    return found


def _entries(tables: list[Unknowns], n: int) -> sp.csc_array:
    """Return which free coordinates meet in the tables."""
    import scipy.sparse as sp

    rows, columns = [], []
    for table in tables:
        k = table.shape[1]
        rows.append(np.repeat(table, k, axis=1).ravel())
        columns.append(np.tile(table, k).ravel())
    row, column = np.concatenate(rows), np.concatenate(columns)
    kept = (row >= 0) & (column >= 0) & (row < n) & (column < n)
    ones = np.ones(np.count_nonzero(kept))
    out = sp.coo_array((ones, (row[kept], column[kept])), shape=(n, n)).tocsc()
    out.sort_indices()
    return out


def _groups(entries: sp.csc_array) -> NDArray[np.int64]:
    """Give columns the same number only if they have no row in common; empty ones -1."""
    n = entries.shape[0]
    starts, rows = entries.indptr, entries.indices
    group = np.full(n, -1)
    for column in np.flatnonzero(np.diff(starts)):
        taken = set()
        for row in rows[starts[column] : starts[column + 1]]:
            taken.update(group[rows[starts[row] : starts[row + 1]]].tolist())
        group[column] = next(k for k in range(len(taken) + 1) if k not in taken)
    return group


def _sizes(system: System) -> Vector:
    """Return what displacements of the coordinates are small beside, (n_all,) [m, 1]."""
    sizes = np.ones(system.n_all)
    for body, places in zip(system.scene.bodies, system.vectors("r"), strict=True):
        sizes[places] = body.shortest
    return sizes


def _whole(system: System, values: Vector) -> sp.csr_array:
    from ancfsparse.solve.stability import on_free, whole

    return whole(on_free(system, values))
