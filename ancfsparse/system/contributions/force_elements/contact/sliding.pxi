"""Motion of points along the surface of an obstacle, and friction; included by `_contacts.pyx`."""


cdef void weigh(const Data *self, ptrdiff_t k, const double *q0, const double *q1,
                const Place *here) noexcept nogil:
    """Set the weights of velocities in the motion of a point along the body of the obstacle.

    The body moves there with the velocity of its base plus sum (u_i . d) / |u_i|^2 u_i', where u_i
    are midway from q0 to q1.
    """
    cdef const Points *points = &self.points
    cdef ptrdiff_t i, c, first = points.start[k]
    cdef double u, along, square
    for i in range(first, points.start[k + 1]):
        self.weights[i - first] = points.weight[i]
        if self.turning[i]:
            along = square = 0.0
            for c in range(points.dim):
                u = 0.5 * (q0[points.place[c * points.m + i]] + q1[points.place[c * points.m + i]])
                along += u * here.d[c]
                square += u * u
            self.weights[i - first] -= along / square


cdef void move(const Data *self, ptrdiff_t k, const double *v, double *u) noexcept nogil:
    """Set the sum of velocities with the weights of `weigh`."""
    cdef const Points *points = &self.points
    cdef ptrdiff_t i, c, first = points.start[k]
    u[2] = 0.0
    for c in range(points.dim):
        u[c] = 0.0
        for i in range(first, points.start[k + 1]):
            u[c] += self.weights[i - first] * v[points.place[c * points.m + i]]


cdef void push_friction(const Data *self, ptrdiff_t k, const double *f, double *r) noexcept nogil:
    """Subtract the force that does work on this motion from the residual."""
    cdef const Points *points = &self.points
    cdef ptrdiff_t i, c, first = points.start[k]
    for i in range(first, points.start[k + 1]):
        for c in range(points.dim):
            r[points.place[c * points.m + i]] -= self.weights[i - first] * f[c]


cdef inline void add_turning(const Data *self, const Place *here, double factor,
                             double *u) noexcept nogil:
    """Add a factor times the velocity of the surface of a turning obstacle."""
    cdef ptrdiff_t c
    if self.omega > 0.0:
        for c in range(3):
            u[c] += factor * dot(self.spin + 3 * c, here.d)


cdef inline double slide(const Data *self, const Place *here, double *u) noexcept nogil:
    """Replace the velocity of a point by its sliding velocity u; return sqrt(u^2 + slip_speed^2)."""
    add_turning(self, here, -1.0, u)
    remove_normal(here.n, u)
    return sqrt(self.slip_speed * self.slip_speed + dot(u, u))


cdef inline void rub(const Data *self, const Place *here, double pressure, double *f) noexcept nogil:
    """Replace the velocity of a point by the friction on it."""
    scale(-self.friction * pressure / slide(self, here, f), f)


cdef inline void displace(const Data *self, ptrdiff_t k, const double *q0, const double *q1,
                          const Place *begin, const Place *end, double *x) noexcept nogil:
    """Set the displacement on this motion from one state to another."""
    cdef double[3] before
    cdef ptrdiff_t c
    if self.on_body:
        move(self, k, q0, &before[0])
        move(self, k, q1, x)
        for c in range(3):
            x[c] -= before[c]
    else:
        for c in range(3):
            x[c] = end.x[c] - begin.x[c]


cdef inline void halve(const Data *self, Place *begin, const Place *end) noexcept nogil:
    """Move a place halfway to another one, with the normal there."""
    cdef ptrdiff_t c
    cdef double square, inverse
    if self.is_flat:
        return
    if self.has_frame:
        halve_in_frame(self, begin, end)
        return
    for c in range(3):
        begin.d[c] = 0.5 * (begin.d[c] + end.d[c])
    square = dot(begin.d, begin.d)
    if self.is_round and square > 0.0:
        inverse = 1.0 / sqrt(square)
        for c in range(3):
            begin.n[c] = inverse * begin.d[c]


