# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Residual, matrix and energy of a flattened system: clears, lets the elements add, adds the rest.

The rest is what is not an element: loads that follow the motion or the clock, and constraints
phi = sum of terms ``coefficient * (q[i] - about) * (q[j] - about)`` (or ``coefficient * q[i]``)
plus a constant.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.math cimport fabs
from libc.stdint cimport int32_t
from libc.string cimport memset

import numpy as np


cdef extern from "parallel.h":
    void in_parts "ancf_in_parts" (
        ptrdiff_t, void (*)(void *, ptrdiff_t) noexcept nogil, void *) noexcept nogil

cdef extern from "vectors.h":
    double vec_dot_parts(ptrdiff_t, const double *, const double *, ptrdiff_t) noexcept nogil
    void vec_scale_parts(
        ptrdiff_t, double *, double, const double *, ptrdiff_t) noexcept nogil
    void vec_sum_parts(
        ptrdiff_t, double *, double, const double *, double, const double *,
        ptrdiff_t) noexcept nogil

include "../kernels/solver_abi.pxi"

cdef extern from "system_abi.h":
    enum Quantity "ancf_quantity":
        FORCE "ANCF_FORCE"
        INERTIA "ANCF_INERTIA"
        RESIDUAL "ANCF_RESIDUAL"
        TANGENT "ANCF_TANGENT"
        MASS "ANCF_MASS"
        DAMPING "ANCF_DAMPING"
        MATERIAL "ANCF_MATERIAL"
        DISCRETE_GRADIENT "ANCF_DISCRETE_GRADIENT"

    ctypedef struct ancf_elements:
        void *context
        ptrdiff_t n_parts
        int damped
        void (*add)(void *, int, const double *, const double *, double *, int) noexcept nogil
        double (*strain_energy)(void *, const double *) noexcept nogil

    ctypedef struct ancf_moments:
        void *context
        ptrdiff_t n
        void (*add)(void *, const double *, const double *, double *) noexcept nogil
        void (*add_stiffness)(void *, const double *, const double *, double *) noexcept nogil

include "arrays.pxi"


# Entries of a matrix up to which that of the masses is kept, not made again each time: 2 MB.
cdef ptrdiff_t FEW_VALUES = 250_000


cdef struct Flat:
    const ancf_elements *elements
    const ancf_moments *moments
    ptrdiff_t n_all, n_multipliers, n_values, n_terms, n_loads
    const double *mass_values  # of the matrix; NULL where they would be too many
    # Constraints: one entry for each term; places in q, and slots in the values of the matrix.
    const int32_t *term_row
    const int32_t *term_i
    const int32_t *term_j
    const int32_t *slot_i
    const int32_t *slot_j
    const int32_t *slot_ij
    const int32_t *slot_diagonal
    const double *coefficient
    const double *about
    const double *offset
    double regularization
    # Loads that change with time: force[place] += weight * amplitude[column].
    const int32_t *load_place
    const int32_t *load_column
    const double *load_weight


cdef struct Range:
    # Numbers that the threads clear together.
    ptrdiff_t parts, n
    double *out


