"""The base of compiled contributions, with pointers to arrays; an include file.

A class derived from it sets in `__cinit__` a structure from its arguments, and in `interface` the
structure's address and those functions of system_abi.h that apply.
"""
from cpython.pycapsule cimport PyCapsule_New
from libc.stdint cimport int32_t

import numpy as np

include "../../abi/system_abi.pxi"
include "../assembly/arrays.pxi"


cdef class CompiledContribution:
    """A contribution, which keeps the arguments that its structure points into."""

    cdef ancf_contribution interface
    cdef list owners
    cdef readonly object capsule

    def __cinit__(self, *arguments):
        self.owners = list(arguments)
        self.capsule = PyCapsule_New(&self.interface, "ancf_contribution", NULL)

    cdef double *copy(self, values) except NULL:
        """Return the address of a copy of numbers, which the contribution may change."""
        cdef double[::1] view = np.array(values, dtype=float).reshape(-1)
        self.owners.append(view)
        return &view[0]
