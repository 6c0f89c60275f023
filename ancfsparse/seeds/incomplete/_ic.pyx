# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Incomplete factor of a sparse symmetric positive definite matrix in blocks of three, and its solves.

``ic.h`` describes the factor; this file allocates the arrays.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.stdint cimport int32_t, int64_t

import numpy as np


include "../../abi/solver_abi.pxi"

cdef extern from "ic.h":
    ctypedef struct Ways "ic_modes":
        ptrdiff_t n, n_ways, n_terms, n_values
        ptrdiff_t first[3]
        const int32_t *triple
        const int32_t *mode
        const float *direction
        float *way
        const int32_t *block
        const int32_t *row
        const int32_t *column
        const int32_t *place
        double *values
        double *sums
        const ancf_seed *factor
    ctypedef struct Equations "ic_border":
        ptrdiff_t n, n_own
        const int32_t *first
        const int64_t *entry
        const int32_t *unknown
        const int32_t *place
        const int64_t *own
        const int32_t *own_place
        double *term
        double *schur
        double *size
        double *off
        double *of_x
        double *of_p
        double *of_z
        double *sums
    ctypedef struct Factor "ic":
        ptrdiff_t n, n_triples, n_blocks
        ptrdiff_t first[4]
        ptrdiff_t longest, n_threads
        const int64_t *indptr
        const int32_t *indices
        const int32_t *unknown
        const int32_t *start
        const int32_t *row
        const int32_t *place_of_entry
        double *scale
        double *scale_of
        double *blocks
        double *column
        float *x
        float *r
        float *z
        float *p
        float *w
        Ways modes
        Equations border
        int use, slides
        int mode
        double share
        int64_t sweeps, products
        double extra, per_sweep, per_round, per_slide
    const int BLOCK "IC_BLOCK"
    const int TRIPLE "IC_TRIPLE"
    const int PLAIN "IC_PLAIN"
    const int PAST "IC_PAST"
    const int FRONTS "IC_FRONTS"

cdef extern from "ic_factor.h":
    ptrdiff_t factor "ic_factor" (void *, const double *) noexcept nogil
    int mend "ic_mend" (void *, const double *) noexcept nogil

cdef extern from "ic_solve.h":
    void solve "ic_solve" (void *, const double *, double *) noexcept nogil
    int refine "ic_refine" (void *, double) noexcept nogil
    int gather "ic_gather" (Factor *, const double *, float *) noexcept nogil
    void scatter "ic_scatter" (Factor *, double *, int) noexcept nogil
    double sweep "ic_sweep" (Factor *, const float *, float *) noexcept nogil
    double product "ic_product" (Factor *, float *, float *) noexcept nogil
    ptrdiff_t conjugate "ic_conjugate" (Factor *, double, ptrdiff_t) noexcept nogil


