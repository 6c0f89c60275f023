# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Elastic ropes over points: U = L EA s(eps)^2 / 2 with the strain eps = d / L - 1, d the sum of the
distances of consecutive points and L the natural length.

s = (eps + sqrt(eps^2 + w^2)) / 2 is the positive part of the strain, smooth about zero over a width w
that may be zero, so the tension EA s s' is never negative.  Viscosity adds eta s'^2 deps/dt, but
never a push.  Between two states the tension is (U1 - U0) / (d1 - d0).
"""
from libc.math cimport fabs

include "../contribution.pxi"
include "../joints/coordinate_functions.pxi"


cdef struct Data:
    Measures measures  # distances of points
    ptrdiff_t n
    const int32_t *first  # of the measures of each rope
    const double *fixed  # path between points fixed in space
    const double *stiffness
    const double *viscosity
    const double *width
    const double *natural
    const int32_t *column  # of the change of the natural length, or -1
    const int32_t *begin  # of the coordinates of each rope
    const int32_t *place
    const int32_t *own  # of each coordinate of a measure, its number among those of the rope
    const int32_t *slot  # of all pairs of coordinates of each rope
    const int32_t *first_slot
    const int32_t *slot_of_part  # of all pairs of coordinates of each measure
    const int32_t *first_of_part
    double *length  # natural lengths now
    double *slope  # workspace: derivatives of a path by the coordinates of its rope


cdef class Ropes(CompiledContribution):
    """The elastic ropes of a system.

    Parameters
    ----------
    arrays : mapping
        Of the measures ``kind``, ``start``, ``place``, ``weight`` and ``constant`` as in
        coordinate_functions.pxi; ``first (n + 1,)`` of those of each rope; ``fixed``, ``natural`` and ``width``
        [m, m, 1], ``stiffness`` [N], ``viscosity`` [N s]; ``column`` of the change of the length;
        ``begin (n + 1,)`` into ``places``, the coordinates of each rope; ``own`` of each coordinate
        of a measure; ``slot`` from ``first_slot`` on, ``slot_of_part`` from ``first_of_part`` on.
    """

    cdef Data data

    def __cinit__(self, arrays):
        cdef Data *data = &self.data
        take(&data.measures, arrays)
        data.n, data.first = len(arrays["natural"]), integers(arrays["first"])
        data.fixed, data.stiffness = reals(arrays["fixed"]), reals(arrays["stiffness"])
        data.viscosity, data.width = reals(arrays["viscosity"]), reals(arrays["width"])
        data.natural, data.column = reals(arrays["natural"]), integers(arrays["column"])
        data.begin, data.place = integers(arrays["begin"]), integers(arrays["places"])
        data.own, data.slot = integers(arrays["own"]), integers(arrays["slot"])
        data.first_slot = integers(arrays["first_slot"])
        data.slot_of_part = integers(arrays["slot_of_part"])
        data.first_of_part = integers(arrays["first_of_part"])
        data.length = self.copy(arrays["natural"])
        data.slope = self.copy(np.empty(max(np.diff(arrays["begin"]))))
        self.interface.context = data
        self.interface.damped = bool(arrays["viscosity"].any())
        self.interface.residual, self.interface.between = residual, between
        self.interface.matrix, self.interface.energy = matrix, energy
        self.interface.work, self.interface.reach = work, reach
        self.interface.tune = tune
        self.interface.damping = add_damping


cdef void tune(void *context, const double *amplitudes) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef ptrdiff_t k
    for k in range(self.n):
        if self.column[k] >= 0:
            self.length[k] = self.natural[k] + amplitudes[self.column[k]]


cdef inline double root(double strain, double width) noexcept nogil:
    return sqrt(strain * strain + width * width)


cdef inline double positive(double strain, double width) noexcept nogil:
    """The positive part s of a strain, without cancellation."""
    cdef double size = root(strain, width)
    if strain >= 0.0:
        return 0.5 * (strain + size)
    return 0.5 * width * width / (size - strain)


cdef inline double share(double strain, double width) noexcept nogil:
    """The derivative s' = s / sqrt(eps^2 + w^2); 0 at a kink."""
    cdef double size = root(strain, width)
    return positive(strain, width) / size if size > 0.0 else 0.0


