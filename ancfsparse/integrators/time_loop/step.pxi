"""One step: corrections, residual, acceptance and energy; included by `loop.pxi`."""


cdef double correct(void *context, double factor, const double *s) noexcept nogil:
    """Equation 10; if no force depends on the velocity, it is updated when the step is accepted."""
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t i
    self.s, self.factor, self.corrected = s, factor, True
    self.corrections += 1
    in_parts(self.n_parts, correct_part, self)
    for i in range(self.m):
        self.lam[i] += factor / self.scale * s[self.n_free + i]
    if self.ways[0] == self.ways[0]:
        self.interface.moved = sqrt(total(self, self.ways) / self.interface.mass_total)
    return total(self, self.squares)


cdef void residual_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t begin = share(self, part), n = share(self, part + 1) - begin
    self.squares[part] = vec_scale_weigh(
        self.out + begin, self.scale, self.r + begin, self.interface.inverse_mass + begin, n)


cdef double residual(void *context, double *r) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t k
    evaluate(self)
    if self.interface.mass == NULL:
        scaled(self.n_parts, r, self.scale, self.r, self.n_free)
    else:
        self.out = r
        in_parts(self.n_parts, residual_part, self)
    memcpy(r + self.n_free, self.phi, self.m * sizeof(double))
    if self.softness > 0.0:
        for k in range(self.m):
            r[self.n_free + k] -= self.softness * self.scale * self.lam[k]
    return total(self, self.squares)


cdef void load(Motion *self, const double *amplitudes) noexcept nogil:
    """Set the length and the loads of the next step, and find their jumps in it."""
    set_step(self, self.dt)
    set_load(self, amplitudes)
    if is_driven(self):
        self.drives.row = amplitudes + self.system.n_amplitudes
        prescribe(self)
    if self.system.n_amplitudes > 0:
        self.interface.sudden = ancf_jumps_find(
            &self.jumps, self.amplitudes0, amplitudes, self.dt)


cdef inline void set_step(const Motion *self, double dt) noexcept nogil:
    if self.system.set_step != NULL:
        self.system.set_step(self.system.context, dt)


cdef inline bint is_admitted(const Motion *self) noexcept nogil:
    """Return True if no bodies pass through each other in the current step."""
    return (self.system.admits == NULL
            or self.system.admits(self.system.context, self.q0, self.q))


cdef void accept(Motion *self) noexcept nogil:
    if not self.ahead:
        add_work(self)
    if self.system.n_amplitudes > 0:
        ancf_jumps_accept(&self.jumps, self.amplitudes0, self.amplitudes, self.dt)
        memcpy(self.amplitudes0, self.amplitudes, self.system.n_amplitudes * sizeof(double))
    if is_driven(self):
        take_prescribed(self)
        accept_drives(self)
    choose_start(self)
    in_parts(self.n_parts, accept_part, self)
    extend_trend(self)
    self.corrected = False
    memcpy(self.lam0, self.lam, self.m * sizeof(double))
    if self.system.accept != NULL:
        remember(self, self.system.accept)


cdef void remember(Motion *self,
                   void (*keep)(void *, const ancf_state *) noexcept nogil) noexcept nogil:
    """Pass the last accepted state to the system, which updates its memory."""
    cdef ancf_state x
    x.q, x.v, x.a, x.lam, x.amplitudes = self.q0, self.v0, self.a0, self.lam0, self.amplitudes0
    keep(self.system.context, &x)


cdef void add_work(Motion *self) noexcept nogil:
    """Add the work of loads and drives in the current step, and the uncertain part of it."""
    cdef const ancf_system *system = self.system
    cdef ancf_state x0, x1
    cdef double work, unsure
    if is_driven(self):
        self.watch.work += work_of_drives(self)
    if system.load_work == NULL:
        return
    x0.q, x0.v, x0.amplitudes = self.q0, start_velocity(self), self.amplitudes0
    x1.q, x1.v, x1.amplitudes = self.q, self.v, self.amplitudes
    work = system.load_work(system.context, &x0, &x1, self.r)
    self.watch.work += work
    if self.watch.kinetic <= ancf_watch_rounding(&self.watch) and is_still(self):
        self.watch.noise += fabs(work)
    if self.jumps.any and self.jump_share > 0.0:
        unsure = self.jump_share * system.load_reach(
            system.context, self.q0, self.q, self.jumps.jump, self.r)
        self.watch.unsure += unsure * unsure


cdef bint is_still(const Motion *self) noexcept nogil:
    """Return True if the displacement in the current step is no larger than rounding error."""
    return way(self, 0, self.n_free) <= STILL * weighed(self, self.q0, 0, self.n_free)


cdef bint look(Motion *self) noexcept nogil:
    """Check the energy of some steps; return whether it is a reason to stop.

    Only regular checks are: they follow the same steps whatever the solver.
    """
    cdef bint seen = self.ahead  # before the step was accepted
    self.ahead = False
    self.watch.steps += 1
    self.watch.errors += self.watch.rounding
    if not seen:
        if self.watch.steps < self.watch.due:
            return False
        measure(self)
    ancf_watch_remember(&self.watch)
    return self.watch.steps % WATCH_EVERY == 0 and ancf_watch_gains(&self.watch, False)


cdef void measure(Motion *self) noexcept nogil:
    ancf_watch_measure(&self.watch, self.system, self.dead_load, self.amplitudes0, self.q0, self.v0,
                       self.r)
