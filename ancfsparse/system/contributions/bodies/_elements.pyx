# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The elements of a system: kernel calls by groups and threads."""
from cpython.pycapsule cimport PyCapsule_GetPointer
from libc.math cimport fabs
from libc.stdlib cimport calloc, free
from libc.string cimport memset

include "../../../abi/vectors.pxi"
include "../contribution.pxi"

cdef extern from "kernel_abi.h":
    const char *ANCF_KERNEL_SIGNATURE
    ctypedef void (*ancf_kernel)(
        ptrdiff_t, const int32_t *, const int32_t *, const int32_t *,
        const double *, const double *, const double *, double *) noexcept nogil

cdef extern from "simd.h":
    const int LANES "ANCF_LANES"

include "../../../kernels/kernel_list.pxi"


# Scatter indices for the energies of a block: all lanes add to one number.
cdef int32_t[16] NOWHERE
memset(NOWHERE, 0, sizeof(NOWHERE))


cdef struct Group:
    ptrdiff_t n_blocks, n, n_matrix  # numbers per element in a vector and in the matrix
    const int32_t *gather
    const int32_t *matrix_scatter
    const int32_t *table_of  # NULL if every block has its own tables
    const int32_t *base
    const int32_t *matrix_base
    const int32_t *set_of
    const double *parameters
    ancf_kernel[N_KERNELS] kernels
    # Damping: viscosities in place of stiffnesses, and damped masses in place of masses.
    bint strains_damped, masses_damped
    const int32_t *damping_set_of
    const double *damping_parameters
    # Parameters that change with time: parameters[place] = value + amplitude[column].
    ptrdiff_t n_tuned
    const int32_t *tuned_place
    const int32_t *tuned_column
    const double *tuned_value
    double *tuned


cdef struct Run:
    # Consecutive blocks of one group, processed by one thread.
    int32_t group, begin, end


cdef struct Flat:
    ptrdiff_t n_groups, n_all
    bint tunes  # whether parameters of any group change with time
    bint damped  # whether any group is
    Group *groups
    # Runs of each part, then those that share coordinates with several parts.
    ptrdiff_t n_parts
    const int32_t *run_start
    const Run *runs


cdef struct Call:
    # Arguments of a parallel call of a kernel that adds to `out`.
    const Flat *flat
    int kernel
    bint damped  # with the parameters of damping
    const double *q
    const double *a
    double *out


cdef class Elements(CompiledContribution):
    """Evaluate the elements of a system.

    Parameters
    ----------
    groups : sequence of mappings
        Per beam the arrays of `kernels.layout` and the kernel capsules; ``tuned`` is None, or
        places of parameters that change with time, columns of amplitudes, and values without them.
    n_all : int
        Number of coordinates.
    """

    cdef Flat flat
    cdef object runs
    cdef readonly object groups

    def __cinit__(self, groups, ptrdiff_t n_all):
        cdef Flat *flat = &self.flat
        cdef Group *group
        cdef double[::1] tuned
        self.groups = groups
        flat.n_groups, flat.n_all = len(groups), n_all
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
            if arrays["tuned"] is not None:
                place, column, value = arrays["tuned"]
                group.n_tuned, group.tuned_value = len(place), reals(value)
                group.tuned_place, group.tuned_column = integers(place), integers(column)
                tuned = layout.parameters.reshape(-1)
                group.tuned = &tuned[0]
                flat.tunes = True
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
        self.interface.context, self.interface.damped = flat, flat.damped
        self.interface.residual, self.interface.between = residual, between
        self.interface.matrix, self.interface.inertia = matrix, inertia
        self.interface.energy = energy
        if flat.tunes:
            self.interface.tune, self.interface.work = tune, work
            self.interface.reach = reach
        self.interface.damping = add_damping

    def __dealloc__(self):
        free(self.flat.groups)

    def divide(self, run_start, runs):
        """Distribute the work among threads.

        Parameters
        ----------
        run_start : (n_parts + 2,) int
            First run of each part, of those that follow all parts, and the end.
        runs : (n_runs, 3) int
            Group, first block and end of each run.  Runs of different parts share no coordinates.
        """
        self.runs = [np.array(run_start, dtype=np.int32),
                     np.array(runs, dtype=np.int32).reshape(-1, 3)]
        self.flat.n_parts = len(run_start) - 2
        self.flat.run_start = integers(self.runs[0])
        self.flat.runs = <const Run *>integers(self.runs[1])


