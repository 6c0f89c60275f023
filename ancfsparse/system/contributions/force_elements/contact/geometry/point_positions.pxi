"""Positions of all points of an element at once; included by `_contacts.pyx`.

Consecutive points that are sums of the same coordinates form a group.  Their indices are read once,
and forces on the points of a group are added to the residual together.
"""


cdef extern from "vectors.h":
    void sum_rows "vec_sum_rows" (
        const double *, const int32_t *, const double *, double *) noexcept nogil


cdef enum:
    MAX_POINTS = 3  # points of a group: those of an element
    CACHE_LINE = 8  # numbers


cdef struct Groups:
    ptrdiff_t n
    const int32_t *first  # point of each group, and the end
    const int32_t *term  # first coordinate of each group in `place`, and the end
    const int32_t *place  # of all directions of each coordinate together
    const int32_t *in_row  # whether `sum_rows` applies: to cubic elements in space
    const int32_t *alike  # first of the groups up to each one that are like it, see `PointSums.alike`


cdef take_groups(Groups *self, first, term, place, in_row, alike):
    """Set the pointers into arrays that their owner keeps."""
    if np.max(np.diff(first)) > MAX_POINTS:
        raise ValueError(f"a group has at most {MAX_POINTS} points")
    self.n = len(first) - 1
    self.first, self.term, self.place = integers(first), integers(term), integers(place)
    self.in_row, self.alike = integers(in_row), integers(alike)


cdef inline void sum_terms(const double *weight, const int32_t *place, ptrdiff_t size,
                           ptrdiff_t dim, const double *q, double *x) noexcept nogil:
    cdef double a = 0.0, b = 0.0, c = 0.0
    cdef ptrdiff_t i
    for i in range(size):
        a += weight[i] * q[place[dim * i]]
        b += weight[i] * q[place[dim * i + 1]]
        if dim == 3:
            c += weight[i] * q[place[dim * i + 2]]
    x[0], x[1], x[2] = a, b, c


cdef void sum_group(const Data *self, ptrdiff_t g, const double *q, double *x,
                    ptrdiff_t stride) noexcept nogil:
    """Sum the coordinates of a group, with zero third components in the plane.

    Each has four numbers, the last one unused.
    """
    cdef const Groups *groups = &self.groups
    cdef const double *weight = self.points.weight + self.points.start[groups.first[g]]
    cdef const int32_t *place = groups.place + self.points.dim * groups.term[g]
    cdef ptrdiff_t size = groups.term[g + 1] - groups.term[g], k
    cdef ptrdiff_t n = groups.first[g + 1] - groups.first[g]
    if groups.in_row[g]:
        for k in range(n):
            sum_rows(weight + 4 * k, place, q, x + stride * k)
        return
    for k in range(n):
        sum_terms(weight, place, size, self.points.dim, q, x)
        weight += size
        x += stride


cdef void locate_group(const Data *self, ptrdiff_t g, const double *q, Place *out) noexcept nogil:
    """Find the points of a group relative to the obstacle."""
    cdef ptrdiff_t p
    approach_group(self, g, q, out)
    for p in range(self.groups.first[g + 1] - self.groups.first[g]):
        face(self, &out[p])


cdef inline void approach_group(const Data *self, ptrdiff_t g, const double *q,
                                Place *out) noexcept nogil:
    """Find the distances of the points of a group, see `approach`."""
    cdef ptrdiff_t p, first = self.groups.first[g]
    sum_group(self, g, q, &out[0].x[0], sizeof(Place) // sizeof(double))
    for p in range(self.groups.first[g + 1] - first):
        if self.frame_moves:
            take_vectors(self, first + p, q, &out[p])
        approach(self, first + p, &out[p])


cdef inline void subtract_terms(const double *weight, ptrdiff_t size, ptrdiff_t n,
                            const int32_t *place, ptrdiff_t dim, const double *f,
                            double *r) noexcept nogil:
    """Subtract forces with their weights for one of `size` coordinates."""
    cdef double a = weight[0] * f[0], b = weight[0] * f[1], c = weight[0] * f[2]
    if n > 1:
        a += weight[size] * f[4]
        b += weight[size] * f[5]
        c += weight[size] * f[6]
    if n > 2:
        a += weight[2 * size] * f[8]
        b += weight[2 * size] * f[9]
        c += weight[2 * size] * f[10]
    r[place[0]] -= a
    r[place[1]] -= b
    if dim == 3:
        r[place[2]] -= c


cdef void subtract_group_forces(const Data *self, ptrdiff_t g, const double *f,
                                double *r) noexcept nogil:
    """Subtract forces on the points of a group, (MAX_POINTS, 4), from the residual."""
    cdef const Groups *groups = &self.groups
    cdef const double *weight = self.points.weight + self.points.start[groups.first[g]]
    cdef const int32_t *place = groups.place + self.points.dim * groups.term[g]
    cdef ptrdiff_t size = groups.term[g + 1] - groups.term[g]
    cdef ptrdiff_t n = groups.first[g + 1] - groups.first[g], dim = self.points.dim, i
    if n == 3 and size == 4 and dim == 3:
        subtract_terms(weight, 4, 3, place, 3, f, r)
        subtract_terms(weight + 1, 4, 3, place + 3, 3, f, r)
        subtract_terms(weight + 2, 4, 3, place + 6, 3, f, r)
        subtract_terms(weight + 3, 4, 3, place + 9, 3, f, r)
        return
    for i in range(size):
        subtract_terms(weight + i, size, n, place + dim * i, dim, f, r)
