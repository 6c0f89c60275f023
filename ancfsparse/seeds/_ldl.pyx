# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Refactorisation L D L^T in the order that CHOLMOD found, and its two triangular sweeps.

Up-looking: row k of L is the solution of a triangular system whose pattern is read off the
elimination tree.  Written here because the time loop refactors thousands of small matrices: calling
CHOLMOD through Python and copying L costs ten times the arithmetic at ten elements.
"""
from cpython.pycapsule cimport PyCapsule_New
from libc.stdint cimport int8_t, int32_t, int64_t

import numpy as np


cdef extern from "solver_abi.h":
    ctypedef struct ancf_seed:
        void *context
        ptrdiff_t n
        ptrdiff_t (*factor)(void *, const double *) noexcept nogil
        void (*solve)(void *, const double *, double *) noexcept nogil


cdef struct Factor:
    ptrdiff_t n
    const int32_t *permutation
    const int32_t *parent
    const int8_t *sign
    const int64_t *start
    const int64_t *upper_start
    const int32_t *upper_row
    const int32_t *upper_slot
    int32_t *row
    double *lower
    double *pivot
    double *work  # cleared between calls
    int32_t *flag
    int32_t *reach
    int32_t *count


cdef class Ldl:
    """Factor of a symmetric quasi-definite matrix in permuted order.

    Parameters
    ----------
    permutation : (n,) int32
        ``permutation[k]`` is the unknown eliminated in place k.
    upper_start, upper_row, upper_slot : int64, int32 and int32 arrays
        Upper triangle of the permuted matrix by columns: rows, and the place of each entry in the
        array of values that `factor` gets.
    sign : (n,) int8
        Sign that the pivot of each permuted unknown must have: +1 coordinates, -1 multipliers.
    """

    cdef ancf_seed interface
    cdef Factor data
    cdef object given, parent, row, lower, pivot, work, integers
    cdef readonly ptrdiff_t nnz
    cdef readonly object column_start
    cdef readonly object capsule

    def __cinit__(self, const int32_t[::1] permutation, const int64_t[::1] upper_start,
                  const int32_t[::1] upper_row, const int32_t[::1] upper_slot,
                  const int8_t[::1] sign):
        cdef Factor *data = &self.data
        cdef ptrdiff_t n = permutation.shape[0]
        cdef int64_t[::1] column_start
        cdef int32_t[::1] parent, row
        cdef int32_t[:, ::1] integers
        cdef double[::1] lower, pivot, work
        self.parent, self.column_start = elimination_tree(upper_start, upper_row)
        parent, column_start = self.parent, self.column_start
        self.nnz = column_start[n]
        self.given = (permutation, upper_start, upper_row, upper_slot, sign)
        # One more entry than needed, so that a pointer to the first always exists.
        self.row, self.lower = np.zeros(self.nnz + 1, dtype=np.int32), np.zeros(self.nnz + 1)
        self.pivot, self.work = np.ones(n), np.zeros(n)
        self.integers = np.zeros((3, n), dtype=np.int32)
        row, lower, pivot, work = self.row, self.lower, self.pivot, self.work
        integers = self.integers
        data.n = n
        data.permutation, data.parent, data.sign = &permutation[0], &parent[0], &sign[0]
        data.start, data.upper_start = &column_start[0], &upper_start[0]
        data.upper_row, data.upper_slot = &upper_row[0], &upper_slot[0]
        data.row, data.lower, data.pivot, data.work = &row[0], &lower[0], &pivot[0], &work[0]
        data.flag, data.reach = &integers[0, 0], &integers[1, 0]
        data.count = &integers[2, 0]
        self.interface.context, self.interface.n = data, n
        self.interface.factor, self.interface.solve = factor, solve
        self.capsule = PyCapsule_New(&self.interface, "ancf_seed", NULL)

    def factor(self, const double[::1] values):
        """Factor; return 0, or 1 + the first unknown whose pivot has the wrong sign."""
        return factor(&self.data, &values[0])

    def solve(self, const double[::1] r):
        """Return the solution ``x (n,)`` for the right-hand side ``r (n,)``."""
        x = np.empty(self.data.n)
        cdef double[::1] view = x
        solve(&self.data, &r[0], &view[0])
        return x

    def arrays(self):
        """Return ``(column_start, row, lower, pivot, permutation)`` as copies, for tests."""
        return (self.column_start.copy(), self.row[: self.nnz].copy(),
                self.lower[: self.nnz].copy(), self.pivot.copy(), np.array(self.given[0]))


def elimination_tree(const int64_t[::1] upper_start, const int32_t[::1] upper_row):
    """Return the elimination tree ``(n,)`` and the column starts ``(n + 1,)`` of L.

    Row k of L has an entry in every column that a walk from the entries of column k of the upper
    triangle up the tree meets below k.
    """
    cdef ptrdiff_t n = upper_start.shape[0] - 1, k, i
    cdef int64_t p
    parents, starts, flags = np.full(n, -1, np.int32), np.zeros(n + 1, np.int64), np.zeros(n, np.int32)
    cdef int32_t[::1] parent = parents, flag = flags
    cdef int64_t[::1] start = starts
    for k in range(n):
        flag[k] = <int32_t>k
        for p in range(upper_start[k], upper_start[k + 1]):
            i = upper_row[p]
            while flag[i] != k:
                if parent[i] == -1:
                    parent[i] = <int32_t>k
                start[i + 1] += 1
                flag[i] = <int32_t>k
                i = parent[i]
    return parents, np.cumsum(starts)


cdef ptrdiff_t factor(void *context, const double *values) noexcept nogil:
    cdef const Factor *self = <const Factor *>context
    cdef const int32_t *parent = self.parent
    cdef int32_t *flag = self.flag
    cdef int32_t *reach = self.reach
    cdef int32_t *count = self.count
    cdef int32_t *row = self.row
    cdef const int64_t *start = self.start
    cdef double *lower = self.lower
    cdef double *y = self.work
    cdef double *pivot = self.pivot
    cdef ptrdiff_t n = self.n, k, i, length, top, bad = 0
    cdef int64_t p, end
    cdef double yi, lki, d
    for k in range(n):
        # The pattern of row k: walk from each entry of column k up the elimination tree.
        flag[k] = <int32_t>k
        count[k] = 0
        top = n
        d = 0.0
        for p in range(self.upper_start[k], self.upper_start[k + 1]):
            i = self.upper_row[p]
            if i == k:
                d += values[self.upper_slot[p]]
                continue
            y[i] += values[self.upper_slot[p]]
            length = 0
            while flag[i] != k:
                reach[length] = <int32_t>i
                length += 1
                flag[i] = <int32_t>k
                i = parent[i]
            while length > 0:
                top -= 1
                length -= 1
                reach[top] = reach[length]
        # Solve for the row in that (topological) order.
        while top < n:
            i = reach[top]
            top += 1
            yi = y[i]
            y[i] = 0.0
            end = start[i] + count[i]
            for p in range(start[i], end):
                y[row[p]] -= lower[p] * yi
            lki = yi / pivot[i]
            d -= lki * yi
            row[end] = <int32_t>k
            lower[end] = lki
            count[i] += 1
        pivot[k] = d
        if not d * self.sign[k] > 0.0:  # a NaN ends here too
            if bad == 0:
                bad = 1 + self.permutation[k]
            if d == 0.0 or d != d:
                return bad
    return bad


cdef void solve(void *context, const double *r, double *x) noexcept nogil:
    cdef const Factor *self = <const Factor *>context
    cdef const int32_t *permutation = self.permutation
    cdef int32_t *row = self.row
    cdef const int64_t *start = self.start
    cdef double *lower = self.lower
    cdef double *y = self.work
    cdef double *pivot = self.pivot
    cdef ptrdiff_t n = self.n, k
    cdef int64_t p
    cdef double yk
    for k in range(n):
        y[k] = r[permutation[k]]
    for k in range(n):
        yk = y[k]
        for p in range(start[k], start[k + 1]):
            y[row[p]] -= lower[p] * yk
    for k in range(n - 1, -1, -1):
        yk = y[k] / pivot[k]
        for p in range(start[k], start[k + 1]):
            yk -= lower[p] * y[row[p]]
        y[k] = yk
    for k in range(n):
        x[permutation[k]] = y[k]
        y[k] = 0.0  # the factorisation expects cleared work space
