# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Product with the inverse of a block-diagonal matrix with small dense blocks.

A triangular solve is sequential, since each unknown depends on the previous ones; a product is not.
"""
from cpython.pycapsule cimport PyCapsule_New
from libc.stdint cimport int32_t, int64_t

import numpy as np


cdef extern from "simd.h":
    const int LANES "ANCF_LANES"
    ctypedef double vec
    vec set1 "vec_set1" (double) noexcept nogil

include "../../abi/solver_abi.pxi"


cdef struct Inverse:
    ptrdiff_t n, n_blocks
    const int32_t *order  # unknowns, block by block
    const int64_t *first  # first entry of each block in `order`, and the end
    const int64_t *start  # and in `columns`
    const double *columns  # of each inverse: an even number, each of an even number of SIMD vectors
    double *right
    double *left


cdef class Blocks:
    """Inverses of the diagonal blocks of a matrix.

    Parameters
    ----------
    members : sequence of (n_k,) int arrays
        Unknowns of each block, which partition all unknowns.
    inverses : sequence of (n_k, n_k) float arrays
        Inverse of each block.
    """

    cdef ancf_seed interface
    cdef Inverse data
    cdef object arrays
    cdef readonly object capsule

    def __cinit__(self, members, inverses):
        cdef Inverse *data = &self.data
        cdef const int32_t[::1] order
        cdef const int64_t[::1] first, start
        cdef double[::1] columns, right, left
        sizes = np.array([len(block) for block in members])
        rows, even = padded(sizes), sizes + sizes % 2
        self.arrays = [
            np.concatenate(members).astype(np.int32),
            np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
            np.concatenate([[0], np.cumsum(rows * even)]).astype(np.int64),
            np.zeros(np.sum(rows * even)), np.zeros(np.max(even)), np.zeros(np.max(rows)),
        ]
        for begin, row, inverse in zip(self.arrays[2], rows, inverses):
            size = len(inverse)
            table = self.arrays[3][begin:begin + row * size].reshape(size, row)
            table[:, :size] = np.asarray(inverse).T
        order, first, start, columns, right, left = self.arrays
        data.n, data.n_blocks = order.shape[0], first.shape[0] - 1
        data.order, data.first, data.start = &order[0], &first[0], &start[0]
        data.columns, data.right, data.left = &columns[0], &right[0], &left[0]
        self.interface.context, self.interface.n = data, data.n
        self.interface.factor, self.interface.solve = NULL, solve
        self.capsule = PyCapsule_New(&self.interface, "ancf_seed", NULL)

    def solve(self, const double[::1] r):
        """Return the solution ``x (n,)`` for the right-hand side ``r (n,)``."""
        x = np.empty(self.data.n)
        cdef double[::1] view = x
        solve(&self.data, &r[0], &view[0])
        return x


def padded(sizes):
    """Return lengths rounded up to an even number of vectors of this instruction set."""
    return -(-sizes // (2 * LANES)) * (2 * LANES)


cdef void solve(void *context, const double *r, double *x) noexcept nogil:
    cdef Inverse *self = <Inverse *>context
    cdef const int32_t *order
    cdef const vec *column
    cdef vec *out = <vec *>self.left
    cdef vec z0, z1, y0, y1, rj
    cdef ptrdiff_t b, i, j, size, even, step
    for b in range(self.n_blocks):
        order = self.order + self.first[b]
        size = self.first[b + 1] - self.first[b]
        even = size + size % 2
        step = (self.start[b + 1] - self.start[b]) // even // LANES
        for j in range(size):
            self.right[j] = r[order[j]]
        self.right[even - 1] = self.right[even - 1] if even == size else 0.0
        # Four independent sums: a single one would be limited by the latency of additions.
        i = 0
        while i < step:
            column = <const vec *>(self.columns + self.start[b]) + i
            z0 = z1 = y0 = y1 = set1(0.0)
            j = 0
            while j < even:
                rj = set1(self.right[j])
                z0 = z0 + column[0] * rj
                z1 = z1 + column[1] * rj
                rj = set1(self.right[j + 1])
                y0 = y0 + column[step] * rj
                y1 = y1 + column[step + 1] * rj
                column += 2 * step
                j += 2
            out[i] = z0 + y0
            out[i + 1] = z1 + y1
            i += 2
        for j in range(size):
            x[order[j]] = self.left[j]