cdef class Ic:
    """Incomplete factor in the order of its triples.

    Parameters
    ----------
    indptr, indices : int64 and int32 arrays
        Lower triangle of the matrix by columns, with equations after the coordinates.
    n : int
        Number of coordinates.
    unknown : (n_triples, 3) int32
        Unknowns of each triple in order of elimination; each unknown is in one triple; -1: none.
    start, row : (n_triples + 1,) and (at least 1,) int32
        Blocks below the diagonal, by block columns, rows ascending.  In columns of the second
        front, rows of the middle refer to its image: they are numbered after all triples.
    first : (4,) int
        First triple of each of two fronts, which are not coupled, and of the middle, which is
        coupled to both; and the end.
    """

    cdef ancf_seed interface
    cdef Factor data
    cdef dict arrays
    cdef object coarse
    cdef readonly object capsule

    def __cinit__(self, const int64_t[::1] indptr, const int32_t[::1] indices, ptrdiff_t n,
                  const int32_t[:, ::1] unknown, const int32_t[::1] start,
                  const int32_t[::1] row, first):
        cdef Factor *data = &self.data
        cdef float[:, ::1] vectors
        cdef double[::1] blocks, column, scale
        cdef double[:, ::1] scale_of
        cdef const int32_t[::1] place
        cdef ptrdiff_t middle, width
        data.n, data.n_triples = n, unknown.shape[0]
        data.n_blocks = data.n_triples + start[data.n_triples]
        for k in range(FRONTS + 2):
            data.first[k] = first[k]
        middle, width = first[FRONTS], data.n_triples - first[FRONTS]
        data.longest, data.n_threads = int(np.max(np.diff(start), initial=1)), 1
        image = width + start[data.n_triples] - start[middle]
        # Some arrays have an extra entry, so that the address of the first one is always valid.
        self.arrays = a = {
            "indptr": np.asarray(indptr), "indices": np.asarray(indices),
            "unknown": np.asarray(unknown), "start": np.asarray(start), "row": np.asarray(row),
            "place": places(indptr, indices, n, unknown, start, row, first,
                            BLOCK * (data.n_blocks + image) + PAST),
            "scale": np.ones(indptr.shape[0] - 1), "scale of": np.ones((data.n_triples, 3)),
            "blocks": np.zeros(BLOCK * (data.n_blocks + image) + PAST + FRONTS),
            "column": np.zeros(FRONTS * (BLOCK * data.longest + PAST)),
            "vectors": np.zeros((5, TRIPLE * (data.n_triples + width)), dtype=np.float32),
        }
        place, scale, blocks, column = a["place"], a["scale"], a["blocks"], a["column"]
        scale_of = a["scale of"]
        vectors = a["vectors"]
        data.indptr, data.indices, data.unknown = &indptr[0], &indices[0], &unknown[0, 0]
        data.start, data.row, data.place_of_entry = &start[0], &row[0], &place[0]
        data.scale, data.scale_of = &scale[0], &scale_of[0, 0]
        data.blocks, data.column = &blocks[0], &column[0]
        data.x, data.r = &vectors[0, 0], &vectors[1, 0]
        data.z, data.p, data.w = &vectors[2, 0], &vectors[3, 0], &vectors[4, 0]
        data.per_sweep = 2.0 * indptr[n]
        data.per_round = 2.0 * data.per_sweep + 10.0 * data.n
        data.per_slide = data.per_sweep + 6.0 * data.n
        self.interface.context, self.interface.n = data, indptr.shape[0] - 1
        self.interface.factor, self.interface.solve = factor, solve
        self.interface.mend, self.interface.refine = mend, refine
        self.interface.extra = &data.extra
        self.capsule = PyCapsule_New(&self.interface, "ancf_seed", NULL)

    @property
    def nbytes(self):
        """Bytes of all arrays except the sparsity pattern of the matrix, which the caller owns."""
        return sum(array.nbytes for name, array in self.arrays.items()
                   if name not in ("indptr", "indices"))

    @property
    def sweeps(self):
        """Number of sweeps so far in solves, each forward and backward."""
        return self.data.sweeps

    @property
    def products(self):
        """Number of products with the matrix so far in solves."""
        return self.data.products

    @property
    def plain(self):
        """Return True if a solve is one sweep."""
        return self.data.mode == PLAIN

    def take_modes(self, modes):
        """Set modes that conjugate gradients may use, a `modes.Coarse`, before the first factor."""
        cdef Ways *own = &self.data.modes
        cdef const int32_t[::1] triple = modes.triple, mode = modes.mode
        cdef const int32_t[::1] block = modes.block, row = modes.row, column = modes.column
        cdef const int32_t[::1] place = modes.place
        cdef const float[:, ::1] direction = modes.direction
        cdef float[:, ::1] way = np.zeros((len(modes.mode), TRIPLE), dtype=np.float32)
        cdef double[::1] values = np.zeros(FRONTS * len(modes.factor._pattern[1]))
        cdef double[::1] sums = np.zeros(2 * FRONTS * modes.factor.n)
        self.arrays |= {"way": np.asarray(way), "values": np.asarray(values),
                        "sums": np.asarray(sums), "triple": modes.triple, "mode": modes.mode,
                        "direction": modes.direction, "block": modes.block, "left": modes.row,
                        "right": modes.column, "place of term": modes.place}
        self.coarse = modes.factor.own
        own.n, own.n_ways, own.n_terms = modes.factor.n, mode.shape[0], block.shape[0]
        own.n_values = values.shape[0] // FRONTS
        second = int(np.searchsorted(modes.triple, self.data.first[1]))
        own.first[0], own.first[1], own.first[2] = 0, second, own.n_ways
        own.triple, own.mode, own.direction = &triple[0], &mode[0], &direction[0, 0]
        own.block, own.row, own.column, own.place = &block[0], &row[0], &column[0], &place[0]
        own.way, own.values, own.sums = &way[0, 0], &values[0], &sums[0]
        own.factor = <const ancf_seed *>PyCapsule_GetPointer(self.coarse.capsule, "ancf_seed")

    def take_border(self, border):
        """Set the equations, a `border.Border`, before the first factor."""
        cdef Equations *own = &self.data.border
        cdef const int32_t[::1] first = border.first, unknown = border.unknown, place = border.place
        cdef const int32_t[::1] own_place = border.own_place
        cdef const int64_t[::1] entry = border.entry, entries = border.own
        cdef double[::1] term = np.zeros(len(border.entry))
        cdef double[:, ::1] schur = np.zeros((border.n, border.n)), rows = np.zeros((6, border.n))
        self.arrays |= {"term": np.asarray(term), "schur": np.asarray(schur),
                        "rows": np.asarray(rows), "first": border.first,
                        "entry": border.entry, "held": border.unknown, "lane": border.place,
                        "own": border.own, "own place": border.own_place}
        own.n, own.n_own = border.n, entries.shape[0]
        own.first, own.entry, own.unknown, own.place = &first[0], &entry[0], &unknown[0], &place[0]
        own.own, own.own_place = &entries[0], &own_place[0]
        own.term, own.schur = &term[0], &schur[0, 0]
        own.size, own.off, own.of_x = &rows[0, 0], &rows[1, 0], &rows[2, 0]
        own.of_p, own.of_z, own.sums = &rows[3, 0], &rows[4, 0], &rows[5, 0]
        self.data.per_round += self.data.per_sweep

    @property
    def sizes(self):
        """Scale factors that make the equations comparable with unit residuals, (m,)."""
        return self.arrays["rows"][0] if "rows" in self.arrays else np.zeros(0)

    @property
    def coarse_values(self):
        """Entries of the coarse matrix of the last factor that used the modes."""
        return self.arrays["values"][: self.data.modes.n_values].copy()

    @property
    def slides(self):
        """Return True if conjugate gradients use the modes with this factor."""
        return bool(self.data.slides)

    @property
    def use(self):
        """Use of the modes, from one factor to the next (`ic_coarse.h`)."""
        return self.data.use

    @use.setter
    def use(self, int value):
        self.data.use = value

    def set_threads(self, ptrdiff_t threads):
        """Set the number of threads; at most two are used."""
        self.data.n_threads = threads

    def factor(self, const double[::1] values):
        """Factor; return 0, or 1 + the first unknown whose pivot is not positive (no factor)."""
        return factor(&self.data, &values[0])

    def mend(self, const double[::1] values):
        """Factor with a larger diagonal; return whether that succeeded."""
        return bool(mend(&self.data, &values[0]))

    def refine(self, double share):
        """Reduce the residual of solves to a fraction; return whether that is a change."""
        return bool(refine(&self.data, share))

    def solve(self, const double[::1] r):
        """Return the solution ``x (n,)`` of ``r (n,)``, as for compiled callers."""
        x = np.empty(self.interface.n)
        cdef double[::1] view = x
        solve(&self.data, &r[0], &view[0])
        return x

    def sweep(self, const double[::1] r):
        """Return the result of one sweep for ``r (n,)``, without equations; it is not counted."""
        x = np.empty(self.data.n)
        cdef double[::1] view = x
        cdef int power = gather(&self.data, &r[0], self.data.x)
        sweep(&self.data, NULL, self.data.x)
        scatter(&self.data, &view[0], power)
        self.data.sweeps -= 1
        return x

    def solve_to(self, const double[::1] r, double share, ptrdiff_t most):
        """Return a solution by conjugate gradients, and the number of iterations; none is counted.

        Parameters
        ----------
        r : (n,) float
            Right-hand side.
        share : float
            Relative residual to reach, in the norm of the factor.
        most : int
            Largest number of iterations.
        """
        x = np.empty(self.interface.n)
        cdef double[::1] view = x
        cdef int64_t sweeps = self.data.sweeps, products = self.data.products
        cdef int power = gather(&self.data, &r[0], self.data.r)
        rounds = conjugate(&self.data, share, most)
        self.data.sweeps, self.data.products = sweeps, products
        scatter(&self.data, &view[0], power)
        return x, rounds

    def columns(self):
        """Return ``(unknown, start, row, blocks)`` of the factor, for tests.

        ``blocks (n_blocks, 3, 3)`` are the inverse pivots, then N below the diagonal by columns.
        """
        a = self.arrays
        singles = a["blocks"].view(np.float32)[:BLOCK * self.data.n_blocks]
        blocks = singles.reshape(-1, 3, 3).transpose(0, 2, 1).astype(float)
        width = self.data.n_triples - self.data.first[FRONTS]
        row = a["row"] - width * (a["row"] >= self.data.n_triples)
        return a["unknown"], a["start"], row, blocks, a["scale"]


