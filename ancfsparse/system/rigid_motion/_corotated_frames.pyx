# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Rotations of the nodes between two states, and their application to vectors of unknowns.

A rotation belongs to a row (a node with one slope), or is the average over all rows that share a
position.  Every vector among the coordinates, a position or a slope, rotates with one of them.
"""
from cpython.pycapsule cimport PyCapsule_New
from libc.math cimport fabs, sqrt
from libc.stdint cimport int32_t
from libc.string cimport memcpy

import numpy as np


include "../../abi/solver_abi.pxi"


# Distance of the cosine from minus one below which the axis of the smallest rotation is rounding.
cdef double OPPOSITE = 1e-12


cdef struct Turn:
    ptrdiff_t dim, n, n_rows, n_averages, n_vectors
    const int32_t *axes
    const int32_t *average_start
    const int32_t *average_rows
    const int32_t *places
    const int32_t *rotation_of
    bint turned  # False while R is the identity
    double *reference
    double *rotation


cdef class Frame:
    """Rotations R of all nodes since a reference state, as a block-diagonal matrix.

    In the plane a row rotates with its slope r_x; in space, a cable by the smallest rotation that
    maps one tangent to the other, a beam with section vectors with r_x and r_y orthonormalized.

    Parameters
    ----------
    n : int
        Number of unknowns: free coordinates, then multipliers, which are not rotated.
    axes : (n_rows, dim or 6) int32
        Indices in q of r_x, and in space of r_y; -1 if there is none.
    average_start : (n_averages + 1,) int32
    average_rows : int32
        The rows of each average, concatenated.
    places : (n_vectors, dim) int32
        The vectors among the unknowns that are rotated; all others are unchanged.
    rotation_of : (n_vectors,) int32
        The row each vector rotates with, or ``n_rows`` plus the index of an average.
    """

    cdef ancf_frame interface
    cdef Turn data
    cdef object owners, tables
    cdef readonly object capsule

    def __cinit__(self, ptrdiff_t n, const int32_t[:, ::1] axes, const int32_t[::1] average_start,
                  const int32_t[::1] average_rows, const int32_t[:, ::1] places,
                  const int32_t[::1] rotation_of):
        cdef Turn *data = &self.data
        cdef double[:, ::1] reference, rotation
        self.owners = (axes, average_start, average_rows, places, rotation_of)
        data.dim, data.n = places.shape[1], n
        data.n_rows, data.n_vectors = axes.shape[0], places.shape[0]
        data.n_averages = average_start.shape[0] - 1
        self.tables = (np.zeros((data.n_rows, axes.shape[1])),
                       np.zeros((data.n_rows + data.n_averages, 2 if data.dim == 2 else 9)))
        reference, rotation = self.tables
        data.reference, data.rotation = &reference[0, 0], &rotation[0, 0]
        data.axes, data.average_start = &axes[0, 0], &average_start[0]
        data.average_rows = &average_rows[0] if average_rows.shape[0] > 0 else NULL
        data.places = &places[0, 0] if data.n_vectors > 0 else NULL
        data.rotation_of = &rotation_of[0] if data.n_vectors > 0 else NULL
        self.interface.context, self.interface.n = data, n
        self.interface.hold, self.interface.turn = hold, turn
        self.interface.forward, self.interface.backward = forward, backward
        self.capsule = PyCapsule_New(&self.interface, "ancf_frame", NULL)

    @property
    def operations(self):
        """Arithmetic operations to rotate a vector of unknowns back and forth."""
        return self.data.n_vectors * (12 if self.data.dim == 2 else 30)

    def hold(self, const double[::1] q):
        """Make the state q ``(n_all,)`` the reference, where R is the identity."""
        hold(&self.data, &q[0])

    def turn(self, const double[::1] q):
        """Set R to the rotations from the reference to the state q ``(n_all,)``."""
        turn(&self.data, &q[0])

    def forward(self, const double[::1] x):
        """Return ``R x``, (n,)."""
        y = np.empty(self.data.n)
        cdef double[::1] view = y
        forward(&self.data, &x[0], &view[0])
        return y

    def backward(self, const double[::1] x):
        """Return ``R^T x``, (n,)."""
        y = np.empty(self.data.n)
        cdef double[::1] view = y
        backward(&self.data, &x[0], &view[0])
        return y


cdef inline double dot(const double *a, const double *b) noexcept nogil:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


cdef inline void cross(const double *a, const double *b, double *c) noexcept nogil:
    c[0] = a[1] * b[2] - a[2] * b[1]
    c[1] = a[2] * b[0] - a[0] * b[2]
    c[2] = a[0] * b[1] - a[1] * b[0]


cdef inline void normalize(double *a, ptrdiff_t dim) noexcept nogil:
    cdef double square = 0.0
    cdef ptrdiff_t d
    for d in range(dim):
        square += a[d] * a[d]
    for d in range(dim):
        a[d] /= sqrt(square)


cdef inline void normalize_across(double *b, const double *t) noexcept nogil:
    """Make b a unit vector orthogonal to the unit vector t."""
    cdef double along = dot(b, t)
    cdef ptrdiff_t d
    for d in range(3):
        b[d] -= along * t[d]
    normalize(b, 3)


cdef inline void axes_at(const Turn *self, ptrdiff_t row, const double *q,
                         double *out) noexcept nogil:
    """Compute the unit tangent of a row, followed by a unit normal if it has section vectors.

    A row without a tangent, of a string, gets a fixed axis instead, so it does not rotate.
    """
    cdef ptrdiff_t d
    cdef const int32_t *place = self.axes + (2 if self.dim == 2 else 6) * row
    if place[0] < 0:
        for d in range(self.dim):
            out[d] = 1.0 if d == 0 else 0.0
        return
    if self.dim == 2:
        out[0], out[1] = q[place[0]], q[place[1]]
        normalize(out, 2)
        return
    for d in range(3):
        out[d] = q[place[d]]
    normalize(out, 3)
    if place[3] >= 0:
        for d in range(3):
            out[3 + d] = q[place[3 + d]]
        normalize_across(out + 3, out)


cdef void hold(void *context, const double *q) noexcept nogil:
    cdef Turn *self = <Turn *>context
    cdef ptrdiff_t k, width = 2 if self.dim == 2 else 6
    for k in range(self.n_rows):
        axes_at(self, k, q, self.reference + width * k)
    self.turned = False


cdef void frame_rotation(const double *old, const double *new, double *r) noexcept nogil:
    """Rotation from one pair of orthonormal vectors to another, by rows."""
    cdef double n_old[3]
    cdef double n_new[3]
    cdef ptrdiff_t i, j
    cross(old, old + 3, n_old)
    cross(new, new + 3, n_new)
    for i in range(3):
        for j in range(3):
            r[3 * i + j] = new[i] * old[j] + new[3 + i] * old[3 + j] + n_new[i] * n_old[j]


cdef void smallest_rotation(const double *old, const double *new, double *r) noexcept nogil:
    """Smallest rotation from one unit vector to another, by rows: c 1 + [w] + w w^T / (1 + c)."""
    cdef double w[3]
    cdef double c = dot(old, new), factor
    cdef ptrdiff_t i, j, least = 0
    if 1.0 + c <= OPPOSITE:  # half a turn about some orthogonal axis, 2 w w^T - 1
        for i in range(3):
            if fabs(old[i]) < fabs(old[least]):
                least = i
        for i in range(3):
            w[i] = 1.0 if i == least else 0.0
        normalize_across(w, old)
        for i in range(3):
            for j in range(3):
                r[3 * i + j] = 2.0 * w[i] * w[j]
            r[4 * i] -= 1.0
        return
    cross(old, new, w)
    factor = 1.0 / (1.0 + c)
    for i in range(3):
        for j in range(3):
            r[3 * i + j] = factor * w[i] * w[j]
        r[4 * i] += c
    r[1] -= w[2]
    r[2] += w[1]
    r[3] += w[2]
    r[5] -= w[0]
    r[6] -= w[1]
    r[7] += w[0]


cdef void average(const Turn *self, ptrdiff_t k, double *r) noexcept nogil:
    """Average rotation of some rows: their sum with orthonormalized columns."""
    cdef ptrdiff_t size = 2 if self.dim == 2 else 9, m, d
    cdef const double *one
    cdef double columns[9]
    for d in range(size):
        r[d] = 0.0
    for m in range(self.average_start[k], self.average_start[k + 1]):
        one = self.rotation + size * self.average_rows[m]
        for d in range(size):
            r[d] += one[d]
    if self.dim == 2:
        normalize(r, 2)
        return
    for d in range(6):
        columns[d] = r[3 * (d % 3) + d // 3]
    normalize(columns, 3)
    normalize_across(columns + 3, columns)
    cross(columns, columns + 3, columns + 6)
    for d in range(9):
        r[3 * (d % 3) + d // 3] = columns[d]


cdef void turn(void *context, const double *q) noexcept nogil:
    cdef Turn *self = <Turn *>context
    cdef double axes[6]
    cdef const double *old
    cdef double *r
    cdef ptrdiff_t k
    for k in range(self.n_rows):
        axes_at(self, k, q, axes)
        if self.dim == 2:
            old, r = self.reference + 2 * k, self.rotation + 2 * k
            r[0] = old[0] * axes[0] + old[1] * axes[1]
            r[1] = old[0] * axes[1] - old[1] * axes[0]
        elif self.axes[6 * k + 3] >= 0:
            frame_rotation(self.reference + 6 * k, axes, self.rotation + 9 * k)
        else:
            smallest_rotation(self.reference + 6 * k, axes, self.rotation + 9 * k)
    for k in range(self.n_averages):
        average(self, k, self.rotation + (2 if self.dim == 2 else 9) * (self.n_rows + k))
    self.turned = True


cdef void rotate(const Turn *self, const double *x, double *y, bint back) noexcept nogil:
    cdef const int32_t *place
    cdef const double *r
    cdef double c, s, a, b
    cdef double v[3]
    cdef ptrdiff_t k, i, down = 1 if back else 3, along = 3 if back else 1
    if y != x:
        memcpy(y, x, self.n * sizeof(double))
    if not self.turned:
        return
    if self.dim == 2:
        for k in range(self.n_vectors):
            place = self.places + 2 * k
            r = self.rotation + 2 * self.rotation_of[k]
            c, s = r[0], -r[1] if back else r[1]
            a, b = y[place[0]], y[place[1]]
            y[place[0]] = c * a - s * b
            y[place[1]] = s * a + c * b
        return
    for k in range(self.n_vectors):
        place = self.places + 3 * k
        r = self.rotation + 9 * self.rotation_of[k]
        for i in range(3):
            v[i] = y[place[i]]
        for i in range(3):
            y[place[i]] = (r[down * i] * v[0] + r[down * i + along] * v[1]
                           + r[down * i + 2 * along] * v[2])


cdef void forward(void *context, const double *x, double *y) noexcept nogil:
    rotate(<const Turn *>context, x, y, False)


cdef void backward(void *context, const double *x, double *y) noexcept nogil:
    rotate(<const Turn *>context, x, y, True)
