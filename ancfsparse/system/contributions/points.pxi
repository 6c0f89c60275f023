"""Sums of coordinates, such as points and vectors between them (`PointSums`); an include file."""


cdef struct Points:
    ptrdiff_t n, dim, m
    const int32_t *start
    const int32_t *place  # (dim, m)
    const double *weight


cdef take_points(Points *self, start, place, weight):
    """Set the pointers into arrays that their owner keeps."""
    self.n, self.dim, self.m = len(start) - 1, place.shape[0], place.shape[1]
    self.start, self.place, self.weight = integers(start), integers(place), reals(weight)


cdef inline void sum_up(const Points *self, ptrdiff_t k, const double *q, const double *origin,
                        double *d) noexcept nogil:
    """Set sum k of coordinates or velocities, plus its row of `origin` unless that is null."""
    cdef ptrdiff_t c, i
    for c in range(self.dim):
        d[c] = origin[self.dim * k + c] if origin != NULL else 0.0
        for i in range(self.start[k], self.start[k + 1]):
            d[c] += self.weight[i] * q[self.place[c * self.m + i]]


cdef inline void push_sum(const Points *self, ptrdiff_t k, double factor, const double *d,
                          double *r) noexcept nogil:
    """Add a factor times the force d that does work on sum k."""
    cdef ptrdiff_t c, i
    for i in range(self.start[k], self.start[k + 1]):
        for c in range(self.dim):
            r[self.place[c * self.m + i]] += factor * self.weight[i] * d[c]
