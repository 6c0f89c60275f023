"""The base of compiled inverses; an include file."""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New

import numpy as np

include "../../abi/solver_abi.pxi"


cdef class CompiledInverse:
    """An inverse, which keeps the arguments that its structure points to."""

    cdef ancf_inverse interface
    cdef tuple owners
    cdef readonly object capsule

    def __cinit__(self, *arguments):
        self.owners = arguments
        self.capsule = PyCapsule_New(&self.interface, "ancf_inverse", NULL)

    def apply(self, const double[::1] r):
        """Return ``H r``."""
        z = np.empty(self.interface.n)
        cdef double[::1] view = z
        self.interface.apply(self.interface.context, &r[0], &view[0])
        return z

    def learn(self, const double[::1] s, const double[::1] y, const double[::1] r_new):
        """Update with the pair; return ``(H_new r_new, accepted)``.  ``s`` must be ``-H r_old``."""
        z = np.empty(self.interface.n)
        cdef double[::1] view = z
        return z, bool(self.interface.learn(
            self.interface.context, &s[0], &y[0], &r_new[0], &view[0]))
