"""End of an explicit step: energy of contacts, work of loads, memory; included by `_explicit.pyx`."""

# Energy that impacts can add to a motion, over the energy exchanged.  Without it the errors of a cable that
# falls on a drum, in 20 000 steps of RungeKuttaNystrom(8), are 1.6e-7 instead of 6e-12 m.
cdef double IMPACT_GAIN = 5e-5


cdef void remove_gain(Explicit self, int next) noexcept nogil:
    """Take the energy that bodies which separate have gained in their contact from the velocities.

    To the gain of the pressures belongs that of the dead load: the method moves bodies in a contact by
    more or less than the mean of their velocities.  Small gains are left until their sum is not small, so
    that steps that resolve impacts keep their order.  With forces p on the bodies towards each other and
    y = M^-1 p, velocities change by s y with p.v s + (p.y / 2) s^2 = -gain, or to the least energy
    along y if there is no such s.
    """
    cdef const ancf_system *system = self.system
    cdef Saddle *saddle = &self.saddle
    cdef const double *q0 = &self.q[self.now, 0]
    cdef const double *q1 = &self.q[next, 0]
    cdef const double *v0 = &self.v[self.now, 0]
    cdef double *v1 = &self.v[next, 0]
    cdef double *p = &self.r[0]
    cdef double *y = &self.change[0]
    cdef ancf_state x0, x1
    cdef double gain = 0.0, along, square, factor
    cdef ptrdiff_t k
    x0.q, x0.v, x1.q, x1.v = q0, v0, q1, v1
    memset(p, 0, self.n_all * sizeof(double))
    if not system.end_impulses(system.context, -self.kick[0], &x0, &x1, &gain, p):
        self.lifted = 0.0
        return
    for k in range(self.n):
        self.lifted += self.dead_load[k] * (0.5 * self.dt * (v0[k] + v1[k]) - (q1[k] - q0[k]))
    gain += self.lifted
    along = dot(p, v1, self.n)
    if along == 0.0:  # no point separates
        return
    self.lifted = 0.0
    if self.gained + gain <= IMPACT_GAIN * self.watch.exchanged:
        self.gained = max(self.gained + gain, 0.0)
        return
    if along > 0.0:
        return
    if saddle.m > 0:
        memcpy(saddle.right, p, self.n * sizeof(double))
        memset(saddle.right + self.n, 0, saddle.m * sizeof(double))
        self.seed.solve(self.seed.context, saddle.right, saddle.right)
        y = saddle.right
    else:
        self.seed.solve(self.seed.context, p, y)
        if self.held.m > 0 and not hold(&self.held, q1, &self.rest[0], NULL, y):
            return
    square = dot(p, y, self.n)
    factor = -along / square
    if 2.0 * square * gain < along * along:
        factor = 2.0 * gain / (sqrt(along * along - 2.0 * square * gain) - along)
    for k in range(self.n):
        v1[k] += factor * y[k]


cdef void add_work(Explicit self, const double *load, int next) noexcept nogil:
    """Add the work of the loads in a step, and the uncertain part of it."""
    cdef const ancf_system *system = self.system
    cdef const double *q0 = &self.q[self.now, 0]
    cdef const double *q1 = &self.q[next, 0]
    cdef ancf_state x0, x1
    cdef double unsure
    if system.load_work == NULL:
        return
    x0.q, x0.v, x0.amplitudes = q0, &self.v[self.now, 0], &self.load[0]
    x1.q, x1.v, x1.amplitudes = q1, &self.v[next, 0], load
    self.watch.work += system.load_work(system.context, &x0, &x1, &self.r[0])
    ancf_jumps_find(&self.jumps, &self.load[0], load, self.dt)
    if self.jumps.any:
        unsure = JUMP_SHARE * system.load_reach(
            system.context, q0, q1, self.jumps.jump, &self.r[0])
        self.watch.unsure += unsure * unsure
    ancf_jumps_accept(&self.jumps, &self.load[0], load, self.dt)


cdef void remember(
        Explicit self, void (*keep)(void *, const ancf_state *) noexcept nogil) noexcept nogil:
    """Pass the last accepted state to the system, which updates its memory."""
    cdef ancf_state x
    x.q, x.v, x.a = &self.q[self.now, 0], &self.v[self.now, 0], NULL
    x.lam, x.amplitudes = &self.lam[0], &self.load[0]
    keep(self.system.context, &x)


cdef void set_step(Explicit self, double dt) noexcept nogil:
    if self.system.set_step != NULL:
        self.system.set_step(self.system.context, dt)
