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


cdef double slide(const Data *self, const Place *here, double *u) noexcept nogil:
    """Replace the velocity of a point by its sliding velocity u; return sqrt(u^2 + slip_speed^2)."""
    cdef ptrdiff_t c, i, dim = self.points.dim
    cdef double normal = 0.0, square = self.slip_speed * self.slip_speed
    for c in range(dim):
        for i in range(dim):
            u[c] -= self.spin[dim * c + i] * here.d[i]
        normal += here.n[c] * u[c]
    for c in range(dim):
        u[c] -= normal * here.n[c]
        square += u[c] * u[c]
    return sqrt(square)


cdef void rub(const Data *self, const Place *here, double pressure, double *f) noexcept nogil:
    """Replace the velocity of a point by the friction on it."""
    cdef ptrdiff_t c
    cdef double speed = slide(self, here, f)
    for c in range(self.points.dim):
        f[c] *= -self.friction * pressure / speed


cdef double work_along(const Data *self, ptrdiff_t k, const double *f, const double *q0,
                       const double *q1) noexcept nogil:
    """Work of a force on this motion from one state to another."""
    cdef double[3] before
    cdef double[3] after
    cdef double sum = 0.0
    cdef ptrdiff_t c
    move(self, k, q0, &before[0])
    move(self, k, q1, &after[0])
    for c in range(self.points.dim):
        sum += f[c] * (after[c] - before[c])
    return sum


cdef void halve(const Data *self, Place *begin, const Place *end) noexcept nogil:
    """Move a place halfway to another one, with the normal there."""
    cdef ptrdiff_t c
    cdef double square = 0.0
    if self.has_frame:
        halve_in_frame(self, begin, end)
        return
    for c in range(self.points.dim):
        begin.d[c] = 0.5 * (begin.d[c] + end.d[c])
        square += begin.d[c] * begin.d[c]
    if self.is_round and square > 0.0:
        for c in range(self.points.dim):
            begin.n[c] = begin.d[c] / sqrt(square)


cdef double work(void *context, const ancf_state *x0, const ancf_state *x1,
                 double *scratch) noexcept nogil:
    """Work of friction on the body: of `between`, or by the trapezoidal rule from both states."""
    cdef double supplied = 0.0
    return friction_work(<const Data *>context, x0, x1, 0.0, &supplied)


cdef double friction_work(const Data *self, const ancf_state *x0, const ancf_state *x1, double dt,
                          double *supplied) noexcept nogil:
    """Work of friction on the body in a step; adds the part that a turning obstacle supplies."""
    cdef Place begin
    cdef Place end
    cdef double[3] f
    cdef double[3] u
    cdef double pressure, before, sum = 0.0
    cdef ptrdiff_t k, c
    if self.grip == 0.0 and (x0.v == NULL or x1.v == NULL):
        return 0.0
    for k in range(self.points.n):
        locate(self, k, x0.q, &begin)
        locate(self, k, x1.q, &end)
        pressure, before = damped_force(self, k, end.e), self.last[k]
        if begin.e <= 0.0 and end.e <= 0.0 and pressure <= 0.0 and before <= 0.0:
            continue
        if self.is_mean:
            pressure = self.stiffness[k] * mean_force(begin.e, end.e, self.layer)
        if self.grip > 0.0:
            sum += work_of_bristles(self, k, x1.q, pressure, supplied)
        elif self.is_mean:
            halve(self, &begin, &end)
            weigh(self, k, x0.q, x1.q, &begin)
            move(self, k, x0.v, &f[0])
            move(self, k, x1.v, &u[0])
            for c in range(self.points.dim):
                f[c] = 0.5 * (f[c] + u[c])
            rub(self, &begin, pressure, &f[0])
            sum += work_along(self, k, &f[0], x0.q, x1.q)
            supplied[0] += dt * turned(self, &begin, &f[0])
        else:
            weigh(self, k, x0.q, x0.q, &begin)
            move(self, k, x0.v, &f[0])
            rub(self, &begin, 0.5 * before, &f[0])
            sum += work_along(self, k, &f[0], x0.q, x1.q)
            supplied[0] += dt * turned(self, &begin, &f[0])
            weigh(self, k, x1.q, x1.q, &end)
            move(self, k, x1.v, &f[0])
            rub(self, &end, 0.5 * pressure, &f[0])
            sum += work_along(self, k, &f[0], x0.q, x1.q)
            supplied[0] += dt * turned(self, &end, &f[0])
    return sum
