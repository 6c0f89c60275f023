# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Moments about fixed axes on nodes: forces that follow the slopes, and their derivative."""
from cpython.pycapsule cimport PyCapsule_New
from libc.stdint cimport int32_t


cdef extern from "system_abi.h":
    ctypedef struct ancf_moments:
        void *context
        ptrdiff_t n
        void (*add)(void *, const double *, const double *, double *) noexcept nogil
        void (*add_stiffness)(void *, const double *, const double *, double *) noexcept nogil

include "arrays.pxi"


cdef struct Data:
    ptrdiff_t n, dim
    const int32_t *place  # of r_x, r_y, r_z; -1 where there is none
    const int32_t *slot
    const int32_t *column


cdef class Moments:
    """The moments of a system.

    Parameters
    ----------
    arrays : mapping
        ``place (n, 3 dim)`` of r_x, r_y, r_z in q, -1 where there is none; ``slot``, places of their
        lower triangle in the values of the matrix; ``column`` of the amplitudes.
    """

    cdef ancf_moments interface
    cdef Data data
    cdef object owner
    cdef readonly object capsule

    def __cinit__(self, arrays):
        cdef Data *data = &self.data
        self.owner = arrays  # the pointers below lead into it
        data.n, data.dim = len(arrays["place"]), arrays["place"].shape[1] // 3
        data.place, data.slot = integers(arrays["place"]), integers(arrays["slot"])
        data.column = integers(arrays["column"])
        self.interface.context, self.interface.n = data, data.n
        self.interface.add, self.interface.add_stiffness = add, add_stiffness
        self.capsule = PyCapsule_New(&self.interface, "ancf_moments", NULL)


cdef inline void moment_at(const Data *self, ptrdiff_t k, const double *amplitudes,
                           double *m) noexcept nogil:
    cdef ptrdiff_t d
    m[0] = m[1] = 0.0
    if self.dim == 2:
        m[2] = amplitudes[self.column[k]]
    else:
        for d in range(3):
            m[d] = amplitudes[self.column[3 * k + d]]


cdef inline bint vector_at(const Data *self, ptrdiff_t k, ptrdiff_t v, const double *q,
                           double *x) noexcept nogil:
    """Read vector v (r_x, r_y, r_z) of the node of moment k; False if it has none."""
    cdef const int32_t *place = self.place + (3 * k + v) * self.dim
    cdef ptrdiff_t d
    if place[0] < 0:
        return False
    x[2] = 0.0
    for d in range(self.dim):
        x[d] = q[place[d]]
    return True


cdef inline void cross(const double *a, const double *b, double *out) noexcept nogil:
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


cdef inline double dot(const double *a, const double *b) noexcept nogil:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


cdef void add(void *context, const double *q, const double *amplitudes, double *r) noexcept nogil:
    """A moment m bends by m x r_x / |r_x|^2 on the slope; the part of it along the axis twists by
    half of itself on each of the two section vectors, if there are any."""
    cdef const Data *self = <const Data *>context
    cdef double x[3]
    cdef double y[3]
    cdef double m[3]
    cdef double f[3]
    cdef double p, along
    cdef const int32_t *place
    cdef ptrdiff_t k, d, v
    for k in range(self.n):
        moment_at(self, k, amplitudes, m)
        place = self.place + 3 * k * self.dim
        vector_at(self, k, 0, q, x)
        p = dot(x, x)
        cross(m, x, f)
        for d in range(self.dim):
            r[place[d]] -= f[d] / p
        for v in range(1, 3):
            if vector_at(self, k, v, q, y):
                along = 0.5 * dot(m, x) / (p * dot(y, y))
                cross(x, y, f)
                for d in range(self.dim):
                    r[place[v * self.dim + d]] -= along * f[d]


cdef void add_stiffness(void *context, const double *q, const double *amplitudes,
                        double *values) noexcept nogil:
    """The symmetric part of the derivative: in space the force of a fixed moment has no potential."""
    cdef const Data *self = <const Data *>context
    cdef double x[3]
    cdef double y[3]
    cdef double m[3]
    cdef double f[3]
    cdef double unit[3]
    cdef double g[3]
    cdef double derivative[9][9]
    cdef double p, s, along
    cdef const int32_t *slot
    cdef ptrdiff_t k, v, i, j, n = 3 * self.dim
    for k in range(self.n):
        for i in range(9):
            for j in range(9):
                derivative[i][j] = 0.0
        moment_at(self, k, amplitudes, m)
        vector_at(self, k, 0, q, x)
        p = dot(x, x)
        cross(m, x, f)
        for i in range(self.dim):
            for j in range(self.dim):
                derivative[i][j] = 2.0 * f[i] * x[j] / (p * p)
        for v in range(1, 3):
            if not vector_at(self, k, v, q, y):
                continue
            s = dot(y, y)
            along = 0.5 * dot(m, x) / (p * s)
            cross(x, y, f)
            for j in range(3):
                unit[0] = unit[1] = unit[2] = 0.0
                unit[j] = 1.0
                cross(unit, y, g)
                for i in range(3):
                    derivative[3 * v + i][3 * v + j] = 2.0 * along * f[i] * y[j] / s
                    derivative[3 * v + i][j] = (
                        -along * g[i] - f[i] * (0.5 * m[j] / (p * s) - 2.0 * along * x[j] / p))
        slot = self.slot + k * (n * (n + 1) // 2)
        for i in range(n):
            for j in range(i + 1):
                values[slot[0]] += 0.5 * (derivative[i][j] + derivative[j][i])
                slot += 1
