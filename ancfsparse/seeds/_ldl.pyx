# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Refactorisation L D L^T in a given order, and its two triangular sweeps, in supernodes.

A supernode is a run of columns of L with one and the same pattern below: the coordinates of a node, or
more.  Its part of L is a packed unit triangle and a dense block with one row for each row of the pattern,
so an index is read once for a whole row and the inner loops run over neighbours in memory.

Right-looking: the matrix is written into the places of L, and every supernode, once eliminated, updates
those that its rows belong to.  Written here because the time loop refactors thousands of small matrices.

For several threads the supernodes stand in parts that do not update one another, disjoint subtrees of the
elimination tree, and a root that all of them may update and that is left to one thread.  In the sweeps
every part has an image of the root's unknowns behind its own: there it adds, and from there it reads, so
rows of a part that belong to the root are numbered as places of the image.
"""
from cpython.pycapsule cimport PyCapsule_New
from libc.math cimport INFINITY
from libc.stdint cimport int32_t, int64_t
from libc.string cimport memcpy, memset

import numpy as np


cdef extern from "parallel.h":
    void in_parts "ancf_in_parts" (
        ptrdiff_t, void (*)(void *, ptrdiff_t) noexcept nogil, void *) noexcept nogil

cdef extern from "solver_abi.h":
    ctypedef struct ancf_seed:
        void *context
        ptrdiff_t n
        ptrdiff_t (*factor)(void *, const double *) noexcept nogil
        void (*solve)(void *, const double *, double *) noexcept nogil


# Entries of the matrix up to which the place of each is kept: 1 MB.
cdef ptrdiff_t FEW_ENTRIES = 250_000


cdef struct Factor:
    ptrdiff_t n, n_super, n_positive
    const int32_t *permutation
    const int32_t *place  # its inverse
    # Lower triangle of the matrix by columns.
    const int64_t *start
    const int32_t *index
    # Supernodes: first column (and the end), rows of the pattern below, numbers of triangle and block.
    const int32_t *super_of
    const int32_t *first
    const int64_t *row_start
    const int64_t *triangle_start
    const int64_t *block_start
    const int32_t *row
    double *entries  # of D and L: pivots, triangles and blocks one after another
    const int32_t *place_of_entry  # of the matrix in them; NULL where these would be too many
    double *triangle
    double *block
    double *inverse_pivot
    double *work
    # Parts: first supernode of each, of the root and the end; first column of the root.
    ptrdiff_t n_parts, root_column, n_root, n_boundary
    const int32_t *part
    const int32_t *boundary  # supernodes of the parts with rows in the root
    double *rows  # space for the rows of one supernode, for each part
    ptrdiff_t most_rows
    ptrdiff_t *outcome  # of each part
    const double *values  # what is being factored
    const double *r  # what is being solved for
    double *x


cdef class Ldl:
    """Factor of a symmetric quasi-definite matrix in permuted order.

    Parameters
    ----------
    indptr, indices : (n + 1,) int64 and int32 arrays
        Lower triangle of the matrix by columns.
    permutation : (n,) int32
        ``permutation[k]`` is the unknown eliminated in place k.
    n_positive : int
        The first unknowns must have positive pivots (coordinates), the others negative ones.
    shape : Shape
        Supernodes and parts.
    row : int32 array
        Rows below the supernodes, as ``shape.rows`` returns them; it is written to.
    """

    cdef ancf_seed interface
    cdef Factor data
    cdef dict arrays
    cdef readonly object capsule

    def __cinit__(self, const int64_t[::1] indptr, const int32_t[::1] indices,
                  const int32_t[::1] permutation, ptrdiff_t n_positive, shape, row):
        cdef Factor *data = &self.data
        cdef ptrdiff_t[::1] outcome
        cdef ptrdiff_t n_triangle
        first, super_of, row_start, parts = shape.first, shape.super_of, shape.row_start, shape.part
        n, n_parts = permutation.shape[0], shape.n_parts
        place = np.empty(n, dtype=np.int32)
        place[np.asarray(permutation)] = np.arange(n, dtype=np.int32)
        width, rows = np.diff(first).astype(np.int64), np.diff(row_start)
        triangle_start = np.concatenate([[0], np.cumsum(width * (width - 1) // 2)])
        block_start = np.concatenate([[0], np.cumsum(width * rows)])
        n_triangle = triangle_start[-1]
        most_rows = int(np.max(width * rows, initial=1))
        root = int(first[parts[-2]])
        boundary = images(row, row_start, n, root, parts)
        # One more entry than needed here and there, so that a pointer to the first always exists.
        self.arrays = {
            "indptr": np.asarray(indptr), "indices": np.asarray(indices),
            "permutation": np.asarray(permutation), "place": place, "super_of": super_of,
            "first": first, "row_start": row_start, "triangle_start": triangle_start,
            "block_start": block_start, "row": row,
            "entries": np.zeros(n + triangle_start[-1] + block_start[-1] + 1), "part": parts,
            "work": np.zeros(n + n_parts * (n - root)),
            "boundary": np.append(boundary, np.int32(0)),
            "rows": np.zeros(n_parts * most_rows), "outcome": np.zeros(n_parts, dtype=np.intp),
        }
        a = self.arrays
        data.n, data.n_super, data.n_positive = n, len(width), n_positive
        data.permutation, data.place = &permutation[0], ints(place)
        data.start, data.index = &indptr[0], &indices[0]
        data.super_of, data.first, data.row = ints(super_of), ints(first), ints(row)
        data.row_start, data.triangle_start = longs(row_start), longs(triangle_start)
        data.block_start = longs(block_start)
        a["entries"][:n] = 1.0
        data.entries, data.work = reals(a["entries"]), reals(a["work"])
        data.inverse_pivot, data.triangle = data.entries, data.entries + data.n
        data.block = data.triangle + n_triangle
        data.n_parts, data.n_boundary = n_parts, len(boundary)
        data.root_column, data.n_root = root, n - root
        data.part, data.boundary = ints(parts), ints(a["boundary"])
        data.rows, data.most_rows = reals(a["rows"]), most_rows
        outcome = a["outcome"]
        data.outcome = &outcome[0]
        if indices.shape[0] <= FEW_ENTRIES:
            a["place_of_entry"] = places(data, indices.shape[0])
            data.place_of_entry = ints(a["place_of_entry"])
        self.interface.context, self.interface.n = data, n
        self.interface.factor, self.interface.solve = factor, solve
        self.capsule = PyCapsule_New(&self.interface, "ancf_seed", NULL)

    @property
    def nbytes(self):
        """Bytes of all arrays but the pattern of the matrix, which is not ours."""
        return sum(array.nbytes for name, array in self.arrays.items()
                   if name not in ("indptr", "indices"))

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
        width, rows = np.diff(a["first"]), np.diff(a["row_start"])
        length = [np.arange(w - 1, -1, -1) + r for w, r in zip(width, rows)]
        start = np.concatenate([[0], np.cumsum(np.concatenate(length))])
        row, lower = np.empty(start[-1], dtype=np.int32), np.empty(start[-1])
        pivots, triangles, blocks = np.split(
            a["entries"], [self.data.n, self.data.n + int(a["triangle_start"][-1])])
        for s, (f, end) in enumerate(zip(a["first"][:-1], a["first"][1:])):
            below = a["row"][a["row_start"][s]:a["row_start"][s + 1]]
            image = below - self.data.n
            below = np.where(image < 0, below, self.data.root_column + image % self.data.n_root
                             if self.data.n_root else 0)
            block = blocks[a["block_start"][s]:a["block_start"][s + 1]].reshape(-1, end - f)
            for c in range(end - f):
                inside = np.arange(c + 1, end - f)
                triangle = triangles[a["triangle_start"][s] + inside * (inside - 1) // 2 + c]
                place = slice(start[f + c], start[f + c + 1])
                row[place] = np.concatenate([f + inside, below])
                lower[place] = np.concatenate([triangle, block[:, c]])
        return start, row, lower, 1.0 / pivots, a["permutation"].copy()


cdef images(int32_t[::1] row, row_start, ptrdiff_t n, ptrdiff_t root, parts):
    """Let rows of the root point to the image of their part; return the supernodes that have such."""
    boundary = []
    if root == n:
        return np.empty(0, dtype=np.int32)
    rows = np.asarray(row)
    for t, (begin, end) in enumerate(zip(parts[:-2], parts[1:-1])):
        mine = rows[row_start[begin]:row_start[end]]
        in_root = mine >= root
        mine[in_root] += np.int32(n - root + t * (n - root))
        # Rows ascend, so the last one tells.
        starts = row_start[begin:end + 1] - row_start[begin]
        filled = np.flatnonzero(np.diff(starts))
        boundary.append(begin + filled[in_root[starts[filled + 1] - 1]])
    return np.concatenate(boundary).astype(np.int32)


cdef const int32_t *ints(array) except NULL:
    cdef const int32_t[::1] view = array
    return &view[0]


cdef const int64_t *longs(array) except NULL:
    cdef const int64_t[::1] view = array
    return &view[0]


cdef double *reals(array) except NULL:
    cdef double[::1] view = array
    return &view[0]


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


cdef void clear(void *context, ptrdiff_t t) noexcept nogil:
    """Clear a part's share of L; the last part takes that of the root too."""
    cdef const Factor *self = <const Factor *>context
    cdef ptrdiff_t a = self.part[t]
    cdef ptrdiff_t b = self.n_super if t + 1 == self.n_parts else self.part[t + 1]
    cdef int64_t at = self.triangle_start[a]
    memset(self.triangle + at, 0, (self.triangle_start[b] - at) * sizeof(double))
    at = self.block_start[a]
    memset(self.block + at, 0, (self.block_start[b] - at) * sizeof(double))