cdef inline double secant(double one, double other, double width) noexcept nogil:
    """The difference quotient of s^2 / 2 between two strains."""
    cdef double sum = root(one, width) + root(other, width)
    if sum == 0.0:
        return 0.0
    return 0.25 * (positive(one, width) + positive(other, width)) * (1.0 + (one + other) / sum)


cdef inline double bend_of(double strain, double width) noexcept nogil:
    """The second derivative of s^2 / 2, not negative; at a kink that of a taut rope."""
    cdef double size = root(strain, width), first = share(strain, width)
    if size == 0.0:
        return 1.0
    return first * first + 0.5 * positive(strain, width) * width * width / (size * size * size)


cdef inline double path_of(const Data *self, ptrdiff_t k, const double *q) noexcept nogil:
    cdef Vectors a
    cdef double sum = self.fixed[k]
    cdef ptrdiff_t i
    for i in range(self.first[k], self.first[k + 1]):
        vectors_of(&self.measures, i, q, &a)
        sum += sqrt(a.x)
    return sum


cdef inline double strain_of(const Data *self, ptrdiff_t k, double path) noexcept nogil:
    return (path - self.length[k]) / self.length[k]


cdef inline double tension(const Data *self, ptrdiff_t k, double strain) noexcept nogil:
    return self.stiffness[k] * positive(strain, self.width[k]) * share(strain, self.width[k])


cdef void pull(const Data *self, ptrdiff_t k, double force, const double *q,
               double *r) noexcept nogil:
    """Add a tension times the derivatives of the path."""
    cdef const Measures *m = &self.measures
    cdef Vectors a
    cdef ptrdiff_t i
    for i in range(self.first[k], self.first[k + 1]):
        differentiate(m, i, q, &a)
        push(m, i, force, a.g, r)


cdef double viscous(const Data *self, ptrdiff_t k, double strain, const double *q,
                    const double *v, double *slope) noexcept nogil:
    """The tension by viscosity, and its derivative by the rate of the path."""
    cdef const Measures *m = &self.measures
    cdef Vectors a
    cdef double rate = 0.0, first = share(strain, self.width[k]), elastic, found
    cdef ptrdiff_t i
    for i in range(self.first[k], self.first[k + 1]):
        differentiate(m, i, q, &a)
        rate += rate_of(m, i, a.g, v)
    slope[0] = self.viscosity[k] * first * first / self.length[k]
    elastic, found = tension(self, k, strain), slope[0] * rate
    if found < -elastic:
        slope[0] = 0.0
        return -elastic
    return found


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef double force
    cdef ptrdiff_t k
    for k in range(self.n):
        force = tension(self, k, strain_of(self, k, path_of(self, k, x.q)))
        if force != 0.0:
            pull(self, k, force, x.q, r)
    if x.v != NULL:
        add_damping(context, x.q, x.v, r)


cdef void between(void *context, const double *q0, const double *q1, const ancf_state *x,
                  double *r, double *phi) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef const Measures *m = &self.measures
    cdef Vectors a
    cdef Vectors b
    cdef double begin, end, force
    cdef ptrdiff_t k, i
    for k in range(self.n):
        begin = strain_of(self, k, path_of(self, k, q0))
        end = strain_of(self, k, path_of(self, k, q1))
        force = self.stiffness[k] * secant(begin, end, self.width[k])
        if force == 0.0:
            continue
        for i in range(self.first[k], self.first[k + 1]):
            vectors_of(m, i, q0, &a)
            vectors_of(m, i, q1, &b)
            change_of(LENGTH, &a, &b)
            vectors_of(m, i, x.q, &a)
            gradient_of(&a)
            push(m, i, force, a.g, r)
    if x.v != NULL:
        add_damping(context, x.q, x.v, r)


