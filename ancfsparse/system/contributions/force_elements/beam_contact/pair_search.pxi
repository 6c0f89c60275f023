"""Pairs of elements whose boxes overlap, by a uniform grid, in time linear in their number; an include file.

A box holds the control points of an element, and thereby its axis, in one or two states, and a skin
around them.  The list is complete while all control points are in their boxes.
"""
from libc.math cimport floor, fmax, fmin
from libc.stdlib cimport calloc, free, realloc
from libc.string cimport memset

# Listed pairs and cells of an element on average: more, and steps are refused, as in motions that
# sweep over much of the scene.  Dense packings of elements of one diameter have about 30 pairs.
cdef enum:
    MOST_PER_ELEMENT = 400


cdef struct Search:
    ptrdiff_t n
    const double *radius  # of the elements
    const int32_t *side  # that they are on, 1, 2, or 3 for both
    const int32_t *near_start  # neighbours along an axis, which do not
    const int32_t *near
    double skin
    double *box  # (n, 6): lower and upper corners without radii
    int32_t *cell  # (entries, 4): cell and element
    int32_t *bucket  # (buckets + 1,)
    int32_t *order
    int32_t *pair  # (n_pairs, 2)
    ptrdiff_t n_pairs, room_for_pairs, room_for_cells, room_for_buckets
    bint listed  # whether there is a list
    ptrdiff_t renewals


cdef inline void bounds(const double *points, double *low, double *high) noexcept nogil:
    """Extend a box by the control points of an element."""
    cdef int k, c
    for k in range(4):
        for c in range(3):
            low[c] = fmin(low[c], points[3 * k + c])
            high[c] = fmax(high[c], points[3 * k + c])


cdef bint inside(const Search *self, const double *points) noexcept nogil:
    """Return True if all control points (n, 4, 3) are in their boxes."""
    cdef ptrdiff_t e
    cdef int k, c
    cdef const double *box
    cdef const double *x
    for e in range(self.n):
        box, x = self.box + 6 * e, points + 12 * e
        for k in range(4):
            for c in range(3):
                if not box[c] <= x[3 * k + c] <= box[3 + c]:
                    return False
    return True


cdef bint cover(Search *self, const double *one, const double *other) noexcept nogil:
    """List the pairs for two states, or one and null; return False if there are too many."""
    if self.listed and inside(self, one) and (other == NULL or inside(self, other)):
        return True
    return renew(self, one, other)


cdef bint renew(Search *self, const double *one, const double *other) noexcept nogil:
    cdef ptrdiff_t e, k, total = 0, buckets = 16
    cdef double size = 0.0, cells, extent
    cdef double *box
    cdef int c
    self.n_pairs, self.listed = 0, False
    self.renewals += 1
    for e in range(self.n):
        box = self.box + 6 * e
        for c in range(3):
            box[c] = box[3 + c] = one[12 * e + c]
        bounds(one + 12 * e, box, box + 3)
        if other != NULL:
            bounds(other + 12 * e, box, box + 3)
        extent = 0.0
        for c in range(3):
            box[c] -= self.skin
            box[3 + c] += self.skin
            extent = fmax(extent, box[3 + c] - box[c])
        size += extent + 2.0 * self.radius[e]
    size /= self.n
    if not 0.0 < size < 1e300:
        return False
    while buckets < 2 * self.n:
        buckets *= 2
    for e in range(self.n):
        cells = 1.0
        for c in range(3):
            if not (fabs(self.box[6 * e + c]) < 1e9 * size and fabs(self.box[6 * e + 3 + c]) < 1e9 * size):
                return False
            cells *= last_cell(self, e, c, size) - first_cell(self, e, c, size) + 1.0
        total += <ptrdiff_t>fmin(cells, 1e15)
        if total > MOST_PER_ELEMENT * self.n + 1000:
            return False
    if not make_room(self, total, buckets):
        return False
    fill(self, size, buckets)
    if not pair_up(self, size, total, buckets):
        return False
    self.listed = True
    return True


cdef inline double first_cell(const Search *self, ptrdiff_t e, int c, double size) noexcept nogil:
    return floor((self.box[6 * e + c] - self.radius[e]) / size)


cdef inline double last_cell(const Search *self, ptrdiff_t e, int c, double size) noexcept nogil:
    return floor((self.box[6 * e + 3 + c] + self.radius[e]) / size)