cdef inline ptrdiff_t image_shift(const Factor *self, ptrdiff_t s) noexcept nogil:
    """Return how far the image of the root in the part of supernode s is behind the root."""
    cdef ptrdiff_t t = 0
    while self.part[t + 1] <= s:
        t += 1
    return self.n + t * self.n_root - self.root_column


cdef inline ptrdiff_t locate(const Factor *self, ptrdiff_t j, int64_t p, ptrdiff_t *at) noexcept nogil:
    """Where in L entry p of column j of the matrix has its place; ``at`` guesses its row there."""
    cdef ptrdiff_t row = self.place[self.index[p]], column = self.place[j], s, width, high, middle
    cdef const int32_t *rows
    if row == column:
        return row
    if row < column:
        row, column = column, row
    s = self.super_of[column]
    column -= self.first[s]
    width = self.first[s + 1] - self.first[s]
    if row < self.first[s + 1]:
        row -= self.first[s]
        return (self.triangle - self.entries) + self.triangle_start[s] + row * (row - 1) // 2 + column
    if row >= self.root_column and s < self.part[self.n_parts]:
        row += image_shift(self, s)
    rows = self.row + self.row_start[s]
    high = self.row_start[s + 1] - self.row_start[s]
    if at[0] >= high or rows[at[0]] != row:
        at[0] = 0
        while high - at[0] > 1:
            middle = (at[0] + high) // 2
            if rows[middle] <= row:
                at[0] = middle
            else:
                high = middle
    at[0] += 1  # the next entry of the column is often the next row
    return (self.block - self.entries) + self.block_start[s] + (at[0] - 1) * width + column


