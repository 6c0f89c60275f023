# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The explicit time loop for Runge-Kutta-Nystrom methods whose last stage is the new state.

A step of s stages is

    Q_i = q + c_i h v + h^2 sum_{j < i} A_ij a_j,    a_i = M^-1 (f(t + c_i h) - Q(Q_i)),
    q_new = Q_s,  v_new = v + h sum_j b_j a_j,

and the last acceleration is the first one of the next step.  If forces depend on velocities, or if
there are constraints (held.pxi), stages have velocities too, V_i = v + h sum_{j < i} B_ij a_j.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer
from libc.math cimport INFINITY, fabs, isinf, sqrt
from libc.stdint cimport int32_t
from libc.stdlib cimport calloc, free
from libc.string cimport memcpy, memset

import numpy as np


cdef extern from "simd.h":
    const int LANES "ANCF_LANES"
    ctypedef double vec
    vec set1 "vec_set1" (double) noexcept nogil

include "../time_loop/energy_watch.pxi"
include "../../abi/outcome.pxi"
include "../../abi/signals.pxi"
include "../../abi/vectors.pxi"
include "../../system/assembly/arrays.pxi"
include "few_constraints.pxi"
include "many_constraints.pxi"
include "prescribed_coordinates.pxi"


REMEMBERED = ("rate", "bend", "size", "past")  # history of the loads

cdef ptrdiff_t LOOK_EVERY = 64  # evaluations of forces; one of the energy costs about two of them
# Relative pivot of G M^-1 G^T below which a constraint depends on the previous ones.
cdef double DEPENDENT = 1e-10
cdef double JUMP_SHARE = 0.5  # uncertain fraction of |jump| |motion| if a load jumps within a step


