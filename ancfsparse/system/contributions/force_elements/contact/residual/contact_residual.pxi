"""Forces of a contact in a state or between two, and their potential; included by `_contacts.pyx`."""


cdef inline double damping_ratio(const Data *self, ptrdiff_t k) noexcept nogil:
    """Theta of the numerical damping of an impact."""
    cdef double ratio = self.dt * self.rate[k]
    return ratio * ratio if ratio < 1.0 else 1.0


cdef inline double damped_force(const Data *self, ptrdiff_t k, double e) noexcept nogil:
    """Force of the pressure at the end of a step, with the numerical damping of an impact."""
    if is_free(self, k, e):
        return 0.0
    e += damping_ratio(self, k) * (e - self.before[k])
    return self.stiffness[k] * law_force(e, self.layer[k])


cdef inline bint is_free(const Data *self, ptrdiff_t k, double e) noexcept nogil:
    """Return True if e is not positive, with the damping of an impact either, at most 2 e - e0."""
    return e <= 0.0 and 2.0 * e <= self.before[k]


cdef struct GroupForces:  # on the points of a group
    bint any
    double[4 * MAX_POINTS] f  # forces
    double[4 * MAX_POINTS] v  # velocities


cdef inline void clear_point_force(ptrdiff_t p, GroupForces *forces) noexcept nogil:
    """Set the force on a point of a group to zero."""
    forces.f[4 * p] = forces.f[4 * p + 1] = forces.f[4 * p + 2] = 0.0


cdef inline void set_point_force(const Data *self, ptrdiff_t g, ptrdiff_t p, const ancf_state *x,
                                 const double *q1, const Place *along, const Place *here,
                                 GroupForces *forces, double *r) noexcept nogil:
    """Set the force on a point of a group: pressure along the normal at `along`, and friction."""
    cdef ptrdiff_t c, k = self.groups.first[g] + p
    cdef const double *n = leaving(self, along)
    cdef double *f = &forces.f[4 * p]
    cdef double[3] rubbing
    cdef Place begin
    if not forces.any:
        forces.any = True
        if self.grip == 0.0 and self.friction > 0.0 and x.v != NULL and not self.on_body:
            sum_group(self, g, x.v, forces.v, 4)
    for c in range(3):
        f[c] = self.force[k] * n[c]
    if self.frame_moves:
        subtract_vector_forces(self, k, self.force[k], along, r)
    if self.grip > 0.0:
        if self.interval > 0.0:
            recall(self, k, &begin)
        stick(self, k, q1, &begin, here, self.force[k], &rubbing[0])
    elif self.friction > 0.0 and x.v != NULL:
        if self.on_body:
            weigh(self, k, x.q, x.q, here)
            move(self, k, x.v, &rubbing[0])
        else:
            for c in range(3):
                rubbing[c] = forces.v[4 * p + c]
        rub(self, here, self.force[k], &rubbing[0])
    else:
        return
    if self.on_body:
        push_friction(self, k, &rubbing[0], r)
    else:
        for c in range(3):
            f[c] += rubbing[c]


cdef void press_groups(Data *self, ptrdiff_t first, ptrdiff_t last, const Call *call,
                       ptrdiff_t part) noexcept nogil:
    """Subtract the forces on groups in a state from the residual."""
    cdef Block block
    cdef ptrdiff_t g = first, n
    block.like = -1
    while g < last:
        n = block_size(self, g, last)
        if n > 0:
            press_block(self, g, n, &block, call.x, call.out)
        else:
            press_group(self, g, call.x, call.out)
        g += max(n, 1)


