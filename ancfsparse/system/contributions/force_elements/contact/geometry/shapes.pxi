"""Obstacles that are the points within a radius of their core; included by `_contacts.pyx`.

A point x is at d = x - base, with the components b = d in space, or b_i = u_i . d along the vectors
u_i of the rigid body of the obstacle, and y = F b in the frame F of the core.  The core is the set
low <= y <= high with bounds that can be infinite or equal (a segment, a block, on moving bodies a
half-space and an axis too), or a circle about the first axis of the frame, or given by distances on
a grid (grids.pxi).  With the closest point c of the core the distance is D = |y - c|, and within a
block minus the depth below its nearest face.  With the derivatives m_i of D by b_i the pressure
acts along sum m_i u_i on the point, and with m_i d on u_i: momentum and angular momentum are
conserved.

Between two states m is taken at the midpoint and corrected along the change of b, so that their
product is the change of D (Gonzalez, J. Nonlinear Sci. 6 (1996) 449-467); with d and u_i at the
midpoint the work is exact, as b is bilinear in them.
"""

# Change of a position over the distance from the base below which the correction is left out.
# Without a limit rounding errors turn the force by 1e-5 where a point 0.1 m from the base moves by
# 1e-12 m; with 1e-3 the work of a motion of 1e-6 m is off by 1e-12 of the energy instead of 1e-14.
cdef double SAME_PLACE = 1e-6


cdef void locate(const Data *self, ptrdiff_t k, const double *q, Place *out) noexcept nogil:
    """Find a point relative to the obstacle."""
    out.x[2] = 0.0
    sum_up(&self.points, k, q, NULL, &out.x[0])
    if self.frame_moves:
        take_vectors(self, k, q, out)
    measure(self, k, out)


cdef void take_vectors(const Data *self, ptrdiff_t k, const double *q, Place *out) noexcept nogil:
    """Set the vectors of the body of the obstacle."""
    cdef const Points *points = &self.points
    cdef ptrdiff_t c, i
    for i in range(points.start[k], points.start[k + 1]):
        if self.turning[i]:
            for c in range(points.dim):
                out.u[3 * (self.turning[i] - 1) + c] = q[points.place[c * points.m + i]]


cdef inline void measure(const Data *self, ptrdiff_t k, Place *out) noexcept nogil:
    """Set all but the position; the normal is zero on the axis or centre of a round obstacle."""
    approach(self, k, out)
    face(self, out)


cdef inline void approach(const Data *self, ptrdiff_t k, Place *out) noexcept nogil:
    """Set the distance, and all but the normal unless the obstacle has a frame."""
    if self.has_frame:
        approach_core(self, out)
    else:
        approach_base(self, out)
    out.e = self.reach[k] - out.distance


cdef void approach_core(const Data *self, Place *out) noexcept nogil:
    cdef ptrdiff_t c
    if self.points.dim == 2:
        out.d[2] = out.n[2] = out.g[2] = 0.0
    for c in range(self.points.dim):
        out.d[c] = out.x[c] - self.base[c]
    measure_in_frame(self, out)


cdef inline void approach_base(const Data *self, Place *out) noexcept nogil:
    cdef ptrdiff_t c
    cdef double[3] from_base
    for c in range(3):
        from_base[c] = out.x[c] - self.base[c]
        out.d[c] = from_base[c]
    if not self.is_round:
        out.distance = dot(self.normal, from_base)
        return
    for c in range(3):
        out.d[c] = dot(self.projector + 3 * c, from_base)
    out.distance = sqrt(dot(out.d, out.d))


cdef inline void face(const Data *self, Place *out) noexcept nogil:
    """Set the normal, after `approach`."""
    cdef ptrdiff_t c
    cdef double inverse
    if self.has_frame:
        return
    if not self.is_round:
        for c in range(3):
            out.n[c] = self.normal[c]
        return
    inverse = 1.0 / out.distance if out.distance > 0.0 else 0.0
    for c in range(3):
        out.n[c] = inverse * out.d[c]


cdef double reduce_ring(const Data *self, double *y, double *e) noexcept nogil:
    """Turn y into the vector from the closest point of the circle; return the distance to its axis.

    Sets the unit vector e along the radius, zero on the axis.
    """
    cdef ptrdiff_t c, dim = self.points.dim, first = dim - 2
    cdef double across = sqrt(y[first] * y[first] + y[first + 1] * y[first + 1])
    e[0] = 0.0
    for c in range(first, dim):
        e[c] = y[c] / across if across > 0.0 else 0.0
        y[c] -= self.ring * e[c]
    return across


cdef double leave_block(const Data *self, double *y) noexcept nogil:
    """Turn y into the vector from the closest point of the block; return the depth in the block.

    Within the block y becomes the outward unit normal of the nearest face.
    """
    cdef ptrdiff_t c, dim = self.points.dim, nearest = 0
    cdef double low, high, depth = INFINITY, side = 1.0, outside = 0.0
    for c in range(dim):
        low, high = y[c] - self.bounds[c], self.bounds[dim + c] - y[c]
        if min(low, high) < depth:
            depth, nearest, side = min(low, high), c, 1.0 if high <= low else -1.0
        y[c] = low if low < 0.0 else -high if high < 0.0 else 0.0
        outside += fabs(y[c])
    if outside > 0.0:
        return 0.0
    y[nearest] = side
    return depth