cdef class Explicit:
    """State of a system in time, advanced by an explicit method.

    Parameters
    ----------
    system : object with a ``capsule`` "ancf_system"
    seed : object with a ``capsule`` "ancf_seed"
        Inverse of the mass matrix, or of the matrix with the constraints.
    dt : float
        Time step [s].
    A : (s, s) float
        Strictly lower triangular; its last row gives the new position.
    b, c : (s,) float
        Weights of the velocity; times of the stages, from 0 to 1.
    B : (s, s) float or None
        Weights of the accelerations in the velocities of the stages; None where these are not
        needed.
    constraints : Constraints
        Equations enforced by multipliers; they must be independent.
    parts : sequence of objects with a ``capsule`` "ancf_contribution"
        What contributes to the system.
    sizes : (m,) float or None
        Magnitude of the terms of each equation, if the seed includes the constraints.
    q, v : (n_all,) float
        State at the start: free coordinates first, then fixed ones, the driven ones last.
    dead_load : (n_all,) float
        Constant applied force.
    inputs : (n_amplitudes + 3 n_driven + 3 n_led,) float
        At the start: changing loads; positions, velocities and accelerations of driven coordinates;
        what equations follow, its rates and second rates.
    n_driven, n_led : int
        Number of coordinates and of equations that are prescribed functions of time.
    largest_gain : float
        Largest energy gain, as a fraction of the energy exchanged so far.
    noise, rounding : float
        Energy due to rounding [J]; root of the energy of the errors in a step [J^(1/2)].
    """

    cdef const ancf_system *system
    cdef const ancf_seed *seed
    cdef ancf_watch watch
    cdef ancf_jumps jumps
    cdef Held held
    cdef Saddle saddle  # without equations where Held has them
    cdef Drives drives
    cdef ptrdiff_t n, n_all, stages, padded
    cdef double dt
    cdef double lifted, gained  # energy of the dead load in the present contacts, and of past ones [J]
    cdef double[::1] drift, kick, dead_load, load, r, none, phi, lam, change, rest
    cdef double[:, ::1] pull, swing, rate, history, histories, accelerations
    cdef bint swings  # whether stages have velocities
    # Two buffers for the state, current and next.
    cdef double[:, ::1] q, v
    cdef ptrdiff_t now, first  # buffer of the current state; row of `rate` with its acceleration
    cdef object owner
    cdef int trouble  # reason for a missing acceleration
    cdef readonly ptrdiff_t steps  # accepted so far
    cdef readonly bint finite  # whether there is an acceleration at the start

    def __cinit__(self, system, seed, double dt, A, b, c, B, constraints, parts, sizes, q, v,
                  dead_load, inputs, ptrdiff_t n_driven, ptrdiff_t n_led, double largest_gain, double noise,
                  double rounding):
        self.system = <const ancf_system *>PyCapsule_GetPointer(system.capsule, "ancf_system")
        self.seed = <const ancf_seed *>PyCapsule_GetPointer(seed.capsule, "ancf_seed")
        self.n, self.n_all, self.stages = self.system.n_free, self.system.n_all, len(b)
        # Loops run over whole SIMD vectors.  Entries after the free coordinates have neither
        # velocity nor acceleration, so they do not change.
        self.padded = (self.n + LANES - 1) // LANES * LANES
        width = max(self.n_all, self.padded)
        # The rates are M^-1 r = -a, with r as the system returns it; the coefficients carry the
        # sign.
        self.pull = -dt * dt * np.array(A, dtype=float)
        self.kick = -dt * np.array(b, dtype=float)
        self.drift = dt * np.array(c, dtype=float)
        self.swings = B is not None
        self.swing = -dt * np.array(B if self.swings else A, dtype=float)
        self.dead_load, self.r = np.array(dead_load, dtype=float), np.zeros(width)
        # Never empty, so that a pointer to the first input always exists.
        self.load = np.append(inputs, 0.0)
        self.dt, self.jumps.n = dt, self.system.n_amplitudes
        self.histories = np.empty((0, 0))
        self.history = np.zeros((5, self.jumps.n + 1))
        self.jumps.rate, self.jumps.bend = &self.history[0, 0], &self.history[1, 0]
        self.jumps.size, self.jumps.past = &self.history[2, 0], &self.history[3, 0]
        self.jumps.jump = &self.history[4, 0]
        np.asarray(self.history[2])[:self.jumps.n] = np.abs(inputs[:self.jumps.n])
        self.accelerations = np.zeros((3, self.n_all))
        self.drives.n, self.drives.base = n_driven, self.n_all - n_driven
        self.drives.column = self.system.n_amplitudes
        self.drives.given = &self.accelerations[0, 0]
        self.drives.moved, self.drives.inertia = &self.accelerations[1, 0], &self.accelerations[2, 0]
        places, speeds = np.zeros((2, width)), np.zeros((2, width))
        places[:, :self.n_all] = q
        speeds[0, :self.n] = v[:self.n]
        self.q, self.v, self.rate = places, speeds, np.zeros((self.stages, self.padded))
        self.lam, self.phi = np.zeros((2, max(len(constraints.offset), 1)))
        self.none = np.zeros(max(len(constraints.offset), 1))
        self.change, self.rest = np.zeros((2, width))
        if sizes is None:
            self.owner = (system, seed, set_held(
                &self.held, self.seed, self.n, constraints, &self.q[0, 0], &self.lam[0]))
        else:
            self.saddle.system, self.saddle.seed, self.saddle.n_led = self.system, self.seed, n_led
            self.saddle.phi, self.saddle.none = &self.phi[0], &self.none[0]
            self.saddle.lam = &self.lam[0]
            self.owner = (system, seed, parts, set_saddle(&self.saddle, constraints, parts, sizes))
        if self.system.begin != NULL:
            remember(self, self.system.begin)
        self.finite = self.look_again()
        self.watch.limit, self.watch.noise, self.watch.rounding = largest_gain, noise, rounding
        ancf_watch_start(&self.watch, self.system, &self.dead_load[0], &self.load[0],
                         &self.q[0, 0], &self.v[0, 0], &self.r[0])

    def __dealloc__(self):
        free(self.saddle.each)

    @property
    def state(self):
        """Last accepted ``(q, v, a, lam)`` as copies."""
        q = np.array(self.q[self.now, :self.n_all])
        v = np.array(self.v[self.now, :self.n_all])
        a = np.zeros(self.n_all)
        a[:self.n] = -np.asarray(self.rate[self.first, :self.n])
        first = self.drives.column + 2 * self.drives.n
        a[self.drives.base:] = self.load[first : first + self.drives.n]
        return q, v, a, np.array(self.lam[:self.system.n_multipliers])

    @property
    def memory(self):
        """Return the memory of the loop besides the state: energy watch, history of the loads."""
        out = {"watch": watch_memory(&self.watch), "amplitudes0": np.array(self.load)}
        out["power0"], out["lifted"], out["gained"] = self.drives.power0, self.lifted, self.gained
        for row, name in enumerate(REMEMBERED):
            out[name] = np.array(self.history[row])
        return out

    def recall(self, memory):
        """Restore the `memory` of a time loop that reached the current state."""
        recall_watch(&self.watch, memory["watch"])
        self.lifted, self.gained = memory.get("lifted", 0.0), memory.get("gained", 0.0)
        np.asarray(self.load)[:] = memory["amplitudes0"]
        for row, name in enumerate(REMEMBERED):
            np.asarray(self.history[row])[:] = memory[name]

    def move(self, q, v, a, lam, memory):
        """Return to a state, with its memory."""
        np.asarray(self.q[self.now])[:self.n_all] = q
        np.asarray(self.v[self.now])[:self.n_all] = v
        np.asarray(self.rate[self.first])[:self.n] = -a[:self.n]
        np.asarray(self.lam)[:len(lam)] = lam
        self.drives.power0 = memory["power0"]
        self.recall(memory)

    @property
    def energy_gain(self):
        """Energy gain, and the largest energy exchanged, at the last check [J]."""
        return self.watch.gain, self.watch.exchanged

    def save_history(self, double[:, ::1] rows):
        """Write history variables of the system to rows of this table, as `advance` does states."""
        self.histories = rows

    def advance(self, _nonlinear, ptrdiff_t n_steps, const double[:, ::1] inputs,
                ptrdiff_t save_every, ptrdiff_t steps_done, double[:, ::1] q_out,
                double[:, ::1] v_out, double[:, ::1] a_out, double[:, ::1] lam_out):
        """Take steps; return ``(steps taken, outcome)``, outcome 0 if all succeeded.

        Signals are handled between two steps, as in `TimeLoop.advance` (loop.pxi).

        Parameters
        ----------
        inputs : (n_steps * (s - 1), n_amplitudes + 3 n_driven + 3 n_led)
            Loads and prescribed motions at the stages of each step after its first.
        save_every, steps_done : int
            Step number k of the run (from 1) is written to row ``k / save_every`` of the outputs.
        """
        cdef ptrdiff_t k, i, j, row, last = self.stages - 1, next
        cdef ptrdiff_t look = max(1, LOOK_EVERY // last)
        cdef const double *load = NULL
        cdef double *acceleration
        cdef bint changes = inputs.shape[1] > 0
        cdef Drives *drives = &self.drives
        cdef double work
        cdef int outcome = 0
        cdef Signals signals = Signals(0, now())
        with nogil:
            set_step(self, -self.dt)  # which damps no impacts
            for k in range(n_steps):
                next, work = 1 - self.now, self.kick[0] * drives.power0
                for i in range(1, self.stages):
                    self.place(i, &self.q[next, 0])
                    if self.swings:
                        self.combine(&self.v[next, 0], &self.v[self.now, 0], &self.v[self.now, 0],
                                     0.0, &self.swing[i, 0], i)
                    if changes:
                        load = &inputs[k * last + i - 1, 0]
                    if not self.accelerate(i, next, load):
                        outcome = self.trouble
                    if self.system.add_impulses != NULL:
                        self.system.add_impulses(self.system.context, -self.kick[i])
                    work += self.kick[i] * drives.power
                if outcome:
                    break
                if self.saddle.m == 0:
                    self.combine(&self.v[next, 0], &self.v[self.now, 0], &self.v[self.now, 0], 0.0,
                                 &self.kick[0], self.stages)
                if drives.n + self.saddle.n_led > 0:
                    follow(drives, load, &self.q[next, 0], &self.v[next, 0])
                    self.watch.work -= work
                if self.system.add_impulses != NULL and not isinf(self.watch.limit):
                    remove_gain(self, next)
                if not dot(&self.v[next, 0], &self.v[next, 0], self.n) < INFINITY:
                    outcome = NOT_FINITE
                    break
                add_work(self, load, next)
                if changes:
                    memcpy(&self.load[0], load, inputs.shape[1] * sizeof(double))
                self.now, drives.power0 = next, drives.power
                self.first = (self.first + last) % self.stages
                if self.system.accept != NULL:
                    remember(self, self.system.accept)
                    if not self.look_again():
                        outcome = self.trouble
                if (steps_done + k + 1) % save_every == 0:
                    row = (steps_done + k + 1) // save_every
                    memcpy(&q_out[row, 0], &self.q[next, 0], self.n_all * sizeof(double))
                    memcpy(&v_out[row, 0], &self.v[next, 0], self.n_all * sizeof(double))
                    acceleration = self.stage(0)
                    for j in range(self.n):
                        a_out[row, j] = -acceleration[j]
                    for j in range(self.n, drives.base):
                        a_out[row, j] = 0.0
                    for j in range(drives.n):
                        a_out[row, drives.base + j] = load[drives.column + 2 * drives.n + j]
                    for j in range(self.system.n_multipliers):
                        lam_out[row, j] = self.lam[j]
                    if row < self.histories.shape[0]:
                        self.system.history(self.system.context, &self.histories[row, 0])
                self.steps += 1
                if outcome:
                    k += 1
                    break
                if (k + 1) % look == 0 or k + 1 == n_steps:
                    self.watch.errors += (k % look + 1) * self.watch.rounding
                    if self.watch.exchanged > ancf_watch_rounding(&self.watch):
                        self.watch.steps += k % look + 1
                    ancf_watch_measure(&self.watch, self.system, &self.dead_load[0], &self.load[0],
                                       &self.q[next, 0], &self.v[next, 0], &self.r[0])
                    if ancf_watch_stops(&self.watch):
                        outcome = GAINED_ENERGY
                        k += 1
                        break
                if due(&signals, self.n_all * self.stages):
                    with gil:
                        PyErr_CheckSignals()
            else:
                k = n_steps
            set_step(self, 0.0)
        return k, outcome

    def refresh(self):
        """Recompute the acceleration of the current state after a change of the system's memory."""
        self.finite = self.look_again()

    def accelerations_of(self, const double[:, ::1] q, const double[:, ::1] v,
                      const double[:, ::1] inputs, double[:, ::1] a_out, double[:, ::1] lam_out):
        """Set accelerations and multipliers of states between steps, by the forces there."""
        accelerations_at(self, q, v, inputs, a_out, lam_out)

    cdef inline bint look_again(self) noexcept nogil:
        cdef bint finite = self.accelerate(0, self.now, &self.load[0])
        self.drives.power0 = self.drives.power
        return finite

    cdef inline bint accelerate(self, ptrdiff_t i, ptrdiff_t place,
                                const double *load) noexcept nogil:
        """Set the acceleration of stage i; return whether that succeeded."""
        cdef double *q = &self.q[place, 0]
        cdef double *v = &self.v[place, 0]
        cdef double *rate = self.stage(i)
        cdef Drives *drives = &self.drives
        cdef const double *given = NULL
        cdef const double *led = load + drives.column + 3 * drives.n
        self.trouble = NOT_FINITE
        if drives.n > 0:
            follow(drives, load, q, v)
            given = drives.given
        if self.saddle.m > 0:
            if not self.balance(i, q, v, given, led, load, rate):
                return False
        else:
            self.forces(q, v, given, load)
            self.seed.solve(self.seed.context, &self.r[0], rate)
            if self.held.m > 0 and not hold(&self.held, q, v, given, rate):
                return False
        if drives.n + self.saddle.n_led > 0:
            drives.power = power_of_drives(drives, self.system, v, rate, &self.r[0])
            if self.saddle.m > 0:
                drives.power += saddle_power(&self.saddle, drives.base, q, v, led)
            else:
                drives.power += power_of_held(drives, &self.held, q, v)
        return True

    cdef bint balance(self, ptrdiff_t i, double *q, double *v, const double *given,
                      const double *led, const double *load, double *rate) noexcept nogil:
        """Set the acceleration of stage i; project positions and velocities at the last stage."""
        cdef Saddle *saddle = &self.saddle
        cdef bint ends = i == self.stages - 1
        cdef ptrdiff_t k
        if ends and not put_on(saddle, q, led):
            self.trouble = DIVERGED
            return False
        if not saddle_factor(saddle, q):
            return False
        if ends and self.swings:
            aim(saddle, q, v, NULL, 0.0, led)
        self.forces(q, v, given, load)
        if ends and not self.swings:
            self.combine(v, &self.v[self.now, 0], &self.v[self.now, 0], 0.0, &self.kick[0], i)
            for k in range(self.n):
                v[k] += saddle.moved[k] / self.dt
            if self.drives.n > 0:
                follow(&self.drives, load, q, v)
            aim(saddle, q, v, &self.r[0], -self.kick[i], led)
        saddle_accelerate(saddle, q, v, given, led, &self.r[0], rate)
        return True

    cdef inline void forces(self, const double *q, const double *v, const double *given,
                            const double *load) noexcept nogil:
        self.system.residual(self.system.context, q, v, given, &self.none[0], &self.dead_load[0],
                             load, &self.r[0], &self.phi[0])

    cdef inline double *stage(self, ptrdiff_t i) noexcept nogil:
        """Acceleration of stage i; the rows rotate by one per step: the last becomes the first."""
        return &self.rate[(self.first + i) % self.stages, 0]

    cdef inline void place(self, ptrdiff_t i, double *out) noexcept nogil:
        """Position of stage i."""
        self.combine(out, &self.q[self.now, 0], &self.v[self.now, 0], self.drift[i],
                     &self.pull[i, 0], i)

    cdef inline void combine(self, double *out, const double *base, const double *along,
                             double far, const double *weight, ptrdiff_t count) noexcept nogil:
        """``out = base + far along + sum of weight_j rate_j``, one pass for two rates."""
        cdef ptrdiff_t j = 0, k, step = self.padded // LANES
        cdef vec w0, w1
        cdef const vec *x
        cdef const vec *y
        cdef vec *z = <vec *>out
        x = <const vec *>base
        y = <const vec *>along
        w0 = set1(far)
        for k in range(step):
            z[k] = x[k] + w0 * y[k]
        while j < count:
            x = <const vec *>self.stage(j)
            y = <const vec *>self.stage(min(j + 1, count - 1))
            w0 = set1(weight[j])
            w1 = set1(weight[j + 1] if j + 1 < count else 0.0)
            for k in range(step):
                z[k] = z[k] + w0 * x[k] + w1 * y[k]
            j += 2


include "accepted_step.pxi"
include "accelerations_at_states.pxi"
