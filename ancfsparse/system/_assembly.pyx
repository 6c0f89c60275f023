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

cdef extern from "parallel.h":
    const int MOST_PARTS "ANCF_MOST_PARTS"
    void in_parts "ancf_in_parts" (
        ptrdiff_t, void (*)(void *, ptrdiff_t) noexcept nogil, void *) noexcept nogil

cdef extern from "simd.h":
    const int LANES "ANCF_LANES"

cdef extern from "vectors.h":
    double vec_dot_parts(ptrdiff_t, const double *, const double *, ptrdiff_t) noexcept nogil
    void vec_scale_parts(
        ptrdiff_t, double *, double, const double *, ptrdiff_t) noexcept nogil
    void vec_sum_parts(
        ptrdiff_t, double *, double, const double *, double, const double *,
        ptrdiff_t) noexcept nogil

cdef extern from "solver_abi.h":
    ctypedef struct ancf_system:
        void *context
        ptrdiff_t n_free, n_all, n_multipliers, n_values, n_amplitudes
        int damped
        void (*residual)(void *, const double *, const double *, const double *, const double *,
                         const double *, const double *, double *, double *) noexcept nogil
        void (*matrix)(void *, double, double, double, const double *, const double *,
                       const double *, const double *, double *) noexcept nogil
        void (*material)(void *, double, double, double, const double *,
                         double *) noexcept nogil
        void (*inertia)(void *, const double *, double *) noexcept nogil
        void (*energies)(void *, const double *, const double *, double *, double *) noexcept nogil
        double (*load_work)(void *, const double *, const double *, const double *, const double *,
                            double *) noexcept nogil
        void (*residual_between)(void *, const double *, const double *, const double *,
                                 const double *, const double *, const double *, const double *,
                                 const double *, double *, double *) noexcept nogil


cdef enum Kernel:
    ENERGY
    FORCE
    INERTIA
    RESIDUAL
    TANGENT
    MASS
    DAMPING
    MATERIAL
    DISCRETE_GRADIENT
    N_KERNELS


KERNELS = ("energy", "force", "inertia", "residual", "tangent", "mass", "damping", "material",
           "discrete_gradient")
# Places of the energies of a block: all in one.
cdef int32_t[16] NOWHERE
memset(NOWHERE, 0, sizeof(NOWHERE))


# Entries of a matrix up to which that of the masses is kept, not made again each time: 2 MB.
cdef ptrdiff_t FEW_VALUES = 250_000


cdef struct Group:
    ptrdiff_t n_blocks, n, n_matrix  # numbers per element in a vector and in the matrix
    const int32_t *gather
    const int32_t *matrix_scatter
    const int32_t *table_of  # NULL if every block has tables of its own
    const int32_t *base
    const int32_t *matrix_base
    const int32_t *set_of
    const double *parameters
    ancf_kernel[N_KERNELS] kernels
    # Damping: viscosities for stiffnesses and damped masses for masses.
    bint strains_damped, masses_damped
    const int32_t *damping_set_of
    const double *damping_parameters


cdef struct Run:
    # Blocks of one group that one thread takes one after another.
    int32_t group, begin, end


cdef struct Flat:
    bint damped  # whether any group is
    ptrdiff_t n_free, n_all, n_multipliers, n_values, n_groups, n_terms, n_loads, n_moments, dim
    Group *groups
    const double *mass_values  # of the matrix; NULL where they would be too many
    # Runs of each part, and then those that share places with several parts.
    ptrdiff_t n_parts
    const int32_t *run_start
    const Run *runs
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


