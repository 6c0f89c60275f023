# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Residual, matrix and energy of a flattened system: clears, calls the element kernels, adds the rest.

The rest is what is not an element: loads that follow the motion or the clock, and constraints
phi = sum of terms ``coefficient * q[i] * q[j]`` (or ``coefficient * q[i]``) plus a constant.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.stdint cimport int32_t
from libc.stdlib cimport calloc, free
from libc.string cimport memset

import numpy as np


cdef extern from "kernel_abi.h":
    const char *ANCF_KERNEL_SIGNATURE
    ctypedef void (*ancf_kernel)(
        ptrdiff_t, const int32_t *, const int32_t *, const int32_t *,
        const double *, const double *, const double *, double *) noexcept nogil

cdef extern from "vectors.h":
    double vec_dot(const double *, const double *, ptrdiff_t) noexcept nogil

cdef extern from "solver_abi.h":
    ctypedef struct ancf_system:
        void *context
        ptrdiff_t n_free, n_all, n_multipliers, n_values, n_amplitudes
        int damped
        void (*residual)(void *, const double *, const double *, const double *, const double *,
                         const double *, const double *, double *, double *) noexcept nogil
        void (*matrix)(void *, double, double, double, const double *, const double *,
                       const double *, const double *, double *) noexcept nogil
        void (*energies)(void *, const double *, const double *, double *, double *) noexcept nogil
        double (*load_work)(void *, const double *, const double *, const double *, const double *,
                            double *) noexcept nogil


cdef struct Group:
    ptrdiff_t n_blocks
    const int32_t *gather
    const int32_t *matrix_scatter
    const int32_t *energy_scatter
    const int32_t *set_of
    const double *parameters
    ancf_kernel energy, force, inertia, residual, tangent, mass


cdef struct Flat:
    ptrdiff_t n_free, n_all, n_multipliers, n_values, n_groups, n_terms, n_loads, n_moments, dim
    Group *groups
    const double *mass_values
    # Constraints: one entry for each term; places in q, and slots in the values of the matrix.
    const int32_t *term_row
    const int32_t *term_i
    const int32_t *term_j
    const int32_t *slot_i
    const int32_t *slot_j
    const int32_t *slot_ij
    const int32_t *slot_diagonal
    const double *coefficient
    const double *offset
    double regularization
    # Loads that change with time: force[place] += weight * amplitude[column].
    const int32_t *load_place
    const int32_t *load_column
    const double *load_weight
    # Moments about fixed axes, see add_moments.
    const int32_t *moment_place  # of r_x, r_y, r_z; -1 where there is none
    const int32_t *moment_slot
    const int32_t *moment_column


cdef flattened(array):
    # A copy would be gone when its pointer is used.
    if not array.flags.c_contiguous:
        raise ValueError("arrays of the assembly must be contiguous")
    return array.reshape(-1)


cdef const int32_t *integers(array) except? NULL:
    cdef const int32_t[::1] view = flattened(array)
    return &view[0] if view.shape[0] > 0 else NULL


cdef const double *reals(array) except? NULL:
    cdef const double[::1] view = flattened(array)
    return &view[0] if view.shape[0] > 0 else NULL


