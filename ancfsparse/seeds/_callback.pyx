# cython: language_level=3
"""A seed written in Python behind the same structure as the compiled ones.

For factors so large that a call through Python does not count.
"""
from cpython.pycapsule cimport PyCapsule_New

import numpy as np


include "../abi/solver_abi.pxi"


cdef class Callback:
    """Hand the compiled loop an object with ``factor(values)`` and ``solve(r)``.

    An exception cannot pass through compiled code: it is kept in ``error`` and every solution from
    then on is not a number, which ends the step.
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
    except BaseException as error:  # nothing passes through C: the march raises it when it is back
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
