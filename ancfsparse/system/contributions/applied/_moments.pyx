# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Moments on nodes: forces that depend on the slopes, and their derivatives for fixed axes."""
from libc.math cimport fabs, sqrt
from libc.string cimport memset

include "../contribution.pxi"


cdef struct Data:
    ptrdiff_t n, dim, n_all
    const int32_t *place  # of r_x, r_y, r_z; -1 where the moment does not act
    const int32_t *slot
    const int32_t *column
    const int32_t *axes  # in space: of the vectors that are the axes of a moment; -1 for those of space


cdef class Moments(CompiledContribution):
    """The moments of a system.

    Parameters
    ----------
    n_all : int
        Number of coordinates.
    arrays : mapping
        ``place (n, 3 dim)``, indices in q of those of r_x, r_y, r_z that the moment acts on, -1 for
        the others; ``slot``, indices of their lower triangle in the values of the matrix;
        ``column`` of the amplitudes; ``axes (n, 9)``, places of the vectors about which a moment in
        space follows, or -1.
    """

    cdef Data data

    def __cinit__(self, ptrdiff_t n_all, arrays):
        cdef Data *data = &self.data
        data.n_all = n_all
        data.n, data.dim = len(arrays["place"]), arrays["place"].shape[1] // 3
        data.place, data.slot = integers(arrays["place"]), integers(arrays["slot"])
        data.column, data.axes = integers(arrays["column"]), integers(arrays["axes"])
        self.interface.context = data
        self.interface.residual, self.interface.matrix = residual, matrix
        self.interface.work, self.interface.reach = work, reach


cdef inline void moment_at(const Data *self, ptrdiff_t k, const double *q,
                           const double *amplitudes, double *m) noexcept nogil:
    cdef const int32_t *axis = self.axes + 9 * k
    cdef double size
    cdef ptrdiff_t d, v
    m[0] = m[1] = m[2] = 0.0
    if self.dim == 2:
        m[2] = amplitudes[self.column[k]]
    elif axis[0] < 0:
        for d in range(3):
            m[d] = amplitudes[self.column[3 * k + d]]
    else:
        for v in range(3):
            size = 0.0
            for d in range(3):
                size += q[axis[3 * v + d]] * q[axis[3 * v + d]]
            size = amplitudes[self.column[3 * k + v]] / sqrt(size)
            for d in range(3):
                m[d] += size * q[axis[3 * v + d]]


cdef inline bint vector_at(const Data *self, ptrdiff_t k, ptrdiff_t v, const double *q,
                           double *x) noexcept nogil:
    """Read vector v (r_x, r_y, r_z) of the node of moment k; False if it does not act there."""
    cdef const int32_t *place = self.place + (3 * k + v) * self.dim
    cdef ptrdiff_t d
    if place[0] < 0:
        return False
    x[2] = 0.0
    for d in range(self.dim):
        x[d] = q[place[d]]
    return True


cdef inline double share_at(const Data *self, ptrdiff_t k) noexcept nogil:
    """Fraction of a twist for each of r_y and r_z where moment k acts."""
    cdef const int32_t *place = self.place + 3 * k * self.dim
    return 0.5 if place[self.dim] >= 0 and place[2 * self.dim] >= 0 else 1.0


cdef inline void cross(const double *a, const double *b, double *out) noexcept nogil:
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


cdef inline double dot(const double *a, const double *b) noexcept nogil:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


cdef inline void section_at(const Data *self, ptrdiff_t k, const double *q,
                            double units[2][3]) noexcept nogil:
    """Read r_y and r_z; in the plane, r_z is the unit normal unless it is a coordinate."""
    units[1][0] = units[1][1] = 0.0
    units[1][2] = 1.0
    vector_at(self, k, 1, q, units[0])
    vector_at(self, k, 2, q, units[1])


cdef inline void turning_of(const double units[2][3], const double *m, double *w) noexcept nogil:
    """Solve sum over both vectors u of u x (w x u) = m for w."""
    cdef double s[6]
    cdef double c[6]
    cdef const double *y = units[0]
    cdef const double *z = units[1]
    cdef double size = dot(y, y) + dot(z, z)
    s[0], s[1], s[2] = size - y[0] * y[0] - z[0] * z[0], -y[0] * y[1] - z[0] * z[1], -y[0] * y[2] - z[0] * z[2]
    s[3], s[4], s[5] = size - y[1] * y[1] - z[1] * z[1], -y[1] * y[2] - z[1] * z[2], size - y[2] * y[2] - z[2] * z[2]
    c[0], c[1], c[2] = s[3] * s[5] - s[4] * s[4], s[2] * s[4] - s[1] * s[5], s[1] * s[4] - s[2] * s[3]
    c[3], c[4], c[5] = s[0] * s[5] - s[2] * s[2], s[1] * s[2] - s[0] * s[4], s[0] * s[3] - s[1] * s[1]
    size = s[0] * c[0] + s[1] * c[1] + s[2] * c[2]
    w[0] = (c[0] * m[0] + c[1] * m[1] + c[2] * m[2]) / size
    w[1] = (c[1] * m[0] + c[3] * m[1] + c[4] * m[2]) / size
    w[2] = (c[2] * m[0] + c[4] * m[1] + c[5] * m[2]) / size