cdef class Assembly:
    """Evaluate a system given as flat arrays.

    Parameters
    ----------
    n_free, n_all, n_values, n_amplitudes : int
        Free and all coordinates; stored entries of the lower triangle of the matrix; amplitudes of
        the loads that change.
    groups : sequence of mappings
        Per beam the arrays of `kernels.layout` and the kernel capsules.
    constraints, loads, moments : mapping
        Contiguous arrays as built by `system.system`.
    """

    cdef ancf_system interface
    cdef Flat flat
    cdef object owners, mass_values
    cdef readonly object capsule

    def __cinit__(self, ptrdiff_t n_free, ptrdiff_t n_all, ptrdiff_t n_values,
                  ptrdiff_t n_amplitudes, groups, constraints, loads, moments):
        cdef Flat *flat = &self.flat
        cdef Group *group
        cdef double[::1] mass
        # The structures below point into these arrays.
        self.owners = (groups, constraints, loads, moments)
        flat.n_free, flat.n_all, flat.n_values = n_free, n_all, n_values
        flat.n_multipliers = len(constraints["offset"])
        flat.n_groups, flat.n_terms = len(groups), len(constraints["row"])
        flat.n_loads, flat.n_moments = len(loads["place"]), len(moments["place"])
        flat.dim = moments["place"].shape[1] // 3
        flat.term_row, flat.term_i = integers(constraints["row"]), integers(constraints["i"])
        flat.term_j, flat.slot_i = integers(constraints["j"]), integers(constraints["slot_i"])
        flat.slot_j = integers(constraints["slot_j"])
        flat.slot_ij = integers(constraints["slot_ij"])
        flat.slot_diagonal = integers(constraints["diagonal"])
        flat.coefficient = reals(constraints["coefficient"])
        flat.offset = reals(constraints["offset"])
        flat.load_place, flat.load_column = integers(loads["place"]), integers(loads["column"])
        flat.load_weight = reals(loads["weight"])
        flat.moment_place, flat.moment_slot = integers(moments["place"]), integers(moments["slot"])
        flat.moment_column = integers(moments["column"])
        flat.groups = <Group *>calloc(max(flat.n_groups, 1), sizeof(Group))
        if flat.groups == NULL:
            raise MemoryError
        for index, arrays in enumerate(groups):
            group = &flat.groups[index]
            group.n_blocks = len(arrays["gather"])
            group.gather = integers(arrays["gather"])
            group.matrix_scatter = integers(arrays["matrix_scatter"])
            group.energy_scatter = integers(arrays["energy_scatter"])
            group.set_of = integers(arrays["set_of"])
            group.parameters = reals(arrays["parameters"])
            kernels = arrays["kernels"]
            group.energy = pointer(kernels["energy"])
            group.force = pointer(kernels["force"])
            group.inertia = pointer(kernels["inertia"])
            group.residual = pointer(kernels["residual"])
            group.tangent = pointer(kernels["tangent"])
            group.mass = pointer(kernels["mass"])

        self.interface.context = flat
        self.interface.n_free, self.interface.n_all = n_free, n_all
        self.interface.n_multipliers = flat.n_multipliers
        self.interface.n_values = n_values
        self.interface.n_amplitudes = n_amplitudes
        self.interface.residual, self.interface.matrix = residual, matrix
        self.interface.energies, self.interface.load_work = energies, load_work
        self.capsule = PyCapsule_New(&self.interface, "ancf_system", NULL)

        # One more place than values: kernels throw the entries of fixed coordinates into it.
        self.mass_values = np.zeros(n_values + 1)
        mass = self.mass_values
        for index in range(flat.n_groups):
            group = &flat.groups[index]
            group.mass(group.n_blocks, group.gather, group.matrix_scatter, group.set_of,
                       group.parameters, NULL, NULL, &mass[0])
        flat.mass_values = &mass[0]

    def __dealloc__(self):
        free(self.flat.groups)

    def set_regularization(self, double value):
        """Set epsilon of the constraint block, in the units of the scaled matrix [1/kg]."""
        self.flat.regularization = value

    @property
    def mass(self):
        """Values of the mass matrix on the pattern, lower triangle [kg, kg m, kg m^2]."""
        return self.mass_values[: self.flat.n_values].copy()

    def residual(self, const double[::1] q, const double[::1] v, const double[::1] a,
                 const double[::1] lam, const double[::1] dead_load, const double[::1] amplitudes):
        """Return ``r (n_all,)`` [N, N m] and ``phi (m,)`` [m]."""
        r, phi = np.empty(self.flat.n_all), np.empty(self.flat.n_multipliers)
        cdef double[::1] r_view = r, phi_view = phi
        residual(&self.flat, &q[0], &v[0], &a[0], first(lam), &dead_load[0], first(amplitudes),
                 &r_view[0], first(phi_view))
        return r, phi

    def matrix(self, double mass_factor, double stiffness_factor, const double[::1] q,
               const double[::1] lam, const double[::1] amplitudes, *, double damping_factor=0.0,
               const double[::1] v=None):
        """Return the values ``(n_values,)`` of the matrix on the pattern."""
        values = np.empty(self.flat.n_values + 1)
        cdef double[::1] view = values
        matrix(&self.flat, mass_factor, stiffness_factor, damping_factor, &q[0],
               NULL if v is None else &v[0], first(lam), first(amplitudes), &view[0])
        return values[: self.flat.n_values]

    def load_work(self, const double[::1] q0, const double[::1] amplitudes0, const double[::1] q1,
                  const double[::1] amplitudes1):
        """Return the work of the changing loads from one state to another [J]."""
        cdef double[::1] scratch = np.empty(self.flat.n_all)
        return load_work(&self.flat, &q0[0], first(amplitudes0), &q1[0], first(amplitudes1),
                         &scratch[0])

    def force(self, const double[::1] q):
        """Return the elastic force ``Q(q)``, shape (n_all,) [N, N m]."""
        out = np.zeros(self.flat.n_all)
        cdef double[::1] view = out
        cdef Group *group
        cdef ptrdiff_t index
        for index in range(self.flat.n_groups):
            group = &self.flat.groups[index]
            group.force(group.n_blocks, group.gather, group.gather, group.set_of,
                        group.parameters, &q[0], NULL, &view[0])
        return out

    def inertia(self, const double[::1] a):
        """Return ``M a`` over all coordinates, shape (n_all,) [N, N m]."""
        out = np.zeros(self.flat.n_all)
        cdef double[::1] view = out
        cdef Group *group
        cdef ptrdiff_t index
        for index in range(self.flat.n_groups):
            group = &self.flat.groups[index]
            group.inertia(group.n_blocks, group.gather, group.gather, group.set_of,
                          group.parameters, NULL, &a[0], &view[0])
        return out

    def strain_energy(self, const double[::1] q):
        """Return the strain energy [J]."""
        cdef double energy = 0.0
        cdef Group *group
        cdef ptrdiff_t index
        for index in range(self.flat.n_groups):
            group = &self.flat.groups[index]
            group.energy(group.n_blocks, group.gather, group.energy_scatter, group.set_of,
                         group.parameters, &q[0], NULL, &energy)
        return energy