cdef void spread(void *context, ptrdiff_t t) noexcept nogil:
    """Write the entries of a range of the matrix' columns to their places in L."""
    cdef const Factor *self = <const Factor *>context
    cdef const double *values = self.values
    cdef const int32_t *place_of_entry = self.place_of_entry
    cdef double *entries = self.entries
    cdef ptrdiff_t begin = self.n * t // self.n_parts, end = self.n * (t + 1) // self.n_parts, j, at
    cdef int64_t p
    if place_of_entry != NULL:
        for p in range(self.start[begin], self.start[end]):
            entries[place_of_entry[p]] = values[p]
        return
    for j in range(begin, end):
        at = 0
        for p in range(self.start[j], self.start[j + 1]):
            entries[locate(self, j, p, &at)] = values[p]


cdef places(const Factor *self, ptrdiff_t n_entries):
    """Return the place of every entry of the matrix in L."""
    cdef ptrdiff_t j, at
    cdef int64_t p
    found = np.empty(n_entries, dtype=np.int32)
    cdef int32_t[::1] place = found
    for j in range(self.n):
        at = 0
        for p in range(self.start[j], self.start[j + 1]):
            place[p] = <int32_t>locate(self, j, p, &at)
    return found


cdef inline void update(const Factor *self, ptrdiff_t s, ptrdiff_t width, ptrdiff_t r,
                        ptrdiff_t end, ptrdiff_t shift, const double *scaled) noexcept nogil:
    """Subtract what supernode s gives to the columns of its rows r to end; ``scaled`` is L D.

    These rows are numbered from ``shift`` on: zero, or where the image of the root is.
    """
    cdef const double *block = self.block + self.block_start[s]
    cdef const int32_t *row = self.row + self.row_start[s]
    cdef const int32_t *to
    cdef double *target
    cdef ptrdiff_t n_rows = self.row_start[s + 1] - self.row_start[s], t, first, i, k, a, behind
    while r < end:
        # The rows up to `behind` are columns of supernode t.
        t = self.super_of[row[r] - shift]
        first = self.first[t]
        behind = r + 1
        while behind < end and row[behind] - shift < self.first[t + 1]:
            behind += 1
        for i in range(r, behind):
            a = row[i] - shift - first
            target = self.triangle + self.triangle_start[t] + a * (a - 1) // 2
            for k in range(r, i):
                target[row[k] - shift - first] -= dot(
                    block + i * width, scaled + k * width, width)
            self.inverse_pivot[first + a] -= dot(block + i * width, scaled + i * width, width)
        to = self.row + self.row_start[t]
        target = self.block + self.block_start[t]
        for i in range(behind, n_rows):
            while to[0] != row[i] - shift:
                to += 1
                target += self.first[t + 1] - first
            for k in range(r, behind):
                target[row[k] - shift - first] -= dot(
                    block + i * width, scaled + k * width, width)
        r = behind


