"""Energy that explicit steps give to points in an impact; included by `_contacts.pyx`.

With a constant mass matrix the impulse j of a pressure in a step changes the kinetic energy by j times the
mean of the rates of separation at both ends.  The sum of these and of the changes of the potential over
the steps of a contact is the energy that they gain; it would be zero in exact motion.
"""


cdef void add_impulses(void *context, double weight) noexcept nogil:
    cdef Data *self = <Data *>context
    cdef ptrdiff_t k
    for k in range(self.points.n):
        self.impulse[k] += weight * self.force[k]


cdef int end_impulses(void *context, double weight, const ancf_state *x0, const ancf_state *x1,
                      double *gain, double *out) noexcept nogil:
    cdef Data *self = <Data *>context
    cdef Place[MAX_POINTS] begin
    cdef Place[MAX_POINTS] end
    cdef double[MAX_POINTS] before
    cdef double[MAX_POINTS] after
    cdef double impulse
    cdef ptrdiff_t g, k, p, n
    cdef bint is_touching = False
    cdef const Place *start = end  # which has the same normals on a plane at rest
    for g in range(self.groups.n):
        k, n = self.groups.first[g], self.groups.first[g + 1] - self.groups.first[g]
        if not touches(self, k, n):
            continue
        is_touching = True
        locate_group(self, g, x1.q, end)
        if not self.is_flat:
            locate_group(self, g, x0.q, begin)
            start = begin
        set_rates(self, g, x0.v, start, before)
        set_rates(self, g, x1.v, end, after)
        for p in range(n):
            impulse = self.impulse[k + p] + weight * self.last[k + p]
            self.impulse[k + p] = 0.0
            self.gain[k + p] += 0.5 * impulse * (before[p] + after[p])
            self.gain[k + p] += self.stiffness[k + p] * (
                law_energy(end[p].e, self.layer[k + p]) - law_energy(self.before[k + p], self.layer[k + p]))
            if end[p].e <= 0.0 and (self.before[k + p] > 0.0 or impulse != 0.0):
                gain[0] += self.gain[k + p]
                self.gain[k + p] = 0.0
                pull(self, k + p, &end[p], self.stiffness[k + p], out)
    return is_touching


cdef inline bint touches(const Data *self, ptrdiff_t first, ptrdiff_t n) noexcept nogil:
    """Return True if any of n points had a force at the start of a step, in it or at its end."""
    cdef ptrdiff_t k
    for k in range(first, first + n):
        if self.last[k] > 0.0 or self.impulse[k] != 0.0 or self.force[k] > 0.0:
            return True
    return False


cdef inline void set_rates(const Data *self, ptrdiff_t g, const double *v, const Place *here,
                           double *rate) noexcept nogil:
    """Set the rates of separation of the points of a group."""
    cdef double[4 * MAX_POINTS] u
    cdef ptrdiff_t p, first = self.groups.first[g]
    if not self.frame_moves:
        sum_group(self, g, v, u, 4)
    for p in range(self.groups.first[g + 1] - first):
        if self.frame_moves:
            rate[p] = separation_rate(self, first + p, v, &here[p])
        else:
            rate[p] = dot(leaving(self, &here[p]), u + 4 * p)


cdef void pull(const Data *self, ptrdiff_t k, const Place *here, double size, double *out) noexcept nogil:
    """Add a force on a point towards the obstacle."""
    cdef const Points *points = &self.points
    cdef const double *n = leaving(self, here)
    cdef double along
    cdef ptrdiff_t c, i
    for i in range(points.start[k], points.start[k + 1]):
        for c in range(points.dim):
            along = points.weight[i] * n[c]
            if self.frame_moves and self.turning[i]:
                along += here.m[self.turning[i] - 1] * here.d[c]
            out[points.place[c * points.m + i]] -= size * along