cdef ancf_kernel pointer(capsule) except NULL:
    return <ancf_kernel>PyCapsule_GetPointer(capsule, ANCF_KERNEL_SIGNATURE)


cdef void add_run(const Flat *self, const Run *run, int kernel, bint damped, const double *q,
                  const double *a, double *out) noexcept nogil:
    """Call a kernel for the elements of a run, with damping parameters if requested."""
    cdef const Group *group = &self.groups[run.group]
    cdef ancf_kernel call = group.kernels[kernel]
    cdef bint to_matrix = fills_matrix(kernel), to_masses = is_of_mass(kernel)
    cdef const int32_t *set_of = group.damping_set_of if damped else group.set_of
    cdef const double *parameters = group.damping_parameters if damped else group.parameters
    cdef ptrdiff_t n_in = group.n * LANES, n_out = n_in, b, table
    cdef const int32_t *scatter = group.gather
    cdef const int32_t *base = group.base
    if damped and not (group.masses_damped if to_masses else group.strains_damped):
        return
    if to_matrix:
        scatter, base, n_out = group.matrix_scatter, group.matrix_base, group.n_matrix * LANES
    if kernel == KERNEL_ENERGY:
        scatter, n_out = &NOWHERE[0], 0
    if group.table_of == NULL and kernel != KERNEL_ENERGY:
        call(run.end - run.begin, group.gather + run.begin * n_in, scatter + run.begin * n_out,
             set_of + run.begin, parameters, q, a, out)
        return
    for b in range(run.begin, run.end):
        table = b if group.table_of == NULL else group.table_of[b]
        call(1, group.gather + table * n_in,
             scatter + table * n_out, set_of + b, parameters,
             q if group.table_of == NULL else q + group.base[b],
             a if group.table_of == NULL else a + group.base[b],
             out if group.table_of == NULL or kernel == KERNEL_ENERGY else out + base[b])


cdef void add_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef const Call *call = <const Call *>context
    cdef const Flat *flat = call.flat
    cdef ptrdiff_t k
    for k in range(flat.run_start[part], flat.run_start[part + 1]):
        add_run(flat, &flat.runs[k], call.kernel, call.damped, call.q, call.a, call.out)


cdef void add(const Flat *self, int kernel, const double *q, const double *a, double *out,
              bint damped=False) noexcept nogil:
    """Call a kernel for all elements; runs that share coordinates with several parts come last."""
    cdef Call call
    call.flat, call.kernel, call.q, call.a, call.out = self, kernel, q, a, out
    call.damped = damped
    in_parts(self.n_parts, add_part, &call)
    add_part(&call, self.n_parts)


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    if x.a == NULL:
        add(self, KERNEL_FORCE, x.q, x.q, r)
    else:
        add(self, KERNEL_RESIDUAL, x.q, x.a, r)
    if self.damped:
        add_damping(context, x.q, x.v, r)


cdef void between(void *context, const double *q0, const double *q1, const ancf_state *x,
                  double *r, double *phi) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    add(self, KERNEL_DISCRETE_GRADIENT, q0, q1, r)
    add(self, KERNEL_INERTIA, x.a, x.a, r)
    if self.damped:
        add_damping(context, x.q, x.v, r)


cdef void add_damping(void *context, const double *q, const double *v,
                      double *r) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    add(self, KERNEL_DAMPING, q, v, r, True)
    add(self, KERNEL_INERTIA, v, v, r, True)