cdef class Assembly:
    """Evaluate a system given as flat arrays.

    Parameters
    ----------
    n_free, n_all, n_values, n_amplitudes : int
        Free and all coordinates; stored entries of the lower triangle of the matrix; amplitudes of
        the loads that change.
    elements : Elements
        What its elements give.
    moments : Moments
        The moments on its nodes.
    constraints, loads : mapping
        Contiguous arrays as built by `system.system`.
    """

    cdef ancf_system interface
    cdef Flat flat
    cdef object mass_values
    cdef tuple owners
    cdef readonly object elements
    cdef readonly object capsule

    def __cinit__(self, ptrdiff_t n_free, ptrdiff_t n_all, ptrdiff_t n_values,
                  ptrdiff_t n_amplitudes, elements, moments, constraints, loads):
        cdef Flat *flat = &self.flat
        # The structures below point into these.
        self.elements, self.owners = elements, (moments, constraints, loads)
        flat.elements = <const ancf_elements *>PyCapsule_GetPointer(
            elements.capsule, "ancf_elements")
        flat.moments = <const ancf_moments *>PyCapsule_GetPointer(moments.capsule, "ancf_moments")
        flat.n_all, flat.n_values = n_all, n_values
        flat.n_multipliers, flat.n_terms = len(constraints["offset"]), len(constraints["row"])
        flat.n_loads = len(loads["place"])
        flat.term_row, flat.term_i = integers(constraints["row"]), integers(constraints["i"])
        flat.term_j, flat.slot_i = integers(constraints["j"]), integers(constraints["slot_i"])
        flat.slot_j = integers(constraints["slot_j"])
        flat.slot_ij = integers(constraints["slot_ij"])
        flat.slot_diagonal = integers(constraints["diagonal"])
        flat.coefficient = reals(constraints["coefficient"])
        flat.about = reals(constraints["about"])
        flat.offset = reals(constraints["offset"])
        flat.load_place, flat.load_column = integers(loads["place"]), integers(loads["column"])
        flat.load_weight = reals(loads["weight"])
        if n_values <= FEW_VALUES:
            self.mass_values = self.mass
            flat.mass_values = reals(self.mass_values)
        self.interface.context = flat
        self.interface.n_free, self.interface.n_all = n_free, n_all
        self.interface.n_multipliers = flat.n_multipliers
        self.interface.n_values = n_values
        self.interface.n_amplitudes = n_amplitudes
        self.interface.damped = flat.elements.damped
        self.interface.residual, self.interface.matrix = residual, matrix
        self.interface.material = material
        self.interface.inertia, self.interface.energies = inertia, energies
        self.interface.load_work, self.interface.load_reach = load_work, load_reach
        self.interface.residual_between = residual_between
        self.capsule = PyCapsule_New(&self.interface, "ancf_system", NULL)

    def set_regularization(self, double value):
        """Set epsilon of the constraint block, in the units of the scaled matrix [1/kg]."""
        self.flat.regularization = value

    @property
    def mass(self):
        """Values of the mass matrix on the pattern, lower triangle [kg, kg m, kg m^2]."""
        # One more place than values: kernels throw the entries of fixed coordinates into it.
        values = np.zeros(self.flat.n_values + 1)
        cdef double[::1] view = values
        add(&self.flat, MASS, &view[0], &view[0], &view[0])
        return values[: self.flat.n_values]

    def residual(self, const double[::1] q, const double[::1] v, const double[::1] a,
                 const double[::1] lam, const double[::1] dead_load, const double[::1] amplitudes):
        """Return ``r (n_all,)`` [N, N m] and ``phi (m,)`` [m]."""
        r, phi = np.empty(self.flat.n_all), np.empty(self.flat.n_multipliers)
        cdef double[::1] r_view = r, phi_view = phi
        residual(&self.flat, &q[0], &v[0], &a[0], first(lam), &dead_load[0], first(amplitudes),
                 &r_view[0], first(phi_view))
        return r, phi

    def residual_between(self, const double[::1] q0, const double[::1] q1, const double[::1] v,
                         const double[::1] a, const double[::1] lam, const double[::1] dead_load,
                         const double[::1] amplitudes):
        """Return ``r (n_all,)`` [N, N m] between two states and ``phi (m,)`` [m] at the second."""
        r, phi = np.empty(self.flat.n_all), np.empty(self.flat.n_multipliers)
        cdef double[::1] r_view = r, phi_view = phi
        cdef double[::1] q = 0.5 * (np.asarray(q0) + q1)
        residual_between(&self.flat, &q0[0], &q1[0], &q[0], &v[0], &a[0], first(lam),
                         &dead_load[0], first(amplitudes), &r_view[0], first(phi_view))
        return r, phi

    def matrix(self, double mass_factor, double stiffness_factor, const double[::1] q,
               const double[::1] lam, const double[::1] amplitudes, *, double damping_factor=0.0,
               const double[::1] v=None, out=None):
        """Return the values ``(n_values,)`` of the matrix, in ``out (n_values + 1,)`` if given."""
        values = np.empty(self.flat.n_values + 1) if out is None else out
        cdef double[::1] view = values
        matrix(&self.flat, mass_factor, stiffness_factor, damping_factor, &q[0],
               NULL if v is None else &v[0], first(lam), first(amplitudes), &view[0])
        return values[: self.flat.n_values]

    def material(self, double mass_factor, double stiffness_factor, const double[::1] q, *,
                 double damping_factor=0.0, out=None):
        """Return the matrix with the material part of the stiffness alone, as `matrix` does."""
        values = np.empty(self.flat.n_values + 1) if out is None else out
        cdef double[::1] view = values
        material(&self.flat, mass_factor, stiffness_factor, damping_factor, &q[0], &view[0])
        return values[: self.flat.n_values]

    def load_work(self, const double[::1] q0, const double[::1] amplitudes0, const double[::1] q1,
                  const double[::1] amplitudes1):
        """Return the work of the changing loads from one state to another [J]."""
        cdef double[::1] scratch = np.empty(self.flat.n_all)
        return load_work(&self.flat, &q0[0], first(amplitudes0), &q1[0], first(amplitudes1),
                         &scratch[0])

    def load_reach(self, const double[::1] q0, const double[::1] q1,
                   const double[::1] amplitudes):
        """Return the most work that loads of any signs could do between two states [J]."""
        cdef double[::1] scratch = np.empty(self.flat.n_all)
        return load_reach(&self.flat, &q0[0], &q1[0], first(amplitudes), &scratch[0])

    def force(self, const double[::1] q):
        """Return the elastic force ``Q(q)``, shape (n_all,) [N, N m]."""
        out = np.zeros(self.flat.n_all)
        cdef double[::1] view = out
        add(&self.flat, FORCE, &q[0], &q[0], &view[0])
        return out

    def inertia(self, const double[::1] a):
        """Return ``M a`` over all coordinates, shape (n_all,) [N, N m]."""
        out = np.empty(self.flat.n_all)
        cdef double[::1] view = out
        inertia(&self.flat, &a[0], &view[0])
        return out

    def damping(self, const double[::1] q, const double[::1] v):
        """Return the force of damping, shape (n_all,) [N, N m]."""
        out = np.zeros(self.flat.n_all)
        cdef double[::1] view = out
        add_damping(&self.flat, &q[0], &v[0], &view[0])
        return out

    def strain_energy(self, const double[::1] q):
        """Return the strain energy [J]."""
        return self.flat.elements.strain_energy(self.flat.elements.context, &q[0])


cdef inline const double *first(const double[::1] values) noexcept nogil:
    return &values[0] if values.shape[0] > 0 else NULL


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
