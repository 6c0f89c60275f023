"""Passes over all groups of points in parts, each on its own thread; included by `_contacts.pyx`."""


cdef struct Call


ctypedef void (*group_work)(Data *, ptrdiff_t, ptrdiff_t, const Call *, ptrdiff_t) noexcept nogil


cdef struct Call:  # arguments of a pass
    Data *data
    group_work work  # on the groups from one number to another, in a part
    const ancf_state *x
    const double *q0
    const double *q1
    double *out
    int matrix  # which part of the matrix


cdef void do_part(void *context, ptrdiff_t part) noexcept nogil:
    """Do the work on the groups of a part, each thread with a workspace of its own."""
    cdef const Call *call = <const Call *>context
    cdef Data *data = call.data
    cdef Data own
    cdef ptrdiff_t k
    if 0 < part < data.n_parts:
        own = data[0]
        own.weights += part * own.n_weights
        data = &own
    for k in range(data.run_start[part], data.run_start[part + 1]):
        call.work(data, data.runs[3 * k + 1], data.runs[3 * k + 2], call, part)


cdef void for_all_groups(Call *call) noexcept nogil:
    """Do the work on all groups; those that share coordinates with several parts come last."""
    in_parts(call.data.n_parts, do_part, call)
    do_part(call, call.data.n_parts)
