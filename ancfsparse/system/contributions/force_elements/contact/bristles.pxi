"""Friction of bristles that stick; included by `_contacts.pyx`.

A bristle is a spring of the stiffness k_t between a point and the place of the surface that it
sticks to, deflected by z.  While a point moves along the surface by x, z becomes z + x, and friction
is f = -k_t z, until |f| reaches mu p: then the bristle slides, and z is that of f = -mu p z / |z|.
Between two states f is that of z + x/2, so that friction never returns more energy than k_t z^2 / 2.
Outside of a step x is zero.
"""

# Relative distance of a deflection to its limit below which a bristle of a saved state slides: the
# damped pressure, which limited it, differs from the pressure in the state by up to 1e-4.
cdef double SLIDING_RATIO = 1e-3


cdef void transport(const Data *self, const double *n, double *u) noexcept nogil:
    """Rotate a vector of another tangent plane into that with the normal n."""
    cdef ptrdiff_t c, dim = self.points.dim
    cdef double normal = 0.0, before = 0.0, after = 0.0
    for c in range(dim):
        normal += n[c] * u[c]
        before += u[c] * u[c]
    for c in range(dim):
        u[c] -= normal * n[c]
        after += u[c] * u[c]
    if after > 0.0:
        for c in range(dim):
            u[c] *= sqrt(before / after)


cdef double limit_of(const Data *self, ptrdiff_t k, double pressure) noexcept nogil:
    """Deflection at which a bristle slides [m]."""
    return self.friction * pressure / (self.grip * self.stiffness[k])


cdef void shorten(const Data *self, double limit, double *z) noexcept nogil:
    """Scale a deflection to a limit, if it is longer."""
    cdef ptrdiff_t c
    cdef double square = 0.0
    for c in range(self.points.dim):
        square += z[c] * z[c]
    if square > limit * limit:
        for c in range(self.points.dim):
            z[c] *= limit / sqrt(square)


cdef void grip(const Data *self, ptrdiff_t k, double pressure, double *z) noexcept nogil:
    """Replace a deflection by the friction on the point."""
    cdef ptrdiff_t c
    shorten(self, limit_of(self, k, pressure), z)
    for c in range(self.points.dim):
        z[c] *= -self.grip * self.stiffness[k]


cdef void creep(const Data *self, ptrdiff_t k, const double *q1, Place *begin, const Place *end,
                double *x) noexcept nogil:
    """Set the displacement of a point along the surface since the last accepted state.

    It is halfway, where `begin` moves, and the weights are set there.
    """
    cdef ptrdiff_t c, i, dim = self.points.dim
    cdef double[3] before
    cdef double normal = 0.0
    halve(self, begin, end)
    weigh(self, k, self.q0, q1, begin)
    move(self, k, self.q0, &before[0])
    move(self, k, q1, x)
    for c in range(dim):
        x[c] -= before[c]
        for i in range(dim):
            x[c] -= self.turn * self.spin[dim * c + i] * begin.d[i]
        normal += begin.n[c] * x[c]
    for c in range(dim):
        x[c] -= normal * begin.n[c]


cdef void stick(const Data *self, ptrdiff_t k, const double *q1, double pressure,
                double *f) noexcept nogil:
    """Set the friction on a point at the end of a step, or that between its states.

    Set the weights for it, too, and remember the deflection without sliding.
    """
    cdef ptrdiff_t c, dim = self.points.dim
    cdef Place place
    cdef Place end
    cdef double[3] x
    cdef double *trial = self.trial + dim * k
    locate(self, k, q1, &end)
    if self.interval > 0.0:
        locate(self, k, self.q0, &place)
        creep(self, k, q1, &place, &end, &x[0])
    else:
        x[0] = x[1] = x[2] = 0.0
    if self.interval == 0.0 or not self.is_mean:
        place = end
        weigh(self, k, q1, q1, &end)
    for c in range(dim):
        trial[c] = self.z[dim * k + c]
    if self.is_mean:
        shorten(self, limit_of(self, k, pressure), trial)
    else:
        transport(self, &end.n[0], &x[0])
    transport(self, &place.n[0], trial)
    for c in range(dim):
        trial[c] += 0.5 * x[c] if self.is_mean else x[c]
        f[c] = trial[c]
    grip(self, k, pressure, f)


