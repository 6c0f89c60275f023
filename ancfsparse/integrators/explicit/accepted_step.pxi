"""Updates after an accepted explicit step: work of loads, memory of the system; included by `_explicit.pyx`."""


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
