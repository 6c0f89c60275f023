# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Newmark's family in the paper's incremental form (equations 4 to 10).

For the formulas see `integrators.implicit.newmark_family`.
"""
include "../time_loop/energy_watch.pxi"
include "mean_jerk.pxi"


cdef struct Weights:
    # Weights of the predictor of a coordinate, in addition to q0 + dt v0, and of the velocity.
    double q_b, q_a, v_b, v_a, v_new
    double b_b, b_a, b_new


cdef bint MEAN_FORCES = False


cdef struct Scheme:
    Weights weights
    Weights regular  # by the integrator, with the scale that belongs to them
    double regular_scale
    double *alert  # number of steps whose energy is still checked after an impact
    double *b0  # a0 itself where it is the true acceleration
    bint shifted  # whether b0 differs from a0
    MeanJerk jerk
    ptrdiff_t evaluated, matrices  # residuals and matrices so far
    ancf_watch refused  # the energy watch at the last solution that was rejected
    ancf_watch tried  # the same of the first step accepted on trial, see `try_it`
    double most_tried  # the largest gain of such steps
    double *aside  # storage for a solution; takes no memory until a solution is rejected


include "../time_loop/time_loop.pxi"


# The energy of a step that took this many residuals, or matrices as Newton's fewer corrections do,
# is checked before the step is accepted.
cdef ptrdiff_t HARD_STEP = 5, HARD_FOR_NEWTON = 3


cdef class March(TimeLoop):
    """Time loop of Newmark's family, see `TimeLoop`, with equal or changed steps."""

    def __cinit__(self, system, dt, integrator, q, v, a, b, *_):
        cdef Scheme *scheme = &self.motion.scheme
        scheme.shifted = integrator.shift != 0.0
        scheme.b0 = self.motion.a0
        if scheme.shifted:
            scheme.b0 = kept(self.arrays, "b0", b)
        scheme.alert = reserved(self.arrays, "alert", 1)
        vectors = 3 if self.motion.system.damped else 2  # as `keep` stores
        aside = self.arrays["aside"] = np.empty(vectors * len(q) + self.motion.m)
        cdef double[::1] view = aside
        scheme.aside = &view[0]

    def follow_jerk(self):
        """Keep the mean rate of the accelerations, which changes of the step size need."""
        self.motion.trend.used = False  # the size of steps changes too often
        self.motion.scheme.jerk.mean = kept(self.arrays, "jerk", np.zeros(self.motion.n_all))

    def jump(self, change_a, amplitudes):
        """Continue after a jump of the loads, given the new loads and change of accelerations."""
        self.arrays["a0"] += change_a
        if "b0" in self.arrays:
            self.arrays["b0"] += change_a
        self.motion.phase[0] = UNKNOWN
        forget(&self.motion)
        self.arrays["amplitudes0"][: len(amplitudes)] = amplitudes
        self.motion.corrected = True  # otherwise the next start would assume that a equals a0

    @property
    def jerk(self):
        """Rate of the accelerations over the last accepted steps, (n_all,)."""
        return self.arrays["jerk"].copy()

    @property
    def refused_gain(self):
        """As `energy_gain`, for the last solution rejected because of it [J]."""
        return self.motion.scheme.refused.gain, self.motion.scheme.refused.exchanged

    def withdraw(self):
        """Return how many of the last steps a failed run must not keep: those since a trial.

        They are kept if the energy exchanged up to now covers what was gained on trial.  Otherwise
        `refused_gain` is then that of the first step on trial.
        """
        cdef Scheme *scheme = &self.motion.scheme
        if not is_pending(&self.motion):
            return 0
        scheme.refused = scheme.tried
        scheme.most_tried = 0.0
        return self.motion.watch.steps - scheme.tried.steps


cdef set_weights(Motion *self, double dt, integrator):
    """Compute the weights of the formulas."""
    cdef Weights *w = &self.scheme.weights
    cdef double m = integrator.alpha_m, f = integrator.alpha_f
    cdef double beta = integrator.beta, gamma = integrator.gamma
    self.dt = dt
    # b1 = b_new a1 + b_a a0 + b_b b0, substituted in Newmark's formulas with a1 = a0 + change.
    w.b_new, w.b_a, w.b_b = (1.0 - f) / (1.0 - m), f / (1.0 - m), -m / (1.0 - m)
    w.q_b, w.q_a = dt * dt * (0.5 - beta + beta * w.b_b), dt * dt * beta * (w.b_a + w.b_new)
    w.v_b, w.v_a = dt * (1.0 - gamma + gamma * w.b_b), dt * gamma * w.b_a
    w.v_new, self.scale = dt * gamma * w.b_new, dt * dt * beta * w.b_new
    self.scheme.regular, self.scheme.regular_scale = w[0], self.scale


cdef void set_load(Motion *self, const double *amplitudes) noexcept nogil:
    self.amplitudes = amplitudes
    take_regular_weights(self)


cdef void prescribe(Motion *self) noexcept nogil:
    cdef ptrdiff_t n = self.drives.n, base = self.n_all - n
    cdef const double *row = self.drives.row
    memcpy(self.q + base, row, n * sizeof(double))
    memcpy(self.a + base, row + 2 * n, n * sizeof(double))
    if self.system.damped:
        memcpy(self.v + base, row + n, n * sizeof(double))


cdef void take_prescribed(Motion *self) noexcept nogil:
    pass


