# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Springs and dampers between two points: N = N(l - L) + c dl/dt along the line between them.

Between two states the force is the discrete gradient of the energy U(l - L),

    (U1 - U0) / (l1 - l0)  (d0 + d1) / (l0 + l1),    times d1 - d0 it is U1 - U0,

where d is the vector from end to end.
"""
from cpython.pycapsule cimport PyCapsule_GetContext, PyCapsule_GetName, PyCapsule_GetPointer
from libc.math cimport sqrt
from libc.stdlib cimport calloc, free

include "../contribution.pxi"
include "../points.pxi"


ctypedef double (*plain_law)(double) noexcept nogil
ctypedef double (*data_law)(double, void *) noexcept nogil


cdef struct Law:
    plain_law plain
    data_law with_data
    void *data
    void *function  # in Python; all of these are NULL if the spring is linear
    void *owner
    bint failed  # whether the last force was not finite
    double elongation  # at which it failed


cdef struct Data:
    Points points
    const int32_t *slot
    const double *origin  # (n, dim) constant added to the sum of coordinates
    const double *stiffness
    const double *damping
    const double *length
    const double *scale
    bint damped
    Law *laws


cdef class Springs(CompiledContribution):
    """The springs of a system.

    Parameters
    ----------
    start, place, weight, slot
        The vectors from end to end as sums of coordinates, see points.pxi.
    origin : (n, dim) float
        Constants added to them [m].
    stiffness, damping, length : (n,) float
        [N/m], [N s/m], [m].
    scale : (n,) float
        Scale of length for numerical differentiation of force laws [m].
    laws : list
        For each spring None, or: a function or capsule, the index of its signature in `LAWS`, and
        a function that returns the error of a failed call.
    """

    cdef Data data
    cdef list laws
    cdef object raised  # by a force law
    cdef ptrdiff_t which  # law that raised it
    cdef double where  # at which elongation [m]

    def __cinit__(self, start, place, weight, slot, origin, stiffness, damping, length, scale, laws):
        cdef Data *data = &self.data
        cdef Law *law
        self.laws = laws
        take_points(&data.points, start, place, weight)
        data.slot, data.origin = integers(slot), reals(origin)
        data.stiffness, data.damping = reals(stiffness), reals(damping)
        data.length, data.scale = reals(length), reals(scale)
        data.damped = bool(damping.any())
        data.laws = <Law *>calloc(max(data.points.n, 1), sizeof(Law))
        if data.laws == NULL:
            raise MemoryError
        for k, each in enumerate(laws):
            law = &data.laws[k]
            law.owner = <void *>self
            if each is None:
                continue
            if each[1] is None:
                law.function = <void *>each[0]
                continue
            name = PyCapsule_GetName(each[0])
            if each[1] == 0:
                law.plain = <plain_law>PyCapsule_GetPointer(each[0], name)
            else:
                law.with_data = <data_law>PyCapsule_GetPointer(each[0], name)
                law.data = PyCapsule_GetContext(each[0])
        self.interface.context = data
        self.interface.damped = data.damped
        self.interface.residual, self.interface.between = residual, between
        self.interface.matrix, self.interface.energy = matrix, energy
        self.interface.damping = add_damping

    def __dealloc__(self):
        free(self.data.laws)

    def pull(self, ptrdiff_t k, double elongation):
        """Return the force of a spring at an elongation [N]."""
        return force(&self.data, k, elongation)

    @property
    def error(self):
        """Error of the last call of a force law, or None."""
        if isinstance(self.raised, Exception):
            return self.laws[self.which][2](self.where, self.raised)
        if self.raised is not None:
            return self.raised
        for k in range(self.data.points.n):
            if self.data.laws[k].failed:
                return self.laws[k][2](self.data.laws[k].elongation)
        return None

    def forget(self):
        """Call force laws again after an error."""
        self.raised = None
        for k in range(self.data.points.n):
            self.data.laws[k].failed = False


include "spring_laws.pxi"


cdef inline double dot(const Data *self, const double *x, const double *y) noexcept nogil:
    cdef double sum = 0.0
    cdef ptrdiff_t c
    for c in range(self.points.dim):
        sum += x[c] * y[c]
    return sum


cdef inline double over_length(const Data *self, ptrdiff_t k, double length) noexcept nogil:
    """Force over length; for a spring of zero natural length also defined at zero length."""
    if length > 0.0:
        return force(self, k, length - self.length[k]) / length
    return slope(self, k, 0.0) if self.length[k] == 0.0 else 0.0


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef double[3] d
    cdef ptrdiff_t k
    for k in range(self.points.n):
        sum_up(&self.points, k, x.q, self.origin, &d[0])
        push_sum(&self.points, k, over_length(self, k, sqrt(dot(self, &d[0], &d[0]))), &d[0], r)
    if self.damped:
        add_damping(context, x.q, x.v, r)


cdef void between(void *context, const double *q0, const double *q1, const ancf_state *x,
                  double *r, double *phi) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef double[3] d0
    cdef double[3] d1
    cdef double l0, l1, begin, end, pull
    cdef ptrdiff_t k, c
    for k in range(self.points.n):
        sum_up(&self.points, k, q0, self.origin, &d0[0])
        sum_up(&self.points, k, q1, self.origin, &d1[0])
        l0, l1 = sqrt(dot(self, &d0[0], &d0[0])), sqrt(dot(self, &d1[0], &d1[0]))
        begin, end = l0 - self.length[k], l1 - self.length[k]
        if is_linear(self, k):
            pull = 0.5 * self.stiffness[k] * (begin + end)
        elif begin == end:
            pull = force(self, k, end)
        else:
            pull = integral(self, k, begin, end) / (end - begin)
        for c in range(self.points.dim):
            d0[c] += d1[c]
        if l0 + l1 > 0.0:
            push_sum(&self.points, k, pull / (l0 + l1), &d0[0], r)
    if self.damped:
        add_damping(context, x.q, x.v, r)


cdef void add_damping(void *context, const double *q, const double *v,
                      double *r) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef double[3] d
    cdef double[3] rate
    cdef double square
    cdef ptrdiff_t k
    for k in range(self.points.n):
        if self.damping[k] == 0.0:
            continue
        sum_up(&self.points, k, q, self.origin, &d[0])
        sum_up(&self.points, k, v, NULL, &rate[0])
        square = dot(self, &d[0], &d[0])
        if square > 0.0:
            push_sum(&self.points, k,
                     self.damping[k] * dot(self, &d[0], &rate[0]) / square, &d[0], r)


cdef double energy(void *context, const double *q) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef double[3] d
    cdef double sum = 0.0, elongation
    cdef ptrdiff_t k
    for k in range(self.points.n):
        sum_up(&self.points, k, q, self.origin, &d[0])
        elongation = sqrt(dot(self, &d[0], &d[0])) - self.length[k]
        if is_linear(self, k):
            sum += 0.5 * self.stiffness[k] * elongation * elongation
        else:
            sum += integral(self, k, 0.0, elongation)
    return sum


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef double[3] d
    cdef double[3][3] block
    cdef double square, along, across
    cdef ptrdiff_t k, i, j, c, e
    cdef const int32_t *slot = self.slot
    cdef const Points *points = &self.points
    if not (part == STIFFNESS or part == MATERIAL or part == DAMPING and self.damped):
        return
    for k in range(self.points.n):
        sum_up(&self.points, k, x.q, self.origin, &d[0])
        square = dot(self, &d[0], &d[0])
        along = across = 0.0
        if part == DAMPING:
            along = self.damping[k]
        else:
            along = slope(self, k, sqrt(square) - self.length[k])
            if part == STIFFNESS:
                across = over_length(self, k, sqrt(square))
            else:
                along = max(along, 0.0)
        # along: in the direction of the line; across: orthogonal to it
        for c in range(self.points.dim):
            for e in range(self.points.dim):
                block[c][e] = (along - across) * d[c] * d[e] / square if square > 0.0 else 0.0
            block[c][c] += across
        # Coordinates are numbered consecutively, with the directions of each together.
        for i in range(points.start[k], points.start[k + 1]):
            for c in range(self.points.dim):
                for j in range(points.start[k], i + 1):
                    for e in range(self.points.dim if j < i else c + 1):
                        values[slot[0]] += points.weight[i] * points.weight[j] * block[c][e]
                        slot += 1
