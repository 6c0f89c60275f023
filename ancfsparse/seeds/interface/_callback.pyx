# cython: language_level=3
"""A seed written in Python with the same interface as the compiled ones.

For factors so large that the cost of a Python call is negligible.
"""
from cpython.pycapsule cimport PyCapsule_New

import numpy as np


include "../../abi/solver_abi.pxi"


cdef class Callback:
    """Adapt an object with ``factor(values)`` and ``solve(r)`` to the compiled loop.

    An exception cannot propagate through compiled code: it is stored in ``error``, and all later
    solutions are NaN, which ends the step.
    """

    cdef ancf_seed interface
    cdef object seed
    cdef ptrdiff_t n_values
    cdef readonly object capsule
    cdef public object error

    def __cinit__(self, seed, ptrdiff_t n, ptrdiff_t n_values):
        self.seed, self.n_values = seed, n_values
        self.interface.context, self.interface.n = <void *>self, n
        self.interface.factor, self.interface.solve = factor, solve
        self.capsule = PyCapsule_New(&self.interface, "ancf_seed", NULL)


cdef ptrdiff_t factor(void *context, const double *values) noexcept with gil:
    cdef Callback self = <Callback>context
    try:
        return self.seed.factor(np.asarray(<double[:self.n_values]>values))
    except BaseException as error:  # cannot propagate through C: the caller of C raises it
        self.error = error
        return 1


cdef void solve(void *context, const double *r, double *x) noexcept with gil:
    cdef Callback self = <Callback>context
    cdef ptrdiff_t n = self.interface.n
    cdef double[:] out = <double[:n]>x
    try:
        if self.error is None:
            np.asarray(out)[:] = self.seed.solve(np.asarray(<double[:n]>r))
            return
    except BaseException as error:
        self.error = error
    out[:] = np.nan
