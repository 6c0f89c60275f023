"""Energy that friction and the numerical damping of impacts take; an include file."""


cdef bint set_braking(Data *self, const ancf_state *x, double *out) noexcept nogil:
    """Set the forces of the damping of impacts on control points; return if it succeeds."""
    memset(out, 0, 12 * self.n * sizeof(double))
    if self.dt == 0.0 and self.gamma == 0.0:
        return True
    if not find_end(self, x.q, x.v) or not collect(self, self.end, NULL, &self.at_now):
        return False
    push_all(self, &self.at_end, 1.0, out)
    push_all(self, &self.at_now, -1.0, out)
    return True


cdef void look_back(Data *self, const ancf_state *x, double dt) noexcept nogil:
    """Set the control points one step before a state from its velocities."""
    cdef ptrdiff_t k
    set_points(self, x.q, self.before)
    set_points(self, x.v, self.speed)
    for k in range(12 * self.n):
        self.before[k] -= dt * self.speed[k]
    self.ended = False


cdef add_losses(Data *self, const double[:, ::1] q, const double[:, ::1] v, const double[::1] t,
                double step, bint is_mean, double *braked, bint begins, double[:, ::1] out):
    """Set the energies of `BeamContact.losses`; memory and `braked` are moved to the last state."""
    cdef ancf_state x0, x1
    cdef ptrdiff_t j, k
    cdef bint is_step
    cdef double[::1] braking = np.zeros(12 * self.n), start = np.zeros(12 * self.n)
    self.start = &start[0]
    self.dt = 0.0 if is_mean or self.gamma > 0.0 else step
    x1.q, x1.v = &q[0, 0], &v[0, 0]
    self.interval = 0.0
    if begins:
        memset(self.slots, 0, self.n_slots * self.width * sizeof(double))
        look_back(self, &x1, self.dt)  # of a run that continues, the memory is not known
        set_friction(self, &x1, self.rubbed)
        set_braking(self, &x1, braked)
    for j in range(1, t.shape[0]):
        x0, x1.q, x1.v = x1, &q[j, 0], &v[j, 0]
        is_step = fabs(t[j] - t[j - 1] - step) <= SAME_STEP * step
        if is_step:
            set_points(self, x0.q, self.before)
            self.ended = False
        else:
            look_back(self, &x1, step)
        set_points(self, x0.q, &start[0])
        self.interval = t[j] - t[j - 1]
        if self.friction > 0.0:
            out[j - 1, 1] = -friction_work(self, &x0, &x1, is_mean and is_step)
            if self.grip > 0.0:
                keep_bristles(self)
            self.interval = 0.0
            set_friction(self, &x1, self.rubbed)
        if (self.dt > 0.0 or self.gamma > 0.0) and set_braking(self, &x1, &braking[0]):
            set_points(self, x0.q, self.begin)
            for k in range(12 * self.n):
                out[j - 1, 2] -= 0.5 * (braked[k] + braking[k]) * (self.end[k] - self.begin[k])
                braked[k] = braking[k]
        if self.gamma > 0.0 and is_mean and is_step:
            self.interval = t[j] - t[j - 1]
            if list_between(self, x0.q, x1.q):
                set_means(self)
                out[j - 1, 2] = self.lost