cdef void measure_in_frame(const Data *self, Place *out) noexcept nogil:
    """Set the distance and its derivatives from the vectors of a place."""
    cdef ptrdiff_t c, i, dim = self.points.dim
    cdef double[3] y
    cdef double[3] e
    cdef double depth = 0.0, square = 0.0
    for i in range(dim):
        out.b[i] = out.d[i]
        if self.frame_moves:
            out.b[i] = 0.0
            for c in range(dim):
                out.b[i] += out.u[3 * i + c] * out.d[c]
    for i in range(dim):
        y[i] = 0.0
        for c in range(dim):
            y[i] += self.frame[dim * i + c] * out.b[c]
    if self.grid != NULL:
        out.distance = interpolate(self, &y[0], &e[0], NULL)
    else:
        if self.ring > 0.0:
            reduce_ring(self, &y[0], &e[0])
        else:
            depth = leave_block(self, &y[0])
        for i in range(dim):
            square += y[i] * y[i]
        out.distance = sqrt(square)
        for i in range(dim):
            e[i] = y[i] / out.distance if out.distance > 0.0 else 0.0
        if depth > 0.0:
            out.distance = -depth
    for i in range(dim):
        out.m[i] = 0.0
        for c in range(dim):
            out.m[i] += self.frame[dim * c + i] * e[c]
    turn_normal(self, out)


cdef inline void turn_normal(const Data *self, Place *out) noexcept nogil:
    """Set the gradient of the distance and the unit normal in space from m."""
    cdef ptrdiff_t c, i
    cdef double square = 0.0
    for c in range(self.points.dim):
        out.g[c] = out.m[c]
        if self.frame_moves:
            out.g[c] = 0.0
            for i in range(self.points.dim):
                out.g[c] += out.m[i] * out.u[3 * i + c]
        square += out.g[c] * out.g[c]
    for c in range(self.points.dim):
        out.n[c] = out.g[c] / sqrt(square) if square > 0.0 else 0.0


cdef inline const double *leaving(const Data *self, const Place *here) noexcept nogil:
    """Return the gradient of the distance with respect to the position of a point."""
    if self.has_frame:
        return &here.g[0]
    return &here.n[0]


cdef void halve_in_frame(const Data *self, Place *begin, const Place *end) noexcept nogil:
    """Move a place halfway to another one, with the normal there."""
    cdef ptrdiff_t c, i
    for c in range(self.points.dim):
        begin.d[c] = 0.5 * (begin.d[c] + end.d[c])
        if self.frame_moves:
            for i in range(self.points.dim):
                begin.u[3 * i + c] = 0.5 * (begin.u[3 * i + c] + end.u[3 * i + c])
    measure_in_frame(self, begin)


cdef void mean_normal(const Data *self, const Place *begin, Place *end) noexcept nogil:
    """Turn the end of a step into a place halfway whose normal makes the change of energy exact."""
    cdef ptrdiff_t c
    cdef double[3] change
    cdef double both, moved = 0.0, size = 0.0, rest = end.distance - begin.distance
    if not self.has_frame:
        if self.is_round:
            both = begin.distance + end.distance
            both = 1.0 / both if both > 0.0 else 0.0
            for c in range(3):
                end.n[c] = both * (begin.d[c] + end.d[c])
        return
    for c in range(self.points.dim):
        change[c] = end.b[c] - begin.b[c]
        moved += change[c] * change[c]
    halve_in_frame(self, end, begin)
    for c in range(self.points.dim):
        rest -= end.m[c] * change[c]
        size += end.b[c] * end.b[c]
    if moved > SAME_PLACE * SAME_PLACE * size:
        for c in range(self.points.dim):
            end.m[c] += rest / moved * change[c]
        turn_normal(self, end)


cdef inline void subtract_vector_forces(const Data *self, ptrdiff_t k, double pressure,
                                        const Place *place, double *r) noexcept nogil:
    """Subtract the forces of a pressure on the vectors of the body of the obstacle."""
    cdef const Points *points = &self.points
    cdef ptrdiff_t c, i
    for i in range(points.start[k], points.start[k + 1]):
        if self.turning[i]:
            for c in range(points.dim):
                r[points.place[c * points.m + i]] -= (
                    pressure * place.m[self.turning[i] - 1] * place.d[c])


cdef void bend_core(const Data *self, double distance, double *v, double *h) noexcept nogil:
    """Add the second derivatives of the distance by y, (3, 3); v is y, and is overwritten.

    They are (1 - n n^T - c') / D with the derivative c' of the closest point.
    """
    cdef ptrdiff_t i, j, dim = self.points.dim, first = dim - 2
    cdef double[3] e
    cdef double across, swing = 0.0
    if self.ring > 0.0:
        across = reduce_ring(self, v, &e[0])
        swing = self.ring / across if across > 0.0 else 0.0  # ratio of the motions of c and y
    else:
        leave_block(self, v)
    for i in range(dim):
        if self.ring > 0.0 or v[i] != 0.0:
            h[4 * i] = 1.0 / distance
        for j in range(dim):
            if swing > 0.0 and i >= first and j >= first:
                h[3 * i + j] += swing * (e[i] * e[j] - (i == j)) / distance
            h[3 * i + j] -= v[i] * v[j] / (distance * distance * distance)


