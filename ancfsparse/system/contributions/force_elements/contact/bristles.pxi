"""Friction of bristles that stick; included by `_contacts.pyx`.

A bristle is a spring of the stiffness k_t with a damper c between a point and the place of the surface
that it sticks to, deflected by z.  While a point moves along the surface by x in the time dt, z
becomes z + x, and friction is f = -k_t (z + x) - c x / dt, until |f| reaches mu p: then the bristle
slides, and its z is that of f = -mu p in the same direction.  The damper, which bristles with a static
coefficient have, damps oscillations of bodies that stick.  The static coefficient applies while a
bristle sticks; one that slides sticks again after the first step in which its deflection does not grow,
so mu is constant in a step.  Between two states z + x/2 takes the place of z + x, and friction never
returns more energy than k_t z^2 / 2.
Outside of a step x is zero.
"""


cdef inline void turn_to(const Data *self, const double *n, double *u) noexcept nogil:
    """Rotate a vector of another tangent plane into that with the normal n."""
    if not self.is_flat:
        transport(n, u)


cdef inline void take_bristle(const Data *self, const double *z, double *u) noexcept nogil:
    """Copy a deflection, with a zero third component in the plane."""
    u[0], u[1] = z[0], z[1]
    u[2] = z[2] if self.points.dim == 3 else 0.0


cdef inline double limit_if(const Data *self, ptrdiff_t k, bint slides,
                            double pressure) noexcept nogil:
    """Largest deflection of a bristle that slides or sticks [m]; 0 at points that are left out."""
    if self.stiffness[k] == 0.0:
        return 0.0
    return (self.friction if slides or self.slides == NULL else self.friction0) * (
        pressure / (self.grip * self.stiffness[k]))


cdef inline double limit_of(const Data *self, ptrdiff_t k, double pressure) noexcept nogil:
    """Deflection at which a bristle slides [m]."""
    return limit_if(self, k, self.slides != NULL and self.slides[k] > 0.0, pressure)


cdef inline void grip(const Data *self, ptrdiff_t k, double limit, double *z) noexcept nogil:
    """Replace a deflection, which is not longer than a limit, by the friction on the point."""
    shorten(limit, z)
    scale(-self.grip * self.stiffness[k], z)


cdef inline double delay_of(const Data *self, ptrdiff_t k) noexcept nogil:
    """Damping of a bristle over its stiffness and the step."""
    return self.settling[k] / self.interval if self.interval > 0.0 else 0.0


cdef inline double share_of(const Data *self, ptrdiff_t k) noexcept nogil:
    """Factor of the displacement x in the friction of a step."""
    return (0.5 if self.is_mean else 1.0) + delay_of(self, k)


cdef inline void creep(const Data *self, ptrdiff_t k, const double *q1, Place *begin,
                       const Place *end, double *x) noexcept nogil:
    """Set the displacement of a point along the surface since the last accepted state.

    It is halfway, where `begin` moves, and the weights are set there.  Between two equilibria it
    begins where the point touches, linearly between both.
    """
    cdef double share = 1.0
    cdef ptrdiff_t c
    if self.is_static and begin.e < 0.0 < end.e:
        share = end.e / (end.e - begin.e)
    self.share[k] = share
    halve(self, begin, end)
    if self.on_body:
        weigh(self, k, self.q0, q1, begin)
    displace(self, k, self.q0, q1, begin, end, x)
    add_turning(self, begin, -self.turn, x)
    remove_normal(begin.n, x)
    for c in range(3):
        x[c] *= share


cdef inline void stick(const Data *self, ptrdiff_t k, const double *q1, Place *begin,
                const Place *end, double pressure, double *f) noexcept nogil:
    """Set the friction on a point at the end of a step, or that between its states.

    Set the weights for it, too, and remember the deflection without sliding; `begin` moves halfway.
    """
    cdef ptrdiff_t c
    cdef const Place *place = begin
    cdef double share = share_of(self, k)
    cdef double[3] x
    cdef double[3] u
    if self.interval > 0.0:
        creep(self, k, q1, begin, end, &x[0])
    else:
        x[0] = x[1] = x[2] = 0.0
    if self.interval == 0.0 or not self.is_mean:
        place = end
        if self.on_body:
            weigh(self, k, q1, q1, end)
    take_bristle(self, self.z + self.points.dim * k, &u[0])
    if self.is_mean:
        shorten(limit_of(self, k, pressure), &u[0])
    else:
        turn_to(self, end.n, &x[0])
    turn_to(self, place.n, &u[0])
    for c in range(3):
        u[c] += share * x[c]
        self.trial[3 * k + c] = u[c]
    grip(self, k, limit_of(self, k, pressure), &u[0])
    for c in range(3):
        f[c] = u[c]


cdef void approach_equilibrium(Data *self, double dt) noexcept nogil:
    """Set the time since the last equilibrium, without damping."""
    if self.is_static:
        set_step(self, dt)
        self.dt, self.interval = 0.0, INFINITY


cdef void follow_equilibrium(Data *self, const double *q) noexcept nogil:
    """Update the deflections of bristles to an equilibrium."""
    cdef ancf_state x0, x
    x0.q, x.q, x0.v, x.v = self.q0, q, NULL, NULL
    work(self, &x0, &x, NULL)
    self.is_static = False
    accept(self, &x)
    self.is_static = True


