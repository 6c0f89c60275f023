# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The time loop of Newmark's family in the paper's incremental form (equations 4 to 10).

The dynamic rows are multiplied by beta dt^2 (over the mass ratio of generalised-alpha) and the
multipliers divided by it, so the matrix of a step, ``[M + scale K, phi_q^T; phi_q, 0]``, does not
degrade as dt goes to zero.  `integrators.implicit` has the formulas.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.math cimport fmax, sqrt
from libc.string cimport memcpy

import numpy as np


cdef extern from "parallel.h":
    void in_parts "ancf_in_parts" (
        ptrdiff_t, void (*)(void *, ptrdiff_t) noexcept nogil, void *) noexcept nogil

cdef extern from "vectors.h":
    double dot "vec_dot" (const double *, const double *, ptrdiff_t) noexcept nogil
    void vec_scale_parts(ptrdiff_t, double *, double, const double *, ptrdiff_t) noexcept nogil

include "../kernels/solver_abi.pxi"


cdef extern from "energy_watch.h":
    ctypedef struct ancf_watch:
        double limit, noise, work, exchanged, gain, kinetic
    void ancf_watch_start(ancf_watch *, const ancf_system *, const double *, const double *,
                          const double *, double *) noexcept nogil
    bint ancf_watch_gains(ancf_watch *, const ancf_system *, const double *, const double *,
                          const double *, double *, bint) noexcept nogil


cdef enum:
    GAINED_ENERGY = 4
    TOO_INACCURATE = 5
    MAY_GROW = 6
    WOULD_GAIN = 8

cdef ptrdiff_t PIECE = 512  # of vectors that are passed over more than once
cdef double NEWEST = 0.25  # share of the last step in the mean rate of the accelerations
# An energy costs about one residual.  Steps that take many, because they are long, are watched more
# closely, and one that took this many alone is looked at by itself, before it is accepted.
cdef ptrdiff_t WATCH_EVERY = 16, WATCH_RESIDUALS = 40, HARD_STEP = 5


cdef struct Weights:
    # Where the predictor puts a coordinate, beside q0 + dt v0, and how the velocity follows.
    double q_b, q_a, v_b, v_a, v_new
    double scale  # metres that a unit of new acceleration moves a coordinate by [s2]
    double b_b, b_a, b_new


cdef struct Control:
    const ancf_seed *seed  # NULL for steps of fixed length
    double *weight
    double *change  # of the accelerations over the step
    double *filtered
    double *jerk
    double constant, limit, easy, error
    int patience, calm
    ptrdiff_t judged


cdef struct Motion:
    const ancf_system *system
    ptrdiff_t n_free, n_all, m, n_parts
    ptrdiff_t unwatched, evaluated  # steps and residuals since the last look at the energy
    bint shifted  # whether b is not the true acceleration
    bint moved  # whether a is no longer a0
    bint ahead  # whether v0 and the work of the loads are already those of the step under way
    double dt
    Weights weights
    ancf_watch watch
    ancf_watch refused  # what it saw of the last step that was refused
    Control control
    # Last accepted state, and the iterate of the step under way.
    double *q0
    double *v0
    double *a0
    double *b0
    double *lam0
    double *q
    double *v  # only if forces depend on it
    double *a
    double *lam
    double *amplitudes0
    const double *dead_load
    const double *amplitudes
    double *r
    double *phi
    const double *s  # the correction under way, its factor, and the squares of each part
    double factor
    double *squares


