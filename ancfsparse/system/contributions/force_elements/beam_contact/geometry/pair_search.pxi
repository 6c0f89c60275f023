"""Pairs of elements whose boxes overlap, by a uniform grid, in time linear in their number; an include file.

A box holds the control points of an element, and thereby its axis, in one or two states, and a skin
around them.  The list is complete while all control points are in their boxes.
"""
from libc.float cimport FLT_EPSILON
from libc.math cimport floor, fmax, fmin
from libc.stdlib cimport calloc, free, realloc
from libc.string cimport memset

# Listed pairs and cells of an element on average: more, and steps are refused, as in motions that
# sweep over much of the scene.  Dense packings of elements of one diameter have about 30 pairs.
cdef enum:
    MOST_PER_ELEMENT = 400


# 44 bytes, in the order of the buckets: comparisons read memory in sequence.
cdef struct Entry:
    int32_t cell[3]
    int32_t element
    int32_t first  # axes of whose cells it is in the first, as bits
    float low[3]  # corners of the box with the radius, rounded outwards
    float high[3]


cdef struct Search:
    ptrdiff_t n
    const double *radius  # of the elements
    const int32_t *side  # that they are on, 1, 2, or 3 for both
    const int32_t *near_start  # neighbours along an axis, which do not
    const int32_t *near
    double skin
    double *box  # (n, 6): lower and upper corners without radii
    Entry *entry  # elements in cells
    int32_t *bucket  # (buckets,): ends of the buckets in entries
    int32_t *pair  # (n_pairs, 2)
    ptrdiff_t n_pairs, room_for_pairs, room_for_entries, room_for_buckets
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
            cells *= 1.0 + last_cell(self, e, c, size) - first_cell(self, e, c, size)
        total += <ptrdiff_t>fmin(cells, 1e15)
        if total > MOST_PER_ELEMENT * self.n + 1000:
            return False
    if not make_room(self, total, buckets):
        return False
    fill(self, size, buckets)
    if not pair_up(self, buckets):
        return False
    self.listed = True
    return True


cdef inline int32_t first_cell(const Search *self, ptrdiff_t e, int c, double size) noexcept nogil:
    return <int32_t>floor((self.box[6 * e + c] - self.radius[e]) / size)


cdef inline int32_t last_cell(const Search *self, ptrdiff_t e, int c, double size) noexcept nogil:
    return <int32_t>floor((self.box[6 * e + 3 + c] + self.radius[e]) / size)


cdef inline ptrdiff_t hashed(const int32_t *cell, ptrdiff_t buckets) noexcept nogil:
    return (<ptrdiff_t>cell[0] * 73856093 ^ <ptrdiff_t>cell[1] * 19349663
            ^ <ptrdiff_t>cell[2] * 83492791) & (buckets - 1)


cdef bint make_room(Search *self, ptrdiff_t total, ptrdiff_t buckets) noexcept nogil:
    """Enlarge the arrays of the grid where they are too small; return False without memory."""
    cdef void *entry
    cdef void *bucket
    if total > self.room_for_entries:
        entry = realloc(self.entry, 2 * total * sizeof(Entry))
        if entry == NULL:
            return False
        self.entry, self.room_for_entries = <Entry *>entry, 2 * total
    if buckets > self.room_for_buckets:
        bucket = realloc(self.bucket, buckets * sizeof(int32_t))
        if bucket == NULL:
            return False
        self.bucket, self.room_for_buckets = <int32_t *>bucket, buckets
    return True


cdef void fill(Search *self, double size, ptrdiff_t buckets) noexcept nogil:
    """Enter every element in the cells that it reaches, sorted by buckets."""
    cdef ptrdiff_t b
    cdef int32_t count, start = 0
    memset(self.bucket, 0, buckets * sizeof(int32_t))
    enter(self, size, buckets, False)
    for b in range(buckets):
        count, self.bucket[b] = self.bucket[b], start
        start += count
    enter(self, size, buckets, True)


cdef void enter(Search *self, double size, ptrdiff_t buckets, bint stores) noexcept nogil:
    """Advance the bucket of each cell that an element reaches, and store the entries."""
    cdef ptrdiff_t e, b
    cdef int32_t first[3]
    cdef int32_t last[3]
    cdef Entry entry
    cdef int c
    for e in range(self.n):
        entry.element = <int32_t>e
        for c in range(3):
            first[c], last[c] = first_cell(self, e, c, size), last_cell(self, e, c, size)
            entry.low[c] = <float>below(self.box[6 * e + c] - self.radius[e])
            entry.high[c] = -<float>below(-self.box[6 * e + 3 + c] - self.radius[e])
        for entry.cell[0] in range(first[0], last[0] + 1):
            for entry.cell[1] in range(first[1], last[1] + 1):
                for entry.cell[2] in range(first[2], last[2] + 1):
                    b = hashed(entry.cell, buckets)
                    if stores:
                        entry.first = 0
                        for c in range(3):
                            entry.first |= (entry.cell[c] == first[c]) << c
                        self.entry[self.bucket[b]] = entry
                    self.bucket[b] += 1


cdef inline double below(double x) noexcept nogil:
    """Return a number that is not above x when it is rounded to single precision."""
    return x - FLT_EPSILON * fabs(x)


cdef bint pair_up(Search *self, ptrdiff_t buckets) noexcept nogil:
    """List the pairs of each cell; return False if there are too many."""
    cdef ptrdiff_t b, i, j, room, begin = 0
    cdef const Entry *one
    cdef const Entry *other
    cdef void *pairs
    for b in range(buckets):
        for i in range(begin, self.bucket[b]):
            one = self.entry + i
            for j in range(i + 1, self.bucket[b]):
                other = self.entry + j
                if not is_close(one, other) or not is_pair(self, one.element, other.element):
                    continue
                if self.n_pairs == self.room_for_pairs:
                    room = 2 * self.room_for_pairs + 64
                    pairs = NULL
                    if room <= 2 * MOST_PER_ELEMENT * self.n + 1000:
                        pairs = realloc(self.pair, 2 * room * sizeof(int32_t))
                    if pairs == NULL:
                        return False
                    self.pair, self.room_for_pairs = <int32_t *>pairs, room
                self.pair[2 * self.n_pairs] = one.element
                self.pair[2 * self.n_pairs + 1] = other.element
                self.n_pairs += 1
        begin = self.bucket[b]
    return True


cdef inline bint is_close(const Entry *one, const Entry *other) noexcept nogil:
    """Return True if rounded boxes overlap, for the cell of the lower corner of their overlap only."""
    cdef int c
    if (one.first | other.first) != 7:
        return False
    for c in range(3):
        if (one.cell[c] != other.cell[c] or one.low[c] > other.high[c]
                or other.low[c] > one.high[c]):
            return False
    return True


cdef bint is_pair(const Search *self, ptrdiff_t a, ptrdiff_t b) noexcept nogil:
    """Return True if boxes of elements on both sides overlap that are not neighbours."""
    cdef const double *box = self.box + 6 * a
    cdef const double *next_box = self.box + 6 * b
    cdef double reach = self.radius[a] + self.radius[b]
    cdef ptrdiff_t k
    cdef int c
    if self.side[a] | self.side[b] != 3:  # both on one side
        return False
    for c in range(3):
        if box[c] > next_box[3 + c] + reach or next_box[c] > box[3 + c] + reach:
            return False
    for k in range(self.near_start[a], self.near_start[a + 1]):
        if self.near[k] == b:
            return False
    return True
