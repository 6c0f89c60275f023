"""Memory of contacts between beams: changes with accepted states; included by `_beam_contacts.pyx`."""


cdef void set_step(void *context, double dt) noexcept nogil:
    cdef Data *self = <Data *>context
    self.ended = self.ended and (self.stepped or fabs(dt) == self.interval)
    self.dt, self.interval = 0.0 if self.gamma > 0.0 else fmax(dt, 0.0), fabs(dt)


cdef void begin(void *context, const ancf_state *x) noexcept nogil:
    cdef Data *self = <Data *>context
    self.stepped = self.ended = False
    self.search.listed = False  # the order of the pairs is that of this state
    empty_list(&self.coupling)
    set_points(self, x.q, self.before)
    self.touching = self.at_end.n if find_end(self, x.q, x.v) else 0
    set_braking(self, x, self.braked)
    self.loss = 0.0
    memset(self.spent, 0, N_LOSSES * sizeof(double))
    if self.grip > 0.0:  # it begins without deflections
        memset(self.slots, 0, self.n_slots * self.width * sizeof(double))
        memset(self.rubbed, 0, 12 * self.n * sizeof(double))
        self.crowded = 0
    else:
        accept(context, x)
    self.deepest[0] = 0.0


cdef inline double smaller_radius(const Data *self, ptrdiff_t a, ptrdiff_t b) noexcept nogil:
    return fmin(self.search.radius[a], self.search.radius[b])


cdef void accept(void *context, const ancf_state *x) noexcept nogil:
    """Keep the control points of a state, and the friction on them unless its work is that of means."""
    cdef Data *self = <Data *>context
    cdef const Touch *each
    cdef double radius
    cdef ptrdiff_t k
    if self.is_static:
        return  # a relaxation passes no equilibria
    add_losses(self, x)
    if self.grip > 0.0:
        settle(self, x)
    elif self.friction > 0.0 and not self.stepped:
        set_friction(self, x, self.rubbed)
    set_points(self, x.q, self.before)
    self.ended = self.ended and self.stepped
    self.changes += self.at_end.n != self.touching
    self.touching = self.at_end.n
    leave_out_idle_pairs(&self.coupling, &self.at_end)
    for k in range(self.at_end.n):
        each = self.at_end.touch + k
        radius = smaller_radius(self, <ptrdiff_t>self.deepest[1], <ptrdiff_t>self.deepest[2])
        if each.depth * radius > self.deepest[0] * smaller_radius(self, each.a, each.b):
            self.deepest[0], self.deepest[1], self.deepest[2] = each.depth, each.a, each.b
            self.deepest[3], self.deepest[4] = each.z, each.u


cdef int contacts_changed(void *context) noexcept nogil:
    cdef const Data *self = <const Data *>context
    return self.at_end.n != self.touching