cdef class March:
    """State of a system in time, and the equations of its next step.

    Parameters
    ----------
    system : object with a ``capsule`` "ancf_system"
    dt : float
        Time step [s].
    integrator : Implicit
        The weights.
    q, v, a, b : (n_all,) float
        State at the start: free coordinates first, then fixed ones, which never move; ``b`` is
        the integrator's own acceleration.
    lam : (m,) float
        Multipliers at the start.
    dead_load : (n_all,) float
        Constant applied force.
    amplitudes : (n_amplitudes,) float
        Changing loads at the start.
    largest_gain : float
        Share of the energy exchanged so far by which the energy may exceed what was given.
    noise : float
        Energy that rounding makes [J].
    """

    cdef ancf_equations interface
    cdef Motion motion
    cdef object owner, seed, arrays, loads  # the loads are pointed into until the next ones come
    cdef readonly object capsule

    def __cinit__(self, system, double dt, integrator, q, v, a, b, lam, dead_load, amplitudes,
                  double largest_gain, double noise):
        cdef Motion *motion = &self.motion
        self.owner = system
        motion.system = <const ancf_system *>PyCapsule_GetPointer(system.capsule, "ancf_system")
        motion.n_free, motion.n_all = motion.system.n_free, motion.system.n_all
        motion.m = motion.system.n_multipliers
        motion.shifted = integrator.shift != 0.0
        # Never empty, so that a pointer to the first multiplier or amplitude always exists.
        lam = np.append(lam, 0.0)
        self.arrays = {
            name: np.array(x, dtype=float) for name, x in {
                "q0": q, "v0": v, "a0": a, "lam0": lam, "q": q, "a": a, "lam": lam,
                "dead_load": dead_load, "r": np.zeros(len(q)), "phi": np.zeros(len(lam)),
                "amplitudes0": np.append(amplitudes, 0.0)}.items()}
        own = self.arrays
        self.set_threads(1)
        own["b0"] = np.array(b, dtype=float) if motion.shifted else own["a0"]
        if motion.system.damped:
            own["v"] = np.array(v, dtype=float)
            motion.v = first(own["v"])
        motion.q0, motion.v0, motion.a0 = first(own["q0"]), first(own["v0"]), first(own["a0"])
        motion.b0, motion.lam0 = first(own["b0"]), first(own["lam0"])
        motion.q, motion.a, motion.lam = first(own["q"]), first(own["a"]), first(own["lam"])
        motion.dead_load, motion.r = first(own["dead_load"]), first(own["r"])
        motion.phi, motion.amplitudes0 = first(own["phi"]), first(own["amplitudes0"])
        set_weights(motion, dt, integrator)
        self.interface.context = motion
        self.interface.n, self.interface.n_coordinates = motion.n_free + motion.m, motion.n_free
        self.interface.n_values = motion.system.n_values
        self.interface.restart, self.interface.coast = restart, coast
        self.interface.correct = correct
        self.interface.residual, self.interface.matrix = residual, matrix
        if motion.system.material != NULL:
            self.interface.material = material
        self.interface.q = motion.q
        self.capsule = PyCapsule_New(&self.interface, "ancf_equations", NULL)
        motion.watch.limit, motion.watch.noise = largest_gain, noise
        ancf_watch_start(&motion.watch, motion.system, motion.dead_load, motion.q0, motion.v0,
                         motion.r)

    def change_step(self, double dt, integrator, change_b, change_v):
        """Go on with another step: the weights, and what a smooth motion asks of ``b`` and ``v``."""
        set_weights(&self.motion, dt, integrator)
        if self.motion.shifted:
            self.arrays["b0"] += change_b
        self.arrays["v0"] += change_v

    def control(self, seed, const double[::1] weight, double constant, double limit, double easy,
                int patience):
        """Estimate the error of every step; stop before one above a limit, or after easy ones.

        Parameters
        ----------
        seed : object with a ``capsule`` "ancf_seed"
            Factor of the matrix of a step, or nearly.
        weight : (n_free,) float
            Weights of the squared errors of the coordinates.
        constant : float
            Error of a step over dt^2 and the change of the acceleration.
        limit, easy : float
            The error that is refused, and the one below which a step may grow [m].
        patience : int
            Easy steps in a row that let it grow.
        """
        cdef Control *control = &self.motion.control
        self.seed = seed
        control.seed = <const ancf_seed *>PyCapsule_GetPointer(seed.capsule, "ancf_seed")
        self.arrays["weight"] = np.array(weight)
        self.arrays["change"] = np.zeros(self.motion.n_all)
        self.arrays["filtered"] = np.zeros(self.interface.n)
        control.weight, control.change = first(self.arrays["weight"]), first(self.arrays["change"])
        self.arrays["jerk"] = np.zeros(self.motion.n_all)
        control.filtered, control.jerk = first(self.arrays["filtered"]), first(self.arrays["jerk"])
        control.constant, control.limit, control.easy = constant, limit, easy
        control.patience = patience

    @property
    def step_error(self):
        """Estimated error of the last step that was looked at [m]."""
        return self.motion.control.error

    @property
    def jerk(self):
        """Rate of the accelerations over the last accepted steps, (n_all,)."""
        return self.arrays["jerk"].copy()

    def set_threads(self, ptrdiff_t threads):
        """Set the number of threads for passes over vectors."""
        self.motion.n_parts = threads
        self.arrays["squares"] = np.zeros(threads)
        self.motion.squares = first(self.arrays["squares"])

    @property
    def state(self):
        """Last accepted ``(q, v, a, lam)`` as copies."""
        own = self.arrays
        q, v, a, lam = (own[name].copy() for name in ("q0", "v0", "a0", "lam0"))
        return q, v, a, lam[: self.motion.m]

    @property
    def unbalanced(self):
        """Residual ``(n_all,)`` [N, N m] and constraints ``(m,)`` [m] of the last iterate."""
        cdef Motion *motion = &self.motion
        motion.system.residual(motion.system.context, motion.q, motion.v, motion.a, motion.lam,
                               motion.dead_load, motion.amplitudes, motion.r, motion.phi)
        return self.arrays["r"].copy(), self.arrays["phi"][: self.motion.m].copy()

    @property
    def energy_gain(self):
        """Energy above what was given, and the largest energy exchanged, at the last look [J]."""
        return self.motion.watch.gain, self.motion.watch.exchanged

    @property
    def refused_gain(self):
        """The same, of the last solution that was refused for it [J]."""
        return self.motion.refused.gain, self.motion.refused.exchanged

    def gains_energy(self):
        """Whether the energy is now too far above what was given: the last look of a run."""
        return bool(gains_energy(&self.motion))

    def prepare(self, const double[:, ::1] amplitudes):
        """Set the loads of the next step and put its predictor in place."""
        self.loads = amplitudes
        self.motion.amplitudes = &amplitudes[0, 0] if amplitudes.shape[1] > 0 else NULL
        restart(&self.motion)

    def residual(self):
        """Return the scaled residual ``(n,)`` at the present iterate."""
        out = np.empty(self.interface.n)
        cdef double[::1] view = out
        residual(&self.motion, &view[0])
        return out

    def correct(self, const double[::1] s):
        """Add a correction ``(n,)`` to the present iterate."""
        correct(&self.motion, 1.0, &s[0])

    def matrix(self):
        """Return the values of the scaled iteration matrix at the present iterate."""
        out = np.empty(self.interface.n_values + 1)
        cdef double[::1] view = out
        matrix(&self.motion, &view[0])
        return out[: self.interface.n_values]

    def advance(self, nonlinear, ptrdiff_t n_steps, const double[:, ::1] amplitudes,
                ptrdiff_t save_every, ptrdiff_t steps_done, double[:, ::1] q_out,
                double[:, ::1] v_out, double[:, ::1] a_out, double[:, ::1] lam_out):
        """Take steps; return ``(steps taken, outcome)``, outcome 0 if all of them were accepted.

        Parameters
        ----------
        amplitudes : (n_steps, n_amplitudes)
            Loads at the end of each step.
        save_every, steps_done : int
            Step number k of the run (from 1) is written to row ``k / save_every`` of the outputs.
        """
        cdef const ancf_nonlinear *solver = <const ancf_nonlinear *>PyCapsule_GetPointer(
            nonlinear.capsule, "ancf_nonlinear")
        cdef Motion *motion = &self.motion
        cdef ptrdiff_t k, row, before
        cdef int outcome = 0
        cdef bint hard
        self.loads = amplitudes
        with nogil:
            for k in range(n_steps):
                motion.amplitudes = &amplitudes[k, 0] if amplitudes.shape[1] > 0 else NULL
                restart(motion)
                before = motion.evaluated
                outcome = solver.solve(solver.context)
                if outcome != 0:
                    if gains_energy(motion):  # the likely cause
                        outcome = GAINED_ENERGY
                    break
                if motion.control.seed != NULL and not accurate(motion):
                    outcome = TOO_INACCURATE
                    break
                hard = motion.evaluated - before >= HARD_STEP
                if hard and not settle(motion, solver):
                    outcome = WOULD_GAIN
                    break
                if motion.control.seed != NULL:
                    outcome = follow(motion)
                accept(motion)
                if (steps_done + k + 1) % save_every == 0:
                    row = (steps_done + k + 1) // save_every
                    memcpy(&q_out[row, 0], motion.q0, motion.n_all * sizeof(double))
                    memcpy(&v_out[row, 0], motion.v0, motion.n_all * sizeof(double))
                    memcpy(&a_out[row, 0], motion.a0, motion.n_all * sizeof(double))
                    if motion.m > 0:
                        memcpy(&lam_out[row, 0], motion.lam0, motion.m * sizeof(double))
                motion.unwatched += 1
                if (motion.unwatched >= WATCH_EVERY or motion.evaluated >= WATCH_RESIDUALS
                        or hard):
                    motion.unwatched = motion.evaluated = 0
                    if not hard and gains_energy(motion):
                        outcome = GAINED_ENERGY
                if outcome != 0:
                    k += 1
                    break
            else:
                k = n_steps
        return k, outcome


