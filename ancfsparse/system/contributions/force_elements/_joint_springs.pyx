# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Springs, stops and friction in joints: forces along joint coordinates, see coordinate_functions.pxi.

Between two states an elastic force is its discrete gradient, (U1 - U0) / (h1 - h0).  Friction may
be proportional to the force of its joint, by the multipliers of the same state.
"""
from libc.math cimport fabs

include "../contribution.pxi"
include "../joints/coordinate_functions.pxi"


# The order of `LAWS` in scene/force_elements/joint_springs.py.
cdef enum Law:
    SPRING, STOP, FRICTION, RUBBING


cdef struct Data:
    Measures measures
    const int32_t *law
    const double *low  # without force between these
    const double *high
    const double *stiffness
    const double *damping
    const double *slip  # rate at which friction has 0.7 of its size
    # The force of a joint with friction, from `force_start` on: the sum of factor * lam[row] *
    # (q[other] - about) in each direction, without the bracket where `other` is negative.
    const int32_t *force_start
    const int32_t *force_row
    const int32_t *force_other
    const int32_t *force_direction
    const double *force_factor
    const double *force_about
    const int32_t *slot
    const int32_t *first_slot


cdef class JointSprings(CompiledContribution):
    """The springs, stops and friction in the joints of a system.

    Parameters
    ----------
    arrays : mapping
        Of the measures ``kind``, ``start``, ``place``, ``weight`` and ``constant`` as in
        coordinate_functions.pxi; ``law``, ``low``, ``high``, ``stiffness``, ``damping`` and ``slip`` of each,
        in SI units of forces along angles or lengths; ``slot`` of the pairs of its coordinates,
        from ``first_slot`` on; ``force_start`` ``(n + 1,)`` into ``force_row``, ``force_other``,
        ``force_direction``, ``force_factor`` and ``force_about`` of the terms of the joint's force.
    """

    cdef Data data

    def __cinit__(self, arrays):
        cdef Data *data = &self.data
        take(&data.measures, arrays)
        data.law, data.slot = integers(arrays["law"]), integers(arrays["slot"])
        data.first_slot = integers(arrays["first_slot"])
        data.low, data.high = reals(arrays["low"]), reals(arrays["high"])
        data.stiffness, data.damping = reals(arrays["stiffness"]), reals(arrays["damping"])
        data.slip, data.force_start = reals(arrays["slip"]), integers(arrays["force_start"])
        data.force_row = integers(arrays["force_row"])
        data.force_other = integers(arrays["force_other"])
        data.force_direction = integers(arrays["force_direction"])
        data.force_factor = reals(arrays["force_factor"])
        data.force_about = reals(arrays["force_about"])
        self.interface.context = data
        self.interface.damped = bool(arrays["damping"].any())
        self.interface.residual, self.interface.between = residual, between
        self.interface.matrix, self.interface.energy = matrix, energy
        self.interface.damping = add_damping


cdef inline double value_of(const Data *self, ptrdiff_t k, const Vectors *a) noexcept nogil:
    """Return the joint coordinate; of an angle the turn closest to the range without force."""
    return h_of(self.measures.kind[k], a, 0.5 * (self.low[k] + self.high[k]))


cdef inline double beyond(const Data *self, ptrdiff_t k, double h) noexcept nogil:
    """Return the distance of the joint coordinate from the range without force."""
    if h > self.high[k]:
        return h - self.high[k]
    return min(h - self.low[k], 0.0)


cdef double force_of(const Data *self, ptrdiff_t k, const double *q,
                     const double *lam) noexcept nogil:
    """Magnitude of the force of a joint [N]."""
    cdef double[3] force
    cdef double value
    cdef ptrdiff_t i
    force[0] = force[1] = force[2] = 0.0
    if lam == NULL:
        return 0.0
    for i in range(self.force_start[k], self.force_start[k + 1]):
        value = self.force_factor[i] * lam[self.force_row[i]]
        if self.force_other[i] >= 0:
            value *= q[self.force_other[i]] - self.force_about[i]
        force[self.force_direction[i]] += value
    return sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2])


cdef inline double damping_of(const Data *self, ptrdiff_t k, double h, double rate,
                              const double *q, const double *lam, double *slope) noexcept nogil:
    """Return the dissipative force, and its derivative by the rate."""
    cdef double size, most = self.damping[k]
    if self.law[k] == FRICTION or self.law[k] == RUBBING:
        if self.law[k] == RUBBING:
            most *= force_of(self, k, q, lam)
        size = sqrt(rate * rate + self.slip[k] * self.slip[k])
        slope[0] = most * self.slip[k] * self.slip[k] / (size * size * size)
        return most * rate / size
    slope[0] = self.damping[k]
    if self.law[k] == STOP:  # none at the first touch, so the force does not jump
        slope[0] *= self.stiffness[k] * fabs(beyond(self, k, h))
    return slope[0] * rate


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef const Measures *m = &self.measures
    cdef Vectors a
    cdef double pull
    cdef ptrdiff_t k
    for k in range(m.n):
        if self.stiffness[k] == 0.0:
            continue
        differentiate(m, k, x.q, &a)
        pull = self.stiffness[k] * beyond(self, k, value_of(self, k, &a))
        if pull != 0.0:
            push(m, k, pull, a.g, r)
    if x.v != NULL:
        damp(context, x.q, x.v, x.lam, r)


cdef void between(void *context, const double *q0, const double *q1, const ancf_state *x,
                  double *r, double *phi) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef const Measures *m = &self.measures
    cdef Vectors a
    cdef Vectors b
    cdef double begin, end, change, first, last, share
    cdef ptrdiff_t k
    for k in range(m.n):
        if self.stiffness[k] == 0.0:
            continue
        vectors_of(m, k, q0, &a)
        vectors_of(m, k, q1, &b)
        begin = value_of(self, k, &a)
        change = change_of(m.kind[k], &a, &b)
        end = begin + change
        first, last = beyond(self, k, begin), beyond(self, k, end)
        share = (last - first) / change if change != 0.0 else 1.0
        if share == 0.0:
            continue
        vectors_of(m, k, x.q, &a)
        gradient_of(&a)
        push(m, k, 0.5 * self.stiffness[k] * (first + last) * share, a.g, r)
    if x.v != NULL:
        damp(context, x.q, x.v, x.lam, r)


cdef void add_damping(void *context, const double *q, const double *v, double *r) noexcept nogil:
    damp(context, q, v, NULL, r)


cdef void damp(void *context, const double *q, const double *v, const double *lam,
               double *r) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef const Measures *m = &self.measures
    cdef Vectors a
    cdef double slope, pull
    cdef ptrdiff_t k
    for k in range(m.n):
        if self.damping[k] == 0.0:
            continue
        differentiate(m, k, q, &a)
        pull = damping_of(
            self, k, value_of(self, k, &a), rate_of(m, k, a.g, v), q, lam, &slope)
        push(m, k, pull, a.g, r)


cdef double energy(void *context, const double *q) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef Vectors a
    cdef double sum = 0.0, out
    cdef ptrdiff_t k
    for k in range(self.measures.n):
        if self.stiffness[k] != 0.0:
            vectors_of(&self.measures, k, q, &a)
            out = beyond(self, k, value_of(self, k, &a))
            sum += 0.5 * self.stiffness[k] * out * out
    return sum


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef const Measures *m = &self.measures
    cdef Vectors a
    cdef double[9][9] s
    cdef double value, out, bend, square
    cdef ptrdiff_t k
    if part != STIFFNESS and part != MATERIAL and part != DAMPING:
        return
    for k in range(m.n):
        if (self.damping[k] if part == DAMPING else self.stiffness[k]) == 0.0:
            continue
        differentiate(m, k, x.q, &a)
        value = value_of(self, k, &a)
        bend = 0.0
        if part == DAMPING:
            damping_of(self, k, value, rate_of(m, k, a.g, x.v) if x.v != NULL else 0.0,
                       x.q, x.lam, &square)
        else:
            out = beyond(self, k, value)
            square = self.stiffness[k] if out != 0.0 or self.law[k] == SPRING else 0.0
            bend = self.stiffness[k] * out if part == STIFFNESS else 0.0
        if square == 0.0 and bend == 0.0:
            continue
        second_of(m.kind[k], &a, s)
        add_pairs(m, k, s, a.g, bend, square, self.slot + self.first_slot[k], values)
