# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""A force f(q, v, t) on points, defined by a user function in C or Python."""
from cpython.pycapsule cimport PyCapsule_GetContext, PyCapsule_GetName, PyCapsule_GetPointer
from libc.math cimport NAN, fabs, isfinite
from libc.string cimport memset

include "../contribution.pxi"
include "../points.pxi"


ctypedef int (*user_function)(
    ptrdiff_t, double *, double *, double, double *, void *) noexcept nogil

cdef double DIFFERENCE_STEP = 6e-6  # relative, the cube root of the unit roundoff


cdef struct Data:
    Points points
    ptrdiff_t n, dim, clock  # n and dim as in `points`
    bint coupled
    const int32_t *slot
    double way, speed  # scales of displacements and velocities [m], [m/s]
    user_function function  # NULL for a Python function
    void *data
    void *owner
    int status  # of the last call of a C function
    bint failed  # whether the last force is not finite
    double t  # of that call [s]
    # By points: positions, velocities, forces; those of a second state; and differences.
    double *q
    double *v
    double *f
    double *q1
    double *f1
    double *jacobian


cdef class UserForce(CompiledContribution):
    """A force on points.

    Parameters
    ----------
    start, place, weight, slot
        The points as sums of coordinates, see points.pxi.
    clock : int
        Index of the amplitude that is the time.
    coupled : bool
        Whether the force on one point depends on the motion of others.
    way, speed : float
        Scales of displacements and velocities, for numerical differentiation [m], [m/s].
    capsule : capsule or None
        The C function.
    function : callable
        Used without a capsule: takes positions, velocities and time, and returns checked forces.
    failure : callable
        Returns an error, given a time and the status of a C function.
    """

    cdef Data data
    cdef object call, failure, raised

    def __cinit__(self, start, place, weight, slot, ptrdiff_t clock, bint coupled, double way,
                  double speed, capsule, function, failure):
        cdef Data *data = &self.data
        cdef ptrdiff_t n
        self.call, self.failure = function, failure
        take_points(&data.points, start, place, weight)
        data.n, data.dim, data.slot = data.points.n, data.points.dim, integers(slot)
        data.clock, data.coupled, data.way, data.speed = clock, coupled, way, speed
        data.owner, n = <void *>self, data.n * data.dim
        if capsule is not None:
            name = PyCapsule_GetName(capsule)
            data.function = <user_function>PyCapsule_GetPointer(capsule, name)
            data.data = PyCapsule_GetContext(capsule)
        data.q = self.copy(np.zeros((5, n)))
        data.v, data.f, data.q1, data.f1 = (
            data.q + n, data.q + 2 * n, data.q + 3 * n, data.q + 4 * n)
        data.jacobian = self.copy(np.zeros((n if coupled else data.dim, n)))
        self.interface.context, self.interface.damped = data, True
        self.interface.residual, self.interface.matrix = residual, matrix
        self.interface.work = work

    @property
    def error(self):
        """Error of the last call, or None."""
        if self.raised is not None:
            return self.raised
        return self.failure(self.data.t, self.data.status) if self.data.failed else None

    def forget(self):
        """Call the function again after an error."""
        self.raised, self.data.failed = None, False

    def power(self, const double[::1] q, const double[::1] v, const double[::1] amplitudes):
        """Return the power of the force [W]."""
        cdef ancf_state x
        cdef double sum = 0.0
        cdef ptrdiff_t i
        x.q, x.v, x.amplitudes = &q[0], &v[0], &amplitudes[0]
        evaluate(&self.data, &x)
        for i in range(self.data.n * self.data.dim):
            sum += self.data.f[i] * self.data.v[i]
        return sum


cdef void in_python(Data *self, double t) noexcept with gil:
    """Call the Python function; after a failure it is not called again."""
    cdef UserForce owner = <UserForce>self.owner
    cdef ptrdiff_t i
    cdef const double[:, ::1] found
    shape = self.n, self.dim
    if owner.raised is None:
        try:
            # Copies, which the user function may keep or modify.
            q = np.array(<double[:self.n, :self.dim]>self.q)
            v = np.array(<double[:self.n, :self.dim]>self.v)
            found = np.ascontiguousarray(owner.call(q, v, t))
            for i in range(self.n * self.dim):
                self.f[i] = (&found[0, 0])[i]
            return
        except BaseException as error:  # a user function may raise anything
            owner.raised = error
    for i in range(self.n * self.dim):
        self.f[i] = NAN


