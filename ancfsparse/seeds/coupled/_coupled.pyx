# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""A seed whose pattern grows by the blocks of pairs of elements in contact.

Its factor is that of another seed, which Python replaces when the list of pairs has changed.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.math cimport NAN
from libc.stdint cimport int32_t, int64_t
from libc.string cimport memset
from libc.stdlib cimport calloc, free

import numpy as np


include "../../abi/solver_abi.pxi"
include "../../abi/sort.pxi"
include "pattern_growth.pxi"


cdef struct Data:
    const ancf_seed *present
    ptrdiff_t n_couplings
    ancf_coupling **couplings
    ptrdiff_t *changes  # of each list that `present` is for
    bint coupled  # whether there are any pairs
    bint failed  # whether a seed for the present lists is lacking
    ptrdiff_t n_values  # on the pattern without pairs
    ptrdiff_t n_coupled
    const int32_t *slot  # of these in the values of `present`
    const int32_t *slot_of_block  # of the values of all blocks, one list after the other
    double *values


cdef class Coupled:
    """Adapt a seed to matrices with couplings.

    Parameters
    ----------
    renew : callable
        Called without arguments when a list of pairs has changed; it calls `take`.  Its exception is
        stored in ``error``, and all later solutions are NaN.
    seed : capsule "ancf_seed"
        Seed without couplings.
    couplings : sequence of capsules "ancf_coupling"
        Lists of pairs.
    n_values : int
        Number of values on the pattern without pairs.
    """

    cdef ancf_seed interface
    cdef Data data
    cdef object renew, kept
    cdef readonly object capsule
    cdef public object error

    def __cinit__(self, renew, seed, couplings, ptrdiff_t n_values):
        cdef Data *data = &self.data
        cdef ptrdiff_t k
        self.renew, data.n_values = renew, n_values
        data.n_couplings = len(couplings)
        data.couplings = <ancf_coupling **>calloc(data.n_couplings, sizeof(ancf_coupling *))
        data.changes = <ptrdiff_t *>calloc(data.n_couplings, sizeof(ptrdiff_t))
        if data.couplings == NULL or data.changes == NULL:
            raise MemoryError
        for k, capsule in enumerate(couplings):
            data.couplings[k] = <ancf_coupling *>PyCapsule_GetPointer(capsule, "ancf_coupling")
        self.take(seed)
        self.interface.context, self.interface.n = <void *>self, data.present.n
        self.interface.factor, self.interface.solve = factor, solve
        self.interface.round_to_single = round_to_single
        self.capsule = PyCapsule_New(&self.interface, "ancf_seed", NULL)

    def __dealloc__(self):
        free(self.data.couplings)
        free(self.data.changes)

    def take(self, capsule, seed=None, slot=None, slot_of_block=None, ptrdiff_t n_values=0):
        """Take a seed for the present lists of pairs; one of the pattern without pairs needs no slots.

        Parameters
        ----------
        capsule : capsule "ancf_seed"
            The seed.
        seed : object, optional
            Its owner, which is kept alive.
        slot, slot_of_block : int32 arrays, optional
            Positions of the values on the pattern without pairs, and of those of all blocks.
        n_values : int, optional
            Number of values, also the position of those of fixed coordinates.
        """
        cdef Data *data = &self.data
        cdef const int32_t[::1] view
        cdef double[::1] values
        data.present = <const ancf_seed *>PyCapsule_GetPointer(capsule, "ancf_seed")
        data.coupled = slot is not None
        self.kept = [seed, slot, slot_of_block]
        if data.coupled:
            view = slot
            data.slot = &view[0]
            view = slot_of_block
            data.slot_of_block = &view[0]
            values = np.zeros(n_values + 1)
            data.values, data.n_coupled = &values[0], n_values
            self.kept.append(values)

    def factor(self, const double[::1] values):
        """Factor values with the blocks of pairs behind those on the pattern; as `Ldl.factor`."""
        return factor(<void *>self, &values[0])

    def solve(self, const double[::1] r):
        """Return the solution ``x (n,)`` for the right-hand side ``r (n,)``."""
        x = np.empty(self.data.present.n)
        cdef double[::1] view = x
        solve(<void *>self, &r[0], &view[0])
        return x


cdef ptrdiff_t factor(void *context, const double *values) noexcept nogil:
    cdef Data *data = &(<Coupled>context).data
    cdef const ancf_coupling *each
    cdef const int32_t *slot
    cdef double *out
    cdef ptrdiff_t k, i, where
    for k in range(data.n_couplings):
        if data.changes[k] != data.couplings[k].changes:
            renew(context)
            break
    if data.failed:
        return 1
    if not data.coupled:
        return data.present.factor(data.present.context, values)
    out = data.values
    memset(out, 0, data.n_coupled * sizeof(double))
    for i in range(data.n_values):
        out[data.slot[i]] = values[i]
    slot = data.slot_of_block
    for k in range(data.n_couplings):
        each = data.couplings[k]
        for i in range(each.n * each.size):
            if slot[i] >= 0:
                out[slot[i]] += values[each.first + i]
            else:
                where = -1 - slot[i]
                out[where] += 2.0 * values[each.first + i]
        slot += each.n * each.size
    return data.present.factor(data.present.context, out)


cdef void renew(void *context) noexcept with gil:
    """Let Python order and take a seed for the present pairs; an error ends the step."""
    cdef Coupled self = <Coupled>context
    cdef Data *data = &self.data
    cdef ptrdiff_t k
    try:
        self.renew()
        for k in range(data.n_couplings):
            data.changes[k] = data.couplings[k].changes
    except BaseException as error:  # cannot propagate through C: the caller of C raises it
        self.error, data.failed = error, True


cdef void solve(void *context, const double *r, double *x) noexcept nogil:
    cdef Data *data = &(<Coupled>context).data
    cdef ptrdiff_t i
    if data.failed:
        for i in range(data.present.n):
            x[i] = NAN
        return
    data.present.solve(data.present.context, r, x)


cdef void round_to_single(void *context) noexcept nogil:
    cdef Data *data = &(<Coupled>context).data
    if data.present.round_to_single != NULL:
        data.present.round_to_single(data.present.context)