cdef set_weights(Motion *self, double dt, integrator):
    """Work out the weights of the formulas."""
    cdef Weights *w = &self.weights
    cdef double m = integrator.alpha_m, f = integrator.alpha_f
    cdef double beta = integrator.beta, gamma = integrator.gamma
    self.dt = dt
    # b1 = b_new a1 + b_a a0 + b_b b0, put into Newmark's formulas with a1 = a0 + change.
    w.b_new, w.b_a, w.b_b = (1.0 - f) / (1.0 - m), f / (1.0 - m), -m / (1.0 - m)
    w.q_b, w.q_a = dt * dt * (0.5 - beta + beta * w.b_b), dt * dt * beta * (w.b_a + w.b_new)
    w.v_b, w.v_a = dt * (1.0 - gamma + gamma * w.b_b), dt * gamma * w.b_a
    w.v_new, w.scale = dt * gamma * w.b_new, dt * dt * beta * w.b_new


cdef double *first(array) except NULL:
    cdef double[::1] view = array
    return &view[0]


cdef inline ptrdiff_t share(const Motion *self, ptrdiff_t part) noexcept nogil:
    """Where the share of a part begins among the free coordinates: whole cache lines for each."""
    if part == self.n_parts:
        return self.n_free
    return self.n_free // 8 * part // self.n_parts * 8


