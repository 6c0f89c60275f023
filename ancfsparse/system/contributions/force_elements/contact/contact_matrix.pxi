"""Contribution of a contact to the iteration matrix; included by `_contacts.pyx`."""


cdef inline bint is_of_residual(const Data *self, ptrdiff_t k, const Place *here) noexcept nogil:
    """Return whether a penetration is that of the last residual, but for rounding."""
    return fabs(here.e - self.at[k]) <= SAME * self.layer[k]


cdef inline bint respond(const Data *self, ptrdiff_t k, const Place *here, double *pressure,
                        double *slope) noexcept nogil:
    """Set pressure and stiffness of a point; return whether one of them is positive.

    In the state of the last residual they are taken from the residual, with damping.
    """
    if is_of_residual(self, k, here):
        pressure[0], slope[0] = self.force[k], self.slope[k]
    else:
        pressure[0] = self.stiffness[k] * law_force(here.e, self.layer[k])
        slope[0] = self.stiffness[k] * law_slope(here.e, self.layer[k])
    return pressure[0] > 0.0 or slope[0] > 0.0


cdef void normal_block(const Data *self, int part, const Place *here, double pressure,
                       double slope, double *block) noexcept nogil:
    """Set the derivative of the pressure on a point by its position, (3, 3)."""
    cdef double across = 0.0
    cdef ptrdiff_t c, e, dim = self.points.dim
    if self.has_frame:
        block_in_frame(self, part, here, pressure, slope, block)
        return
    if part == STIFFNESS and self.is_round and here.distance > 0.0:
        across = pressure / here.distance
    for c in range(dim):
        for e in range(dim):
            block[3 * c + e] = (slope + across) * here.n[c] * here.n[e]
            if self.is_round:
                block[3 * c + e] -= across * self.projector[3 * c + e]


cdef void sliding_block(const Data *self, ptrdiff_t k, const ancf_state *x, const Place *here,
                        double pressure, double *block) noexcept nogil:
    """Set the derivative of friction by the velocity of a point along the obstacle, (3, 3)."""
    cdef double speed
    cdef double[3] u
    move(self, k, x.v, &u[0])
    speed = slide(self, here, &u[0])
    along_surface(self, here, self.friction * pressure / speed, 1.0 / (speed * speed), &u[0], block)


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    cdef Call call
    call.data, call.work, call.x, call.out, call.matrix = <Data *>context, add_groups, x, values, part
    if part in (STIFFNESS, MATERIAL) or (part == DAMPING and x.v != NULL and (
            call.data.slip_speed > 0.0 or call.data.gamma > 0.0)):
        for_all_groups(&call)


cdef void add_groups(Data *self, ptrdiff_t begin, ptrdiff_t end, const Call *call,
                     ptrdiff_t part) noexcept nogil:
    """Add the derivatives of the forces on groups to the matrix."""
    cdef const int32_t *slot
    cdef Place[MAX_POINTS] here
    cdef int kind = call.matrix
    cdef bint slides = kind == DAMPING and self.slip_speed > 0.0
    cdef bint presses = kind != DAMPING or (self.gamma > 0.0 and not self.is_mean)
    cdef ptrdiff_t g, k, p, size
    for g in range(begin, end):
        locate_group(self, g, call.x.q, here)
        size = self.points.dim * (self.groups.term[g + 1] - self.groups.term[g])
        slot = self.slot + self.first_slot[g]
        for p in range(self.groups.first[g + 1] - self.groups.first[g]):
            k = self.groups.first[g] + p
            add_blocks(self, k, kind, presses, slides, call.x, &here[p], slot, call.out)
            slot += size * (size + 1) // 2


cdef void add_blocks(const Data *self, ptrdiff_t k, int part, bint presses, bint slides,
                     const ancf_state *x, const Place *here, const int32_t *slot,
                     double *values) noexcept nogil:
    """Add the derivatives of the pressure on a point, or of friction by its velocity, or both."""
    cdef const double *weight = self.points.weight + self.points.start[k]
    cdef double[9] block
    cdef double[9] rubbing
    cdef double pressure, slope
    cdef bint sticks = part != DAMPING and (self.is_sticking or (
        self.grip > 0.0 and self.interval > 0.0 and is_of_residual(self, k, here)))
    cdef ptrdiff_t i, j, c, e, dim = self.points.dim
    if not respond(self, k, here, &pressure, &slope):
        return
    if self.is_static and part != DAMPING:
        sticks = True
        try_equilibrium(self, k, x.q, here, pressure)
    if slides or sticks:
        weigh(self, k, x.q, x.q, here)
    if slides:
        sliding_block(self, k, x, here, pressure, &rubbing[0])
    if presses:
        if part == DAMPING:
            part, pressure, slope = MATERIAL, 0.0, restitution_damping(self, k, here, x.v)
        normal_block(self, part, here, pressure, slope, &block[0])
        if self.frame_moves:
            add_vector_blocks(self, part, k, here, pressure, slope, slot, values)
        if sticks:
            sticking_block(self, k, here, pressure, &rubbing[0])
    # Coordinates are numbered consecutively, with the directions of each together.
    for i in range(self.points.start[k + 1] - self.points.start[k]):
        for c in range(dim):
            for j in range(i + 1):
                for e in range(dim if j < i else c + 1):
                    if presses:
                        values[slot[0]] += weight[i] * weight[j] * block[3 * c + e]
                    if slides or sticks:
                        values[slot[0]] += self.weights[i] * self.weights[j] * rubbing[3 * c + e]
                    slot += 1
