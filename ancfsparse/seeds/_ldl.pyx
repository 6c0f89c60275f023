# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Refactorisation L D L^T in a given order, and its two triangular sweeps, in supernodes.

A supernode is a run of columns of L with one and the same pattern below: the coordinates of a node, or
more.  Its part of L is a packed unit triangle and a dense block with one row for each row of the pattern,
so an index is read once for a whole row and the inner loops run over neighbours in memory.

Up-looking: row k of L is the solution of a triangular system whose pattern is read off the elimination
tree of the supernodes.  Written here because the time loop refactors thousands of small matrices.
"""
from cpython.pycapsule cimport PyCapsule_New
from libc.math cimport INFINITY
from libc.stdint cimport INT64_MAX, int8_t, int32_t, int64_t

import numpy as np


cdef extern from "solver_abi.h":
    ctypedef struct ancf_seed:
        void *context
        ptrdiff_t n
        ptrdiff_t (*factor)(void *, const double *) noexcept nogil
        void (*solve)(void *, const double *, double *) noexcept nogil


cdef struct Factor:
    ptrdiff_t n, n_super
    const int32_t *permutation
    const int8_t *sign
    # Upper triangle of the permuted matrix by columns.
    const int64_t *upper_start
    const int32_t *upper_row
    const int32_t *upper_slot
    # Supernodes: first column (and the end), rows of the pattern below, numbers of triangle and block.
    const int32_t *super_of
    const int32_t *parent
    const int32_t *first
    const int64_t *row_start
    const int64_t *triangle_start
    const int64_t *block_start
    int32_t *row
    double *triangle
    double *block
    double *pivot
    double *inverse_pivot
    double *work  # cleared between calls
    int32_t *flag
    int32_t *reach
    int32_t *seen


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
    cdef dict arrays
    cdef readonly object column_length, capsule

    def __cinit__(self, const int32_t[::1] permutation, const int64_t[::1] upper_start,
                  const int32_t[::1] upper_row, const int32_t[::1] upper_slot,
                  const int8_t[::1] sign):
        cdef Factor *data = &self.data
        n = permutation.shape[0]
        parent, self.column_length = elimination_tree(upper_start, upper_row)
        first, super_of, super_parent, row_start = supernodes(parent, self.column_length)
        width, rows = np.diff(first).astype(np.int64), np.diff(row_start)
        triangle_start = np.concatenate([[0], np.cumsum(width * (width - 1) // 2)])
        block_start = np.concatenate([[0], np.cumsum(width * rows)])
        # One more entry than needed here and there, so that a pointer to the first always exists.
        self.arrays = {
            "permutation": np.asarray(permutation), "sign": np.asarray(sign),
            "upper_start": np.asarray(upper_start), "upper_row": np.asarray(upper_row),
            "upper_slot": np.asarray(upper_slot), "super_of": super_of, "parent": super_parent,
            "first": first, "row_start": row_start, "triangle_start": triangle_start,
            "block_start": block_start, "row": np.zeros(row_start[-1] + 1, dtype=np.int32),
            "triangle": np.zeros(triangle_start[-1] + 1), "block": np.zeros(block_start[-1] + 1),
            "pivot": np.ones(n), "inverse_pivot": np.ones(n), "work": np.zeros(n),
            "flag": np.zeros(len(width), dtype=np.int32),
            "reach": np.zeros(len(width), dtype=np.int32),
            "seen": np.zeros(len(width), dtype=np.int32),
        }
        a = self.arrays
        data.n, data.n_super = n, len(width)
        data.permutation, data.sign = &permutation[0], &sign[0]
        data.upper_start, data.upper_row = &upper_start[0], &upper_row[0]
        data.upper_slot = &upper_slot[0]
        data.super_of, data.parent = ints(a["super_of"]), ints(a["parent"])
        data.first, data.row = ints(a["first"]), ints(a["row"])
        data.flag, data.reach, data.seen = ints(a["flag"]), ints(a["reach"]), ints(a["seen"])
        data.row_start, data.triangle_start = longs(row_start), longs(triangle_start)
        data.block_start = longs(block_start)
        data.triangle, data.block = reals(a["triangle"]), reals(a["block"])
        data.pivot, data.inverse_pivot = reals(a["pivot"]), reals(a["inverse_pivot"])
        data.work = reals(a["work"])
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

    def columns(self):
        """Return ``(column_start, row, lower, pivot, permutation)`` of L by columns, for tests."""
        a = self.arrays
        start = np.concatenate([[0], np.cumsum(self.column_length)])
        row, lower = np.empty(start[-1], dtype=np.int32), np.empty(start[-1])
        for s, (f, end) in enumerate(zip(a["first"][:-1], a["first"][1:])):
            below = a["row"][a["row_start"][s]:a["row_start"][s + 1]]
            block = a["block"][a["block_start"][s]:a["block_start"][s + 1]].reshape(-1, end - f)
            for c in range(end - f):
                inside = np.arange(c + 1, end - f)
                triangle = a["triangle"][a["triangle_start"][s] + inside * (inside - 1) // 2 + c]
                place = slice(start[f + c], start[f + c + 1])
                row[place] = np.concatenate([f + inside, below])
                lower[place] = np.concatenate([triangle, block[:, c]])
        return start, row, lower, a["pivot"].copy(), a["permutation"].copy()


cdef int32_t *ints(array) except NULL:
    cdef int32_t[::1] view = array
    return &view[0]


cdef int64_t *longs(array) except NULL:
    cdef int64_t[::1] view = array
    return &view[0]


cdef double *reals(array) except NULL:
    cdef double[::1] view = array
    return &view[0]


def permuted_upper(const int64_t[::1] indptr, const int32_t[::1] indices,
                   const int32_t[::1] permutation):
    """Return the upper triangle by columns of a permuted matrix: starts, rows, and old slots.

    Parameters
    ----------
    indptr, indices : (n + 1,) int64 and (nnz,) int32
        Lower triangle by columns.
    permutation : (n,) int32
        Unknown that comes to each place.
    """
    cdef ptrdiff_t n = permutation.shape[0], j
    cdef int64_t p, to
    cdef int32_t row, column
    starts, places = np.zeros(n + 2, dtype=np.int64), np.empty(n, dtype=np.int32)
    rows, slots = (np.empty(indices.shape[0], dtype=np.int32) for _ in range(2))
    cdef int64_t[::1] start = starts
    cdef int32_t[::1] place = places, out_row = rows, out_slot = slots
    for j in range(n):
        place[permutation[j]] = <int32_t>j
    # Count the columns two places on, so that filling moves every count to its own start.
    for j in range(n):
        for p in range(indptr[j], indptr[j + 1]):
            start[max(place[indices[p]], place[j]) + 2] += 1
    for j in range(n):
        start[j + 2] += start[j + 1]
    for j in range(n):
        for p in range(indptr[j], indptr[j + 1]):
            row, column = place[indices[p]], place[j]
            if row > column:
                row, column = column, row
            to = start[column + 1]
            start[column + 1] += 1
            out_row[to] = row
            out_slot[to] = <int32_t>p
    return starts[:n + 1], rows, slots


def elimination_tree(const int64_t[::1] upper_start, const int32_t[::1] upper_row,
                     int64_t most=INT64_MAX):
    """Return the elimination tree and the length below the diagonal of each column of L, ``(n,)``.

    Row k of L has an entry in every column that a walk from the entries of column k of the upper
    triangle up the tree meets below k.  With more than ``most`` entries in all the walk is broken
    off and None returned.
    """
    cdef ptrdiff_t n = upper_start.shape[0] - 1, k, i
    cdef int64_t total = 0
    cdef int64_t p
    parents, flags = np.full(n, -1, dtype=np.int32), np.zeros(n, dtype=np.int32)
    lengths = np.zeros(n, dtype=np.int64)
    cdef int32_t[::1] parent = parents, flag = flags
    cdef int64_t[::1] length = lengths
    for k in range(n):
        flag[k] = <int32_t>k
        for p in range(upper_start[k], upper_start[k + 1]):
            i = upper_row[p]
            while flag[i] != k:
                if parent[i] == -1:
                    parent[i] = <int32_t>k
                length[i] += 1
                total += 1
                flag[i] = <int32_t>k
                i = parent[i]
        if total > most:
            return None
    return parents, lengths


def supernodes(parent, column_length):
    """Return first columns (and n), supernode of each column, their tree, and starts of their rows.

    A column joins the one before if it is its parent and its pattern is that of the one before
    without itself.
    """
    n = len(parent)
    joins = np.zeros(n, dtype=bool)
    joins[1:] = (parent[:-1] == np.arange(1, n)) & (column_length[:-1] == column_length[1:] + 1)
    first = np.append(np.flatnonzero(~joins), n).astype(np.int32)
    super_of = (np.cumsum(~joins) - 1).astype(np.int32)
    last = first[1:] - 1
    up = parent[last]
    super_parent = np.where(up >= 0, super_of[np.maximum(up, 0)], -1).astype(np.int32)
    row_start = np.concatenate([[0], np.cumsum(column_length[last])]).astype(np.int64)
    return first, super_of, super_parent, row_start


cdef inline double dot(const double *x, const double *y, ptrdiff_t n) noexcept nogil:
    cdef double total = 0.0
    cdef ptrdiff_t i
    for i in range(n):
        total += x[i] * y[i]
    return total


cdef inline void solve_triangle(const double *triangle, double *y, ptrdiff_t width) noexcept nogil:
    cdef ptrdiff_t c
    for c in range(1, width):
        y[c] -= dot(triangle, y, c)
        triangle += c


cdef ptrdiff_t factor(void *context, const double *values) noexcept nogil:
    cdef const Factor *self = <const Factor *>context
    cdef const int32_t *super_of = self.super_of
    cdef const int32_t *row
    cdef int32_t *flag = self.flag
    cdef int32_t *reach = self.reach
    cdef int32_t *seen = self.seen
    cdef double *y = self.work
    cdef double *pivot = self.pivot
    cdef double *entry
    cdef const double *block
    cdef ptrdiff_t k, i, s, own, width, length, top, r, bad = 0
    cdef int64_t p
    cdef double d
    for s in range(self.n_super):
        flag[s] = -1
        seen[s] = 0
    for k in range(self.n):
        # The pattern of row k: walk from each entry of column k up the tree of supernodes.
        own = super_of[k]
        flag[own] = <int32_t>k
        top = self.n_super
        d = 0.0
        for p in range(self.upper_start[k], self.upper_start[k + 1]):
            i = self.upper_row[p]
            if i == k:
                d += values[self.upper_slot[p]]
                continue
            y[i] += values[self.upper_slot[p]]
            s = super_of[i]
            length = 0
            while flag[s] != k:
                reach[length] = <int32_t>s
                length += 1
                flag[s] = <int32_t>k
                s = self.parent[s]
            while length > 0:
                top -= 1
                length -= 1
                reach[top] = reach[length]
        # Solve for the row in that (topological) order.
        while top < self.n_super:
            s = reach[top]
            top += 1
            i = self.first[s]
            width = self.first[s + 1] - i
            block = self.block + self.block_start[s]
            row = self.row + self.row_start[s]
            solve_triangle(self.triangle + self.triangle_start[s], y + i, width)
            for r in range(seen[s]):
                y[row[r]] -= dot(block + r * width, y + i, width)
            entry = self.block + self.block_start[s] + seen[s] * width
            for r in range(width):
                entry[r] = y[i + r] * self.inverse_pivot[i + r]
                d -= entry[r] * y[i + r]
                y[i + r] = 0.0
            self.row[self.row_start[s] + seen[s]] = <int32_t>k
            seen[s] += 1
        i = self.first[own]
        width = k - i
        entry = self.triangle + self.triangle_start[own] + width * (width - 1) // 2
        solve_triangle(self.triangle + self.triangle_start[own], y + i, width)
        for r in range(width):
            entry[r] = y[i + r] * self.inverse_pivot[i + r]
            d -= entry[r] * y[i + r]
            y[i + r] = 0.0
        pivot[k] = d
        self.inverse_pivot[k] = 1.0 / d
        if not 0.0 < d * self.sign[k] < INFINITY:  # a NaN ends here too
            if bad == 0:
                bad = 1 + self.permutation[k]
            if d == 0.0 or not -INFINITY < d < INFINITY:
                return bad
    return bad


cdef inline void forward(const Factor *self, ptrdiff_t s, ptrdiff_t width, double *x,
                         double *held) noexcept nogil:
    """Eliminate a supernode from the rows below it; ``held`` is its part of x, or a copy."""
    cdef const double *block = self.block + self.block_start[s]
    cdef const int32_t *row = self.row + self.row_start[s]
    cdef double *y = x + self.first[s]
    cdef ptrdiff_t r, c
    for c in range(width):
        held[c] = y[c]
    solve_triangle(self.triangle + self.triangle_start[s], held, width)
    for c in range(width):
        y[c] = held[c]
    for r in range(self.row_start[s + 1] - self.row_start[s]):
        x[row[r]] -= dot(block + r * width, held, width)


cdef inline void backward(const Factor *self, ptrdiff_t s, ptrdiff_t width, double *x,
                          double *held) noexcept nogil:
    cdef const double *block = self.block + self.block_start[s]
    cdef const double *triangle = self.triangle + self.triangle_start[s + 1]
    cdef const int32_t *row = self.row + self.row_start[s]
    cdef const double *scale = self.inverse_pivot + self.first[s]
    cdef double *y = x + self.first[s]
    cdef ptrdiff_t r, c, k
    cdef double value
    for c in range(width):
        held[c] = y[c] * scale[c]
    for r in range(self.row_start[s + 1] - self.row_start[s]):
        value = x[row[r]]
        for c in range(width):
            held[c] -= block[r * width + c] * value
    for c in range(width - 1, 0, -1):
        triangle -= c
        for k in range(c):
            held[k] -= triangle[k] * held[c]
    for c in range(width):
        y[c] = held[c]


cdef void solve(void *context, const double *r, double *x) noexcept nogil:
    cdef const Factor *self = <const Factor *>context
    cdef const int32_t *permutation = self.permutation
    cdef double *y = self.work
    cdef double held[12]
    cdef ptrdiff_t k, s, width
    for k in range(self.n):
        y[k] = r[permutation[k]]
    # Nodes of planar cables, spatial cables and thick beams: loops of known length, in registers.
    for s in range(self.n_super):
        width = self.first[s + 1] - self.first[s]
        if width == 4:
            forward(self, s, 4, y, held)
        elif width == 6:
            forward(self, s, 6, y, held)
        elif width == 12:
            forward(self, s, 12, y, held)
        else:
            forward(self, s, width, y, y + self.first[s])
    for s in range(self.n_super - 1, -1, -1):
        width = self.first[s + 1] - self.first[s]
        if width == 4:
            backward(self, s, 4, y, held)
        elif width == 6:
            backward(self, s, 6, y, held)
        elif width == 12:
            backward(self, s, 12, y, held)
        else:
            backward(self, s, width, y, y + self.first[s])
    for k in range(self.n):
        x[permutation[k]] = y[k]
        y[k] = 0.0  # the factorisation expects cleared work space
