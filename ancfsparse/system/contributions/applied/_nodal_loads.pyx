# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Time-dependent loads: force[place] += weight * amplitude[column]."""
from libc.math cimport fabs

include "../contribution.pxi"


cdef struct Data:
    ptrdiff_t n
    const int32_t *place
    const int32_t *column
    const double *weight


cdef class Loads(CompiledContribution):
    """The time-dependent loads of a system.

    Parameters
    ----------
    place, column : (n,) int32
        Index in q on which each load acts, and index of its amplitude.
    weight : (n,) float
        Factor of the amplitude.
    """

    cdef Data data

    def __cinit__(self, place, column, weight):
        self.data.n = len(place)
        self.data.place, self.data.column = integers(place), integers(column)
        self.data.weight = reals(weight)
        self.interface.context, self.interface.residual = &self.data, residual
        self.interface.work, self.interface.reach = work, reach


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef ptrdiff_t k
    for k in range(self.n):
        r[self.place[k]] -= self.weight[k] * x.amplitudes[self.column[k]]


cdef double work(void *context, const ancf_state *x0, const ancf_state *x1,
                 double *scratch) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef ptrdiff_t k, i
    cdef double total = 0.0
    for k in range(self.n):
        i = self.place[k]
        total += 0.5 * self.weight[k] * (x1.q[i] - x0.q[i]) * (
            x0.amplitudes[self.column[k]] + x1.amplitudes[self.column[k]])
    return total


cdef double reach(void *context, const double *q0, const double *q1, const double *amplitudes,
                  double *scratch) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef ptrdiff_t k, i
    cdef double total = 0.0
    for k in range(self.n):
        i = self.place[k]
        total += fabs(self.weight[k] * amplitudes[self.column[k]] * (q1[i] - q0[i]))
    return total
