# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Forces along the axes of sections: f = factor * sum of amplitude times unit vector."""
from libc.math cimport fabs, sqrt
from libc.string cimport memset

include "../contribution.pxi"

# Largest number of coordinates of a point: vectors of two nodes times their components.
cdef enum:
    MOST = 24


cdef struct Data:
    ptrdiff_t n, dim, n_all, width, n_axes
    const int32_t *place  # (n, width, dim)
    const double *weight  # (n, 1 + n_axes, width): of the position, then of each axis
    const int32_t *column  # (n, dim); -1 where there is no component
    const double *factor
    const int32_t *slot


cdef class Followers(CompiledContribution):
    """The follower forces of a system.

    Parameters
    ----------
    n_all : int
        Number of coordinates.
    arrays : mapping
        ``place (n, width, dim)`` of the vectors that a point and its axes depend on, ``weight (n, 1 +
        n_axes, width)`` of each in the position and in the axes, ``column (n, dim)`` of the
        amplitudes along the axes, ``factor (n,)``, and ``slot``, the places of the lower triangle
        of the vectors in the values of the matrix.
    """

    cdef Data data

    def __cinit__(self, ptrdiff_t n_all, arrays):
        cdef Data *data = &self.data
        data.n_all = n_all
        data.n, data.width, data.dim = arrays["place"].shape
        data.n_axes = arrays["weight"].shape[1] - 1
        data.place, data.slot = integers(arrays["place"].ravel()), integers(arrays["slot"])
        data.weight, data.factor = reals(arrays["weight"].ravel()), reals(arrays["factor"])
        data.column = integers(arrays["column"].ravel())
        self.interface.context = data
        self.interface.residual, self.interface.matrix = residual, matrix
        self.interface.work, self.interface.reach = work, reach


cdef inline double unit_at(const Data *self, ptrdiff_t k, ptrdiff_t axis, const double *q,
                           double *unit) noexcept nogil:
    """Set the unit vector of an axis of point k; return one over the length of the vector."""
    cdef const int32_t *place = self.place + k * self.width * self.dim
    cdef const double *weight = self.weight + (k * (1 + self.n_axes) + 1 + axis) * self.width
    cdef double square = 0.0
    cdef ptrdiff_t u, d
    for d in range(self.dim):
        unit[d] = 0.0
        for u in range(self.width):
            unit[d] += weight[u] * q[place[u * self.dim + d]]
        square += unit[d] * unit[d]
    square = 1.0 / sqrt(square)
    for d in range(self.dim):
        unit[d] *= square
    return square


cdef inline double along(const Data *self, ptrdiff_t k, ptrdiff_t axis,
                         const double *amplitudes) noexcept nogil:
    """Component of the force on point k along an axis."""
    cdef int32_t column = self.column[k * self.dim + axis]
    return self.factor[k] * amplitudes[column] if column >= 0 else 0.0


cdef inline void force_at(const Data *self, ptrdiff_t k, const double *q, const double *amplitudes,
                          double *f) noexcept nogil:
    """In the plane the second axis is the first one turned by 90 degrees."""
    cdef double unit[3]
    cdef double c
    cdef ptrdiff_t axis, d
    f[0] = f[1] = f[2] = 0.0
    for axis in range(self.n_axes):
        c = along(self, k, axis, amplitudes)
        if self.dim == 2:
            unit_at(self, k, 0, q, unit)
            f[0] = c * unit[0] - along(self, k, 1, amplitudes) * unit[1]
            f[1] = c * unit[1] + along(self, k, 1, amplitudes) * unit[0]
        elif c != 0.0:
            unit_at(self, k, axis, q, unit)
            for d in range(3):
                f[d] += c * unit[d]


cdef void add(const Data *self, const double *q, const double *amplitudes,
              double *r) noexcept nogil:
    cdef double f[3]
    cdef const int32_t *place
    cdef const double *weight
    cdef ptrdiff_t k, u, d
    for k in range(self.n):
        force_at(self, k, q, amplitudes, f)
        place = self.place + k * self.width * self.dim
        weight = self.weight + k * (1 + self.n_axes) * self.width
        for u in range(self.width):
            for d in range(self.dim):
                r[place[u * self.dim + d]] -= weight[u] * f[d]


include "load_vector.pxi"


cdef inline void turning(const Data *self, ptrdiff_t k, ptrdiff_t axis, const double *q,
                         const double *amplitudes, double out[3][3]) noexcept nogil:
    """Derivative of the force on point k by the vector of an axis."""
    cdef double unit[3]
    cdef double across[3]
    cdef double c = along(self, k, axis, amplitudes), side = 0.0
    cdef double inverse = unit_at(self, k, axis, q, unit)
    cdef ptrdiff_t i, j
    if self.dim == 2:
        side = along(self, k, 1, amplitudes)
    for j in range(self.dim):
        for i in range(self.dim):
            across[i] = ((1.0 if i == j else 0.0) - unit[i] * unit[j]) * inverse
            out[i][j] = c * across[i]
        if self.dim == 2:
            out[0][j] -= side * across[1]
            out[1][j] += side * across[0]


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    """The symmetric part of the derivative."""
    cdef const Data *self = <const Data *>context
    cdef double derivative[MOST][MOST]
    cdef double turn[3][3]
    cdef const double *weight
    cdef const int32_t *place
    cdef const int32_t *slot
    cdef double value
    cdef ptrdiff_t k, axis, i, j, u, v, n = self.width * self.dim
    if part != STIFFNESS or x.amplitudes == NULL:
        return
    for k in range(self.n):
        weight = self.weight + k * (1 + self.n_axes) * self.width
        place = self.place + k * n
        slot = self.slot + k * (n * (n + 1) // 2)
        memset(derivative, 0, sizeof(derivative))
        for axis in range(self.n_axes):
            if self.dim == 3 and self.column[3 * k + axis] < 0:
                continue
            turning(self, k, axis, x.q, x.amplitudes, turn)
            for u in range(self.width):
                for v in range(self.width):
                    for i in range(self.dim):
                        for j in range(self.dim):
                            derivative[u * self.dim + i][v * self.dim + j] -= (
                                weight[u] * weight[(1 + axis) * self.width + v] * turn[i][j])
        for i in range(n):
            for j in range(i + 1):
                value = 0.5 * (derivative[i][j] + derivative[j][i])
                if i != j and place[i] == place[j]:
                    value *= 2.0  # one coordinate that stands twice
                values[slot[0]] += value
                slot += 1
