"""What compiled callers ask of an assembly: sums of elements, constraints, moments and loads."""
from libc.math cimport fabs
from libc.string cimport memset


cdef inline void add(const Flat *self, Quantity quantity, const double *q, const double *a,
                     double *out, bint damped=False) noexcept nogil:
    self.elements.add(self.elements.context, quantity, q, a, out, damped)


cdef void add_damping(const Flat *self, const double *q, const double *v,
                      double *out) noexcept nogil:
    add(self, DAMPING, q, v, out, True)
    add(self, INERTIA, v, v, out, True)


cdef void inertia(void *context, const double *a, double *out) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    clear(self, self.n_all, out)
    add(self, INERTIA, a, a, out)


cdef void clear_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef const Range *call = <const Range *>context
    cdef ptrdiff_t begin = call.n * part // call.parts
    cdef ptrdiff_t end = call.n * (part + 1) // call.parts
    memset(call.out + begin, 0, (end - begin) * sizeof(double))


cdef void clear(const Flat *self, ptrdiff_t n, double *out) noexcept nogil:
    cdef Range call
    call.parts, call.n, call.out = self.elements.n_parts, n, out
    in_parts(call.parts, clear_part, &call)


cdef void residual(void *context, const double *q, const double *v, const double *a,
                   const double *lam, const double *dead_load, const double *amplitudes, double *r,
                   double *phi) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    vec_scale_parts(self.elements.n_parts, r, -1.0, dead_load, self.n_all)
    if a == NULL:
        add(self, FORCE, q, q, r)
    else:
        add(self, RESIDUAL, q, a, r)
    add_the_rest(self, q, v, lam, amplitudes, r)
    set_constraints(self, q, phi)


cdef void residual_between(void *context, const double *q0, const double *q1, const double *q,
                           const double *v, const double *a, const double *lam,
                           const double *dead_load, const double *amplitudes, double *r,
                           double *phi) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    vec_scale_parts(self.elements.n_parts, r, -1.0, dead_load, self.n_all)
    add(self, DISCRETE_GRADIENT, q0, q1, r)
    add(self, INERTIA, a, a, r)
    add_the_rest(self, q, v, lam, amplitudes, r)
    set_constraints(self, q1, phi)


cdef void add_the_rest(const Flat *self, const double *q, const double *v, const double *lam,
                       const double *amplitudes, double *r) noexcept nogil:
    """Forces of damping, of loads that change and of constraints."""
    cdef ptrdiff_t k, i, j
    cdef double c, a
    if self.elements.damped:
        add_damping(self, q, v, r)
    for k in range(self.n_loads):
        r[self.load_place[k]] -= self.load_weight[k] * amplitudes[self.load_column[k]]
    if self.moments.n > 0:
        self.moments.add(self.moments.context, q, amplitudes, r)
    for k in range(self.n_terms):
        i, j, c, a = self.term_i[k], self.term_j[k], self.coefficient[k], self.about[k]
        if j < 0:
            r[i] += c * lam[self.term_row[k]]
        else:
            r[i] += c * (q[j] - a) * lam[self.term_row[k]]
            r[j] += c * (q[i] - a) * lam[self.term_row[k]]


cdef void set_constraints(const Flat *self, const double *q, double *phi) noexcept nogil:
    cdef ptrdiff_t k, i, j
    cdef double a
    for k in range(self.n_multipliers):
        phi[k] = self.offset[k]
    for k in range(self.n_terms):
        i, j, a = self.term_i[k], self.term_j[k], self.about[k]
        phi[self.term_row[k]] += self.coefficient[k] * (
            q[i] if j < 0 else (q[i] - a) * (q[j] - a))


cdef void matrix(void *context, double mass_factor, double stiffness_factor, double damping_factor,
                 const double *q, const double *v, const double *lam, const double *amplitudes,
                 double *values) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef ptrdiff_t k
    cdef double c
    # What `values` is counted in until the mass is added.
    cdef double unit = stiffness_factor if stiffness_factor != 0.0 else damping_factor
    start_with_damping(self, damping_factor / unit if unit != 0.0 else 0.0, q, values)
    if stiffness_factor != 0.0:
        add(self, TANGENT, q, q, values)
        if self.moments.n > 0:
            self.moments.add_stiffness(self.moments.context, q, amplitudes, values)
        for k in range(self.n_terms):
            if self.term_j[k] >= 0:
                c = self.coefficient[k] * lam[self.term_row[k]]
                values[self.slot_ij[k]] += 2.0 * c if self.term_i[k] == self.term_j[k] else c
    add_masses(self, mass_factor, unit, q, values)
    add_constraint_rows(self, q, values)


