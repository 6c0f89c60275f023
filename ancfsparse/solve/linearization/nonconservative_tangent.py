"""Unsymmetric tangents of nonconservative forces, by finite differences."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Indices, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.solve.linearization.matrices import free_submatrix, symmetric_from_lower
from ancfsparse.system import System
from ancfsparse.system.assembly.column_colouring import colour_columns

if TYPE_CHECKING:
    import scipy.sparse as sp

    from ancfsparse.system.assembly.assembly_protocol import CompiledAssembly


DIFFERENCE_RATIO = 6e-6  # step of differences over a coordinate: the cube root of rounding
ROUNDING_RATIO = 1e-9  # derivatives over the largest that are rounding
GMRES_TOLERANCE = 1e-13  # relative residual at which GMRES stops
MAX_RESIDUAL = 1e-9  # largest relative residual of a solution
MAX_ITERATIONS = 400  # iterations of GMRES


class NonconservativeTangent:
    """Differences of the true tangents and the symmetric matrices, over the free coordinates.

    The matrix of a nonconservative force contains at most the symmetric part of its derivative.

    Parameters
    ----------
    system : System
        The system with the forces.
    """

    def __init__(self, system: System) -> None:
        self._system, n = system, system.n_free
        pairs = zip(system.contributions, system.parts, strict=True)
        nonconservative = [(term, element) for term, element in pairs if not term.conservative]
        self._entries: sp.csc_array | None = None
        if not nonconservative:
            return
        self._assembly: CompiledAssembly = compiled_module("assembly").Assembly(
            n,
            system.n_all,
            system.loads.n_amplitudes,
            system.pattern.indptr,
            [element for _, element in nonconservative],
        )
        tables = [table for term, _ in nonconservative for table in term.cliques()]
        self._entries = _entries(tables, n)
        self._group = colour_columns(self._entries)
        self._column = np.repeat(np.arange(n), np.diff(self._entries.indptr))
        self._steps = DIFFERENCE_RATIO * _sizes(system)

    def stiffness(self, q: Vector, amplitudes: Vector) -> sp.csr_array:
        """Return the missing part of the stiffness at rest, (n_free, n_free) [N/m, N, N m]."""
        return self._missing(q, amplitudes, 0.0)

    def damping(self, q: Vector, amplitudes: Vector, rate: float) -> sp.csr_array:
        """Return the missing part of the damping at rest, (n_free, n_free) [N s/m, N s, N m s].

        Velocities of differences are those of small motions at a rate [1/s].
        """
        return self._missing(q, amplitudes, rate)

    def _missing(self, q: Vector, amplitudes: Vector, rate: float) -> sp.csr_array:
        """Return the missing part by velocities at a rate, or if it is zero by coordinates."""
        import scipy.sparse as sp

        n, entries = self._system.n_free, self._entries
        if entries is None:
            return sp.csr_array((n, n))
        zero, lam = np.zeros(len(q)), np.zeros(self._system.n_multipliers)
        steps = self._steps * (rate or 1.0)

        def force(displacement: Vector) -> Vector:
            state = (q, displacement) if rate else (q + displacement, zero)
            r = self._assembly.residual(*state, zero, lam, zero, amplitudes)[0]
            return np.array(r)[:n]

        values = np.zeros(entries.nnz)
        for group in range(int(self._group.max(initial=-1)) + 1):
            displacement = np.zeros(len(q))
            displacement[:n] = np.where(self._group == group, steps[:n], 0.0)
            change = force(displacement) - force(-displacement)
            chosen = self._group[self._column] == group
            values[chosen] = change[entries.indices[chosen]] / (2.0 * steps[self._column[chosen]])
        self._assembly.check()
        matrix = sp.csc_array((values, entries.indices, entries.indptr), shape=(n, n))
        factors = (0.0, 0.0) if rate else (0.0, 1.0)
        symmetric = self._assembly.matrix(
            *factors, q, lam, amplitudes, damping_factor=1.0 if rate else 0.0, v=zero
        )
        full = symmetric_from_lower(free_submatrix(self._system, symmetric))
        missing = (matrix - full).tocsr()
        missing.data[
            np.abs(missing.data) <= ROUNDING_RATIO * np.max(np.abs(values), initial=0.0)
        ] = 0.0
        missing.eliminate_zeros()
        return missing


def solve_with_correction(
    solve: Callable[[Vector], Vector], correction: sp.csr_array, force: Vector, unit: Vector
) -> Vector | None:
    """Solve ``(S + correction) x = force`` by GMRES, preconditioned by a solver of S.

    Parameters
    ----------
    solve : callable
        Returns ``S^-1 r``.
    correction : (n, n) sparse
        The part that the factor does not contain; few of its columns should matter.
    force : (n,) float
        The right-hand side.
    unit : (n,) float
        Square roots of the masses, the scale of corrections.

    Returns
    -------
    (n,) float or None
        The solution; None if it does not converge.
    """
    x = solve(force)
    if not correction.nnz:
        return x
    from scipy.sparse.linalg import LinearOperator, gmres

    n = len(force)

    def apply(y: Vector) -> Vector:
        return np.asarray(np.ravel(y) + unit * solve(correction @ (np.ravel(y) / unit)))

    limit = min(n, MAX_ITERATIONS)
    operator = LinearOperator((n, n), matvec=apply, dtype=float)
    y = gmres(operator, unit * x, rtol=GMRES_TOLERANCE, atol=0.0, restart=limit, maxiter=1)[0]
    residual = np.linalg.norm(unit * x - apply(y))
    return y / unit if residual <= MAX_RESIDUAL * np.linalg.norm(unit * x) else None


def _entries(tables: list[Indices], n: int) -> sp.csc_array:
    """Return the pattern of free coordinates that are coupled in the tables."""
    import scipy.sparse as sp

    rows, columns = [], []
    for table in tables:
        k = table.shape[1]
        rows.append(np.repeat(table, k, axis=1).ravel())
        columns.append(np.tile(table, k).ravel())
    row, column = np.concatenate(rows), np.concatenate(columns)
    free = (row >= 0) & (column >= 0) & (row < n) & (column < n)
    ones = np.ones(np.count_nonzero(free))
    out = sp.coo_array((ones, (row[free], column[free])), shape=(n, n)).tocsc()
    out.sort_indices()
    return out


def _sizes(system: System) -> Vector:
    """Return the size of each coordinate: element lengths for positions, (n_all,) [m, 1]."""
    sizes = np.ones(system.n_all)
    for body, indices in zip(system.scene.bodies, system.vectors("r"), strict=True):
        sizes[indices] = body.shortest
    return sizes
