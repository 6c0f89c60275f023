"""Derivatives of forces without a potential, whose matrices are not symmetric, by differences."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled_module
from ancfsparse.solve.linearization.matrices import free_submatrix, symmetric_from_lower
from ancfsparse.system import System
from ancfsparse.system.assembly.column_colouring import colours
from ancfsparse.system.assembly.sparsity_pattern import Unknowns

if TYPE_CHECKING:
    import scipy.sparse as sp

    from ancfsparse.system.assembly.assembly_protocol import Assembly

Vector = NDArray[np.float64]

# Share of a size over which a force is differentiated, the cube root of rounding.
SHARE = 6e-6
# Derivatives beside the largest that are rounding.
ROUNDING = 1e-9
# Relative residual that solutions aim at, the largest that is allowed, and their most iterations.
INNER, ENOUGH, MOST_INNER = 1e-13, 1e-9, 400


class NonconservativeTangent:
    """What the matrices of stiffness and damping of a system lack, over its free coordinates.

    The matrix of a force without a potential contains the symmetric part of its derivatives at
    most.

    Parameters
    ----------
    system : System
        The forces.
    """

    def __init__(self, system: System) -> None:
        self._system, n = system, system.n_free
        pairs = zip(system.contributions, system.parts, strict=True)
        chosen = [(each, made) for each, made in pairs if not each.conservative]
        self._entries: sp.csc_array | None = None
        if not chosen:
            return
        self._assembly: Assembly = compiled_module("assembly").Assembly(
            n,
            system.n_all,
            system.loads.n_amplitudes,
            system.pattern.indptr,
            [made for _, made in chosen],
        )
        self._entries = _entries([table for each, _ in chosen for table in each.cliques()], n)
        self._group = colours(self._entries)
        self._column = np.repeat(np.arange(n), np.diff(self._entries.indptr))
        self._small = SHARE * _sizes(system)

    def stiffness(self, q: Vector, amplitudes: Vector) -> sp.csr_array:
        """Return what the stiffness lacks at rest, (n_free, n_free) [N/m, N, N m]."""
        return self._missing(q, amplitudes, 0.0)

    def damping(self, q: Vector, amplitudes: Vector, rate: float) -> sp.csr_array:
        """Return what the damping lacks at rest, (n_free, n_free) [N s/m, N s, N m s].

        Velocities for differences are those of small motions of a rate [1/s].
        """
        return self._missing(q, amplitudes, rate)

    def _missing(self, q: Vector, amplitudes: Vector, rate: float) -> sp.csr_array:
        """Differentiate by velocities of a rate, or without one by coordinates."""
        import scipy.sparse as sp

        n, entries = self._system.n_free, self._entries
        if entries is None:
            return sp.csr_array((n, n))
        none, lam = np.zeros(len(q)), np.zeros(self._system.n_multipliers)
        steps = self._small * (rate or 1.0)

        def force(moved: Vector) -> Vector:
            state = (q, moved) if rate else (q + moved, none)
            r = self._assembly.residual(*state, none, lam, none, amplitudes)[0]
            return np.array(r)[:n]

        values = np.zeros(entries.nnz)
        for group in range(int(self._group.max(initial=-1)) + 1):
            moved = np.zeros(len(q))
            moved[:n] = np.where(self._group == group, steps[:n], 0.0)
            change = force(moved) - force(-moved)
            mine = self._group[self._column] == group
            values[mine] = change[entries.indices[mine]] / (2.0 * steps[self._column[mine]])
        self._assembly.check()
        matrix = sp.csc_array((values, entries.indices, entries.indptr), shape=(n, n))
        factors = (0.0, 0.0) if rate else (0.0, 1.0)
        own = self._assembly.matrix(
            *factors, q, lam, amplitudes, damping_factor=1.0 if rate else 0.0, v=none
        )
        missing = (matrix - symmetric_from_lower(free_submatrix(self._system, own))).tocsr()
        missing.data[np.abs(missing.data) <= ROUNDING * np.max(np.abs(values), initial=0.0)] = 0.0
        missing.eliminate_zeros()
        return missing


def solve_beside(
    solve: Callable[[Vector], Vector], beside: sp.csr_array, force: Vector, unit: Vector
) -> Vector | None:
    """Solve ``(S + beside) x = force`` by GMRES, with a solver of S.

    Parameters
    ----------
    solve : callable
        Returns ``S^-1 r``.
    beside : (n, n) sparse
        What the factor does not contain; few of its columns should count.
    force : (n,) float
        The right-hand side.
    unit : (n,) float
        Roots of the masses, by which corrections are measured.

    Returns
    -------
    (n,) float or None
        None if it does not converge.
    """
    x = solve(force)
    if not beside.nnz:
        return x
    from scipy.sparse.linalg import LinearOperator, gmres

    n = len(force)

    def apply(y: Vector) -> Vector:
        return np.asarray(np.ravel(y) + unit * solve(beside @ (np.ravel(y) / unit)))

    most = min(n, MOST_INNER)
    operator = LinearOperator((n, n), matvec=apply, dtype=float)
    y = gmres(operator, unit * x, rtol=INNER, atol=0.0, restart=most, maxiter=1)[0]
    off = np.linalg.norm(unit * x - apply(y))
    return y / unit if off <= ENOUGH * np.linalg.norm(unit * x) else None


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


def _sizes(system: System) -> Vector:
    """Return what displacements of the coordinates are small beside, (n_all,) [m, 1]."""
    sizes = np.ones(system.n_all)
    for body, places in zip(system.scene.bodies, system.vectors("r"), strict=True):
        sizes[places] = body.shortest
    return sizes