cdef void inertia(void *context, const double *a, double *r) noexcept nogil:
    add(<const Flat *>context, KERNEL_INERTIA, a, a, r)


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    if part == STIFFNESS:
        add(self, KERNEL_TANGENT, x.q, x.q, values)
    elif part == MATERIAL:
        add(self, KERNEL_MATERIAL, x.q, x.q, values)
    elif part == MASS:
        add(self, KERNEL_MASS, x.q, x.q, values)
    elif part == DAMPING and self.damped:
        add(self, KERNEL_MATERIAL, x.q, x.q, values, True)
        add(self, KERNEL_MASS, x.q, x.q, values, True)


cdef void energy_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef const Call *call = <const Call *>context
    cdef double sum = 0.0
    cdef ptrdiff_t k
    for k in range(call.flat.run_start[part], call.flat.run_start[part + 1]):
        add_run(call.flat, &call.flat.runs[k], KERNEL_ENERGY, False, call.q, call.q, &sum)
    call.out[part] = sum


cdef double energy(void *context, const double *q) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef double[MOST_PARTS + 1] of_part
    cdef double sum = 0.0
    cdef ptrdiff_t part
    cdef Call call
    call.flat, call.q, call.out = self, q, &of_part[0]
    in_parts(self.n_parts, energy_part, &call)
    energy_part(&call, self.n_parts)
    for part in range(self.n_parts + 1):
        sum += of_part[part]
    return sum


cdef void tune(void *context, const double *amplitudes) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const Group *group
    cdef ptrdiff_t k, i
    for k in range(self.n_groups):
        group = &self.groups[k]
        for i in range(group.n_tuned):
            group.tuned[group.tuned_place[i]] = (
                group.tuned_value[i] + amplitudes[group.tuned_column[i]])


cdef void add_tuned(const Flat *self, int kernel, const double *q, double *out) noexcept nogil:
    """Call a kernel for the elements with time-dependent parameters."""
    cdef Run run
    cdef ptrdiff_t k
    for k in range(self.n_groups):
        if self.groups[k].n_tuned > 0:
            run.group, run.begin, run.end = k, 0, self.groups[k].n_blocks
            add_run(self, &run, kernel, False, q, q, out)


cdef double work(void *context, const ancf_state *x0, const ancf_state *x1,
                 double *scratch) noexcept nogil:
    """Work of time-dependent eigenstrains: increase of the energy, the mean of both states."""
    cdef const Flat *self = <const Flat *>context
    cdef double before = 0.0, after = 0.0
    tune(context, x0.amplitudes)
    add_tuned(self, KERNEL_ENERGY, x0.q, &before)
    add_tuned(self, KERNEL_ENERGY, x1.q, &before)
    tune(context, x1.amplitudes)
    add_tuned(self, KERNEL_ENERGY, x0.q, &after)
    add_tuned(self, KERNEL_ENERGY, x1.q, &after)
    return 0.5 * (after - before)


cdef double reach(void *context, const double *q0, const double *q1, const double *amplitudes,
                  double *scratch) noexcept nogil:
    cdef const Flat *self = <const Flat *>context
    cdef const Group *group
    cdef double sum = 0.0
    cdef ptrdiff_t k, i
    memset(scratch, 0, self.n_all * sizeof(double))
    tune(context, amplitudes)
    add_tuned(self, KERNEL_FORCE, q1, scratch)
    for i in range(self.n_all):
        scratch[i] = -scratch[i]
    for k in range(self.n_groups):
        group = &self.groups[k]
        for i in range(group.n_tuned):
            group.tuned[group.tuned_place[i]] = group.tuned_value[i]
    add_tuned(self, KERNEL_FORCE, q1, scratch)
    for i in range(self.n_all):
        sum += fabs(scratch[i] * (q1[i] - q0[i]))
    return sum
