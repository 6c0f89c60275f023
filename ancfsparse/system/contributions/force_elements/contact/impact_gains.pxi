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
    cdef Place begin
    cdef Place end
    cdef double impulse
    cdef ptrdiff_t k
    cdef bint touches = False
    for k in range(self.points.n):
        impulse = self.impulse[k] + weight * self.last[k]
        self.impulse[k] = 0.0
        if self.before[k] <= 0.0 and impulse <= 0.0 and self.force[k] <= 0.0:
            continue
        touches = True
        locate(self, k, x0.q, &begin)
        locate(self, k, x1.q, &end)
        self.gain[k] += 0.5 * impulse * (separation_rate(self, k, x0.v, &begin)
                                         + separation_rate(self, k, x1.v, &end))
        self.gain[k] += self.stiffness[k] * (law_energy(end.e, self.layer[k])
                                             - law_energy(begin.e, self.layer[k]))
        if end.e <= 0.0:
            gain[0] += self.gain[k]
            self.gain[k] = 0.0
            pull(self, k, &end, self.stiffness[k], out)
    return touches


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