cdef void restart_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef Weights w = self.scheme.weights  # a local copy, since stores cannot alias it
    cdef double dt = self.dt
    cdef const double *b0 = self.scheme.b0
    cdef const double *start = self.start
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), i
    cdef ptrdiff_t piece = begin, stop
    cdef double total = 0.0
    while piece < end:
        stop = min(piece + PIECE, end)
        if start == self.a:
            extrapolate(self, piece, stop - piece)
        for i in range(piece, stop):
            self.q[i] = self.q0[i] + dt * self.v0[i] + w.q_b * b0[i] + w.q_a * self.a0[i]
        if start != self.a0:
            for i in range(piece, stop):
                self.q[i] += self.scale * (start[i] - self.a0[i])
        if self.measures:
            total += way(self, piece, stop)
        piece = stop
    self.squares[part] = total
    if start != self.a and (self.corrected or self.elsewhere or start != self.a0):
        for i in range(begin, end):
            self.a[i] = start[i]
    if self.system.damped:
        for i in range(begin, end):
            self.v[i] = self.v0[i] + w.v_b * b0[i] + w.v_a * self.a0[i] + w.v_new * start[i]


cdef void coast_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef double v_new = self.scheme.weights.v_new, scale = self.scale
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), i
    if self.system.damped:
        for i in range(begin, end):
            self.v[i] -= v_new * self.a[i]
    for i in range(begin, end):
        self.q[i] -= scale * self.a[i]
        self.a[i] = 0.0


cdef void coast(void *context) noexcept nogil:
    """Start from another predictor, without acceleration: that of an unresolved step is useless."""
    cdef Motion *self = <Motion *>context
    restart(self)
    in_parts(self.n_parts, coast_part, self)
    self.corrected = True  # otherwise the next start would assume that a equals a0


cdef void correct_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef const double *s = self.s
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), stop, i
    cdef double factor = self.factor, of_a = factor / self.scale, total = 0.0
    cdef double of_v = of_a * self.scheme.weights.v_new
    cdef const double *mass = self.interface.mass
    while begin < end:
        stop = min(begin + PIECE, end)
        if mass != NULL:
            total += vec_advance(self.q + begin, factor, self.a + begin, of_a, s + begin,
                                 mass + begin, stop - begin)
        else:
            for i in range(begin, stop):
                self.q[i] += factor * s[i]
                self.a[i] += of_a * s[i]
            total += dot(s + begin, s + begin, stop - begin)
        if self.system.damped:
            for i in range(begin, stop):
                self.v[i] += of_v * s[i]
        begin = stop
    self.squares[part] = factor * factor * total


cdef void evaluate(Motion *self) noexcept nogil:
    self.scheme.evaluated += 1
    self.system.residual(self.system.context, self.q, self.v, self.a, self.lam,
                         self.dead_load, self.amplitudes, self.r, self.phi)
    lead(self)


cdef void matrix(void *context, double *values) noexcept nogil:
    cdef Motion *self = <Motion *>context
    self.scheme.matrices += 1
    self.system.matrix(self.system.context, 1.0, self.scale, self.scheme.weights.v_new, self.q,
                       self.v, self.lam, self.amplitudes, values)


cdef void material(void *context, double *values) noexcept nogil:
    cdef Motion *self = <Motion *>context
    self.system.material(self.system.context, 1.0, self.scale, self.scheme.weights.v_new, self.q,
                         values)


cdef inline const double *start_velocity(const Motion *self) noexcept nogil:
    """Velocity at the start of the step, for the work of loads; `v` is that at its end."""
    return self.v0


cdef int solve_step(Motion *self, const ancf_nonlinear *solver) noexcept nogil:
    """Solve a step and check its energy; return an outcome."""
    cdef ptrdiff_t evaluated = self.scheme.evaluated, matrices = self.scheme.matrices
    cdef int outcome = solver.solve(solver.context)
    cdef bint hard
    if outcome != 0:
        measure(self)
        if self.watch.steps >= WATCH_EVERY and ancf_watch_gains(&self.watch, False):
            return GAINED_ENERGY  # the likely cause
        return outcome
    if not is_admitted(self):
        return PASSES_THROUGH
    evaluated, matrices = self.scheme.evaluated - evaluated, self.scheme.matrices - matrices
    hard = evaluated >= HARD_STEP or matrices >= HARD_FOR_NEWTON
    if self.scheme.jerk.mean == NULL and is_energy_checked(self):
        if repeat_gaining_step(self, solver, not hard):
            return 0
        hard = True
    if hard and not settle(self, solver):
        return WOULD_GAIN
    if self.scheme.jerk.mean != NULL:
        follow(&self.scheme.jerk, self.a0, self.a, self.n_all, self.dt)
    return 0


cdef inline void push(Motion *self, double sign, ptrdiff_t begin, ptrdiff_t end) noexcept nogil:
    """Advance `v0` to the end of the step, or back."""
    cdef Weights w = self.scheme.weights
    cdef const double *b0 = self.scheme.b0
    cdef ptrdiff_t i
    for i in range(begin, end):
        self.v0[i] += sign * (w.v_b * b0[i] + w.v_a * self.a0[i] + w.v_new * self.a[i])


cdef void push_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    push(self, self.factor, share(self, part), share(self, part + 1))


cdef void accept_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef Weights w = self.scheme.weights
    cdef double *b0 = self.scheme.b0
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), stop, i
    while begin < end:  # in pieces that stay in the cache from the first loop to the last
        stop = min(begin + PIECE, end)
        if not self.ahead:
            push(self, 1.0, begin, stop)
        note(self, part, begin, stop - begin)
        for i in range(begin, stop):
            self.q0[i] = self.q[i]
        if self.scheme.shifted:
            for i in range(begin, stop):
                b0[i] = w.b_b * b0[i] + w.b_a * self.a0[i] + w.b_new * self.a[i]
        for i in range(begin, stop):
            self.a0[i] = self.a[i]
        begin = stop


include "energy_selection.pxi"
include "impact_steps.pxi"