cdef struct Call:
    # What the threads work on together: kernels to add to `out`, or a range of numbers.
    const Flat *flat
    Kernel kernel
    bint damped  # with the parameters of damping
    ptrdiff_t n
    const double *q
    const double *a
    double *out


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
    cdef object runs, mass_values
    cdef tuple owners
    cdef readonly object groups
    cdef readonly object capsule

    def __cinit__(self, ptrdiff_t n_free, ptrdiff_t n_all, ptrdiff_t n_values,
                  ptrdiff_t n_amplitudes, groups, constraints, loads, moments):
        cdef Flat *flat = &self.flat
        cdef Group *group
        # The structures below point into these arrays.
        self.groups, self.owners = groups, (constraints, loads, moments)
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
            layout = arrays["layout"]
            group.n_blocks, group.n = len(layout.set_of), layout.gather.shape[1]
            group.n_matrix = layout.scatter.shape[1]
            group.gather = integers(layout.gather)
            group.matrix_scatter = integers(layout.scatter)
            group.table_of = integers(layout.table_of)
            group.base = integers(layout.base)
            group.matrix_base = integers(layout.scatter_base)
            group.set_of = integers(layout.set_of)
            group.parameters = reals(layout.parameters)
            for number, name in enumerate(KERNELS):
                group.kernels[number] = pointer(arrays["kernels"][name])
            group.strains_damped = arrays["strains_damped"]
            group.masses_damped = arrays["masses_damped"]
            if group.strains_damped or group.masses_damped:
                group.damping_set_of = integers(arrays["damping_set_of"])
                group.damping_parameters = reals(arrays["damping_parameters"])
                flat.damped = True
        self.divide([0, len(groups), len(groups)],
                    [(k, 0, len(arrays["layout"].set_of)) for k, arrays in enumerate(groups)])

        if n_values <= FEW_VALUES:
            self.mass_values = self.mass
            flat.mass_values = reals(self.mass_values)
        self.interface.context = flat
        self.interface.n_free, self.interface.n_all = n_free, n_all
        self.interface.n_multipliers = flat.n_multipliers
        self.interface.n_values = n_values
        self.interface.n_amplitudes = n_amplitudes
        self.interface.damped = flat.damped
        self.interface.residual, self.interface.matrix = residual, matrix
        self.interface.material = material
        self.interface.inertia, self.interface.energies = inertia, energies
        self.interface.load_work, self.interface.residual_between = load_work, residual_between
        self.capsule = PyCapsule_New(&self.interface, "ancf_system", NULL)

    def __dealloc__(self):
        free(self.flat.groups)

    def divide(self, run_start, runs):
        """Share the work among threads.

        Parameters
        ----------
        run_start : (n_parts + 2,) int
            Where the runs of each part start, those that come after all parts, and the end.
        runs : (n_runs, 3) int
            Group, first block and end of each run.  Runs of different parts have no place in common.
        """
        self.runs = [np.array(run_start, dtype=np.int32),
                     np.array(runs, dtype=np.int32).reshape(-1, 3)]
        self.flat.n_parts = len(run_start) - 2
        self.flat.run_start = integers(self.runs[0])
        self.flat.runs = <const Run *>integers(self.runs[1])

    @property
    def threads(self):
        """Number of threads that work on the elements."""
        return self.flat.n_parts

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
               const double[::1] v=None):
        """Return the values ``(n_values,)`` of the matrix on the pattern."""
        values = np.empty(self.flat.n_values + 1)
        cdef double[::1] view = values
        matrix(&self.flat, mass_factor, stiffness_factor, damping_factor, &q[0],
               NULL if v is None else &v[0], first(lam), first(amplitudes), &view[0])
        return values[: self.flat.n_values]

    def material(self, double mass_factor, double stiffness_factor, const double[::1] q, *,
                 double damping_factor=0.0):
        """Return the matrix ``(n_values,)`` with the material part of the stiffness alone."""
        values = np.empty(self.flat.n_values + 1)
        cdef double[::1] view = values
        material(&self.flat, mass_factor, stiffness_factor, damping_factor, &q[0], &view[0])
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
        return strain_energy(&self.flat, &q[0])


cdef ancf_kernel pointer(capsule) except NULL:
    return <ancf_kernel>PyCapsule_GetPointer(capsule, ANCF_KERNEL_SIGNATURE)


cdef inline const double *first(const double[::1] values) noexcept nogil:
    return &values[0] if values.shape[0] > 0 else NULL


cdef void add_run(const Flat *self, const Run *run, Kernel kernel, bint damped, const double *q,
                  const double *a, double *out) noexcept nogil:
    """Let a kernel add what the elements of a run give, with the parameters of damping if wished."""
    cdef const Group *group = &self.groups[run.group]
    cdef ancf_kernel call = group.kernels[<int>kernel]
    cdef bint to_matrix = kernel == TANGENT or kernel == MASS or kernel == MATERIAL
    cdef bint to_masses = kernel == INERTIA or kernel == MASS
    cdef const int32_t *set_of = group.damping_set_of if damped else group.set_of
    cdef const double *parameters = group.damping_parameters if damped else group.parameters
    cdef ptrdiff_t n_in = group.n * LANES, n_out = n_in, b, table
    cdef const int32_t *scatter = group.gather
    cdef const int32_t *base = group.base
    if damped and not (group.masses_damped if to_masses else group.strains_damped):
        return
    if to_matrix:
        scatter, base, n_out = group.matrix_scatter, group.matrix_base, group.n_matrix * LANES
    if kernel == ENERGY:
        scatter, n_out = &NOWHERE[0], 0
    if group.table_of == NULL and kernel != ENERGY:
        call(run.end - run.begin, group.gather + run.begin * n_in, scatter + run.begin * n_out,
             set_of + run.begin, parameters, q, a, out)
        return
    for b in range(run.begin, run.end):
        table = b if group.table_of == NULL else group.table_of[b]
        call(1, group.gather + table * n_in,
             scatter + table * n_out, set_of + b, parameters,
             q if group.table_of == NULL else q + group.base[b],
             a if group.table_of == NULL else a + group.base[b],
             out if group.table_of == NULL or kernel == ENERGY else out + base[b])


cdef void add_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef const Call *call = <const Call *>context
    cdef const Flat *flat = call.flat
    cdef ptrdiff_t k
    for k in range(flat.run_start[part], flat.run_start[part + 1]):
        add_run(flat, &flat.runs[k], call.kernel, call.damped, call.q, call.a, call.out)


