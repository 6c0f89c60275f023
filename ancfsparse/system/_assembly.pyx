# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Residual, matrix and energy of a flattened system: clears, lets the elements add, adds the rest.

The rest is what is not an element: loads that follow the motion or the clock, and constraints
phi = sum of terms ``coefficient * (q[i] - about) * (q[j] - about)`` (or ``coefficient * q[i]``)
plus a constant.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.stdint cimport int32_t

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


include "sums.pxi"
