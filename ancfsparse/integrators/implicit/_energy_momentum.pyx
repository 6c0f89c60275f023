# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The energy-momentum method: the midpoint rule with a discrete gradient.

    q1 - q0 = dt (v0 + v1) / 2,
    M (v1 - v0) / dt + DU(q0, q1) + Q_d(q_m, v_m) + phi_q(q_m)^T lam = f,   phi(q1) = 0,

where m denotes the midpoint and DU . (q1 - q0) = U(q1) - U(q0).  The unknown is the mean
acceleration ``a = (v1 - v0) / dt``, with dq1/da = dt^2 / 2.  See also `integrators.implicit.energy_momentum`.
"""
include "../time_loop/energy_watch.pxi"


cdef bint MEAN_FORCES = True


cdef struct Scheme:
    double *before  # coordinates one step before the last accepted ones
    double *middle  # midpoint of q0 and q, where v is the velocity
    double *load  # mean over the step
    double *values  # workspace for a matrix


include "../time_loop/time_loop.pxi"


cdef class March(TimeLoop):
    """Time loop of the energy-momentum method, see `TimeLoop`; it has no weights and no ``b``.

    The accelerations and multipliers of its state are means over the last step.
    """

    def __cinit__(self, system, dt, integrator, q, v, a, b, lam, dead_load, amplitudes, *_):
        cdef Scheme *scheme = &self.motion.scheme
        cdef dict own = self.arrays
        scheme.before, scheme.middle = kept(own, "before", q), kept(own, "middle", q)
        scheme.load = kept(own, "load", np.append(amplitudes, 0.0))
        scheme.values = kept(own, "values", np.zeros(self.interface.n_values + 1))
        self.interface.q = scheme.middle


cdef set_weights(Motion *self, double dt, integrator):
    self.dt, self.scale = dt, 0.5 * dt * dt


cdef void set_load(Motion *self, const double *amplitudes) noexcept nogil:
    """Set the loads at the end of the step, and their mean over it."""
    cdef ptrdiff_t i
    self.amplitudes = amplitudes
    for i in range(self.system.n_amplitudes):
        self.scheme.load[i] = 0.5 * (self.amplitudes0[i] + amplitudes[i])


cdef void prescribe(Motion *self) noexcept nogil:
    cdef ptrdiff_t n = self.drives.n, base = self.n_all - n, i
    cdef const double *q = self.drives.row
    cdef const double *v = q + n
    for i in range(n):
        self.q[base + i] = q[i]
        self.scheme.middle[base + i] = 0.5 * (self.q0[base + i] + q[i])
        self.a[base + i] = (v[i] - self.v0[base + i]) / self.dt
    if self.system.damped:
        for i in range(n):
            self.v[base + i] = 0.5 * (self.v0[base + i] + v[i])


cdef void take_prescribed(Motion *self) noexcept nogil:
    cdef ptrdiff_t base = self.n_all - self.drives.n
    memcpy(self.scheme.before + base, self.q0 + base, self.drives.n * sizeof(double))


cdef void restart_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), stop, i
    cdef ptrdiff_t piece = begin
    cdef double dt = self.dt, half, total = 0.0
    while piece < end:
        stop = min(piece + PIECE, end)
        for i in range(piece, stop):
            half = 0.5 * dt * (self.v0[i] + 0.5 * dt * self.start[i])
            self.scheme.middle[i] = self.q0[i] + half
            self.q[i] = self.q0[i] + 2.0 * half
            self.a[i] = self.start[i]
        total += way(self, piece, stop)
        piece = stop
    self.squares[part] = total
    if self.system.damped:
        for i in range(begin, end):
            self.v[i] = self.v0[i] + 0.5 * dt * self.start[i]


cdef void coast_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), i
    cdef double dt = self.dt
    for i in range(begin, end):
        self.scheme.middle[i] = self.q0[i] + 0.5 * dt * self.v0[i]
        self.q[i] = self.q0[i] + dt * self.v0[i]
        self.a[i] = 0.0
    if self.system.damped:
        for i in range(begin, end):
            self.v[i] = self.v0[i]


cdef void coast(void *context) noexcept nogil:
    """Start from another predictor, without acceleration."""
    cdef Motion *self = <Motion *>context
    restart(self)
    in_parts(self.n_parts, coast_part, self)


cdef void correct_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef const double *s = self.s
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), i
    cdef double factor = self.factor, of_v = factor / self.dt, of_a = 2.0 * of_v / self.dt
    for i in range(begin, end):
        self.q[i] += factor * s[i]
        self.scheme.middle[i] += 0.5 * factor * s[i]
        self.a[i] += of_a * s[i]
    if self.system.damped:
        for i in range(begin, end):
            self.v[i] += of_v * s[i]
    self.squares[part] = factor * factor * weighed(self, s + begin, begin, end)
    self.ways[part] = way(self, begin, end)


cdef void evaluate(Motion *self) noexcept nogil:
    self.system.residual_between(
        self.system.context, self.q0, self.q, self.scheme.middle, self.v, self.a, self.lam,
        self.dead_load, self.scheme.load, self.r, self.phi)
    lead(self)


cdef void matrix(void *context, double *values) noexcept nogil:
    """Material stiffness at the midpoint plus the geometric stiffness averaged over both ends.

    At the midpoint a rotating body is shorter than at both ends of the step; the resulting stresses
    are artificial, yet they would make the tangent indefinite.  Stresses of the predictor are no
    more reliable: for it the ends of the last step are taken.  The average is over two ends because
    stresses of modes that a step does not resolve alternate in sign.  The terms left out are
    unsymmetric.
    """
    cdef Motion *self = <Motion *>context
    cdef const ancf_system *system = self.system
    cdef double stiffness = 0.25 * self.dt * self.dt, damping = 0.5 * self.dt
    cdef const double *other = self.q if self.corrected else self.scheme.before
    if system.material == NULL:
        system.matrix(system.context, 1.0, stiffness, damping, self.scheme.middle, self.v, self.lam,
                      self.scheme.load, values)
        return
    system.matrix(system.context, 1.0, 0.5 * stiffness, damping, self.q0, self.v, self.lam,
                  self.scheme.load, values)
    system.matrix(system.context, 0.0, 0.5 * stiffness, 0.0, other, self.v, self.lam,
                  self.scheme.load, self.scheme.values)
    add_values(self, 1.0, values)
    system.material(system.context, 0.0, 0.5 * stiffness, 0.0, self.q0, self.scheme.values)
    add_values(self, -1.0, values)
    system.material(system.context, 0.0, 0.5 * stiffness, 0.0, other, self.scheme.values)
    add_values(self, -1.0, values)
    system.material(system.context, 0.0, stiffness, 0.0, self.scheme.middle, self.scheme.values)
    add_values(self, 1.0, values)


cdef void add_values(Motion *self, double factor, double *values) noexcept nogil:
    self.system.add(self.system.context, factor, self.scheme.values, values)


cdef void material(void *context, double *values) noexcept nogil:
    cdef Motion *self = <Motion *>context
    self.system.material(self.system.context, 1.0, 0.25 * self.dt * self.dt, 0.5 * self.dt,
                         self.scheme.middle, values)


cdef inline const double *start_velocity(const Motion *self) noexcept nogil:
    """Velocity at the start of the step for the work of loads: that of the midpoint."""
    return self.v


cdef int solve_step(Motion *self, const ancf_nonlinear *solver) noexcept nogil:
    cdef int outcome = solver.solve(solver.context)
    return PASSES_THROUGH if outcome == 0 and not is_admitted(self) else outcome


cdef void accept_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), i
    cdef double dt = self.dt
    for i in range(begin, end):
        self.scheme.before[i] = self.q0[i]
        self.q0[i] = self.q[i]
        self.v0[i] += dt * self.a[i]
        self.a0[i] = self.a[i]