cdef ancf_kernel pointer(capsule) except NULL:
    return <ancf_kernel>PyCapsule_GetPointer(capsule, ANCF_KERNEL_SIGNATURE)


cdef inline const double *first(const double[::1] values) noexcept nogil:
    return &values[0] if values.shape[0] > 0 else NULL


cdef void residual(void *context, const double *q, const double *v, const double *a,
                   const double *lam, const double *dead_load, const double *amplitudes, double *r,
                   double *phi) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef ptrdiff_t k, i, j
    cdef Group *group
    cdef ancf_kernel add
    cdef double c
    for k in range(self.n_all):
        r[k] = -dead_load[k]
    for k in range(self.n_groups):
        group = &self.groups[k]
        add = group.force if a == NULL else group.residual
        add(group.n_blocks, group.gather, group.gather, group.set_of, group.parameters, q, a, r)
    for k in range(self.n_loads):
        r[self.load_place[k]] -= self.load_weight[k] * amplitudes[self.load_column[k]]
    if self.n_moments > 0:
        add_moments(self, q, amplitudes, r)
    for k in range(self.n_multipliers):
        phi[k] = self.offset[k]
    for k in range(self.n_terms):
        i, j, c = self.term_i[k], self.term_j[k], self.coefficient[k]
        if j < 0:
            phi[self.term_row[k]] += c * q[i]
            r[i] += c * lam[self.term_row[k]]
        else:
            phi[self.term_row[k]] += c * q[i] * q[j]
            r[i] += c * q[j] * lam[self.term_row[k]]
            r[j] += c * q[i] * lam[self.term_row[k]]


cdef void matrix(void *context, double mass_factor, double stiffness_factor, double damping_factor,
                 const double *q, const double *v, const double *lam, const double *amplitudes,
                 double *values) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef ptrdiff_t k, i, j, n = self.n_values
    cdef Group *group
    cdef double c
    if stiffness_factor == 0.0:
        for k in range(n):
            values[k] = mass_factor * self.mass_values[k]
        values[n] = 0.0
    else:
        memset(values, 0, (n + 1) * sizeof(double))
        for k in range(self.n_groups):
            group = &self.groups[k]
            group.tangent(group.n_blocks, group.gather, group.matrix_scatter, group.set_of,
                          group.parameters, q, NULL, values)
        if self.n_moments > 0:
            add_moment_stiffness(self, q, amplitudes, values)
        for k in range(self.n_terms):
            if self.term_j[k] >= 0:
                c = self.coefficient[k] * lam[self.term_row[k]]
                values[self.slot_ij[k]] += 2.0 * c if self.term_i[k] == self.term_j[k] else c
        for k in range(n):
            values[k] = mass_factor * self.mass_values[k] + stiffness_factor * values[k]
    for k in range(self.n_terms):
        i, j, c = self.term_i[k], self.term_j[k], self.coefficient[k]
        if j < 0:
            values[self.slot_i[k]] += c
        else:
            values[self.slot_i[k]] += c * q[j]
            values[self.slot_j[k]] += c * q[i]
    for k in range(self.n_multipliers):
        values[self.slot_diagonal[k]] -= self.regularization


cdef void energies(void *context, const double *q, const double *v, double *scratch,
                   double *out) noexcept nogil:
    """Kinetic and strain energy."""
    cdef const Flat *self = <const Flat *>context
    cdef ptrdiff_t k
    cdef Group *group
    memset(scratch, 0, self.n_all * sizeof(double))
    out[1] = 0.0
    for k in range(self.n_groups):
        group = &self.groups[k]
        group.inertia(group.n_blocks, group.gather, group.gather, group.set_of, group.parameters,
                      NULL, v, scratch)
        group.energy(group.n_blocks, group.gather, group.energy_scatter, group.set_of,
                     group.parameters, q, NULL, out + 1)
    out[0] = 0.5 * vec_dot(v, scratch, self.n_all)