cdef void deflect(const Data *self, ptrdiff_t k, const double *q1, const Place *end) noexcept nogil:
    """Update the deflection of a bristle to the end of an accepted step."""
    cdef ptrdiff_t c, dim = self.points.dim
    cdef Place begin
    cdef double[3] x
    cdef double pressure
    cdef double *z = self.z + dim * k
    locate(self, k, self.q0, &begin)
    if self.is_mean:
        pressure = self.stiffness[k] * mean_force(begin.e, end.e, self.layer)
    else:
        pressure = damped_force(self, k, end.e)
    if pressure <= 0.0:
        for c in range(dim):
            z[c] = 0.0
        return
    creep(self, k, q1, &begin, end, &x[0])
    if self.is_mean:
        shorten(self, limit_of(self, k, pressure), z)
    transport(self, &end.n[0], z)
    transport(self, &end.n[0], &x[0])
    for c in range(dim):
        z[c] += x[c]
    shorten(self, limit_of(self, k, pressure), z)


cdef void hold(Data *self, const double *q) noexcept nogil:
    """Let all bristles begin without deflection."""
    cdef ptrdiff_t i
    for i in range(self.points.n * self.points.dim):
        self.z[i] = 0.0
    memcpy(self.q0, q, self.n_all * sizeof(double))


cdef double work_of_bristles(const Data *self, ptrdiff_t k, const double *q1, double pressure,
                             double *supplied) noexcept nogil:
    """Work of friction on the body in a step: of `between`, or by the trapezoidal rule.

    Adds the part that a turning obstacle supplies.
    """
    cdef ptrdiff_t c
    cdef Place begin
    cdef Place end
    cdef double[3] f
    cdef double sum
    locate(self, k, self.q0, &begin)
    locate(self, k, q1, &end)
    stick(self, k, q1, pressure, &f[0])
    sum = work_along(self, k, &f[0], self.q0, q1)
    if self.is_mean:
        halve(self, &begin, &end)
        supplied[0] += self.turn * turned(self, &begin, &f[0])
        return sum
    supplied[0] += 0.5 * self.turn * turned(self, &end, &f[0])
    for c in range(self.points.dim):
        f[c] = self.z[self.points.dim * k + c]
    grip(self, k, self.last[k], &f[0])
    weigh(self, k, self.q0, self.q0, &begin)
    supplied[0] += 0.5 * self.turn * turned(self, &begin, &f[0])
    return 0.5 * (sum + work_along(self, k, &f[0], self.q0, q1))


cdef void along_surface(const Data *self, const Place *here, double factor, double share,
                        const double *u, double *block) noexcept nogil:
    """Set factor (1 - n n^T - share u u^T), (3, 3), without directions along the axis of n = 0."""
    cdef ptrdiff_t c, e, dim = self.points.dim
    for c in range(dim):
        for e in range(dim):
            block[3 * c + e] = factor * (
                (1.0 if c == e else 0.0) - here.n[c] * here.n[e] - share * u[c] * u[e])


cdef void sticking_block(const Data *self, ptrdiff_t k, const Place *here, double pressure,
                         double *block) noexcept nogil:
    """Set the derivative of friction by the position of a point along the obstacle, (3, 3)."""
    cdef const double *u = self.trial + self.points.dim * k
    cdef ptrdiff_t c
    cdef double square = 0.0, limit = limit_of(self, k, pressure), least
    cdef double factor = self.grip * self.stiffness[k]
    if self.is_sticking:
        u = self.z + self.points.dim * k
    for c in range(self.points.dim):
        square += u[c] * u[c]
    least = limit * (1.0 - SLIDING_RATIO) if self.is_sticking else limit
    if square <= least * least:
        along_surface(self, here, factor, 0.0, u, block)
    else:
        along_surface(self, here, factor * fmin(limit / sqrt(square), 1.0), 1.0 / square, u, block)
