# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Terms ``factor * h`` of constraint equations, h a measure of a joint, and their multipliers' forces.

They are added to equations that the quadratic terms have set before.
"""

include "../contribution.pxi"
include "coordinate_functions.pxi"


cdef struct Data:
    Measures measures
    const int32_t *row
    const double *factor
    const int32_t *slot  # of all pairs of coordinates of each
    const int32_t *first_slot
    const int32_t *slot_of_row  # of each coordinate with the equation
    double *angle  # of the last accepted step


cdef class Couplings(CompiledContribution):
    """The measures in the equations of a system.

    Parameters
    ----------
    arrays : mapping
        Of the measures ``kind``, ``start``, ``place``, ``weight`` and ``constant`` as in
        coordinate_functions.pxi; ``row`` and ``factor`` of each; ``slot`` of the pairs of its coordinates,
        from ``first_slot`` on; ``slot_of_row`` of each coordinate; ``turn``, angles at the start.
    """

    cdef Data data

    def __cinit__(self, arrays):
        cdef Data *data = &self.data
        take(&data.measures, arrays)
        data.row, data.factor = integers(arrays["row"]), reals(arrays["factor"])
        data.slot, data.first_slot = integers(arrays["slot"]), integers(arrays["first_slot"])
        data.slot_of_row, data.angle = integers(arrays["slot_of_row"]), self.copy(arrays["turn"])
        self.interface.context = data
        self.interface.n_memory, self.interface.memory = data.measures.n, data.angle
        self.interface.residual, self.interface.between = residual, between
        self.interface.matrix, self.interface.rates = matrix, rates
        self.interface.begin, self.interface.accept = accept, accept


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef const Measures *m = &self.measures
    cdef Vectors a
    cdef ptrdiff_t k
    for k in range(m.n):
        vectors_of(m, k, x.q, &a)
        phi[self.row[k]] += self.factor[k] * h_of(m.kind[k], &a, self.angle[k])
        slopes_of(m.kind[k], &a)
        gradient_of(&a)
        push(m, k, self.factor[k] * x.lam[self.row[k]], a.g, r)


cdef void between(void *context, const double *q0, const double *q1, const ancf_state *x,
                  double *r, double *phi) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef const Measures *m = &self.measures
    cdef Vectors a
    cdef Vectors b
    cdef ptrdiff_t k
    for k in range(m.n):
        vectors_of(m, k, q0, &a)
        vectors_of(m, k, q1, &b)
        phi[self.row[k]] += self.factor[k] * h_of(m.kind[k], &b, self.angle[k])
        change_of(m.kind[k], &a, &b)
        vectors_of(m, k, x.q, &a)
        gradient_of(&a)
        push(m, k, self.factor[k] * x.lam[self.row[k]], a.g, r)


cdef void rates(void *context, const double *q, const double *v, double *speed,
                double *bend) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef const Measures *m = &self.measures
    cdef Vectors a
    cdef double[9] w
    cdef double[9][9] s
    cdef double sum
    cdef ptrdiff_t k, i, c, e
    for k in range(m.n):
        differentiate(m, k, q, &a)
        speed[self.row[k]] += self.factor[k] * rate_of(m, k, a.g, v)
        if bend == NULL:
            continue
        second_of(m.kind[k], &a, s)
        for c in range(9):
            w[c] = 0.0
        for i in range(m.start[k], m.start[k + 1]):
            for c in range(9):
                w[c] += m.weight[9 * i + c] * v[m.place[i]]
        sum = 0.0
        for c in range(9):
            for e in range(9):
                sum += w[c] * s[c][e] * w[e]
        bend[self.row[k]] += self.factor[k] * sum


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef const Measures *m = &self.measures
    cdef Vectors a
    cdef double[9][9] s
    cdef ptrdiff_t k, i
    if part != STIFFNESS and part != EQUATIONS:
        return
    for k in range(m.n):
        differentiate(m, k, x.q, &a)
        if part == EQUATIONS:
            for i in range(m.start[k], m.start[k + 1]):
                values[self.slot_of_row[i]] += self.factor[k] * along(m, i, a.g)
            continue
        second_of(m.kind[k], &a, s)
        add_pairs(m, k, s, a.g, self.factor[k] * x.lam[self.row[k]], 0.0,
                  self.slot + self.first_slot[k], values)


cdef void accept(void *context, const ancf_state *x) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef const Measures *m = &self.measures
    cdef Vectors a
    cdef ptrdiff_t k
    for k in range(m.n):
        if m.kind[k] == ANGLE:
            vectors_of(m, k, x.q, &a)
            self.angle[k] = h_of(ANGLE, &a, self.angle[k])
