# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The time loop of the energy-momentum method: the midpoint rule with a discrete gradient.

    q1 - q0 = dt (v0 + v1) / 2,
    M (v1 - v0) / dt + DU(q0, q1) + Q_d(q_m, v_m) + phi_q(q_m)^T lam = f,   phi(q1) = 0,

m for the middle, DU . (q1 - q0) = U(q1) - U(q0).  The unknown is the mean acceleration
``a = (v1 - v0) / dt``, which moves ``q1`` by dt^2 / 2; rows and multipliers are scaled by that, as in
`_march.pyx`.  `integrators.conserving` says more.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.string cimport memcpy

import numpy as np


cdef extern from "parallel.h":
    void in_parts "ancf_in_parts" (
        ptrdiff_t, void (*)(void *, ptrdiff_t) noexcept nogil, void *) noexcept nogil

cdef extern from "vectors.h":
    double dot "vec_dot" (const double *, const double *, ptrdiff_t) noexcept nogil
    void vec_scale_parts(ptrdiff_t, double *, double, const double *, ptrdiff_t) noexcept nogil
    void vec_sum_parts(
        ptrdiff_t, double *, double, const double *, double, const double *,
        ptrdiff_t) noexcept nogil

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

cdef ptrdiff_t WATCH_EVERY = 16  # steps: an energy costs about one residual


cdef struct Motion:
    const ancf_system *system
    ptrdiff_t n_free, n_all, m, n_parts
    ptrdiff_t unwatched  # steps since the last look at the energy
    bint corrected  # whether the iterate is no longer the predictor
    double dt
    ancf_watch watch
    # Last accepted state and the means over its step; the iterate of the step under way.
    double *q0
    double *v0
    double *a0
    double *lam0
    double *before  # coordinates one step earlier
    double *q
    double *a
    double *lam
    double *middle  # between q0 and q
    double *v  # there, only if forces depend on it
    double *amplitudes0
    double *load  # mean of both ends
    double *values  # room for a matrix
    const double *dead_load
    const double *amplitudes
    double *r
    double *phi
    const double *s  # the correction under way, its factor, and the squares of each part
    double factor
    double *squares


