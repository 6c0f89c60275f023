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


cdef void add_losses(Data *self, const ancf_state *x) noexcept nogil:
    """Add the losses in the step to an accepted state to those since the start."""
    cdef ptrdiff_t k
    self.spent[1] += self.loss
    self.loss = 0.0
    if self.stepped:
        if self.gamma > 0.0 and take_means(self, x):
            self.spent[2] += self.lost
    elif (self.dt > 0.0 or self.gamma > 0.0) and set_braking(self, x, self.braking):
        for k in range(12 * self.n):
            self.spent[2] -= 0.5 * (self.braked[k] + self.braking[k]) * (self.end[k] - self.before[k])
            self.braked[k] = self.braking[k]