cdef void restart_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef Weights w = self.weights  # of our own, so that no store can change it
    cdef double dt = self.dt, v_a = w.v_a + w.v_new
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), i
    for i in range(begin, end):
        self.q[i] = self.q0[i] + dt * self.v0[i] + w.q_b * self.b0[i] + w.q_a * self.a0[i]
    if self.moved:
        for i in range(begin, end):
            self.a[i] = self.a0[i]
    if self.system.damped:
        for i in range(begin, end):
            self.v[i] = self.v0[i] + w.v_b * self.b0[i] + v_a * self.a0[i]


cdef void restart(void *context) noexcept nogil:
    """The predictor: the acceleration and the multipliers of the last step (equation 4)."""
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t i
    in_parts(self.n_parts, restart_part, self)
    self.moved = False
    for i in range(self.m):
        self.lam[i] = self.lam0[i]


cdef void coast_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef Weights w = self.weights
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), i
    if self.system.damped:
        for i in range(begin, end):
            self.v[i] -= w.v_new * self.a[i]
    for i in range(begin, end):
        self.q[i] -= w.scale * self.a[i]
        self.a[i] = 0.0


cdef void coast(void *context) noexcept nogil:
    """Another start: no acceleration.  That of a step which resolved nothing throws ends away."""
    cdef Motion *self = <Motion *>context
    restart(self)
    in_parts(self.n_parts, coast_part, self)
    self.moved = True


cdef void correct_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef const double *s = self.s
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), stop, i
    cdef double factor = self.factor, of_a = factor / self.weights.scale, total = 0.0
    cdef double of_v = of_a * self.weights.v_new
    while begin < end:
        stop = min(begin + PIECE, end)
        for i in range(begin, stop):
            self.q[i] += factor * s[i]
            self.a[i] += of_a * s[i]
        if self.system.damped:
            for i in range(begin, stop):
                self.v[i] += of_v * s[i]
        total += dot(s + begin, s + begin, stop - begin)
        begin = stop
    self.squares[part] = factor * factor * total


cdef double correct(void *context, double factor, const double *s) noexcept nogil:
    """Equation 10; where no force depends on it, the velocity follows when the step is accepted."""
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t i
    cdef double total = 0.0
    self.s, self.factor, self.moved = s, factor, True
    in_parts(self.n_parts, correct_part, self)
    for i in range(self.m):
        self.lam[i] += factor / self.weights.scale * s[self.n_free + i]
    for i in range(self.n_parts):
        total += self.squares[i]
    return total


cdef void residual(void *context, double *r) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t i
    self.evaluated += 1
    self.system.residual(self.system.context, self.q, self.v, self.a, self.lam,
                         self.dead_load, self.amplitudes, self.r, self.phi)
    vec_scale_parts(self.n_parts, r, self.weights.scale, self.r, self.n_free)
    for i in range(self.m):
        r[self.n_free + i] = self.phi[i]


cdef void matrix(void *context, double *values) noexcept nogil:
    cdef Motion *self = <Motion *>context
    self.system.matrix(self.system.context, 1.0, self.weights.scale, self.weights.v_new, self.q,
                       self.v, self.lam, self.amplitudes, values)


cdef void material(void *context, double *values) noexcept nogil:
    cdef Motion *self = <Motion *>context
    self.system.material(self.system.context, 1.0, self.weights.scale, self.weights.v_new,
                         self.q, values)


