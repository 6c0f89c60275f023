"""Deflated conjugate gradients, preconditioned by an incomplete factor, for accurate solutions."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ancfsparse.array_types import Indices, Vector
from ancfsparse.seeds.complete.sparse_seed import SparseSeed
from ancfsparse.seeds.incomplete.incomplete_seed import IncompleteSeed
from ancfsparse.seeds.ordering.unknown_groups import Groups

if TYPE_CHECKING:
    import scipy.sparse as sp


# Solutions to 1e-2 take half as many Newton corrections again, solutions to 1e-6 the same number.
RESIDUAL_RATIO = 1e-4  # of solution to right-hand side, in the norm of the sweeps
MAX_ITERATIONS = 5000
REGULARIZATION = 1e-10  # of the coarse matrix of unit diagonal; its modes may be dependent
ENTRY_BYTES = 180.0  # per entry, for both triangles, workspace and coarse modes, as measured


class CoarseSpace(NamedTuple):
    """Coarse modes of unit energy in columns, their products with the matrix, their factor."""

    modes: sp.csr_array
    images: sp.csr_array
    seed: SparseSeed


class DeflatedSeed:
    """Inverse of a sparse symmetric matrix by preconditioned conjugate gradients.

    Sweeps through an incomplete factor hardly reduce residuals of motions of large parts, so every
    iteration removes their part in the coarse modes (deflation: method A-DEF2 of Tang, Nabben, Vuik
    and Erlangga 2009).  The matrix is in double precision.

    Parameters
    ----------
    indptr, indices : integer arrays
        Lower triangle by columns, diagonal included.
    groups : Groups
        As for `IncompleteSeed`.

    Attributes
    ----------
    n : int
        Number of unknowns.
    inner : (int, int)
        Numbers of sweeps and of products with the matrix.
    negative_pivots : int
        1 if a direction of negative curvature was found since the last `factor`, else 0.
    """

    def __init__(self, indptr: Indices, indices: Indices, groups: Groups) -> None:
        self._incomplete = IncompleteSeed(indptr, indices, groups)
        self._indptr, self._indices = indptr, indices
        self.n = len(indptr) - 1
        self.inner = 0, 0
        self.negative_pivots = 0
        self._matrix: sp.csr_array | None = None
        self._coarse: CoarseSpace | None = None

    @property
    def nbytes(self) -> float:
        """Approximate memory of factor, matrix and modes [bytes]."""
        return self._incomplete.nbytes + ENTRY_BYTES * len(self._indices)

    def factor(self, values: Vector, modes: sp.csc_array) -> None:
        """Factor again; only solutions show whether the matrix is definite.

        Parameters
        ----------
        values : (n_values,) float
            Entries of the matrix on the pattern.
        modes : (n, n_modes) sparse array
            Coarse modes in its columns, none of them zero.
        """
        import scipy.sparse as sp

        self.negative_pivots = 0
        self._incomplete.factor(values)
        lower = sp.csc_array((values, self._indices, self._indptr), shape=(self.n, self.n))
        self._matrix = (lower + sp.tril(lower, -1).T).tocsr()
        self._coarse = self._build_coarse_space(modes)

    def _build_coarse_space(self, modes: sp.csc_array) -> CoarseSpace | None:
        """Return the coarse modes with their factor, or None if the matrix is not definite."""
        import scipy.sparse as sp

        assert self._matrix is not None
        images = self._matrix @ modes
        energy = modes.multiply(images).sum(axis=0)
        if np.all(energy > 0.0):
            unit = sp.diags_array(1.0 / np.sqrt(energy))
            modes, images = sp.csr_array(modes @ unit), sp.csr_array(images @ unit)
            identity = sp.eye_array(len(energy))
            coarse = sp.csc_array(sp.tril(modes.T @ images) + REGULARIZATION * identity)
            coarse.sort_indices()
            seed = SparseSeed(coarse.indptr, coarse.indices, coarse.shape[0])
            if seed.factor(coarse.data) == 0:
                return CoarseSpace(modes, images, seed)
        self.negative_pivots = 1
        return None

    def solve(self, r: Vector) -> Vector:
        """Return the solution ``(n,)`` for the right-hand side ``r (n,)``.

        A direction of negative curvature is counted, and ends the iteration with the present
        solution; that is NaN if even the first sweep is undefined, as with a zero on the diagonal.
        """
        assert self._matrix is not None
        x, residual = np.zeros(self.n), np.array(r)
        p = self._sweep(residual)
        initial = _dot(p, residual)
        if not initial > 0.0 and residual.any():
            self.negative_pivots = 1
            return np.full(self.n, np.nan)
        if self._coarse is not None:
            modes, images, coarse = self._coarse
            amplitudes = coarse.solve(modes.T @ residual)
            x, residual = modes @ amplitudes, residual - images @ amplitudes
            p = self._deflate(self._sweep(residual), residual)
        zr = _dot(p, residual)
        for k in range(MAX_ITERATIONS):
            if not zr > RESIDUAL_RATIO**2 * initial:  # also for NaN
                break
            image = self._matrix @ p
            self.inner = self.inner[0], self.inner[1] + 1
            curvature = _dot(p, image)
            if not curvature > 0.0:
                self.negative_pivots = 1
                return x if k > 0 else x + p
            x += zr / curvature * p
            residual -= zr / curvature * image
            z = self._deflate(self._sweep(residual), residual)
            last, zr = zr, _dot(z, residual)
            p *= zr / last
            p += z
        return x

    def _sweep(self, r: Vector) -> Vector:
        self.inner = self.inner[0] + 1, self.inner[1]
        z = self._incomplete.own.sweep(r)
        return z

    def _deflate(self, z: Vector, r: Vector) -> Vector:
        """Correct the coarse modes in the result z of a sweep on a residual r."""
        if self._coarse is not None:
            modes, images, coarse = self._coarse
            z += modes @ coarse.solve(modes.T @ r - images.T @ z)
        return z


def _dot(a: Vector, b: Vector) -> float:
    """Return the inner product without the threads of a BLAS, which wait on busy cores."""
    return float(np.einsum("i,i->", a, b))