cdef void start_with_damping(const Flat *self, double factor, const double *q,
                             double *values) noexcept nogil:
    """Clear the values; set C times a factor: the derivative by the coordinates is left to iteration."""
    cdef ptrdiff_t n = self.n_values + 1  # the bin too
    clear(self, n, values)
    if self.elements.damped and factor != 0.0:
        add(self, MATERIAL, q, q, values, True)
        add(self, MASS, q, q, values, True)
        vec_scale_parts(self.elements.n_parts, values, factor, values, n)


cdef void material(void *context, double mass_factor, double stiffness_factor,
                   double damping_factor, const double *q, double *values) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    start_with_damping(self, damping_factor / stiffness_factor, q, values)
    add(self, MATERIAL, q, q, values)
    add_masses(self, mass_factor, stiffness_factor, q, values)
    add_constraint_rows(self, q, values)


cdef void add_masses(const Flat *self, double mass_factor, double unit, const double *q,
                     double *values) noexcept nogil:
    """Multiply what there is by its unit, and add the masses."""
    cdef ptrdiff_t n = self.n_values + 1  # the bin too
    if self.mass_values != NULL:
        vec_sum_parts(self.elements.n_parts, values, unit, values, mass_factor,
                      self.mass_values, self.n_values)
    elif mass_factor == 0.0:
        vec_scale_parts(self.elements.n_parts, values, unit, values, n)
    else:
        vec_scale_parts(self.elements.n_parts, values, unit / mass_factor, values, n)
        add(self, MASS, q, q, values)
        if mass_factor != 1.0:
            vec_scale_parts(self.elements.n_parts, values, mass_factor, values, n)


cdef void add_constraint_rows(const Flat *self, const double *q, double *values) noexcept nogil:
    """Add phi_q and the small negative diagonal below it."""
    cdef ptrdiff_t k, i, j
    cdef double c, a
    for k in range(self.n_terms):
        i, j, c, a = self.term_i[k], self.term_j[k], self.coefficient[k], self.about[k]
        if j < 0:
            values[self.slot_i[k]] += c
        else:
            values[self.slot_i[k]] += c * (q[j] - a)
            values[self.slot_j[k]] += c * (q[i] - a)
    for k in range(self.n_multipliers):
        values[self.slot_diagonal[k]] -= self.regularization


cdef void energies(void *context, const double *q, const double *v, double *scratch,
                   double *out) noexcept nogil:
    """Kinetic and strain energy."""
    cdef const Flat *self = <const Flat *>context
    inertia(context, v, scratch)
    out[0] = 0.5 * vec_dot_parts(self.elements.n_parts, v, scratch, self.n_all)
    out[1] = self.elements.strain_energy(self.elements.context, q)


cdef double load_work(void *context, const double *q0, const double *amplitudes0,
                      const double *q1, const double *amplitudes1, double *scratch) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef ptrdiff_t k, i
    cdef double work = 0.0
    for k in range(self.n_loads):
        i = self.load_place[k]
        work += 0.5 * self.load_weight[k] * (q1[i] - q0[i]) * (
            amplitudes0[self.load_column[k]] + amplitudes1[self.load_column[k]])
    if self.moments.n > 0:
        # Moments are written into the residual with a minus.
        memset(scratch, 0, self.n_all * sizeof(double))
        self.moments.add(self.moments.context, q0, amplitudes0, scratch)
        self.moments.add(self.moments.context, q1, amplitudes1, scratch)
        for i in range(self.n_all):
            work -= 0.5 * scratch[i] * (q1[i] - q0[i])
    return work


cdef double load_reach(void *context, const double *q0, const double *q1,
                       const double *amplitudes, double *scratch) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef ptrdiff_t k, i
    cdef double reach = 0.0
    for k in range(self.n_loads):
        i = self.load_place[k]
        reach += fabs(self.load_weight[k] * amplitudes[self.load_column[k]] * (q1[i] - q0[i]))
    if self.moments.n > 0:
        memset(scratch, 0, self.n_all * sizeof(double))
        self.moments.add(self.moments.context, q1, amplitudes, scratch)
        for i in range(self.n_all):
            reach += fabs(scratch[i] * (q1[i] - q0[i]))
    return reach