cdef inline ptrdiff_t rows_before(const Factor *self, ptrdiff_t s, ptrdiff_t column) noexcept nogil:
    """Return how many rows of supernode s come before a column."""
    cdef const int32_t *row = self.row + self.row_start[s]
    cdef ptrdiff_t n = self.row_start[s + 1] - self.row_start[s]
    while n > 0 and row[n - 1] >= column:
        n -= 1
    return n


cdef inline ptrdiff_t eliminate(const Factor *self, ptrdiff_t s, ptrdiff_t width,
                                double *scaled) noexcept nogil:
    """Eliminate a supernode and update its part; return 0, or what `factor` does, < 0 if unusable."""
    cdef double *triangle = self.triangle + self.triangle_start[s]
    cdef double *block = self.block + self.block_start[s]
    cdef double *entry = triangle
    cdef double *inverse = self.inverse_pivot + self.first[s]
    cdef double *y
    cdef const int32_t *permutation = self.permutation + self.first[s]
    cdef ptrdiff_t n_rows = self.row_start[s + 1] - self.row_start[s], r, c, bad = 0
    cdef double d, sign
    for c in range(width):
        entry = triangle + c * (c - 1) // 2
        solve_triangle(triangle, entry, c)
        d = inverse[c]
        for r in range(c):
            d -= entry[r] * entry[r] * inverse[r]
            entry[r] *= inverse[r]
        inverse[c] = 1.0 / d
        sign = 1.0 if permutation[c] < self.n_positive else -1.0
        if not 0.0 < d * sign < INFINITY:  # a NaN ends here too
            if bad == 0:
                bad = 1 + permutation[c]
            if d == 0.0 or not -INFINITY < d < INFINITY:
                return -bad
    y = scaled
    entry = block
    for r in range(n_rows):
        for c in range(width):
            y[c] = entry[c]
        solve_triangle(triangle, y, width)
        for c in range(width):
            entry[c] = y[c] * inverse[c]
        y += width
        entry += width
    # Rows of the root come later, from one thread; in the root itself there are only such.
    update(self, s, width, 0,
           n_rows if s >= self.part[self.n_parts] else rows_before(self, s, self.root_column),
           0, scaled)
    return bad


cdef ptrdiff_t eliminate_range(const Factor *self, ptrdiff_t s, ptrdiff_t end,
                               double *scaled) noexcept nogil:
    """Eliminate supernodes s to end; return as `eliminate` does."""
    cdef ptrdiff_t width, found, bad = 0
    for s in range(s, end):
        width = self.first[s + 1] - self.first[s]
        # Nodes of planar cables, spatial cables and thick beams: loops of known length.
        if width == 4:
            found = eliminate(self, s, 4, scaled)
        elif width == 6:
            found = eliminate(self, s, 6, scaled)
        elif width == 12:
            found = eliminate(self, s, 12, scaled)
        else:
            found = eliminate(self, s, width, scaled)
        if found < 0:
            return found if bad == 0 else -bad
        if bad == 0:
            bad = found
    return bad


