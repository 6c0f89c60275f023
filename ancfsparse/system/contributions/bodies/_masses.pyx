# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Constant entries of the mass matrix, in addition to those of the elements."""
include "../contribution.pxi"


cdef struct Data:
    ptrdiff_t n
    const int32_t *row
    const int32_t *column
    const int32_t *slot
    const double *value


cdef class Masses(CompiledContribution):
    """Entries of the lower triangle of a mass matrix.

    Parameters
    ----------
    row, column, slot : (n,) int32
        Indices in q, and slot of the entry in the values of the matrix.
    value : (n,) float
        The entries [kg, kg m2].
    """

    cdef Data data

    def __cinit__(self, row, column, slot, value):
        self.data.n = len(row)
        self.data.row, self.data.column = integers(row), integers(column)
        self.data.slot, self.data.value = integers(slot), reals(value)
        self.interface.context = &self.data
        self.interface.residual, self.interface.inertia = residual, inertia
        self.interface.matrix = matrix


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    if x.a != NULL:
        inertia(context, x.a, r)


cdef void inertia(void *context, const double *a, double *r) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef ptrdiff_t k, i, j
    for k in range(self.n):
        i, j = self.row[k], self.column[k]
        r[i] += self.value[k] * a[j]
        if i != j:
            r[j] += self.value[k] * a[i]


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef ptrdiff_t k
    if part == MASS:
        for k in range(self.n):
            values[self.slot[k]] += self.value[k]
