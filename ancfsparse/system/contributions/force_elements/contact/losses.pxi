"""Energy lost by friction and the damping of impacts; included by `_contacts.pyx`."""


cdef double turned(const Data *self, const Place *here, const double *f) noexcept nogil:
    """Power that a turning obstacle supplies by the friction f on a point."""
    cdef double[3] u
    u[0] = u[1] = u[2] = 0.0
    add_turning(self, here, 1.0, &u[0])
    return dot(f, u)


cdef double damping_loss(const Data *self, const ancf_state *x0,
                         const ancf_state *x1) noexcept nogil:
    """Energy that the damping of impacts takes: of `between`, or by the trapezoidal rule.

    It is the work of the difference of the pressures with and without it.
    """
    cdef Place begin
    cdef Place end
    cdef double before, after, sum = 0.0
    cdef ptrdiff_t k, c
    if self.dt == 0.0 and self.gamma == 0.0:
        return 0.0
    for k in range(self.points.n):
        locate(self, k, x0.q, &begin)
        locate(self, k, x1.q, &end)
        if self.is_mean:
            before = self.stiffness[k] * mean_force(begin.e, end.e, self.layer[k])
            sum += (force_between(self, k, begin.e, end.e, NULL) - before) * (end.e - begin.e)
            continue
        before = self.last[k] - self.stiffness[k] * law_force(begin.e, self.layer[k])
        after = force_in_state(self, k, &end, x1.v) - self.stiffness[k] * law_force(end.e, self.layer[k])
        for c in range(self.points.dim):
            if self.has_frame:
                sum += 0.5 * (before * begin.m[c] + after * end.m[c]) * (begin.b[c] - end.b[c])
            else:
                sum += 0.5 * (before * begin.n[c] + after * end.n[c]) * (begin.d[c] - end.d[c])
    return sum


cdef void look_back(Data *self, const ancf_state *x, double dt) noexcept nogil:
    """Set the penetrations one step before a state from its velocities."""
    cdef Place here
    cdef ptrdiff_t k
    for k in range(self.points.n):
        locate(self, k, x.q, &here)
        self.before[k] = here.e + dt * separation_rate(self, k, x.v, &here)


cdef add_losses(Data *self, const double[:, ::1] q, const double[:, ::1] v, const double[::1] t,
                double step, bint is_mean, bint begins, double[:, ::1] out):
    """Set the energies of `Contact.losses`, and move the memory to the last state."""
    cdef ancf_state x0, x1
    cdef ptrdiff_t j
    cdef double dt, supplied, work
    cdef bint is_step
    self.dt = 0.0 if is_mean else step
    x1.q, x1.v = &q[0, 0], &v[0, 0]
    set_interval(self, 0.0)
    if begins:
        if self.grip > 0.0:
            hold(self, x1.q)
        look_back(self, &x1, self.dt)  # of a run that continues, the memory is not known
        accept(self, &x1)
    for j in range(1, t.shape[0]):
        x0, x1.q, x1.v = x1, &q[j, 0], &v[j, 0]
        dt, supplied = t[j] - t[j - 1], 0.0
        is_step = fabs(dt - step) <= SAME_STEP * step
        self.is_mean = is_mean and is_step
        set_interval(self, dt)
        if self.dt > 0.0 and not is_step:
            look_back(self, &x1, step)
        if self.friction > 0.0:
            work = friction_work(self, &x0, &x1, &supplied)
            out[j - 1, 0], out[j - 1, 1] = supplied, supplied - work
        out[j - 1, 2] = damping_loss(self, &x0, &x1)
        accept(self, &x1)