cdef void eliminate_part(void *context, ptrdiff_t t) noexcept nogil:
    cdef const Factor *self = <const Factor *>context
    self.outcome[t] = eliminate_range(self, self.part[t], self.part[t + 1],
                                      self.rows + t * self.most_rows)


cdef ptrdiff_t factor(void *context, const double *values) noexcept nogil:
    cdef Factor *self = <Factor *>context
    cdef double *scaled = self.rows
    cdef ptrdiff_t t, b, s, width, n_rows, r, c, bad = 0
    self.values = values
    in_parts(self.n_parts, clear, self)
    in_parts(self.n_parts, spread, self)
    in_parts(self.n_parts, eliminate_part, self)
    for t in range(self.n_parts):
        if self.outcome[t] < 0:
            return -self.outcome[t] if bad == 0 else bad
        if bad == 0:
            bad = self.outcome[t]
    for b in range(self.n_boundary):
        s = self.boundary[b]
        width = self.first[s + 1] - self.first[s]
        n_rows = self.row_start[s + 1] - self.row_start[s]
        for r in range(n_rows):
            for c in range(width):
                scaled[r * width + c] = (self.block[self.block_start[s] + r * width + c]
                                         / self.inverse_pivot[self.first[s] + c])
        update(self, s, width, rows_before(self, s, self.root_column), n_rows,
               image_shift(self, s), scaled)
    t = eliminate_range(self, self.part[self.n_parts], self.n_super, scaled)
    return bad if bad != 0 else (t if t > 0 else -t)


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


cdef void gather(const Factor *self, ptrdiff_t s, ptrdiff_t end) noexcept nogil:
    cdef ptrdiff_t k
    for k in range(self.first[s], self.first[end]):
        self.work[k] = self.r[self.permutation[k]]


cdef void forward_range(const Factor *self, ptrdiff_t s, ptrdiff_t end, double *y) noexcept nogil:
    cdef double held[12]
    cdef ptrdiff_t width
    # Nodes of planar cables, spatial cables and thick beams: loops of known length, in registers.
    for s in range(s, end):
        width = self.first[s + 1] - self.first[s]
        if width == 4:
            forward(self, s, 4, y, held)
        elif width == 6:
            forward(self, s, 6, y, held)
        elif width == 12:
            forward(self, s, 12, y, held)
        else:
            forward(self, s, width, y, y + self.first[s])


cdef void backward_range(const Factor *self, ptrdiff_t s, ptrdiff_t end, double *y) noexcept nogil:
    cdef double held[12]
    cdef ptrdiff_t k, width, begin = s
    for s in range(end - 1, s - 1, -1):
        width = self.first[s + 1] - self.first[s]
        if width == 4:
            backward(self, s, 4, y, held)
        elif width == 6:
            backward(self, s, 6, y, held)
        elif width == 12:
            backward(self, s, 12, y, held)
        else:
            backward(self, s, width, y, y + self.first[s])
    for k in range(self.first[begin], self.first[end]):
        self.x[self.permutation[k]] = y[k]


cdef void forward_part(void *context, ptrdiff_t t) noexcept nogil:
    cdef const Factor *self = <const Factor *>context
    gather(self, self.part[t], self.part[t + 1])
    memset(self.work + self.n + t * self.n_root, 0, self.n_root * sizeof(double))
    forward_range(self, self.part[t], self.part[t + 1], self.work)


cdef void backward_part(void *context, ptrdiff_t t) noexcept nogil:
    cdef const Factor *self = <const Factor *>context
    memcpy(self.work + self.n + t * self.n_root, self.work + self.root_column,
           self.n_root * sizeof(double))
    backward_range(self, self.part[t], self.part[t + 1], self.work)


cdef void solve(void *context, const double *r, double *x) noexcept nogil:
    cdef Factor *self = <Factor *>context
    cdef ptrdiff_t root = self.part[self.n_parts], k, t
    self.r, self.x = r, x
    in_parts(self.n_parts, forward_part, self)
    if self.n_root > 0:
        gather(self, root, self.n_super)
        for t in range(self.n_parts):
            for k in range(self.n_root):
                self.work[self.root_column + k] += self.work[self.n + t * self.n_root + k]
        forward_range(self, root, self.n_super, self.work)
        backward_range(self, root, self.n_super, self.work)
    in_parts(self.n_parts, backward_part, self)
