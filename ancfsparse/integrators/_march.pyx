# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The time loop: Newmark's formulas in the paper's incremental form (equations 4 to 10).

The dynamic rows are multiplied by beta dt^2 and the multipliers divided by it, so the matrix of a
step, ``[M + beta dt^2 K, phi_q^T; phi_q, 0]``, does not degrade as dt goes to zero.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.string cimport memcpy

import numpy as np


cdef extern from "solver_abi.h":
    ctypedef struct ancf_system:
        void *context
        ptrdiff_t n_free, n_all, n_multipliers, n_values
        void (*residual)(void *, const double *, const double *, const double *, const double *,
                         const double *, double *, double *) noexcept nogil
        void (*matrix)(void *, double, double, const double *, const double *, const double *,
                       double *) noexcept nogil

    ctypedef struct ancf_equations:
        void *context
        ptrdiff_t n, n_coordinates, n_values
        void (*restart)(void *) noexcept nogil
        void (*correct)(void *, const double *) noexcept nogil
        void (*residual)(void *, double *) noexcept nogil
        void (*matrix)(void *, double *) noexcept nogil
        const double *q

    ctypedef struct ancf_nonlinear:
        void *context
        int (*solve)(void *) noexcept nogil


cdef struct Motion:
    const ancf_system *system
    ptrdiff_t n_free, n_all, m
    double dt, gamma, scale
    # Last accepted state, and the iterate of the step under way.
    double *q0
    double *v0
    double *a0
    double *lam0
    double *q
    double *a
    double *lam
    const double *dead_load
    const double *amplitudes
    double *r
    double *phi