cdef void add(const Flat *self, Kernel kernel, const double *q, const double *a, double *out,
              bint damped=False) noexcept nogil:
    """Add what all elements give; runs that share places with several parts come last."""
    cdef Call call
    call.flat, call.kernel, call.q, call.a, call.out = self, kernel, q, a, out
    call.damped = damped
    in_parts(self.n_parts, add_part, &call)
    add_part(&call, self.n_parts)


cdef void add_damping(const Flat *self, const double *q, const double *v,
                      double *out) noexcept nogil:
    add(self, DAMPING, q, v, out, True)
    add(self, INERTIA, v, v, out, True)


cdef void inertia(void *context, const double *a, double *out) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    clear(self, self.n_all, out)
    add(self, INERTIA, a, a, out)


cdef void energy_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef const Call *call = <const Call *>context
    cdef double energy = 0.0
    cdef ptrdiff_t k
    for k in range(call.flat.run_start[part], call.flat.run_start[part + 1]):
        add_run(call.flat, &call.flat.runs[k], ENERGY, False, call.q, call.q, &energy)
    call.out[part] = energy


cdef double strain_energy(const Flat *self, const double *q) noexcept nogil:
    cdef double[MOST_PARTS + 1] of_part
    cdef double energy = 0.0
    cdef ptrdiff_t part
    cdef Call call
    call.flat, call.q, call.out = self, q, &of_part[0]
    in_parts(self.n_parts, energy_part, &call)
    energy_part(&call, self.n_parts)
    for part in range(self.n_parts + 1):
        energy += of_part[part]
    return energy


cdef void clear_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef const Call *call = <const Call *>context
    cdef ptrdiff_t begin = call.n * part // call.flat.n_parts
    cdef ptrdiff_t end = call.n * (part + 1) // call.flat.n_parts
    memset(call.out + begin, 0, (end - begin) * sizeof(double))


cdef void clear(const Flat *self, ptrdiff_t n, double *out) noexcept nogil:
    cdef Call call
    call.flat, call.n, call.out = self, n, out
    in_parts(self.n_parts, clear_part, &call)


cdef void residual(void *context, const double *q, const double *v, const double *a,
                   const double *lam, const double *dead_load, const double *amplitudes, double *r,
                   double *phi) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    vec_scale_parts(self.n_parts, r, -1.0, dead_load, self.n_all)
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
    vec_scale_parts(self.n_parts, r, -1.0, dead_load, self.n_all)
    add(self, DISCRETE_GRADIENT, q0, q1, r)
    add(self, INERTIA, a, a, r)
    add_the_rest(self, q, v, lam, amplitudes, r)
    set_constraints(self, q1, phi)


cdef void add_the_rest(const Flat *self, const double *q, const double *v, const double *lam,
                       const double *amplitudes, double *r) noexcept nogil:
    """Forces of damping, of loads that change and of constraints."""
    cdef ptrdiff_t k, i, j
    cdef double c
    if self.damped:
        add_damping(self, q, v, r)
    for k in range(self.n_loads):
        r[self.load_place[k]] -= self.load_weight[k] * amplitudes[self.load_column[k]]
    if self.n_moments > 0:
        add_moments(self, q, amplitudes, r)
    for k in range(self.n_terms):
        i, j, c = self.term_i[k], self.term_j[k], self.coefficient[k]
        if j < 0:
            r[i] += c * lam[self.term_row[k]]
        else:
            r[i] += c * q[j] * lam[self.term_row[k]]
            r[j] += c * q[i] * lam[self.term_row[k]]


cdef void set_constraints(const Flat *self, const double *q, double *phi) noexcept nogil:
    cdef ptrdiff_t k, i, j
    for k in range(self.n_multipliers):
        phi[k] = self.offset[k]
    for k in range(self.n_terms):
        i, j = self.term_i[k], self.term_j[k]
        phi[self.term_row[k]] += self.coefficient[k] * (q[i] if j < 0 else q[i] * q[j])


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
        if self.n_moments > 0:
            add_moment_stiffness(self, q, amplitudes, values)
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
    if self.damped and factor != 0.0:
        add(self, MATERIAL, q, q, values, True)
        add(self, MASS, q, q, values, True)
        vec_scale_parts(self.n_parts, values, factor, values, n)


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
        vec_sum_parts(self.n_parts, values, unit, values, mass_factor,
                      self.mass_values, self.n_values)
    elif mass_factor == 0.0:
        vec_scale_parts(self.n_parts, values, unit, values, n)
    else:
        vec_scale_parts(self.n_parts, values, unit / mass_factor, values, n)
        add(self, MASS, q, q, values)
        if mass_factor != 1.0:
            vec_scale_parts(self.n_parts, values, mass_factor, values, n)


cdef void add_constraint_rows(const Flat *self, const double *q, double *values) noexcept nogil:
    """Add phi_q and the small negative diagonal below it."""
    cdef ptrdiff_t k, i, j
    cdef double c
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
    inertia(context, v, scratch)
    out[0] = 0.5 * vec_dot_parts(self.n_parts, v, scratch, self.n_all)
    out[1] = strain_energy(self, q)


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