cdef inline ptrdiff_t hashed(const int32_t *cell, ptrdiff_t buckets) noexcept nogil:
    return (<ptrdiff_t>cell[0] * 73856093 ^ <ptrdiff_t>cell[1] * 19349663
            ^ <ptrdiff_t>cell[2] * 83492791) & (buckets - 1)


cdef bint make_room(Search *self, ptrdiff_t total, ptrdiff_t buckets) noexcept nogil:
    """Enlarge the arrays of the grid where they are too small; return False without memory."""
    cdef void *cell
    cdef void *order
    cdef void *bucket
    if total > self.room_for_cells:
        cell = realloc(self.cell, 8 * total * sizeof(int32_t))
        if cell == NULL:
            return False
        self.cell = <int32_t *>cell
        order = realloc(self.order, 2 * total * sizeof(int32_t))
        if order == NULL:
            return False
        self.order, self.room_for_cells = <int32_t *>order, 2 * total
    if buckets > self.room_for_buckets:
        bucket = realloc(self.bucket, (buckets + 1) * sizeof(int32_t))
        if bucket == NULL:
            return False
        self.bucket, self.room_for_buckets = <int32_t *>bucket, buckets
    return True


cdef void fill(Search *self, double size, ptrdiff_t buckets) noexcept nogil:
    """Enter every element in the cells that it reaches, and sort these by buckets."""
    cdef ptrdiff_t e, k = 0, b
    cdef int32_t x, y, z
    cdef int32_t *cell
    memset(self.bucket, 0, (buckets + 1) * sizeof(int32_t))
    for e in range(self.n):
        for x in range(<int32_t>first_cell(self, e, 0, size), <int32_t>last_cell(self, e, 0, size) + 1):
            for y in range(<int32_t>first_cell(self, e, 1, size), <int32_t>last_cell(self, e, 1, size) + 1):
                for z in range(<int32_t>first_cell(self, e, 2, size), <int32_t>last_cell(self, e, 2, size) + 1):
                    cell = self.cell + 4 * k
                    cell[0], cell[1], cell[2], cell[3] = x, y, z, <int32_t>e
                    self.bucket[hashed(cell, buckets)] += 1
                    k += 1
    for b in range(1, buckets + 1):
        self.bucket[b] += self.bucket[b - 1]
    while k > 0:  # backwards, so that each bucket is in ascending order
        k -= 1
        b = hashed(self.cell + 4 * k, buckets)
        self.bucket[b] -= 1
        self.order[self.bucket[b]] = <int32_t>k


cdef bint pair_up(Search *self, double size, ptrdiff_t total, ptrdiff_t buckets) noexcept nogil:
    """List the pairs of each cell; return False if there are too many."""
    cdef ptrdiff_t b, i, j, end, room
    cdef const int32_t *one
    cdef const int32_t *other
    cdef void *pairs
    for b in range(buckets):
        end = self.bucket[b + 1] if b + 1 < buckets else total
        for i in range(self.bucket[b], end):
            one = self.cell + 4 * self.order[i]
            for j in range(i + 1, end):
                other = self.cell + 4 * self.order[j]
                if not is_pair(self, one, other, size):
                    continue
                if self.n_pairs == self.room_for_pairs:
                    room = 2 * self.room_for_pairs + 64
                    pairs = NULL
                    if room <= 2 * MOST_PER_ELEMENT * self.n + 1000:
                        pairs = realloc(self.pair, 2 * room * sizeof(int32_t))
                    if pairs == NULL:
                        return False
                    self.pair, self.room_for_pairs = <int32_t *>pairs, room
                self.pair[2 * self.n_pairs] = one[3]
                self.pair[2 * self.n_pairs + 1] = other[3]
                self.n_pairs += 1
    return True


cdef bint is_pair(const Search *self, const int32_t *one, const int32_t *other,
                  double size) noexcept nogil:
    """Return True if boxes overlap, for the cell of the lower corner of their overlap only."""
    cdef ptrdiff_t a = one[3], b = other[3], k
    cdef const double *box = self.box + 6 * a
    cdef const double *next_box = self.box + 6 * b
    cdef double reach = self.radius[a] + self.radius[b]
    cdef int c
    if a == b or self.side[a] | self.side[b] != 3:  # both on one side
        return False
    for c in range(3):
        if one[c] != other[c] or box[c] > next_box[3 + c] + reach or next_box[c] > box[3 + c] + reach:
            return False
        if fmax(first_cell(self, a, c, size), first_cell(self, b, c, size)) != one[c]:
            return False
    for k in range(self.near_start[a], self.near_start[a + 1]):
        if self.near[k] == b:
            return False
    return True
