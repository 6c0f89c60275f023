# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Refactorisation L D L^T on a pattern that CHOLMOD analysed, and its two triangular sweeps.

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


cdef class Ldl:
    """Factor of a symmetric quasi-definite matrix in permuted order.

    Parameters
    ----------
    permutation : (n,) int32
        ``permutation[k]`` is the unknown eliminated in place k.
    column_start : (n + 1,) int64
        Where each column of L starts (strictly below the diagonal).
    parent : (n,) int32
        Elimination tree, -1 at a root.
    upper_start, upper_row, upper_slot : arrays
        Upper triangle of the permuted matrix by columns: rows, and the place of each entry in the
        array of values that `factor` gets.
    sign : (n,) int8
        Sign that the pivot of each permuted unknown must have: +1 coordinates, -1 multipliers.
    """

    cdef ancf_seed interface
    cdef int32_t[::1] permutation, parent, upper_row, upper_slot, row, flag, reach, count
    cdef int64_t[::1] column_start, upper_start
    cdef double[::1] lower, pivot, work
    cdef int8_t[::1] sign
    cdef readonly object capsule

    def __cinit__(self, permutation, column_start, parent, upper_start, upper_row, upper_slot, sign):
        n = len(permutation)
        self.permutation, self.parent, self.sign = permutation, parent, sign
        self.column_start, self.upper_start = column_start, upper_start
        self.upper_row, self.upper_slot = upper_row, upper_slot
        self.row = np.zeros(column_start[n], dtype=np.int32)
        self.lower = np.zeros(column_start[n])
        self.pivot, self.work = np.ones(n), np.zeros(n)
        self.flag, self.reach, self.count = (np.zeros(n, dtype=np.int32) for _ in range(3))
        self.interface.context, self.interface.n = <void *>self, n
        self.interface.factor, self.interface.solve = factor, solve
        self.capsule = PyCapsule_New(&self.interface, "ancf_seed", NULL)

    @property
    def nnz(self):
        """Entries of L below the diagonal."""
        return self.lower.shape[0]

    def factor(self, const double[::1] values):
        """Factor; return 0, or 1 + the first unknown whose pivot has the wrong sign."""
        return factor(<void *>self, &values[0])

    def solve(self, const double[::1] r):
        """Return the solution ``x (n,)`` for the right-hand side ``r (n,)``."""
        x = np.empty(self.interface.n)
        cdef double[::1] view = x
        solve(<void *>self, &r[0], &view[0])
        return x

    def arrays(self):
        """Return ``(column_start, row, lower, pivot, permutation)`` as copies, for tests."""
        return tuple(np.array(v) for v in (
            self.column_start, self.row, self.lower, self.pivot, self.permutation))


cdef ptrdiff_t factor(void *context, const double *values) noexcept nogil:
    cdef Ldl self = <Ldl>context
    cdef int32_t *parent = &self.parent[0]
    cdef int32_t *flag = &self.flag[0]
    cdef int32_t *reach = &self.reach[0]
    cdef int32_t *count = &self.count[0]
    cdef int32_t *row = &self.row[0] if self.row.shape[0] > 0 else NULL
    cdef int64_t *start = &self.column_start[0]
    cdef double *lower = &self.lower[0] if self.lower.shape[0] > 0 else NULL
    cdef double *y = &self.work[0]
    cdef double *pivot = &self.pivot[0]
    cdef ptrdiff_t n = self.interface.n, k, i, length, top, bad = 0
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
    cdef Ldl self = <Ldl>context
    cdef int32_t *permutation = &self.permutation[0]
    cdef int32_t *row = &self.row[0] if self.row.shape[0] > 0 else NULL
    cdef int64_t *start = &self.column_start[0]
    cdef double *lower = &self.lower[0] if self.lower.shape[0] > 0 else NULL
    cdef double *y = &self.work[0]
    cdef double *pivot = &self.pivot[0]
    cdef ptrdiff_t n = self.interface.n, k
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
