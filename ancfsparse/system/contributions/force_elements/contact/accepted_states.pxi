"""Memory of a contact: changes with accepted states; included by `_contacts.pyx`."""


cdef void set_step(void *context, double dt) noexcept nogil:
    cdef Data *self = <Data *>context
    self.dt = max(dt, 0.0)
    set_interval(self, fabs(dt))


cdef void set_interval(Data *self, double dt) noexcept nogil:
    """Set the time since the last accepted state, 0 for a state of its own."""
    self.interval = self.turn = dt
    if self.omega * dt > 0.0:
        # The tangent is infinite at a rotation of pi: rotations are limited to two radians.
        self.turn = 2.0 / self.omega * tan(min(0.5 * self.omega * dt, 1.0))


cdef void keep_state(Data *self, const double *q) noexcept nogil:
    """Set the last accepted state, and the positions of the points in it."""
    cdef ptrdiff_t g
    memcpy(self.q0, q, self.n_all * sizeof(double))
    for g in range(self.groups.n):
        sum_group(self, g, q, self.x0 + 3 * self.groups.first[g], 3)


cdef inline void recall(const Data *self, ptrdiff_t k, Place *out) noexcept nogil:
    """Find a point in that state."""
    memcpy(out.x, self.x0 + 3 * k, 3 * sizeof(double))
    if self.frame_moves:
        take_vectors(self, k, self.q0, out)
    measure(self, k, out)


cdef void begin(void *context, const ancf_state *x) noexcept nogil:
    cdef Data *self = <Data *>context
    cdef Place[MAX_POINTS] here
    cdef ptrdiff_t g, k, p
    self.deepest[0] = self.supplied = self.rubbed = 0.0
    memset(self.spent, 0, N_LOSSES * sizeof(double))
    if self.slides != NULL:
        memset(self.drag, 0, 3 * self.points.n * sizeof(double))
    if self.grip > 0.0:
        hold(self, x.q)
    for g in range(self.groups.n):
        locate_group(self, g, x.q, here)
        for p in range(self.groups.first[g + 1] - self.groups.first[g]):
            k = self.groups.first[g] + p
            self.before[k] = here[p].e
            self.last[k] = saved_force(self, k, &here[p], x.v)
            self.gain[k] = self.impulse[k] = 0.0


cdef void accept_groups(Data *self, ptrdiff_t begin, ptrdiff_t end, const Call *call,
                        ptrdiff_t part) noexcept nogil:
    """Update the memory of groups to an accepted state; add points that touch or separate to `out`."""
    cdef Place[MAX_POINTS] here
    cdef double force
    cdef ptrdiff_t g, k, p
    for g in range(begin, end):
        locate_group(self, g, call.x.q, here)
        for p in range(self.groups.first[g + 1] - self.groups.first[g]):
            k = self.groups.first[g] + p
            force = force_in_state(self, k, &here[p], call.x.v)
            if self.grip > 0.0:
                if self.interval > 0.0:
                    deflect(self, k, call.x.q, &here[p], force)
                memcpy(self.x0 + 3 * k, here[p].x, 3 * sizeof(double))
            if (here[p].e > 0.0) != (self.before[k] > 0.0) and self.stiffness[k] > 0.0:
                call.out[part] += 1.0
            self.damped[k] = damping_loss(self, k, here[p].e, force)
            self.last[k] = force
            self.before[k] = here[p].e


cdef inline double damping_loss(const Data *self, ptrdiff_t k, double e, double force) noexcept nogil:
    """Energy that the damping of impacts takes in a step to the penetration e and its force.

    It is the work of the difference of the forces with and without it: of `between`, or by the
    trapezoidal rule.
    """
    cdef double before = self.before[k], braking
    if self.dt == 0.0 and self.gamma == 0.0:
        return 0.0
    if before <= 0.0 and e <= 0.0 and self.last[k] == 0.0 and force == 0.0:
        return 0.0
    if self.is_mean:
        braking = force_between(self, k, before, e, NULL) - (
            self.stiffness[k] * mean_force(before, e, self.layer[k]))
    else:
        braking = 0.5 * (self.last[k] + force - self.stiffness[k] * (
            law_force(before, self.layer[k]) + law_force(e, self.layer[k])))
    return braking * (e - before)


cdef void accept(void *context, const ancf_state *x) noexcept nogil:
    cdef Data *self = <Data *>context
    cdef double[MOST_PARTS + 1] of_part
    cdef double changed = 0.0
    cdef ptrdiff_t k
    cdef Call call
    if self.is_static:
        return  # a relaxation passes no equilibria
    call.data, call.work, call.x, call.out = self, accept_groups, x, &of_part[0]
    memset(&of_part[0], 0, (self.n_parts + 1) * sizeof(double))
    for_all_groups(&call)
    for k in range(self.n_parts + 1):
        changed += of_part[k]
    self.changes += changed > 0.0
    self.spent[0] += self.supplied
    self.spent[1] += self.rubbed
    self.supplied = self.rubbed = 0.0
    if self.slides != NULL:
        memcpy(self.drag, self.pull, 3 * self.points.n * sizeof(double))
    for k in range(self.points.n):
        self.spent[2] += self.damped[k]
        if (self.before[k] * self.layer[<ptrdiff_t>self.deepest[1]] > self.deepest[0] * self.layer[k]
                and self.stiffness[k] > 0.0):
            self.deepest[0], self.deepest[1] = self.before[k], k
    if self.grip > 0.0:
        memcpy(self.q0, x.q, self.n_all * sizeof(double))


cdef int contacts_changed(void *context) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef ptrdiff_t k
    for k in range(self.points.n):
        if (self.force[k] > 0.0) != (self.last[k] > 0.0):
            return True
    return False