cdef void add_damping(void *context, const double *q, const double *v,
                      double *r) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef double force, slope
    cdef ptrdiff_t k
    for k in range(self.n):
        if self.viscosity[k] != 0.0:
            force = viscous(self, k, strain_of(self, k, path_of(self, k, q)), q, v, &slope)
            if force != 0.0:
                pull(self, k, force, q, r)


cdef double energy_of(const Data *self, ptrdiff_t k, const double *q) noexcept nogil:
    cdef double s = positive(strain_of(self, k, path_of(self, k, q)), self.width[k])
    return 0.5 * self.stiffness[k] * self.length[k] * s * s


cdef double energy(void *context, const double *q) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef double sum = 0.0
    cdef ptrdiff_t k
    for k in range(self.n):
        sum += energy_of(self, k, q)
    return sum


cdef double work(void *context, const ancf_state *x0, const ancf_state *x1,
                 double *scratch) noexcept nogil:
    """Work of winding: increase of the energy by the change of lengths."""
    cdef const Data *self = <const Data *>context
    cdef double sum = 0.0
    cdef ptrdiff_t k
    for k in range(self.n):
        if self.column[k] < 0:
            continue
        self.length[k] = self.natural[k] + x0.amplitudes[self.column[k]]
        sum -= 0.5 * (energy_of(self, k, x0.q) + energy_of(self, k, x1.q))
        self.length[k] = self.natural[k] + x1.amplitudes[self.column[k]]
        sum += 0.5 * (energy_of(self, k, x0.q) + energy_of(self, k, x1.q))
    return sum


cdef double reach(void *context, const double *q0, const double *q1, const double *amplitudes,
                  double *scratch) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef double sum = 0.0, begin, end
    cdef ptrdiff_t k
    for k in range(self.n):
        if self.column[k] >= 0:
            begin, end = path_of(self, k, q0), path_of(self, k, q1)
            sum += fabs(self.stiffness[k] * amplitudes[self.column[k]] * (end - begin)) * max(
                begin, end) / (self.length[k] * self.length[k])
    return sum


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef double strain, square, force
    cdef ptrdiff_t k
    if part != STIFFNESS and part != MATERIAL and part != DAMPING:
        return
    for k in range(self.n):
        strain, force = strain_of(self, k, path_of(self, k, x.q)), 0.0
        if part == DAMPING:
            square = 0.0
            if self.viscosity[k] != 0.0:
                if x.v != NULL:
                    viscous(self, k, strain, x.q, x.v, &square)
                else:
                    square = self.viscosity[k] * (
                        share(strain, self.width[k]) ** 2 / self.length[k])
        else:
            square = self.stiffness[k] * bend_of(strain, self.width[k]) / self.length[k]
            if part == STIFFNESS:
                force = tension(self, k, strain)
        if square != 0.0 or force != 0.0:
            add_to_matrix(self, k, square, force, x.q, values)


cdef void add_to_matrix(const Data *self, ptrdiff_t k, double square, double force,
                        const double *q, double *values) noexcept nogil:
    """Add ``square d_q d_q^T + force d_qq``, the lower triangle by rows."""
    cdef const Measures *m = &self.measures
    cdef Vectors a
    cdef double[9][9] s
    cdef ptrdiff_t i, j, c, n = self.begin[k + 1] - self.begin[k]
    cdef const int32_t *slot = self.slot + self.first_slot[k]
    for i in range(n):
        self.slope[i] = 0.0
    for i in range(self.first[k], self.first[k + 1]):
        differentiate(m, i, q, &a)
        for c in range(m.start[i], m.start[i + 1]):
            self.slope[self.own[c]] += along(m, c, a.g)
        if force != 0.0:
            second_of(LENGTH, &a, s)
            add_pairs(m, i, s, a.g, force, 0.0, self.slot_of_part + self.first_of_part[i], values)
    for i in range(n):
        for j in range(i + 1):
            values[slot[0]] += square * self.slope[i] * self.slope[j]
            slot += 1
