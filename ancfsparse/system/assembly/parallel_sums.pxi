"""The compiled interface of an assembly: sums over its contributions."""
from libc.string cimport memcpy, memset


cdef inline void set_state(ancf_state *x, const double *q, const double *v, const double *a,
                           const double *lam, const double *amplitudes) noexcept nogil:
    x.q, x.v, x.a, x.lam, x.amplitudes = q, v, a, lam, amplitudes


cdef inline void tune(const Flat *self, const double *amplitudes) noexcept nogil:
    """Set the amplitudes that energies depend on."""
    cdef ptrdiff_t k
    if self.tunes and amplitudes != NULL:
        for k in range(self.n_contributions):
            if self.contributions[k].tune != NULL:
                self.contributions[k].tune(self.contributions[k].context, amplitudes)


cdef void inertia(void *context, const double *a, double *out) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_contribution *each
    cdef ptrdiff_t k
    clear(self, self.n_all, out)
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.inertia != NULL:
            each.inertia(each.context, a, out)


cdef void add_damping(const Flat *self, const double *q, const double *v,
                      double *out) noexcept nogil:
    cdef const ancf_contribution *each
    cdef ptrdiff_t k
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.damped and each.damping != NULL:
            each.damping(each.context, q, v, out)


cdef double elastic(const Flat *self, const double *q) noexcept nogil:
    cdef const ancf_contribution *each
    cdef double sum = 0.0
    cdef ptrdiff_t k
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.energy != NULL:
            sum += each.energy(each.context, q)
    return sum


cdef void clear_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef const Range *call = <const Range *>context
    cdef ptrdiff_t begin = call.n * part // call.parts
    cdef ptrdiff_t end = call.n * (part + 1) // call.parts
    memset(call.out + begin, 0, (end - begin) * sizeof(double))


cdef void clear(const Flat *self, ptrdiff_t n, double *out) noexcept nogil:
    cdef Range call
    call.parts, call.n, call.out = self.n_parts, n, out
    in_parts(call.parts, clear_part, &call)


cdef void residual(void *context, const double *q, const double *v, const double *a,
                   const double *lam, const double *dead_load, const double *amplitudes, double *r,
                   double *phi) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_contribution *each
    cdef ancf_state x
    cdef ptrdiff_t k
    set_state(&x, q, v, a, lam, amplitudes)
    tune(self, amplitudes)
    scaled(self.n_parts, r, -1.0, dead_load, self.n_all)
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.residual != NULL:
            each.residual(each.context, &x, r, phi)


cdef void residual_between(void *context, const double *q0, const double *q1, const double *q,
                           const double *v, const double *a, const double *lam,
                           const double *dead_load, const double *amplitudes, double *r,
                           double *phi) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_contribution *each
    cdef ancf_state x
    cdef ptrdiff_t k
    set_state(&x, q, v, a, lam, amplitudes)
    tune(self, amplitudes)
    scaled(self.n_parts, r, -1.0, dead_load, self.n_all)
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.between != NULL:
            each.between(each.context, q0, q1, &x, r, phi)
        elif each.residual != NULL:
            each.residual(each.context, &x, r, phi)


cdef void add_part(const Flat *self, Part part, const ancf_state *x,
                   double *values) noexcept nogil:
    """Add a part of the matrix."""
    cdef const ancf_contribution *each
    cdef ptrdiff_t k
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.matrix != NULL:
            each.matrix(each.context, part, x, values)


cdef void matrix(void *context, double mass_factor, double stiffness_factor, double damping_factor,
                 const double *q, const double *v, const double *lam, const double *amplitudes,
                 double *values) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef ancf_state x
    # Unit of `values` until the mass is added.
    cdef double unit = stiffness_factor if stiffness_factor != 0.0 else damping_factor
    set_state(&x, q, v, NULL, lam, amplitudes)
    tune(self, amplitudes)
    start_with_damping(self, damping_factor / unit if unit != 0.0 else 0.0, &x, values)
    if stiffness_factor != 0.0:
        add_part(self, STIFFNESS, &x, values)
    add_masses(self, mass_factor, unit, &x, values)
    add_equations(self, mass_factor, &x, values)


cdef void start_with_damping(const Flat *self, double factor, const ancf_state *x,
                             double *values) noexcept nogil:
    """Clear the values; set C times a factor."""
    cdef ptrdiff_t n = self.n_values + 1  # including the entry of fixed coordinates
    clear(self, n, values)
    scale_couplings(self, 0.0, values)
    if self.damped and factor != 0.0:
        add_part(self, DAMPING, x, values)
        scaled(self.n_parts, values, factor, values, n)
        scale_couplings(self, factor, values)


cdef void scale_couplings(const Flat *self, double factor, double *values) noexcept nogil:
    cdef const ancf_coupling *each
    cdef ptrdiff_t k
    for k in range(self.n_couplings):
        each = self.couplings[k]
        if not each.used:
            continue
        if factor == 0.0:
            memset(values + each.first, 0, each.n * each.size * sizeof(double))
        else:
            scaled(self.n_parts, values + each.first, factor, values + each.first,
                   each.n * each.size)