cdef void try_equilibrium(const Data *self, ptrdiff_t k, const double *q, const Place *here,
                          double pressure) noexcept nogil:
    """Set the trial deflection of a bristle in a state that can differ from the last residual's."""
    cdef Place begin
    cdef double[3] f
    recall(self, k, &begin)
    stick(self, k, q, &begin, here, pressure, &f[0])


cdef void deflect(const Data *self, ptrdiff_t k, const double *q1, const Place *end,
                  double pressure) noexcept nogil:
    """Update the deflection of a bristle to the end of an accepted step, with the pressure there."""
    cdef Place begin
    cdef ptrdiff_t c, dim = self.points.dim
    cdef double[3] u
    cdef double[3] x
    cdef double limit, square
    cdef bint slides
    cdef double *z = self.z + dim * k
    if self.is_mean:
        recall(self, k, &begin)
        pressure = force_between(self, k, begin.e, end.e, NULL)
    if pressure <= 0.0:
        for c in range(dim):
            z[c] = 0.0
        if self.slides != NULL:
            self.slides[k] = 0.0
        return
    if not self.is_mean:
        recall(self, k, &begin)
    limit = limit_of(self, k, pressure)
    take_bristle(self, z, &u[0])
    square = dot(u, u)
    creep(self, k, q1, &begin, end, &x[0])
    if self.is_mean:
        shorten(limit, &u[0])
    turn_to(self, end.n, &u[0])
    turn_to(self, end.n, &x[0])
    slides = self.slides != NULL and self.slides[k] > 0.0
    slides = stretch_by(&x[0], share_of(self, k), delay_of(self, k), limit, slides, square, &u[0])
    if self.slides != NULL:
        self.slides[k] = slides
    for c in range(dim):
        z[c] = u[c]


cdef void hold(Data *self, const double *q) noexcept nogil:
    """Let all bristles begin without deflection."""
    cdef ptrdiff_t i
    for i in range(self.points.n * (self.points.dim + (self.slides != NULL))):
        self.z[i] = 0.0
    keep_state(self, q)


cdef double work_of_bristles(const Data *self, ptrdiff_t k, const double *q1, const Place *begin,
                             const Place *end, double pressure, double *supplied) noexcept nogil:
    """Work of friction on the body in a step: of `between`, or by the trapezoidal rule.

    By this rule a bristle returns no more than it has stored: an impact that it does not resolve
    would gain the rest.  Adds the part that a turning obstacle supplies.
    """
    cdef Place place = begin[0]
    cdef double before = supplied[0], stored
    cdef double[3] f
    cdef double[3] path
    cdef double sum
    stick(self, k, q1, &place, end, pressure, &f[0])
    if self.slides != NULL:
        memcpy(self.pull + 3 * k, f, 3 * sizeof(double))
    displace(self, k, self.q0, q1, begin, end, &path[0])
    sum = dot(f, path)
    if self.is_mean:
        supplied[0] += self.turn * turned(self, &place, &f[0])
        return sum
    supplied[0] += 0.5 * self.turn * turned(self, end, &f[0])
    take_bristle(self, self.z + self.points.dim * k, &f[0])
    grip(self, k, limit_of(self, k, self.last[k]), &f[0])
    stored = 0.0
    if self.stiffness[k] > 0.0:
        stored = 0.5 * dot(f, f) / (self.grip * self.stiffness[k])
    if self.slides != NULL:
        memcpy(f, self.drag + 3 * k, 3 * sizeof(double))
    if self.on_body:
        weigh(self, k, self.q0, self.q0, begin)
        displace(self, k, self.q0, q1, begin, end, &path[0])
    supplied[0] += 0.5 * self.turn * turned(self, begin, &f[0])
    return min(0.5 * (sum + dot(f, path)), stored + supplied[0] - before)


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
    cdef const double *u = self.trial + 3 * k
    cdef ptrdiff_t c
    cdef double square = 0.0, limit = limit_of(self, k, pressure), sliding_limit
    cdef double factor = self.grip * self.stiffness[k]
    if self.is_sticking:
        u = self.z + self.points.dim * k
    else:
        factor *= self.share[k] * share_of(self, k) * (2.0 if self.is_mean else 1.0)
    for c in range(self.points.dim):
        square += u[c] * u[c]
    sliding_limit = limit * (1.0 - SLIDING_RATIO) if self.is_sticking else limit
    if square <= sliding_limit * sliding_limit:
        along_surface(self, here, factor, 0.0, u, block)
    else:
        along_surface(self, here, factor * min(limit / sqrt(square), 1.0), 1.0 / square, u, block)


cdef add_sliding(const Data *self, const double *q, double[:, ::1] out):
    """Add the derivatives of friction by penetrations, of points that slide in an equilibrium."""
    cdef Place here
    cdef double pressure, limit
    cdef ptrdiff_t k, c
    for k in range(self.points.n):
        locate(self, k, q, &here)
        pressure = self.stiffness[k] * law_force(here.e, self.layer[k])
        if pressure <= 0.0:
            continue
        try_equilibrium(self, k, q, &here, pressure)
        limit = limit_of(self, k, pressure)
        if dot(self.trial + 3 * k, self.trial + 3 * k) > limit * limit:
            limit = sqrt(dot(self.trial + 3 * k, self.trial + 3 * k))
            for c in range(self.points.dim):
                out[k, c] = -self.grip * self.stiffness[k] * self.trial[3 * k + c] / limit * (
                    limit_of(self, k, self.stiffness[k] * law_slope(here.e, self.layer[k])))