cdef void add_on_section(const Data *self, ptrdiff_t k, const double *m, const double *q,
                         double *r) noexcept nogil:
    cdef double units[2][3]
    cdef double w[3]
    cdef double f[3]
    cdef const int32_t *place = self.place + 3 * k * self.dim
    cdef ptrdiff_t d, v
    section_at(self, k, q, units)
    turning_of(units, m, w)
    for v in range(2):
        place += self.dim
        if place[0] >= 0:
            cross(w, units[v], f)
            for d in range(self.dim):
                r[place[d]] -= f[d]


cdef void stiffness_on_section(const Data *self, ptrdiff_t k, const double *m, const double *q,
                               double derivative[9][9]) noexcept nogil:
    """Derivative of minus the force w x u on each vector u, where w depends on both vectors.

    For constant w the derivative of w x u is skew and has no symmetric part."""
    cdef double units[2][3]
    cdef double w[3]
    cdef double pull[3]
    cdef double change[3]
    cdef double g[3]
    cdef const double *u
    cdef double along
    cdef ptrdiff_t i, j, v, other
    section_at(self, k, q, units)
    turning_of(units, m, w)
    for v in range(2):
        u = units[v]
        along = dot(u, w)
        for j in range(self.dim):
            for i in range(3):
                pull[i] = u[i] * w[j] - 2.0 * u[j] * w[i]
            pull[j] += along
            turning_of(units, pull, change)
            for other in range(2):
                cross(change, units[other], g)
                for i in range(self.dim):
                    derivative[self.dim * (other + 1) + i][self.dim * (v + 1) + j] = -g[i]


include "load_vector.pxi"


cdef void add(const Data *self, const double *q, const double *amplitudes,
              double *r) noexcept nogil:
    """A moment m acts as m x r_x / |r_x|^2 on the slope; its component along the axis acts in equal
    parts on the section vectors, if there are any.

    If r_x is independent of the section, the moment acts on the section vectors only, by forces w x
    u
    with a common vector w whose resultant moment about the node is m."""
    cdef double x[3]
    cdef double y[3]
    cdef double m[3]
    cdef double f[3]
    cdef double p, along
    cdef const int32_t *place
    cdef ptrdiff_t k, d, v
    for k in range(self.n):
        moment_at(self, k, q, amplitudes, m)
        place = self.place + 3 * k * self.dim
        if not vector_at(self, k, 0, q, x):
            add_on_section(self, k, m, q, r)
            continue
        p = dot(x, x)
        cross(m, x, f)
        for d in range(self.dim):
            r[place[d]] -= f[d] / p
        for v in range(1, 3):
            if vector_at(self, k, v, q, y):
                along = share_at(self, k) * dot(m, x) / (p * dot(y, y))
                cross(x, y, f)
                for d in range(self.dim):
                    r[place[v * self.dim + d]] -= along * f[d]


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    if part == STIFFNESS:
        add_stiffness(<const Data *>context, x.q, x.amplitudes, values)


cdef void add_stiffness(const Data *self, const double *q, const double *amplitudes,
                        double *values) noexcept nogil:
    """Add the symmetric part of the derivative: in space a fixed moment has no potential."""
    cdef double x[3]
    cdef double m[3]
    cdef double derivative[9][9]
    cdef const int32_t *slot
    cdef ptrdiff_t k, i, j, n = 3 * self.dim
    for k in range(self.n):
        for i in range(9):
            for j in range(9):
                derivative[i][j] = 0.0
        moment_at(self, k, q, amplitudes, m)
        if vector_at(self, k, 0, q, x):
            stiffness_on_axis(self, k, m, x, q, derivative)
        else:
            stiffness_on_section(self, k, m, q, derivative)
        slot = self.slot + k * (n * (n + 1) // 2)
        for i in range(n):
            for j in range(i + 1):
                values[slot[0]] += 0.5 * (derivative[i][j] + derivative[j][i])
                slot += 1


cdef void stiffness_on_axis(const Data *self, ptrdiff_t k, const double *m, const double *x,
                            const double *q, double derivative[9][9]) noexcept nogil:
    cdef double y[3]
    cdef double f[3]
    cdef double unit[3]
    cdef double g[3]
    cdef double p = dot(x, x), share = share_at(self, k)
    cdef double s, along
    cdef ptrdiff_t v, i, j
    cross(m, x, f)
    for i in range(self.dim):
        for j in range(self.dim):
            derivative[i][j] = 2.0 * f[i] * x[j] / (p * p)
    for v in range(1, 3):
        if not vector_at(self, k, v, q, y):
            continue
        s = dot(y, y)
        along = share * dot(m, x) / (p * s)
        cross(x, y, f)
        for j in range(3):
            unit[0] = unit[1] = unit[2] = 0.0
            unit[j] = 1.0
            cross(unit, y, g)
            for i in range(3):
                derivative[3 * v + i][3 * v + j] = 2.0 * along * f[i] * y[j] / s
                derivative[3 * v + i][j] = (
                    -along * g[i] - f[i] * (share * m[j] / (p * s) - 2.0 * along * x[j] / p))