cdef void press_group(Data *self, ptrdiff_t g, const ancf_state *x, double *r) noexcept nogil:
    """Subtract the forces on a group in a state from the residual."""
    cdef Place[MAX_POINTS] here
    cdef GroupForces forces
    cdef double theta, e
    cdef ptrdiff_t k, p
    approach_group(self, g, x.q, here)
    forces.any = False
    for p in range(self.groups.first[g + 1] - self.groups.first[g]):
        k = self.groups.first[g] + p
        if is_free(self, k, here[p].e):
            self.at[k], self.force[k] = NAN, 0.0
            clear_point_force(p, &forces)
            continue
        face(self, &here[p])
        theta = damping_ratio(self, k)
        e = here[p].e + theta * (here[p].e - self.before[k])
        self.at[k] = here[p].e
        self.slope[k] = (1.0 + theta) * self.stiffness[k] * law_slope(e, self.layer[k])
        self.force[k] = self.stiffness[k] * law_force(e, self.layer[k])
        if self.gamma > 0.0 and x.v != NULL and self.force[k] > 0.0:
            restrain(self, k, &here[p], x.v, &self.force[k], &self.slope[k])
        if self.force[k] > 0.0:
            set_point_force(self, g, p, x, x.q, &here[p], &here[p], &forces, r)
        else:
            clear_point_force(p, &forces)
    if forces.any:
        subtract_group_forces(self, g, forces.f, r)


cdef void press_groups_between(Data *self, ptrdiff_t first, ptrdiff_t last, const Call *call,
                               ptrdiff_t part) noexcept nogil:
    """Subtract the forces on groups between two states from the residual."""
    cdef Block block
    cdef ptrdiff_t g = first, n
    block.like = -1
    while g < last:
        n = block_size(self, g, last)
        if n > 0:
            press_block_between(self, g, n, &block, call.q0, call.q1, call.x, call.out)
        else:
            press_group_between(self, g, call.q0, call.q1, call.x, call.out)
        g += max(n, 1)


cdef void press_group_between(Data *self, ptrdiff_t g, const double *q0, const double *q1,
                              const ancf_state *x, double *r) noexcept nogil:
    """Subtract the forces on a group between two states from the residual."""
    cdef Place[MAX_POINTS] begin
    cdef Place[MAX_POINTS] end
    cdef Place[MAX_POINTS] middle
    cdef GroupForces forces
    cdef ptrdiff_t k, p
    locate_group(self, g, q0, begin)
    locate_group(self, g, q1, end)
    forces.any = False
    for p in range(self.groups.first[g + 1] - self.groups.first[g]):
        k = self.groups.first[g] + p
        if begin[p].e <= 0.0 and end[p].e <= 0.0:
            self.at[k], self.force[k] = NAN, 0.0
            clear_point_force(p, &forces)
            continue
        if not forces.any:
            locate_group(self, g, x.q, middle)
        self.force[k] = force_between(self, k, begin[p].e, end[p].e, &self.slope[k])
        self.at[k] = middle[p].e
        mean_normal(self, &end[p], &begin[p])
        set_point_force(self, g, p, x, q1, &begin[p],
                        &end[p] if self.grip > 0.0 else &middle[p], &forces, r)
    if forces.any:
        subtract_group_forces(self, g, forces.f, r)


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    cdef Call call
    call.data, call.work, call.x, call.out = <Data *>context, press_groups, x, r
    call.data.is_mean = False
    for_all_groups(&call)


cdef void between(void *context, const double *q0, const double *q1, const ancf_state *x,
                  double *r, double *phi) noexcept nogil:
    cdef Call call
    call.data, call.work, call.x, call.out = <Data *>context, press_groups_between, x, r
    call.q0, call.q1, call.data.is_mean = q0, q1, True
    for_all_groups(&call)


cdef void sum_energies(Data *self, ptrdiff_t begin, ptrdiff_t end, const Call *call,
                       ptrdiff_t part) noexcept nogil:
    """Add the energies of groups to the number of a part."""
    cdef Place[MAX_POINTS] here
    cdef ptrdiff_t g, k, p
    for g in range(begin, end):
        locate_group(self, g, call.q0, here)
        for p in range(self.groups.first[g + 1] - self.groups.first[g]):
            k = self.groups.first[g] + p
            if here[p].e > 0.0:
                call.out[part] += self.stiffness[k] * law_energy(here[p].e, self.layer[k])


cdef double energy(void *context, const double *q) noexcept nogil:
    cdef double[MOST_PARTS + 1] of_part
    cdef double sum = 0.0
    cdef ptrdiff_t part
    cdef Call call
    call.data, call.work, call.q0, call.out = <Data *>context, sum_energies, q, &of_part[0]
    memset(&of_part[0], 0, sizeof(of_part))
    for_all_groups(&call)
    for part in range(call.data.n_parts + 1):
        sum += of_part[part]
    return sum
