"""Pointers to arrays that their owner keeps alive; an include file."""


cdef flattened(array):
    # A copy would be freed before its pointer is used.
    if not array.flags.c_contiguous:
        raise ValueError("arrays of the assembly must be contiguous")
    return array.reshape(-1)


cdef const int32_t *integers(array) except? NULL:
    cdef const int32_t[::1] view = flattened(array)
    return &view[0] if view.shape[0] > 0 else NULL


cdef const double *reals(array) except? NULL:
    cdef const double[::1] view = flattened(array)
    return &view[0] if view.shape[0] > 0 else NULL
