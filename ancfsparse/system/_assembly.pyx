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

cdef extern from "solver_abi.h":
    ctypedef struct ancf_system:
        void *context
        ptrdiff_t n_free, n_all, n_multipliers, n_values
        void (*residual)(void *, const double *, const double *, const double *, const double *,
                         const double *, double *, double *) noexcept nogil
        void (*matrix)(void *, double, double, const double *, const double *, const double *,
                       double *) noexcept nogil


cdef struct Group:
    ptrdiff_t n_blocks
    const int32_t *gather
    const int32_t *matrix_scatter
    const int32_t *energy_scatter
    const int32_t *set_of
    const double *parameters
    ancf_kernel energy, force, inertia, residual, tangent, mass


cdef class Assembly:
    """Evaluate a system given as flat arrays.

    Parameters
    ----------
    n_free, n_all, n_values : int
        Free and all coordinates; stored entries of the lower triangle of the matrix.
    groups : sequence
        Per kind of element a mapping of its arrays (`kernels.layout`) and kernel capsules.
    constraints, loads, moments : mapping
        Arrays as built by `system.constraints` and `system.loads`.
    """

    cdef ancf_system interface
    cdef Group *groups
    cdef ptrdiff_t n_groups
    cdef list owners
    # Constraints: one entry per term.
    cdef ptrdiff_t n_terms
    cdef int32_t[::1] term_row, term_i, term_j, slot_i, slot_j, slot_ij
    cdef double[::1] term_coefficient, offset
    cdef int32_t[::1] regularized
    cdef double regularization
    # Loads that change with time: force[place] += weight * amplitude[column].
    cdef int32_t[::1] load_place, load_column
    cdef double[::1] load_weight
    # Moments about fixed axes on slopes: force = m x r' / |r'|^2.
    cdef int32_t[:, ::1] moment_place, moment_slot, moment_column
    cdef double[::1] mass_values
    cdef readonly object capsule

    def __cinit__(self, ptrdiff_t n_free, ptrdiff_t n_all, ptrdiff_t n_values, groups,
                  constraints, loads, moments):
        cdef Group *group
        cdef const int32_t[:, :, ::1] gather, matrix_scatter, energy_scatter
        cdef const int32_t[::1] set_of
        cdef const double[:, :, ::1] parameters
        self.n_groups = len(groups)
        self.groups = <Group *>calloc(max(self.n_groups, 1), sizeof(Group))
        if self.groups == NULL:
            raise MemoryError
        self.owners = []
        for index, arrays in enumerate(groups):
            group = &self.groups[index]
            gather, matrix_scatter = arrays["gather"], arrays["matrix_scatter"]
            energy_scatter = arrays["energy_scatter"]
            set_of, parameters = arrays["set_of"], arrays["parameters"]
            kernels = arrays["kernels"]
            self.owners.append((arrays, kernels))
            group.n_blocks = gather.shape[0]
            group.gather = &gather[0, 0, 0]
            group.matrix_scatter = &matrix_scatter[0, 0, 0]
            group.energy_scatter = &energy_scatter[0, 0, 0]
            group.set_of = &set_of[0]
            group.parameters = &parameters[0, 0, 0]
            group.energy = pointer(kernels["energy"])
            group.force = pointer(kernels["force"])
            group.inertia = pointer(kernels["inertia"])
            group.residual = pointer(kernels["residual"])
            group.tangent = pointer(kernels["tangent"])
            group.mass = pointer(kernels["mass"])

        self.term_row, self.term_i, self.term_j = (constraints[k] for k in ("row", "i", "j"))
        self.slot_i, self.slot_j = constraints["slot_i"], constraints["slot_j"]
        self.slot_ij = constraints["slot_ij"]
        self.term_coefficient, self.offset = constraints["coefficient"], constraints["offset"]
        self.regularized = constraints["diagonal"]
        self.regularization = 0.0
        self.n_terms = self.term_row.shape[0]
        self.load_place, self.load_column = loads["place"], loads["column"]
        self.load_weight = loads["weight"]
        self.moment_place, self.moment_slot = moments["place"], moments["slot"]
        self.moment_column = moments["column"]

        self.interface.context = <void *>self
        self.interface.n_free, self.interface.n_all = n_free, n_all
        self.interface.n_multipliers = self.offset.shape[0]
        self.interface.n_values = n_values
        self.interface.residual = residual
        self.interface.matrix = matrix
        self.capsule = PyCapsule_New(&self.interface, "ancf_system", NULL)

        # One more place than values: kernels throw the entries of fixed coordinates into it.
        self.mass_values = np.zeros(n_values + 1)
        for index in range(self.n_groups):
            group = &self.groups[index]
            group.mass(group.n_blocks, group.gather, group.matrix_scatter, group.set_of,
                       group.parameters, NULL, NULL, &self.mass_values[0])
        self.mass_values[n_values] = 0.0

    def __dealloc__(self):
        free(self.groups)

    def set_regularization(self, double value):
        """Set epsilon of the constraint block, in the units of the scaled matrix [1/kg]."""
        self.regularization = value

    @property
    def mass(self):
        """Values of the mass matrix on the pattern, lower triangle [kg, kg m, kg m^2]."""
        return np.asarray(self.mass_values)[:-1].copy()

    def residual(self, const double[::1] q, const double[::1] a, const double[::1] lam,
                 const double[::1] dead_load, const double[::1] amplitudes):
        """Return ``r (n_all,)`` [N, N m] and ``phi (m,)`` [m]."""
        r, phi = np.empty(self.interface.n_all), np.empty(self.offset.shape[0])
        cdef double[::1] r_view = r, phi_view = phi
        residual(<void *>self, &q[0], &a[0], first(lam), &dead_load[0], first(amplitudes),
                 &r_view[0], first(phi_view))
        return r, phi

    def matrix(self, double mass_factor, double stiffness_factor, const double[::1] q,
               const double[::1] lam, const double[::1] amplitudes):
        """Return the values ``(n_values,)`` of the matrix on the pattern."""
        values = np.empty(self.interface.n_values + 1)
        cdef double[::1] view = values
        matrix(<void *>self, mass_factor, stiffness_factor, &q[0], first(lam), first(amplitudes),
               &view[0])
        return values[:-1]

    def force(self, const double[::1] q):
        """Return the elastic force ``Q(q)``, shape (n_all,) [N, N m]."""
        out = np.zeros(self.interface.n_all)
        cdef double[::1] view = out
        cdef Group *group
        cdef ptrdiff_t index
        for index in range(self.n_groups):
            group = &self.groups[index]
            group.force(group.n_blocks, group.gather, group.gather, group.set_of,
                        group.parameters, &q[0], NULL, &view[0])
        return out

    def inertia(self, const double[::1] a):
        """Return ``M a`` over all coordinates, shape (n_all,) [N, N m]."""
        out = np.zeros(self.interface.n_all)
        cdef double[::1] view = out
        cdef Group *group
        cdef ptrdiff_t index
        for index in range(self.n_groups):
            group = &self.groups[index]
            group.inertia(group.n_blocks, group.gather, group.gather, group.set_of,
                          group.parameters, NULL, &a[0], &view[0])
        return out

    def strain_energy(self, const double[::1] q):
        """Return the strain energy [J]."""
        cdef double energy = 0.0
        cdef Group *group
        cdef ptrdiff_t index
        for index in range(self.n_groups):
            group = &self.groups[index]
            group.energy(group.n_blocks, group.gather, group.energy_scatter, group.set_of,
                         group.parameters, &q[0], NULL, &energy)
        return energy