cdef void apply(Data *self, double t) noexcept nogil:
    """Set f from q and v."""
    cdef ptrdiff_t i
    cdef double sum = 0.0
    self.t, self.status = t, 0
    if self.function == NULL:
        in_python(self, t)
    else:
        self.status = self.function(self.n, self.q, self.v, t, self.f, self.data)
        if self.status != 0:
            self.f[0] = NAN
    for i in range(self.n * self.dim):
        sum += fabs(self.f[i])
    self.failed = not isfinite(sum)


cdef inline void gather(const Data *self, const double *x, double *out) noexcept nogil:
    cdef ptrdiff_t k
    if x == NULL:
        memset(out, 0, self.n * self.dim * sizeof(double))
        return
    for k in range(self.n):
        sum_up(&self.points, k, x, NULL, out + self.dim * k)


cdef void evaluate(Data *self, const ancf_state *x) noexcept nogil:
    gather(self, x.q, self.q)
    gather(self, x.v, self.v)
    apply(self, x.amplitudes[self.clock])


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    cdef Data *self = <Data *>context
    cdef ptrdiff_t k
    evaluate(self, x)
    for k in range(self.n):
        push_sum(&self.points, k, -1.0, self.f + self.dim * k, r)


cdef double work(void *context, const ancf_state *x0, const ancf_state *x1,
                 double *scratch) noexcept nogil:
    cdef Data *self = <Data *>context
    cdef double sum = 0.0
    cdef ptrdiff_t i
    evaluate(self, x0)
    for i in range(self.n * self.dim):
        self.q1[i], self.f1[i] = self.q[i], self.f[i]
    evaluate(self, x1)
    for i in range(self.n * self.dim):
        sum += 0.5 * (self.f[i] + self.f1[i]) * (self.q[i] - self.q1[i])
    return sum


cdef void differentiate(Data *self, const ancf_state *x, bint by_velocity) noexcept nogil:
    """Set rows of the Jacobian: derivatives by a coordinate of one point, or of all at once."""
    cdef double t = x.amplitudes[self.clock]
    cdef double *moved = self.v if by_velocity else self.q
    cdef double step = DIFFERENCE_STEP * (self.speed if by_velocity else self.way)
    cdef double *row
    cdef ptrdiff_t n = self.n * self.dim, column, i, stride = n if self.coupled else self.dim
    gather(self, x.q, self.q)
    gather(self, x.v, self.v)
    for column in range(stride):
        row = self.jacobian + column * n
        shift(moved, column, n, stride, step)
        apply(self, t)
        for i in range(n):
            row[i] = self.f[i]
        shift(moved, column, n, stride, -2.0 * step)
        apply(self, t)
        for i in range(n):
            row[i] = (row[i] - self.f[i]) / (2.0 * step)
        shift(moved, column, n, stride, step)


cdef inline void shift(double *x, ptrdiff_t begin, ptrdiff_t end, ptrdiff_t stride,
                       double step) noexcept nogil:
    cdef ptrdiff_t i = begin
    while i < end:
        x[i] += step
        i += stride


cdef inline double entry(const Data *self, ptrdiff_t k, ptrdiff_t c, ptrdiff_t o,
                         ptrdiff_t e) noexcept nogil:
    """Minus the mean of the derivatives of f_kc by the motion oe and of f_oe by kc."""
    cdef ptrdiff_t n = self.n * self.dim, row = self.dim * k + c, column = self.dim * o + e
    if self.coupled:
        return -0.5 * (self.jacobian[column * n + row] + self.jacobian[row * n + column])
    return -0.5 * (self.jacobian[e * n + row] + self.jacobian[c * n + column])


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    """Add derivatives by positions and velocities, but none to the definite approximation."""
    cdef Data *self = <Data *>context
    cdef const Points *points = &self.points
    cdef const int32_t *slot = self.slot
    cdef ptrdiff_t k, o, i, j, c, e
    cdef double value
    if part != STIFFNESS and part != DAMPING or x.amplitudes == NULL:
        return
    differentiate(self, x, part == DAMPING)
    for k in range(self.n):
        for i in range(points.start[k], points.start[k + 1]):
            for c in range(self.dim):
                for o in range(0 if self.coupled else k, k + 1):
                    for j in range(points.start[o], min(points.start[o + 1], i + 1)):
                        for e in range(self.dim if j < i else c + 1):
                            value = points.weight[i] * points.weight[j] * entry(self, k, c, o, e)
                            if i != j and (points.place[c * points.m + i]
                                           == points.place[e * points.m + j]):
                                value *= 2.0  # a coordinate shared by two of the points
                            values[slot[0]] += value
                            slot += 1