cdef void bend(const Data *self, const Place *here, double *h) noexcept nogil:
    """Set the second derivatives of the distance by b, (3, 3)."""
    cdef ptrdiff_t a, b, i, j, dim = self.points.dim
    cdef double[3] v
    cdef double[3] e
    cdef double[9] own
    for i in range(9):
        own[i] = h[i] = 0.0
    if here.distance <= 0.0 and self.grid == NULL:
        return
    for i in range(dim):
        v[i] = 0.0
        for a in range(dim):
            v[i] += self.frame[dim * i + a] * here.b[a]
    if self.grid != NULL:
        interpolate(self, &v[0], &e[0], &own[0])
    else:
        bend_core(self, here.distance, &v[0], &own[0])
    for a in range(dim):
        for b in range(dim):
            for i in range(dim):
                for j in range(dim):
                    h[3 * a + b] += (
                        self.frame[dim * i + a] * own[3 * i + j] * self.frame[dim * j + b])


cdef void turn_columns(const Data *self, const Place *here, const double *h, double *out) noexcept nogil:
    """Set U h (3, 3), where the columns of U are the vectors of the body."""
    cdef ptrdiff_t a, c, i, dim = self.points.dim
    for c in range(dim):
        for a in range(dim):
            out[3 * c + a] = h[3 * c + a]
            if self.frame_moves:
                out[3 * c + a] = 0.0
                for i in range(dim):
                    out[3 * c + a] += here.u[3 * i + c] * h[3 * i + a]


cdef void block_in_frame(const Data *self, int part, const Place *here, double pressure,
                         double slope, double *block) noexcept nogil:
    """Set the derivative of the pressure on a point by its position, (3, 3)."""
    cdef double[9] h
    cdef double[9] half
    cdef double[9] turned
    cdef ptrdiff_t c, e, dim = self.points.dim
    for c in range(9):
        turned[c] = 0.0
    if part == STIFFNESS:
        bend(self, here, &h[0])
        turn_columns(self, here, &h[0], &half[0])
        for c in range(dim):
            for e in range(dim):
                h[3 * c + e] = half[3 * e + c]
        turn_columns(self, here, &h[0], &turned[0])
    for c in range(dim):
        for e in range(dim):
            block[3 * c + e] = slope * here.g[c] * here.g[e] - pressure * turned[3 * c + e]


cdef void add_vector_blocks(const Data *self, int part, ptrdiff_t k, const Place *here, double pressure,
                            double slope, const int32_t *slot, double *values) noexcept nogil:
    """Add the derivatives of a pressure that involve the vectors of the body."""
    cdef const Points *points = &self.points
    cdef const double *weight = points.weight + points.start[k]
    cdef const int32_t *turning = self.turning + points.start[k]
    cdef double[9] h
    cdef double[9] half
    cdef double along, across, bent, share
    cdef ptrdiff_t i, j, c, e, a, b, dim = points.dim
    bend(self, here, &h[0])
    turn_columns(self, here, &h[0], &half[0])
    for i in range(points.start[k + 1] - points.start[k]):
        a = turning[i] - 1
        for c in range(dim):
            for j in range(i + 1):
                b = turning[j] - 1
                along = here.m[a] if a >= 0 else 0.0
                across = here.m[b] if b >= 0 else 0.0
                for e in range(dim if j < i else c + 1):
                    share = slope * (
                        weight[i] * here.g[c] * across * here.d[e]
                        + along * here.d[c] * (weight[j] * here.g[e] + across * here.d[e]))
                    if part == STIFFNESS:
                        bent = along * weight[j] + across * weight[i] if c == e else 0.0
                        if b >= 0:
                            bent += weight[i] * half[3 * c + b] * here.d[e]
                        if a >= 0:
                            bent += here.d[c] * half[3 * e + a] * weight[j]
                        if a >= 0 and b >= 0:
                            bent += here.d[c] * h[3 * a + b] * here.d[e]
                        share -= pressure * bent
                    values[slot[0]] += share
                    slot += 1


cdef double separation_rate(const Data *self, ptrdiff_t k, const double *v, const Place *here) noexcept nogil:
    """Return the rate of change of the distance of a point [m/s], positive where it separates."""
    cdef const Points *points = &self.points
    cdef double[3] u
    cdef double sum = 0.0
    cdef ptrdiff_t c, i
    sum_up(points, k, v, NULL, &u[0])
    for c in range(points.dim):
        sum += leaving(self, here)[c] * u[c]
        if self.frame_moves:
            for i in range(points.start[k], points.start[k + 1]):
                if self.turning[i]:
                    sum += (here.m[self.turning[i] - 1] * here.d[c]
                            * v[points.place[c * points.m + i]])
    return sum
