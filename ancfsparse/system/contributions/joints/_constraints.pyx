# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Constraints phi = sum of terms ``coefficient * (q[i] - about) * (q[j] - about)`` (or
``coefficient * q[i]``) plus a constant, and the forces of their multipliers."""

include "../contribution.pxi"


cdef struct Data:
    ptrdiff_t n_equations, n_terms
    # One entry per term; indices in q, and slots in the values of the matrix.
    const int32_t *row
    const int32_t *i
    const int32_t *j
    const int32_t *slot_i
    const int32_t *slot_j
    const int32_t *slot_ij
    const double *coefficient
    const double *about
    const double *offset
    # Equations whose gradients are added to the mass matrix: their terms, the coordinates of the
    # equation in each term, and slots of all pairs of the coordinates.
    ptrdiff_t n_massive
    const int32_t *first_term
    const int32_t *first_place
    const int32_t *first_slot
    const int32_t *term
    const int32_t *own
    const int32_t *other
    const int32_t *slot
    const double *mass
    double *gradient


cdef class Constraints(CompiledContribution):
    """The constraint equations of a system.

    Parameters
    ----------
    arrays : mapping
        ``offset (n_equations,)``; of the terms ``row``, ``i``, ``j``, ``coefficient`` and ``about``
        as in `system.coordinates.constraint_terms`, and ``slot_i``, ``slot_j`` and ``slot_ij``, where phi_q and its
        derivative are stored.
    masses : mapping
        The equations with a ``mass (n,)``: ``first_term``, ``first_place`` and ``first_slot``
        ``(n + 1,)`` into ``term``, ``own`` and ``other`` of all their terms, into their
        coordinates, and into ``slot`` of all pairs of these.
    """

    cdef Data data

    def __cinit__(self, arrays, masses):
        cdef Data *data = &self.data
        data.n_massive = len(masses["mass"])
        data.gradient = self.copy(np.empty(1 + max(np.diff(masses["first_place"]), default=0)))
        data.first_term = integers(masses["first_term"])
        data.first_place = integers(masses["first_place"])
        data.first_slot, data.term = integers(masses["first_slot"]), integers(masses["term"])
        data.own, data.other = integers(masses["own"]), integers(masses["other"])
        data.slot, data.mass = integers(masses["slot"]), reals(masses["mass"])
        data.n_equations, data.n_terms = len(arrays["offset"]), len(arrays["row"])
        data.row, data.i = integers(arrays["row"]), integers(arrays["i"])
        data.j, data.slot_i = integers(arrays["j"]), integers(arrays["slot_i"])
        data.slot_j, data.slot_ij = integers(arrays["slot_j"]), integers(arrays["slot_ij"])
        data.coefficient, data.about = reals(arrays["coefficient"]), reals(arrays["about"])
        data.offset = reals(arrays["offset"])
        self.interface.context = data
        self.interface.residual, self.interface.between = residual, between
        self.interface.matrix, self.interface.rates = matrix, rates


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    between(context, x.q, x.q, x, r, phi)


cdef void between(void *context, const double *q0, const double *q1, const ancf_state *x,
                  double *r, double *phi) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef const double *q = x.q
    cdef ptrdiff_t k, i, j, row
    cdef double c, a, push
    for k in range(self.n_equations):
        phi[k] = self.offset[k]
    for k in range(self.n_terms):
        i, j, c, a, row = self.i[k], self.j[k], self.coefficient[k], self.about[k], self.row[k]
        push = x.lam[row]
        if j < 0:
            r[i] += c * push
            phi[row] += c * q1[i]
        else:
            r[i] += c * (q[j] - a) * push
            r[j] += c * (q[i] - a) * push
            phi[row] += c * ((q1[i] - a) * (q1[j] - a))


cdef void rates(void *context, const double *q, const double *v, double *speed,
                double *bend) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef ptrdiff_t k, i, j
    cdef double c, a
    for k in range(self.n_terms):
        i, j, c, a = self.i[k], self.j[k], self.coefficient[k], self.about[k]
        if j < 0:
            speed[self.row[k]] += c * v[i]
            continue
        speed[self.row[k]] += c * ((q[j] - a) * v[i] + (q[i] - a) * v[j])
        if bend != NULL:
            bend[self.row[k]] += 2.0 * c * v[i] * v[j]


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    cdef const Data *self = <const Data *>context
    if part == STIFFNESS:
        add_curvature(self, x.lam, values)
    elif part == EQUATIONS:
        add_rows(self, x.q, values)
    elif part == EQUATION_MASS:
        add_squares(self, x.q, values)


cdef void add_curvature(const Data *self, const double *lam, double *values) noexcept nogil:
    cdef ptrdiff_t k
    cdef double c
    for k in range(self.n_terms):
        if self.j[k] >= 0:
            c = self.coefficient[k] * lam[self.row[k]]
            values[self.slot_ij[k]] += 2.0 * c if self.i[k] == self.j[k] else c


cdef void add_rows(const Data *self, const double *q, double *values) noexcept nogil:
    cdef ptrdiff_t k, i, j
    cdef double c, a
    for k in range(self.n_terms):
        i, j, c, a = self.i[k], self.j[k], self.coefficient[k], self.about[k]
        if j < 0:
            values[self.slot_i[k]] += c
        else:
            values[self.slot_i[k]] += c * (q[j] - a)
            values[self.slot_j[k]] += c * (q[i] - a)


cdef void add_squares(const Data *self, const double *q, double *values) noexcept nogil:
    """Add ``mass gradient gradient^T`` of the equations with a mass."""
    cdef ptrdiff_t e, k, t, a, b, i, j, n
    cdef const int32_t *slot
    cdef double c, about
    for e in range(self.n_massive):
        n = self.first_place[e + 1] - self.first_place[e]
        for a in range(n):
            self.gradient[a] = 0.0
        for k in range(self.first_term[e], self.first_term[e + 1]):
            t = self.term[k]
            i, j, c, about = self.i[t], self.j[t], self.coefficient[t], self.about[t]
            if j < 0:
                self.gradient[self.own[k]] += c
            else:
                self.gradient[self.own[k]] += c * (q[j] - about)
                self.gradient[self.other[k]] += c * (q[i] - about)
        slot = self.slot + self.first_slot[e]
        for a in range(n):
            for b in range(a + 1):
                values[slot[0]] += self.mass[e] * self.gradient[a] * self.gradient[b]
                slot += 1