cdef class March:
    """State of a system in time, and the equations of its next step.

    Parameters
    ----------
    system : object with a ``capsule`` "ancf_system"
    dt : float
        Time step [s].
    beta, gamma : float
        Newmark's parameters.
    q, v, a : (n_all,) float
        State at the start: free coordinates first, then fixed ones, which never move.
    lam : (m,) float
        Multipliers at the start.
    dead_load : (n_all,) float
        Constant applied force.
    """

    cdef ancf_equations interface
    cdef Motion motion
    cdef object owner, arrays, loads  # the loads are pointed into until the next ones come
    cdef readonly object capsule

    def __cinit__(self, system, double dt, double beta, double gamma, q, v, a, lam, dead_load):
        cdef Motion *motion = &self.motion
        cdef double[::1] view
        cdef double *start[10]
        self.owner = system
        motion.system = <const ancf_system *>PyCapsule_GetPointer(system.capsule, "ancf_system")
        motion.n_free, motion.n_all = motion.system.n_free, motion.system.n_all
        motion.m = motion.system.n_multipliers
        motion.dt, motion.gamma, motion.scale = dt, gamma, beta * dt * dt
        # Never empty, so that a pointer to the first multiplier always exists.
        lam = np.append(lam, 0.0)
        self.arrays = [np.array(x, dtype=float) for x in (
            q, v, a, lam, q, a, lam, dead_load, np.zeros(len(q)), np.zeros(len(lam)))]
        for k, array in enumerate(self.arrays):
            view = array
            start[k] = &view[0]
        motion.q0, motion.v0, motion.a0, motion.lam0 = start[0], start[1], start[2], start[3]
        motion.q, motion.a, motion.lam = start[4], start[5], start[6]
        motion.dead_load, motion.r, motion.phi = start[7], start[8], start[9]
        self.interface.context = motion
        self.interface.n, self.interface.n_coordinates = motion.n_free + motion.m, motion.n_free
        self.interface.n_values = motion.system.n_values
        self.interface.restart, self.interface.correct = restart, correct
        self.interface.residual, self.interface.matrix = residual, matrix
        self.interface.q = motion.q
        self.capsule = PyCapsule_New(&self.interface, "ancf_equations", NULL)

    @property
    def state(self):
        """Last accepted ``(q, v, a, lam)`` as copies."""
        q, v, a, lam = (array.copy() for array in self.arrays[:4])
        return q, v, a, lam[: self.motion.m]

    @property
    def unbalanced(self):
        """Residual ``(n_all,)`` [N, N m] and constraints ``(m,)`` [m] of the last iterate."""
        return self.arrays[8].copy(), self.arrays[9][: self.motion.m].copy()

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
        correct(&self.motion, &s[0])

    def matrix(self):
        """Return the values of the scaled iteration matrix at the present iterate."""
        out = np.empty(self.interface.n_values + 1)
        cdef double[::1] view = out
        matrix(&self.motion, &view[0])
        return out[: self.interface.n_values]

    def advance(self, nonlinear, ptrdiff_t n_steps, const double[:, ::1] amplitudes,
                ptrdiff_t save_every, ptrdiff_t steps_done, double[:, ::1] q_out,
                double[:, ::1] v_out, double[:, ::1] a_out, double[:, ::1] lam_out):
        """Take steps; return ``(steps taken, outcome)``, outcome 0 if all of them converged.

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
        cdef ptrdiff_t k, i, row
        cdef int outcome = 0
        self.loads = amplitudes
        cdef double keep = motion.dt * (1.0 - motion.gamma), gain = motion.dt * motion.gamma
        with nogil:
            for k in range(n_steps):
                motion.amplitudes = &amplitudes[k, 0] if amplitudes.shape[1] > 0 else NULL
                restart(&self.motion)
                outcome = solver.solve(solver.context)
                if outcome != 0:
                    break
                for i in range(motion.n_free):
                    motion.v0[i] += keep * motion.a0[i] + gain * motion.a[i]
                    motion.q0[i] = motion.q[i]
                    motion.a0[i] = motion.a[i]
                for i in range(motion.m):
                    motion.lam0[i] = motion.lam[i]
                if (steps_done + k + 1) % save_every == 0:
                    row = (steps_done + k + 1) // save_every
                    memcpy(&q_out[row, 0], motion.q0, motion.n_all * sizeof(double))
                    memcpy(&v_out[row, 0], motion.v0, motion.n_all * sizeof(double))
                    memcpy(&a_out[row, 0], motion.a0, motion.n_all * sizeof(double))
                    if motion.m > 0:
                        memcpy(&lam_out[row, 0], motion.lam0, motion.m * sizeof(double))
            else:
                k = n_steps
        return k, outcome


cdef void restart(void *context) noexcept nogil:
    """The predictor: the acceleration and the multipliers of the last step (equation 4)."""
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t i
    cdef double half = 0.5 * self.dt * self.dt
    for i in range(self.n_free):
        self.q[i] = self.q0[i] + self.dt * self.v0[i] + half * self.a0[i]
        self.a[i] = self.a0[i]
    for i in range(self.m):
        self.lam[i] = self.lam0[i]


cdef void correct(void *context, const double *s) noexcept nogil:
    """Equation 10; the velocity follows once, when the step is accepted."""
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t i
    cdef double factor = 1.0 / self.scale
    for i in range(self.n_free):
        self.q[i] += s[i]
        self.a[i] += factor * s[i]
    for i in range(self.m):
        self.lam[i] += factor * s[self.n_free + i]


cdef void residual(void *context, double *r) noexcept nogil:
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t i
    self.system.residual(self.system.context, self.q, self.a, self.lam,
                         self.dead_load, self.amplitudes, self.r, self.phi)
    for i in range(self.n_free):
        r[i] = self.scale * self.r[i]
    for i in range(self.m):
        r[self.n_free + i] = self.phi[i]


cdef void matrix(void *context, double *values) noexcept nogil:
    cdef Motion *self = <Motion *>context
    self.system.matrix(self.system.context, 1.0, self.scale, self.q, self.lam,
                       self.amplitudes, values)