cdef ancf_kernel pointer(capsule) except NULL:
    return <ancf_kernel>PyCapsule_GetPointer(capsule, ANCF_KERNEL_SIGNATURE)


cdef inline const double *first(const double[::1] values) noexcept nogil:
    return &values[0] if values.shape[0] > 0 else NULL


cdef void residual(void *context, const double *q, const double *a, const double *lam,
                   const double *dead_load, const double *amplitudes, double *r,
                   double *phi) noexcept nogil:
    cdef Assembly self = <Assembly>context
    cdef ptrdiff_t k, i, j
    cdef Group *group
    cdef double c
    for k in range(self.interface.n_all):
        r[k] = -dead_load[k]
    for k in range(self.n_groups):
        group = &self.groups[k]
        group.residual(group.n_blocks, group.gather, group.gather, group.set_of, group.parameters,
                       q, a, r)
    for k in range(self.load_place.shape[0]):
        r[self.load_place[k]] -= self.load_weight[k] * amplitudes[self.load_column[k]]
    if self.moment_place.shape[0] > 0:
        add_moments(self, q, amplitudes, r)
    for k in range(self.offset.shape[0]):
        phi[k] = self.offset[k]
    for k in range(self.n_terms):
        i, j, c = self.term_i[k], self.term_j[k], self.term_coefficient[k]
        if j < 0:
            phi[self.term_row[k]] += c * q[i]
            r[i] += c * lam[self.term_row[k]]
        else:
            phi[self.term_row[k]] += c * q[i] * q[j]
            r[i] += c * q[j] * lam[self.term_row[k]]
            r[j] += c * q[i] * lam[self.term_row[k]]


