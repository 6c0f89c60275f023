# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Centrifugal and Coriolis forces: r += M (W^2 (q - c) + 2 W v), with M the same along all axes."""
include "../contribution.pxi"


cdef struct Data:
    ptrdiff_t n, dim, n_slots
    const int32_t *place  # (n, dim): the coordinates of each vector
    const double *centre  # (n, dim)
    const int32_t *start
    const int32_t *column
    const double *mass  # of the vectors, by rows
    const double *spin  # (dim, dim)
    const double *square
    const int32_t *slot
    const double *value
    double *scratch  # (n, dim)
    int32_t amplitude


cdef class Rotating(CompiledContribution):
    """The inertia forces of a frame with constant angular velocity.

    Parameters
    ----------
    place : (n, dim) int32
        Places of the components of every vector.
    centre : (n, dim) float
        What each is relative to: a point of the axis for positions, else zero [m].
    start, column, mass : (n + 1,) int32, (k,) int32, (k,) float
        The mass matrix over the vectors, by rows [kg, kg m, kg m2].
    spin : (dim, dim) float
        Skew matrix of the angular velocity [rad/s].
    slot, value : (j,) int32, (j,) float
        The stiffness in the values of the matrix [N/m, N, N m].
    amplitude : int
        Column of the share of the loads by which centrifugal forces grow in statics.
    """

    cdef Data data

    def __cinit__(self, place, centre, start, column, mass, spin, slot, value, int32_t amplitude):
        cdef Data *data = &self.data
        square = spin @ spin
        self.owners.append(square)
        data.n, data.dim, data.n_slots = place.shape[0], place.shape[1], len(slot)
        data.place, data.centre = integers(place), reals(centre)
        data.start, data.column, data.mass = integers(start), integers(column), reals(mass)
        data.spin, data.square = reals(spin), reals(square)
        data.slot, data.value, data.amplitude = integers(slot), reals(value), amplitude
        data.scratch = self.copy(centre)
        self.interface.context, self.interface.damped = data, True
        self.interface.residual, self.interface.matrix = residual, matrix
        self.interface.energy = energy


cdef inline void accelerate(const Data *self, const double *q, const double *v,
                            double share) noexcept nogil:
    """Set the centrifugal and Coriolis accelerations of every vector."""
    cdef const int32_t *place
    cdef double *out
    cdef ptrdiff_t k, i, j
    for k in range(self.n):
        place, out = self.place + k * self.dim, self.scratch + k * self.dim
        for i in range(self.dim):
            out[i] = 0.0
            for j in range(self.dim):
                out[i] += share * self.square[i * self.dim + j] * (
                    q[place[j]] - self.centre[k * self.dim + j])
                if v != NULL:
                    out[i] += 2.0 * self.spin[i * self.dim + j] * v[place[j]]


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef ptrdiff_t k, e, i
    if x.amplitudes == NULL:
        return
    accelerate(self, x.q, x.v, x.amplitudes[self.amplitude])
    for k in range(self.n):
        for e in range(self.start[k], self.start[k + 1]):
            for i in range(self.dim):
                r[self.place[k * self.dim + i]] += (
                    self.mass[e] * self.scratch[self.column[e] * self.dim + i])


cdef double energy(void *context, const double *q) noexcept nogil:
    """The potential of the centrifugal forces; Coriolis forces do no work."""
    cdef const Data *self = <const Data *>context
    cdef double sum = 0.0
    cdef ptrdiff_t k, e, i
    accelerate(self, q, NULL, 0.5)
    for k in range(self.n):
        for e in range(self.start[k], self.start[k + 1]):
            for i in range(self.dim):
                sum += (q[self.place[k * self.dim + i]] - self.centre[k * self.dim + i]) * (
                    self.mass[e] * self.scratch[self.column[e] * self.dim + i])
    return sum


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    """Add the centrifugal stiffness; the skew-symmetric velocity derivative is omitted."""
    cdef const Data *self = <const Data *>context
    cdef double share
    cdef ptrdiff_t k
    if part != STIFFNESS or x.amplitudes == NULL:
        return
    share = x.amplitudes[self.amplitude]
    for k in range(self.n_slots):
        values[self.slot[k]] += share * self.value[k]