def places(const int64_t[::1] indptr, const int32_t[::1] indices, ptrdiff_t n,
           const int32_t[:, ::1] unknown, const int32_t[::1] start, const int32_t[::1] row, first,
           ptrdiff_t spare):
    """Return the index of each entry of the coordinates in the values of the blocks, int32.

    Entries of equations go to `spare`, where each front has a slot that is never read.
    """
    cdef ptrdiff_t n_triples = unknown.shape[0], t, k, j
    cdef int64_t p, low, high, between, block
    cdef ptrdiff_t second = first[1], middle = first[2]
    cdef int32_t a, b, r, c
    of_unknown = np.empty(n, dtype=np.int32)
    out = np.empty(indptr[n], dtype=np.int32)
    cdef int32_t[::1] lane = of_unknown, place = out
    for t in range(n_triples):
        for k in range(3):
            if unknown[t, k] >= 0:
                lane[unknown[t, k]] = <int32_t>(3 * t + k)
    for j in range(n):
        for p in range(indptr[j], indptr[j + 1]):
            if indices[p] >= n:
                place[p] = <int32_t>(spare + (j >= n // FRONTS))
                continue
            a, b = lane[indices[p]], lane[j]
            if a < b:
                a, b = b, a
            r, c = a // 3, b // 3
            if r == c:
                block = r
            else:
                if second <= c < middle <= r:
                    r += <int32_t>(n_triples - middle)
                low, high = start[c], start[c + 1]
                while high - low > 1:
                    between = (low + high) // 2
                    if row[between] <= r:
                        low = between
                    else:
                        high = between
                block = n_triples + low
            place[p] = <int32_t>(BLOCK * block + 3 * (b % 3) + a % 3)
    return out