cdef void add(void *context, double factor, const double *more, double *values) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_coupling *each
    cdef ptrdiff_t k
    combined(self.n_parts, values, 1.0, values, factor, more, self.n_values)
    for k in range(self.n_couplings):
        each = self.couplings[k]
        if each.used:
            combined(self.n_parts, values + each.first, 1.0, values + each.first, factor,
                     more + each.first, each.n * each.size)


cdef void material(void *context, double mass_factor, double stiffness_factor,
                   double damping_factor, const double *q, double *values) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef ancf_state x
    set_state(&x, q, NULL, NULL, NULL, NULL)
    start_with_damping(self, damping_factor / stiffness_factor, &x, values)
    add_part(self, MATERIAL, &x, values)
    add_masses(self, mass_factor, stiffness_factor, &x, values)
    add_equations(self, mass_factor, &x, values)


cdef void add_masses(const Flat *self, double mass_factor, double unit, const ancf_state *x,
                     double *values) noexcept nogil:
    """Multiply the values by their unit, and add the masses."""
    cdef ptrdiff_t n = self.n_values + 1  # including the entry of fixed coordinates
    scale_couplings(self, unit, values)
    if self.mass_values != NULL:
        combined(self.n_parts, values, unit, values, mass_factor, self.mass_values, self.n_values)
    elif mass_factor == 0.0:
        scaled(self.n_parts, values, unit, values, n)
    else:
        scaled(self.n_parts, values, unit / mass_factor, values, n)
        add_part(self, MASS, x, values)
        if mass_factor != 1.0:
            scaled(self.n_parts, values, mass_factor, values, n)


cdef void add_equations(const Flat *self, double mass_factor, const ancf_state *x,
                        double *values) noexcept nogil:
    """Add phi_q, the small negative diagonal of the multipliers, and the mass of equations."""
    cdef ptrdiff_t k
    if self.n_multipliers == 0:
        return
    if mass_factor != 0.0:
        add_part(self, EQUATION_MASS, x, values)
    add_part(self, EQUATIONS, x, values)
    for k in range(self.n_multipliers):
        values[self.diagonal[k]] -= self.regularization


cdef void energies(void *context, const double *q, const double *v, const double *amplitudes,
                   double *scratch, double *out) noexcept nogil:
    """Kinetic and elastic energy."""
    cdef const Flat *self = <const Flat *>context
    inertia(context, v, scratch)
    out[0] = 0.5 * dot_parts(self.n_parts, v, scratch, self.n_all)
    tune(self, amplitudes)
    out[1] = elastic(self, q)


cdef double load_work(void *context, const ancf_state *x0, const ancf_state *x1,
                      double *scratch) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_contribution *each
    cdef double sum = 0.0
    cdef ptrdiff_t k
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.work != NULL:
            sum += each.work(each.context, x0, x1, scratch)
    return sum


cdef double load_reach(void *context, const double *q0, const double *q1,
                       const double *amplitudes, double *scratch) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_contribution *each
    cdef double sum = 0.0
    cdef ptrdiff_t k
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.reach != NULL:
            sum += each.reach(each.context, q0, q1, amplitudes, scratch)
    return sum


cdef void begin(void *context, const ancf_state *x) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_contribution *each
    cdef ptrdiff_t k
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.begin != NULL:
            each.begin(each.context, x)


cdef void accept(void *context, const ancf_state *x) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_contribution *each
    cdef ptrdiff_t k
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.accept != NULL:
            each.accept(each.context, x)


cdef void history(void *context, double *out) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_contribution *each
    cdef ptrdiff_t k
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.n_history > 0:
            memcpy(out, each.memory, each.n_history * sizeof(double))
        out += each.n_history


cdef void set_step(void *context, double dt) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_contribution *each
    cdef ptrdiff_t k
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.set_step != NULL:
            each.set_step(each.context, dt)


cdef int admits(void *context, const double *q0, const double *q1) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_contribution *each
    cdef ptrdiff_t k
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.admits != NULL and not each.admits(each.context, q0, q1):
            return False
    return True


cdef int contacts_changed(void *context) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_contribution *each
    cdef ptrdiff_t k
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.contacts_changed != NULL and each.contacts_changed(each.context):
            return True
    return False


cdef void add_impulses(void *context, double weight) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_contribution *each
    cdef ptrdiff_t k
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.add_impulses != NULL:
            each.add_impulses(each.context, weight)


cdef int end_impulses(void *context, double weight, const ancf_state *x0, const ancf_state *x1,
                      double *gain, double *out) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const ancf_contribution *each
    cdef ptrdiff_t k
    cdef int touches = False
    for k in range(self.n_contributions):
        each = self.contributions[k]
        if each.end_impulses != NULL:
            touches |= each.end_impulses(each.context, weight, x0, x1, gain, out)
    return touches