cdef double turned(const Data *self, const Place *here, const double *f) noexcept nogil:
    """Power that a turning obstacle supplies by the friction f on a point."""
    cdef double[3] u
    u[0] = u[1] = u[2] = 0.0
    add_turning(self, here, 1.0, &u[0])
    return dot(f, u)


cdef double work(void *context, const ancf_state *x0, const ancf_state *x1,
                 double *scratch) noexcept nogil:
    """Work of friction on the body: of `between`, or by the trapezoidal rule from both states."""
    cdef Data *self = <Data *>context
    cdef double sum
    self.supplied = 0.0
    if self.slides != NULL:
        memset(self.pull, 0, 3 * self.points.n * sizeof(double))
    sum = friction_work(self, x0, x1, &self.supplied)
    self.rubbed = self.supplied - sum
    return sum


cdef double friction_work(const Data *self, const ancf_state *x0, const ancf_state *x1,
                          double *supplied) noexcept nogil:
    """Work of friction on the body in a step; adds the part that a turning obstacle supplies."""
    cdef Place[MAX_POINTS] begin
    cdef Place[MAX_POINTS] end
    cdef double pressure, sum = 0.0
    cdef ptrdiff_t g, k, p
    if self.grip == 0.0 and (x0.v == NULL or x1.v == NULL):
        return 0.0
    for g in range(self.groups.n):
        if self.grip == 0.0:
            locate_group(self, g, x0.q, begin)
        locate_group(self, g, x1.q, end)
        for p in range(self.groups.first[g + 1] - self.groups.first[g]):
            k = self.groups.first[g] + p
            if self.grip > 0.0:
                recall(self, k, &begin[p])
            pressure = force_in_state(self, k, &end[p], x1.v)
            if (begin[p].e <= 0.0 and end[p].e <= 0.0 and pressure <= 0.0
                    and self.last[k] <= 0.0):
                continue
            if self.is_mean:
                pressure = force_between(self, k, begin[p].e, end[p].e, NULL)
            if self.grip > 0.0:
                sum += work_of_bristles(self, k, x1.q, &begin[p], &end[p], pressure, supplied)
            else:
                sum += work_of_sliding(self, k, x0, x1, &begin[p], &end[p], pressure, supplied)
    return sum


cdef double work_of_sliding(const Data *self, ptrdiff_t k, const ancf_state *x0,
                            const ancf_state *x1, Place *begin, const Place *end, double pressure,
                            double *supplied) noexcept nogil:
    """The same of a point with a friction that depends on its velocity; moves `begin`.

    By the trapezoidal rule it gives no more than a turning obstacle supplies: in a step that does not
    resolve the motion the velocities at both ends can be opposite to the displacement, and the
    scheme gains the rest.  Explicit steps, whose length is not known here, are short.
    """
    cdef double[3] f
    cdef double[3] u
    cdef double[3] path
    cdef double sum, given, dt = self.interval
    cdef ptrdiff_t c
    if self.is_mean:
        halve(self, begin, end)
        weigh(self, k, x0.q, x1.q, begin)
        move(self, k, x0.v, &f[0])
        move(self, k, x1.v, &u[0])
        for c in range(3):
            f[c] = 0.5 * (f[c] + u[c])
        rub(self, begin, pressure, &f[0])
        displace(self, k, x0.q, x1.q, begin, end, &path[0])
        supplied[0] += dt * turned(self, begin, &f[0])
        return dot(f, path)
    weigh(self, k, x0.q, x0.q, begin)
    move(self, k, x0.v, &f[0])
    rub(self, begin, 0.5 * self.last[k], &f[0])
    displace(self, k, x0.q, x1.q, begin, end, &path[0])
    sum = dot(f, path)
    given = dt * turned(self, begin, &f[0])
    weigh(self, k, x1.q, x1.q, end)
    move(self, k, x1.v, &f[0])
    rub(self, end, 0.5 * pressure, &f[0])
    displace(self, k, x0.q, x1.q, begin, end, &path[0])
    sum += dot(f, path)
    given += dt * turned(self, end, &f[0])
    supplied[0] += given
    return min(sum, given) if dt > 0.0 else sum
