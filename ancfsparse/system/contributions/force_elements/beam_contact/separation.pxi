"""Steps in which no axes pass through each other; an include file.

Every point of an axis moves as a mean of its control points.  Two axes that lie on both sides of one
plane in both states do not meet on the straight way, nor do any whose control points move by less than
their distance relative to each other.
"""

cdef enum:
    SAMPLES = 8  # of an axis for its distance from another one
    REFINEMENTS = 4
cdef double NEARLY = 0.9  # of a distance that is found by samples


cdef double nearest(const Cubic *a, const Cubic *b, double *n) noexcept nogil:
    """Return the distance of two axes, approximately, and set its direction from b to a."""
    cdef Foot foot
    cdef Foot best
    cdef double[3] x
    cdef int k, c
    best.distance = 1e300
    best.u = 0.5
    for k in range(SAMPLES + 1):
        place_at(a, <double>k / SAMPLES, x)
        find_foot(b, x, 0.5, &foot)
        if foot.distance < best.distance:
            best = foot
    for k in range(REFINEMENTS):
        place_at(b, best.u, x)
        find_foot(a, x, 0.5, &foot)
        place_at(a, foot.u, x)
        find_foot(b, x, best.u, &best)
    memcpy(n, best.n, 3 * sizeof(double))
    return best.distance


cdef bint is_separated_along(const double *a, const double *b, const double *n) noexcept nogil:
    """Return True if all control points of a are further along a direction than those of b."""
    cdef double low = 1e300, high = -1e300
    cdef int k
    for k in range(4):
        low = fmin(low, dot(a + 3 * k, n))
        high = fmax(high, dot(b + 3 * k, n))
    return low > high


cdef bint remain_separated(const double *a0, const double *b0, const double *a1,
                     const double *b1) noexcept nogil:
    """Return True if two axes do not pass through each other."""
    cdef Cubic a
    cdef Cubic b
    cdef double[3] n
    cdef double[3] way
    cdef double gap, farthest = 0.0
    cdef int i, j, c
    expand(a0, &a)
    expand(b0, &b)
    gap = nearest(&a, &b, n)
    if is_separated_along(a0, b0, n) and is_separated_along(a1, b1, n):
        return True
    for i in range(4):
        for j in range(4):
            for c in range(3):
                way[c] = a1[3 * i + c] - a0[3 * i + c] - b1[3 * j + c] + b0[3 * j + c]
            farthest = fmax(farthest, dot(way, way))
    return sqrt(farthest) < NEARLY * gap


cdef int admits(void *context, const double *q0, const double *q1) noexcept nogil:
    cdef Data *self = <Data *>context
    cdef const int32_t *pair
    cdef const double *box
    cdef const double *other
    cdef ptrdiff_t k
    cdef int c
    cdef bint is_separated
    set_points(self, q0, self.now)
    set_points(self, q1, self.halfway)
    if not cover(&self.search, self.now, self.halfway):
        return False
    set_boxes(self, self.now, self.halfway)
    for k in range(self.search.n_pairs):
        pair = self.search.pair + 2 * k
        box, other = self.tight + 6 * pair[0], self.tight + 6 * pair[1]
        is_separated = False
        for c in range(3):
            is_separated = is_separated or box[c] > other[3 + c] or other[c] > box[3 + c]
        if not is_separated and not remain_separated(
                self.now + 12 * pair[0], self.now + 12 * pair[1],
                self.halfway + 12 * pair[0], self.halfway + 12 * pair[1]):
            return False
    return True