cdef class Conserving:
    """State of a system in time, and the equations of its next step.

    Parameters
    ----------
    system : object with a ``capsule`` "ancf_system"
    dt : float
        Time step [s].
    integrator : EnergyMomentum
        It has no weights.
    q, v, a, b : (n_all,) float
        State at the start: free coordinates first, then fixed ones, which never move; ``b`` is
        of no use here.
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
    cdef object owner, arrays, loads  # the loads are pointed into until the next ones come
    cdef readonly object capsule

    def __cinit__(self, system, double dt, integrator, q, v, a, b, lam, dead_load, amplitudes,
                  double largest_gain, double noise):
        cdef Motion *motion = &self.motion
        self.owner = system
        motion.system = <const ancf_system *>PyCapsule_GetPointer(system.capsule, "ancf_system")
        motion.n_free, motion.n_all = motion.system.n_free, motion.system.n_all
        motion.m, motion.dt = motion.system.n_multipliers, dt
        # Never empty, so that a pointer to the first multiplier or amplitude always exists.
        lam, amplitudes = np.append(lam, 0.0), np.append(amplitudes, 0.0)
        self.arrays = {
            name: np.array(x, dtype=float) for name, x in {
                "q0": q, "v0": v, "a0": a, "lam0": lam, "q": q, "a": a, "lam": lam, "middle": q, "before": q,
                "v": v if motion.system.damped else [0.0], "amplitudes0": amplitudes,
                "load": amplitudes, "dead_load": dead_load, "r": np.zeros(len(q)),
                "phi": np.zeros(len(lam)), "values": np.zeros(motion.system.n_values + 1)}.items()}
        own = self.arrays
        self.set_threads(1)
        motion.q0, motion.v0, motion.a0 = first(own["q0"]), first(own["v0"]), first(own["a0"])
        motion.lam0, motion.middle, motion.v = (
            first(own["lam0"]), first(own["middle"]), first(own["v"]))
        motion.before = first(own["before"])
        motion.q, motion.a, motion.lam = first(own["q"]), first(own["a"]), first(own["lam"])
        motion.dead_load, motion.r = first(own["dead_load"]), first(own["r"])
        motion.phi, motion.values = first(own["phi"]), first(own["values"])
        motion.amplitudes0, motion.load = first(own["amplitudes0"]), first(own["load"])
        self.interface.context = motion
        self.interface.n, self.interface.n_coordinates = motion.n_free + motion.m, motion.n_free
        self.interface.n_values = motion.system.n_values
        self.interface.restart, self.interface.coast = restart, coast
        self.interface.correct = correct
        self.interface.residual, self.interface.matrix = residual, matrix
        if motion.system.material != NULL:
            self.interface.material = material
        self.interface.q = motion.middle
        self.capsule = PyCapsule_New(&self.interface, "ancf_equations", NULL)
        motion.watch.limit, motion.watch.noise = largest_gain, noise
        ancf_watch_start(&motion.watch, motion.system, motion.dead_load, motion.q0, motion.v0,
                         motion.r)

    def change_step(self, double dt, integrator, change_b, change_v):
        """Go on with another step: a step knows nothing of the one before but q and v."""
        self.motion.dt = dt
        self.arrays["v0"] += change_v

    def set_threads(self, ptrdiff_t threads):
        """Set the number of threads for passes over vectors."""
        self.motion.n_parts = threads
        self.arrays["squares"] = np.zeros(threads)
        self.motion.squares = first(self.arrays["squares"])

    @property
    def state(self):
        """Last accepted ``(q, v)`` and means ``(a, lam)`` over its step, as copies."""
        own = self.arrays
        q, v, a, lam = (own[name].copy() for name in ("q0", "v0", "a0", "lam0"))
        return q, v, a, lam[: self.motion.m]

    @property
    def unbalanced(self):
        """Residual ``(n_all,)`` [N, N m] and constraints ``(m,)`` [m] of the last iterate."""
        evaluate(&self.motion)
        return self.arrays["r"].copy(), self.arrays["phi"][: self.motion.m].copy()

    @property
    def energy_gain(self):
        """Energy above what was given, and the largest energy exchanged, at the last look [J]."""
        return self.motion.watch.gain, self.motion.watch.exchanged

    def gains_energy(self):
        """Whether the energy is now too far above what was given: the last look of a run."""
        return bool(gains_energy(&self.motion))

    def prepare(self, const double[:, ::1] amplitudes):
        """Set the loads of the next step and put its predictor in place."""
        self.loads = amplitudes
        set_load(&self.motion, &amplitudes[0, 0] if amplitudes.shape[1] > 0 else NULL)
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
        cdef ptrdiff_t k, row
        cdef int outcome = 0
        self.loads = amplitudes
        with nogil:
            for k in range(n_steps):
                set_load(motion, &amplitudes[k, 0] if amplitudes.shape[1] > 0 else NULL)
                restart(motion)
                outcome = solver.solve(solver.context)
                if outcome != 0:
                    break
                accept(motion)
                if (steps_done + k + 1) % save_every == 0:
                    row = (steps_done + k + 1) // save_every
                    memcpy(&q_out[row, 0], motion.q0, motion.n_all * sizeof(double))
                    memcpy(&v_out[row, 0], motion.v0, motion.n_all * sizeof(double))
                    memcpy(&a_out[row, 0], motion.a0, motion.n_all * sizeof(double))
                    if motion.m > 0:
                        memcpy(&lam_out[row, 0], motion.lam0, motion.m * sizeof(double))
                motion.unwatched += 1
                if motion.unwatched >= WATCH_EVERY:
                    motion.unwatched = 0
                    if gains_energy(motion):
                        outcome = GAINED_ENERGY
                        k += 1
                        break
            else:
                k = n_steps
        return k, outcome


cdef double *first(array) except NULL:
    cdef double[::1] view = array
    return &view[0]


cdef void set_load(Motion *self, const double *amplitudes) noexcept nogil:
    """The loads at the end of the step, and their mean over it."""
    cdef ptrdiff_t i
    self.amplitudes = amplitudes
    for i in range(self.system.n_amplitudes):
        self.load[i] = 0.5 * (self.amplitudes0[i] + amplitudes[i])


cdef inline ptrdiff_t share(const Motion *self, ptrdiff_t part) noexcept nogil:
    """Where the share of a part begins among the free coordinates: whole cache lines for each."""
    if part == self.n_parts:
        return self.n_free
    return self.n_free // 8 * part // self.n_parts * 8


cdef void restart_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), i
    cdef double dt = self.dt, half
    for i in range(begin, end):
        half = 0.5 * dt * (self.v0[i] + 0.5 * dt * self.a0[i])
        self.middle[i] = self.q0[i] + half
        self.q[i] = self.q0[i] + 2.0 * half
        self.a[i] = self.a0[i]
    if self.system.damped:
        for i in range(begin, end):
            self.v[i] = self.v0[i] + 0.5 * dt * self.a0[i]


cdef void restart(void *context) noexcept nogil:
    """The predictor: the mean acceleration and the multipliers of the last step."""
    cdef Motion *self = <Motion *>context
    in_parts(self.n_parts, restart_part, self)
    memcpy(self.lam, self.lam0, self.m * sizeof(double))
    self.corrected = False


cdef void coast_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), i
    cdef double dt = self.dt
    for i in range(begin, end):
        self.middle[i] = self.q0[i] + 0.5 * dt * self.v0[i]
        self.q[i] = self.q0[i] + dt * self.v0[i]
        self.a[i] = 0.0
    if self.system.damped:
        for i in range(begin, end):
            self.v[i] = self.v0[i]


cdef void coast(void *context) noexcept nogil:
    """Another start: no acceleration."""
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
        self.middle[i] += 0.5 * factor * s[i]
        self.a[i] += of_a * s[i]
    if self.system.damped:
        for i in range(begin, end):
            self.v[i] += of_v * s[i]
    self.squares[part] = factor * factor * dot(s + begin, s + begin, end - begin)


cdef double correct(void *context, double factor, const double *s) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t i
    cdef double total = 0.0
    self.s, self.factor, self.corrected = s, factor, True
    in_parts(self.n_parts, correct_part, self)
    for i in range(self.m):
        self.lam[i] += 2.0 * factor / (self.dt * self.dt) * s[self.n_free + i]
    for i in range(self.n_parts):
        total += self.squares[i]
    return total


cdef void evaluate(Motion *self) noexcept nogil:
    self.system.residual_between(
        self.system.context, self.q0, self.q, self.middle, self.v, self.a, self.lam,
        self.dead_load, self.load, self.r, self.phi)


cdef void residual(void *context, double *r) noexcept nogil:
    cdef Motion *self = <Motion *>context
    evaluate(self)
    vec_scale_parts(self.n_parts, r, 0.5 * self.dt * self.dt, self.r, self.n_free)
    memcpy(r + self.n_free, self.phi, self.m * sizeof(double))


cdef void matrix(void *context, double *values) noexcept nogil:
    """The material part of the stiffness in the middle, and the mean of what stresses add to it.

    In the middle a body that turns is shorter than at both ends, by stresses that nobody feels but
    which would make the tangent there indefinite.  Nor are stresses of the predictor to be believed;
    those of the last step stand for them, whose mean is also one over two ends: stresses that a
    step does not resolve change sides in each.  What is left out is not symmetric.
    """
    cdef Motion *self = <Motion *>context
    cdef const ancf_system *system = self.system
    cdef double stiffness = 0.25 * self.dt * self.dt, damping = 0.5 * self.dt
    cdef const double *other = self.q if self.corrected else self.before
    if system.material == NULL:
        system.matrix(system.context, 1.0, stiffness, damping, self.middle, self.v, self.lam,
                      self.load, values)
        return
    system.matrix(system.context, 1.0, 0.5 * stiffness, damping, self.q0, self.v, self.lam,
                  self.load, values)
    system.matrix(system.context, 0.0, 0.5 * stiffness, 0.0, other, self.v, self.lam, self.load,
                  self.values)
    add_values(self, 1.0, values)
    system.material(system.context, 0.0, 0.5 * stiffness, 0.0, self.q0, self.values)
    add_values(self, -1.0, values)
    system.material(system.context, 0.0, 0.5 * stiffness, 0.0, other, self.values)
    add_values(self, -1.0, values)
    system.material(system.context, 0.0, stiffness, 0.0, self.middle, self.values)
    add_values(self, 1.0, values)


cdef void add_values(Motion *self, double factor, double *values) noexcept nogil:
    vec_sum_parts(self.n_parts, values, 1.0, values, factor, self.values, self.system.n_values)


cdef void material(void *context, double *values) noexcept nogil:
    cdef Motion *self = <Motion *>context
    self.system.material(self.system.context, 1.0, 0.25 * self.dt * self.dt, 0.5 * self.dt,
                         self.middle, values)


cdef void accept_part(void *context, ptrdiff_t part) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t begin = share(self, part), end = share(self, part + 1), i
    cdef double dt = self.dt
    for i in range(begin, end):
        self.before[i] = self.q0[i]
        self.q0[i] = self.q[i]
        self.v0[i] += dt * self.a[i]
        self.a0[i] = self.a[i]


cdef void accept(Motion *self) noexcept nogil:
    if self.system.n_amplitudes > 0:
        self.watch.work += self.system.load_work(
            self.system.context, self.q0, self.amplitudes0, self.q, self.amplitudes, self.r)
        memcpy(self.amplitudes0, self.amplitudes, self.system.n_amplitudes * sizeof(double))
    in_parts(self.n_parts, accept_part, self)
    memcpy(self.lam0, self.lam, self.m * sizeof(double))


cdef bint gains_energy(Motion *self) noexcept nogil:
    return ancf_watch_gains(&self.watch, self.system, self.dead_load, self.q0, self.v0, self.r,
                            False)