cdef void accept_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef Weights w = self.weights
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), stop, i
    while begin < end:  # in pieces, so that the later loops find in the cache what the first has read
        stop = min(begin + PIECE, end)
        if not self.ahead:
            for i in range(begin, stop):
                self.v0[i] += w.v_b * self.b0[i] + w.v_a * self.a0[i] + w.v_new * self.a[i]
        for i in range(begin, stop):
            self.q0[i] = self.q[i]
        if self.shifted:
            for i in range(begin, stop):
                self.b0[i] = w.b_b * self.b0[i] + w.b_a * self.a0[i] + w.b_new * self.a[i]
        for i in range(begin, stop):
            self.a0[i] = self.a[i]
        begin = stop


cdef void accept(Motion *self) noexcept nogil:
    cdef ptrdiff_t i
    if self.system.n_amplitudes > 0:
        if not self.ahead:
            add_work(self)
        memcpy(self.amplitudes0, self.amplitudes, self.system.n_amplitudes * sizeof(double))
    in_parts(self.n_parts, accept_part, self)
    self.moved = self.ahead = False
    for i in range(self.m):
        self.lam0[i] = self.lam[i]


cdef void add_work(Motion *self) noexcept nogil:
    self.watch.work += self.system.load_work(
        self.system.context, self.q0, self.amplitudes0, self.q, self.amplitudes, self.r)


cdef void forward_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef Weights w = self.weights
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), i
    for i in range(begin, end):
        self.v0[i] += w.v_b * self.b0[i] + w.v_a * self.a0[i] + w.v_new * self.a[i]


cdef void backward_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef Weights w = self.weights
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), i
    for i in range(begin, end):
        self.v0[i] -= w.v_b * self.b0[i] + w.v_a * self.a0[i] + w.v_new * self.a[i]


cdef bint settle(Motion *self, const ancf_nonlinear *solver) noexcept nogil:
    """Look at the energy of a hard step before it is accepted; whether a solution passes.

    Such a step can have several.  One that gains energy is refused as long as there is another, or
    as steps can be made shorter.  The new velocity stands in the place of the old one while the
    energy is looked at, which needs no room.
    """
    cdef ancf_watch before = self.watch
    cdef bint strict
    while True:
        if self.system.n_amplitudes > 0:
            add_work(self)
        in_parts(self.n_parts, forward_part, self)
        strict = solver.doubtful[0]
        if not ancf_watch_gains(&self.watch, self.system, self.dead_load, self.q, self.v0, self.r,
                                strict):
            self.ahead = True
            return True
        in_parts(self.n_parts, backward_part, self)
        self.refused = self.watch
        if strict:
            self.refused.exchanged = self.watch.kinetic
        self.watch = before
        if self.control.seed != NULL or solver.again(solver.context, GAINED_ENERGY) != 0:
            return False


cdef bint accurate(Motion *self) noexcept nogil:
    """Estimate the error of the step just solved; say whether it is one that it may have.

    It is a constant times dt^2 and the change of the acceleration, which stiff modes that the step
    does not resolve would fill: ``S^-1 M``, S the matrix of the step, leaves slow modes alone and
    takes modes of dt omega >> 1 for what they are, and keeps what constraints allow.
    """
    cdef Control *c = &self.control
    cdef ptrdiff_t i
    cdef double total = 0.0
    for i in range(self.n_all):
        c.change[i] = self.a[i] - self.a0[i]
    self.system.inertia(self.system.context, c.change, self.r)
    for i in range(self.n_free):
        c.filtered[i] = self.r[i]
    for i in range(self.m):
        c.filtered[self.n_free + i] = 0.0
    c.seed.solve(c.seed.context, c.filtered, c.filtered)
    for i in range(self.n_free):
        total += c.weight[i] * c.filtered[i] * c.filtered[i]
    c.error = c.constant * self.dt * self.dt * sqrt(total)
    if c.error <= c.limit:
        return True
    c.calm = 0
    return False


cdef int follow(Motion *self) noexcept nogil:
    """Take the step just judged into the mean rate of the accelerations; say if steps may grow."""
    cdef Control *c = &self.control
    cdef ptrdiff_t i
    cdef double newest
    # Stiff modes change sides with every step: a mean over some steps leaves little of them.
    c.judged += 1
    newest = fmax(1.0 / c.judged, NEWEST)
    for i in range(self.n_all):
        c.jerk[i] += newest * (c.change[i] / self.dt - c.jerk[i])
    c.calm = c.calm + 1 if c.error <= c.easy else 0
    if c.calm < c.patience:
        return 0
    c.calm = 0
    return MAY_GROW


cdef bint gains_energy(Motion *self) noexcept nogil:
    return ancf_watch_gains(&self.watch, self.system, self.dead_load, self.q0, self.v0, self.r,
                            False)
