"""Conjugate gradients on an incomplete factor and coarse modes: solutions to many digits."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.seeds.complete.sparse_seed import SparseSeed
from ancfsparse.seeds.incomplete.incomplete_seed import IncompleteSeed
from ancfsparse.seeds.interface.index_arrays import Indices
from ancfsparse.seeds.ordering.unknown_groups import Groups

if TYPE_CHECKING:
    import scipy.sparse as sp

Vector = NDArray[np.float64]

# Share of a right-hand side that a solution may leave, in the norm of the sweeps, and most sweeps.
# Newton's corrections on solutions to 1e-2 are half as many again, to 1e-6 as many.
REST, MOST = 1e-4, 5000
# What is added to the diagonal of the matrix of the coarse modes, each of unit energy: some may be
# sums of others.
RIDGE = 1e-10
# Bytes for an entry of the matrix beside the incomplete factor, as measured on lattices: both
# triangles, room to make them, and coarse modes.
ENTRY = 180.0


class CoarseSpace(NamedTuple):
    """Coarse modes of unit energy in columns, what the matrix makes of them, their own factor."""

    modes: sp.csr_array
    images: sp.csr_array
    seed: SparseSeed


class DeflatedSeed:
    """Inverse of a sparse symmetric matrix by conjugate gradients, which many sweeps refine.

    Sweeps through an incomplete factor hardly see motions of large parts, so in every iteration
    coarse modes take those out of what is left (deflation: method A-DEF2 of Tang, Nabben, Vuik and
    Erlangga 2009).  The matrix is taken in double precision.

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
        Sweeps and products with the matrix so far.
    negative_pivots : int
        One if a direction of negative curvature was met since the last `factor`, else none.
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
        """Memory of the factor and of all that is made beside it, about [bytes]."""
        return self._incomplete.nbytes + ENTRY * len(self._indices)

    def factor(self, values: Vector, modes: sp.csc_array) -> None:
        """Factor again; only solutions find out whether the matrix is definite.

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
        self._coarse = self._projected(modes)

    def _projected(self, modes: sp.csc_array) -> CoarseSpace | None:
        """Return the coarse modes with their factor, or None where the matrix is not definite."""
        import scipy.sparse as sp

        assert self._matrix is not None
        images = self._matrix @ modes
        energy = modes.multiply(images).sum(axis=0)
        if np.all(energy > 0.0):
            unit = sp.diags_array(1.0 / np.sqrt(energy))
            modes, images = sp.csr_array(modes @ unit), sp.csr_array(images @ unit)
            own = sp.csc_array(sp.tril(modes.T @ images) + RIDGE * sp.eye_array(len(energy)))
            own.sort_indices()
            seed = SparseSeed(own.indptr, own.indices, own.shape[0])
            if seed.factor(own.data) == 0:
                return CoarseSpace(modes, images, seed)
        self.negative_pivots = 1
        return None

    def solve(self, r: Vector) -> Vector:
        """Return the solution ``(n,)`` for the right-hand side ``r (n,)``.

        Where the matrix curves the wrong way, that is counted, and the solution is what there is;
        NaN where even the first sweep is undefined, as with a zero on the diagonal.
        """
        assert self._matrix is not None
        x, left = np.zeros(self.n), np.array(r)
        p = self._sweep(left)
        whole = _dot(p, left)
        if not whole > 0.0 and left.any():
            self.negative_pivots = 1
            return np.full(self.n, np.nan)
        if self._coarse is not None:
            modes, images, coarse = self._coarse
            amplitudes = coarse.solve(modes.T @ left)
            x, left = modes @ amplitudes, left - images @ amplitudes
            p = self._corrected(self._sweep(left), left)
        zr = _dot(p, left)
        for k in range(MOST):
            if not zr > REST**2 * whole:  # a NaN ends here too
                break
            image = self._matrix @ p
            self.inner = self.inner[0], self.inner[1] + 1
            curvature = _dot(p, image)
            if not curvature > 0.0:
                self.negative_pivots = 1
                return x if k > 0 else x + p
            x += zr / curvature * p
            left -= zr / curvature * image
            z = self._corrected(self._sweep(left), left)
            last, zr = zr, _dot(z, left)
            p *= zr / last
            p += z
        return x

    def _sweep(self, r: Vector) -> Vector:
        self.inner = self.inner[0] + 1, self.inner[1]
        z = self._incomplete.own.sweep(r)
        return z

    def _corrected(self, z: Vector, r: Vector) -> Vector:
        """Put the right share of the coarse modes into what a sweep has made of a residual."""
        if self._coarse is not None:
            modes, images, coarse = self._coarse
            z += modes @ coarse.solve(modes.T @ r - images.T @ z)
        return z


def _dot(a: Vector, b: Vector) -> float:
    """Return the inner product without the threads of a BLAS, which wait where cores are busy."""
    return float(np.einsum("i,i->", a, b))