cdef double load_work(void *context, const double *q0, const double *amplitudes0,
                      const double *q1, const double *amplitudes1, double *scratch) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef ptrdiff_t k, i
    cdef double work = 0.0
    for k in range(self.n_loads):
        i = self.load_place[k]
        work += 0.5 * self.load_weight[k] * (q1[i] - q0[i]) * (
            amplitudes0[self.load_column[k]] + amplitudes1[self.load_column[k]])
    if self.n_moments > 0:
        # Moments are written into the residual with a minus.
        memset(scratch, 0, self.n_all * sizeof(double))
        add_moments(self, q0, amplitudes0, scratch)
        add_moments(self, q1, amplitudes1, scratch)
        for i in range(self.n_all):
            work -= 0.5 * scratch[i] * (q1[i] - q0[i])
    return work


cdef inline void moment_at(const Flat *self, ptrdiff_t k, const double *amplitudes,
                           double *m) noexcept nogil:
    cdef ptrdiff_t d
    m[0] = m[1] = 0.0
    if self.dim == 2:
        m[2] = amplitudes[self.moment_column[k]]
    else:
        for d in range(3):
            m[d] = amplitudes[self.moment_column[3 * k + d]]


cdef inline bint vector_at(const Flat *self, ptrdiff_t k, ptrdiff_t v, const double *q,
                           double *x) noexcept nogil:
    """Read vector v (r_x, r_y, r_z) of the node of moment k; False if it has none."""
    cdef const int32_t *place = self.moment_place + (3 * k + v) * self.dim
    cdef ptrdiff_t d
    if place[0] < 0:
        return False
    x[2] = 0.0
    for d in range(self.dim):
        x[d] = q[place[d]]
    return True


cdef inline void cross(const double *a, const double *b, double *out) noexcept nogil:
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


cdef inline double dot(const double *a, const double *b) noexcept nogil:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


cdef void add_moments(const Flat *self, const double *q, const double *amplitudes,
                      double *r) noexcept nogil:
    """A moment m bends by m x r_x / |r_x|^2 on the slope; the part of it along the axis twists by
    half of itself on each of the two section vectors, if there are any."""
    cdef double x[3]
    cdef double y[3]
    cdef double m[3]
    cdef double f[3]
    cdef double p, along
    cdef const int32_t *place
    cdef ptrdiff_t k, d, v
    for k in range(self.n_moments):
        moment_at(self, k, amplitudes, m)
        place = self.moment_place + 3 * k * self.dim
        vector_at(self, k, 0, q, x)
        p = dot(x, x)
        cross(m, x, f)
        for d in range(self.dim):
            r[place[d]] -= f[d] / p
        for v in range(1, 3):
            if vector_at(self, k, v, q, y):
                along = 0.5 * dot(m, x) / (p * dot(y, y))
                cross(x, y, f)
                for d in range(self.dim):
                    r[place[v * self.dim + d]] -= along * f[d]


cdef void add_moment_stiffness(const Flat *self, const double *q, const double *amplitudes,
                               double *values) noexcept nogil:
    """The symmetric part of the derivative: in space the force of a fixed moment has no potential."""
    cdef double x[3]
    cdef double y[3]
    cdef double m[3]
    cdef double f[3]
    cdef double unit[3]
    cdef double g[3]
    cdef double derivative[9][9]
    cdef double p, s, along
    cdef const int32_t *slot
    cdef ptrdiff_t k, v, i, j, n = 3 * self.dim
    for k in range(self.n_moments):
        for i in range(9):
            for j in range(9):
                derivative[i][j] = 0.0
        moment_at(self, k, amplitudes, m)
        vector_at(self, k, 0, q, x)
        p = dot(x, x)
        cross(m, x, f)
        for i in range(self.dim):
            for j in range(self.dim):
                derivative[i][j] = 2.0 * f[i] * x[j] / (p * p)
        for v in range(1, 3):
            if not vector_at(self, k, v, q, y):
                continue
            s = dot(y, y)
            along = 0.5 * dot(m, x) / (p * s)
            cross(x, y, f)
            for j in range(3):
                unit[0] = unit[1] = unit[2] = 0.0
                unit[j] = 1.0
                cross(unit, y, g)
                for i in range(3):
                    derivative[3 * v + i][3 * v + j] = 2.0 * along * f[i] * y[j] / s
                    derivative[3 * v + i][j] = (
                        -along * g[i] - f[i] * (0.5 * m[j] / (p * s) - 2.0 * along * x[j] / p))
        slot = self.moment_slot + k * (n * (n + 1) // 2)
        for i in range(n):
            for j in range(i + 1):
                values[slot[0]] += 0.5 * (derivative[i][j] + derivative[j][i])
                slot += 1