cdef void matrix(void *context, double mass_factor, double stiffness_factor, const double *q,
                 const double *lam, const double *amplitudes, double *values) noexcept nogil:
    cdef Assembly self = <Assembly>context
    cdef ptrdiff_t k, i, j, n = self.interface.n_values
    cdef Group *group
    cdef double c
    if stiffness_factor == 0.0:
        for k in range(n):
            values[k] = mass_factor * self.mass_values[k]
    else:
        memset(values, 0, (n + 1) * sizeof(double))
        for k in range(self.n_groups):
            group = &self.groups[k]
            group.tangent(group.n_blocks, group.gather, group.matrix_scatter, group.set_of,
                          group.parameters, q, NULL, values)
        if self.moment_place.shape[0] > 0:
            add_moment_stiffness(self, q, amplitudes, values)
        for k in range(self.n_terms):
            if self.term_j[k] >= 0:
                c = self.term_coefficient[k] * lam[self.term_row[k]]
                values[self.slot_ij[k]] += 2.0 * c if self.term_i[k] == self.term_j[k] else c
        for k in range(n):
            values[k] = mass_factor * self.mass_values[k] + stiffness_factor * values[k]
    for k in range(self.n_terms):
        i, j, c = self.term_i[k], self.term_j[k], self.term_coefficient[k]
        if j < 0:
            values[self.slot_i[k]] += c
        else:
            values[self.slot_i[k]] += c * q[j]
            values[self.slot_j[k]] += c * q[i]
    for k in range(self.regularized.shape[0]):
        values[self.regularized[k]] -= self.regularization


cdef inline void slope_and_moment(Assembly self, ptrdiff_t k, const double *q,
                                  const double *amplitudes, double *x, double *m) noexcept nogil:
    cdef ptrdiff_t d, dim = self.moment_place.shape[1]
    x[2] = m[0] = m[1] = 0.0
    for d in range(dim):
        x[d] = q[self.moment_place[k, d]]
    if dim == 2:
        m[2] = amplitudes[self.moment_column[k, 0]]
    else:
        for d in range(3):
            m[d] = amplitudes[self.moment_column[k, d]]


cdef void add_moments(Assembly self, const double *q, const double *amplitudes,
                      double *r) noexcept nogil:
    cdef double x[3]
    cdef double m[3]
    cdef double p
    cdef ptrdiff_t k
    for k in range(self.moment_place.shape[0]):
        slope_and_moment(self, k, q, amplitudes, x, m)
        p = x[0] * x[0] + x[1] * x[1] + x[2] * x[2]
        r[self.moment_place[k, 0]] -= (m[1] * x[2] - m[2] * x[1]) / p
        r[self.moment_place[k, 1]] -= (m[2] * x[0] - m[0] * x[2]) / p
        if self.moment_place.shape[1] == 3:
            r[self.moment_place[k, 2]] -= (m[0] * x[1] - m[1] * x[0]) / p


cdef void add_moment_stiffness(Assembly self, const double *q, const double *amplitudes,
                               double *values) noexcept nogil:
    # The force m x r' / |r'|^2 of a moment about a fixed axis has an unsymmetric derivative in
    # space; its skew part is dropped, as the factor is symmetric.  In the plane nothing is dropped.
    cdef double x[3]
    cdef double m[3]
    cdef double f[3]
    cdef double p
    cdef ptrdiff_t k, i, j
    for k in range(self.moment_place.shape[0]):
        slope_and_moment(self, k, q, amplitudes, x, m)
        p = x[0] * x[0] + x[1] * x[1] + x[2] * x[2]
        f[0] = m[1] * x[2] - m[2] * x[1]
        f[1] = m[2] * x[0] - m[0] * x[2]
        f[2] = m[0] * x[1] - m[1] * x[0]
        for i in range(self.moment_place.shape[1]):
            for j in range(i + 1):
                values[self.moment_slot[k, i * (i + 1) // 2 + j]] += (
                    (f[i] * x[j] + f[j] * x[i]) / (p * p))
