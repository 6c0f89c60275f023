"""Pressures with a coefficient of restitution, as those on obstacles (../contact/restitution.pxi); an include file.

The forces of two elements on each other, with the potential W, are multiplied by 1 + gamma tanh s, where
s = W' / (2 c W) is e' / (c e) of their mean approach e'.  All points of a pair have one s, since those at
the front of a crossing that slides approach, and those behind separate, which would brake it.  Here c is
a share of sqrt(K / m), the rate of impacts of parallel lines and of rods that cross, with the stiffness K of
all touching points of two bodies and their reduced mass m.  Between two states W' is the work of the mean
forces over the length of the step; the loss gamma tanh(s) W' is not negative.
"""
from libc.math cimport tanh


cdef ptrdiff_t end_of_pair(const Touches *list, ptrdiff_t k) noexcept nogil:
    """Return the end of the points of a pair from its first one on; those on both axes follow each other."""
    cdef const Touch *first = list.touch + k
    cdef const Touch *each = first
    while k < list.n and min(each.a, each.b) == min(first.a, first.b) and (
            max(each.a, each.b) == max(first.a, first.b)):
        k, each = k + 1, each + 1
    return k


cdef double restrain(const Data *self, Touches *list, double interval) noexcept nogil:
    """Set the ratios of forces by the changes of penetrations in an interval; return the energy lost."""
    cdef Touch *each
    cdef double work, energy, rate, lost = 0.0
    cdef ptrdiff_t i, end, k = 0
    if self.gamma == 0.0 or interval == 0.0:
        return 0.0
    sum_stiffness(self, list)
    while k < list.n:
        end, work, energy = end_of_pair(list, k), 0.0, 0.0
        rate = self.slow * rate_of(self.bodies.pair + list.touch[k].bodies) * interval
        for i in range(k, end):
            each = list.touch + i
            work += each.force * each.change
            energy += each.stiffness * each.e * each.e
        for i in range(k, end):
            each = list.touch + i
            each.s = work / (rate * energy)
            each.ratio = 1.0 + self.gamma * tanh(each.s)
        lost += (each.ratio - 1.0) * work
        k = end
    return lost


cdef void restrain_state(Data *self, Touches *list, const double *v) noexcept nogil:
    """Set the ratios of forces in a state with the velocities v, 1 without them."""
    cdef Touch *each
    cdef double[3] u
    cdef ptrdiff_t k
    if self.gamma == 0.0:
        return
    if v != NULL:
        set_points(self, v, self.speed)
    for k in range(list.n):
        each = list.touch + k
        each.ratio, each.s, each.change = 1.0, 0.0, 0.0
        if v != NULL:
            blend(self.speed, each, u)
            each.change = -dot(each.n, u)
    if v != NULL:
        restrain(self, list, 1.0)
