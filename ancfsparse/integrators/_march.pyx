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

    ctypedef struct ancf_nonlinear:
        void *context
        int (*solve)(void *) noexcept nogil


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
    cdef const ancf_system *system
    cdef ptrdiff_t n_free, n_all, m
    cdef double dt, beta, gamma, scale
    # Last accepted state, and the iterate of the step under way.
    cdef double[::1] q0, v0, a0, lam0, q, a, lam, dead_load, r, phi
    cdef const double *amplitudes
    cdef readonly object capsule, owner

    def __cinit__(self, system, double dt, double beta, double gamma, q, v, a, lam, dead_load):
        self.owner = system
        self.system = <const ancf_system *>PyCapsule_GetPointer(system.capsule, "ancf_system")
        self.n_free, self.n_all = self.system.n_free, self.system.n_all
        self.m = self.system.n_multipliers
        self.dt, self.beta, self.gamma, self.scale = dt, beta, gamma, beta * dt * dt
        self.q0, self.v0, self.a0 = (np.array(x, dtype=float) for x in (q, v, a))
        # Never empty, so that a pointer to the first multiplier always exists.
        self.lam0 = np.zeros(max(self.m, 1))
        self.lam0[: self.m] = np.asarray(lam, dtype=float)
        self.q, self.a, self.lam = np.array(self.q0), np.array(self.a0), np.array(self.lam0)
        self.dead_load = np.array(dead_load, dtype=float)
        self.r, self.phi = np.zeros(self.n_all), np.zeros(max(self.m, 1))
        self.interface.context = <void *>self
        self.interface.n, self.interface.n_coordinates = self.n_free + self.m, self.n_free
        self.interface.n_values = self.system.n_values
        self.interface.restart, self.interface.correct = restart, correct
        self.interface.residual, self.interface.matrix = residual, matrix
        self.capsule = PyCapsule_New(&self.interface, "ancf_equations", NULL)

    @property
    def state(self):
        """Last accepted ``(q, v, a, lam)`` as copies."""
        return (np.array(self.q0), np.array(self.v0), np.array(self.a0),
                np.array(self.lam0)[: self.m])

    @property
    def unbalanced(self):
        """Residual ``(n_all,)`` [N, N m] and constraints ``(m,)`` [m] of the last iterate."""
        return np.array(self.r), np.array(self.phi)[: self.m]

    def prepare(self, const double[:, ::1] amplitudes):
        """Set the loads of the next step and put its predictor in place."""
        self.amplitudes = &amplitudes[0, 0] if amplitudes.shape[1] > 0 else NULL
        restart(<void *>self)

    def residual(self):
        """Return the scaled residual ``(n,)`` at the present iterate."""
        out = np.empty(self.interface.n)
        cdef double[::1] view = out
        residual(<void *>self, &view[0])
        return out

    def correct(self, const double[::1] s):
        """Add a correction ``(n,)`` to the present iterate."""
        correct(<void *>self, &s[0])

    def matrix(self):
        """Return the values of the scaled iteration matrix at the present iterate."""
        out = np.empty(self.interface.n_values + 1)
        cdef double[::1] view = out
        matrix(<void *>self, &view[0])
        return out[:-1]

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
        cdef ptrdiff_t k, i, row
        cdef int outcome = 0
        cdef double keep = self.dt * (1.0 - self.gamma), gain = self.dt * self.gamma
        with nogil:
            for k in range(n_steps):
                self.amplitudes = &amplitudes[k, 0] if amplitudes.shape[1] > 0 else NULL
                restart(<void *>self)
                outcome = solver.solve(solver.context)
                if outcome != 0:
                    break
                for i in range(self.n_free):
                    self.v0[i] += keep * self.a0[i] + gain * self.a[i]
                    self.q0[i] = self.q[i]
                    self.a0[i] = self.a[i]
                for i in range(self.m):
                    self.lam0[i] = self.lam[i]
                if (steps_done + k + 1) % save_every == 0:
                    row = (steps_done + k + 1) // save_every
                    memcpy(&q_out[row, 0], &self.q0[0], self.n_all * sizeof(double))
                    memcpy(&v_out[row, 0], &self.v0[0], self.n_all * sizeof(double))
                    memcpy(&a_out[row, 0], &self.a0[0], self.n_all * sizeof(double))
                    if self.m > 0:
                        memcpy(&lam_out[row, 0], &self.lam0[0], self.m * sizeof(double))
            else:
                k = n_steps
        return k, outcome


cdef void restart(void *context) noexcept nogil:
    """The predictor: the acceleration and the multipliers of the last step (equation 4)."""
    cdef March self = <March>context
    cdef ptrdiff_t i
    cdef double half = 0.5 * self.dt * self.dt
    for i in range(self.n_free):
        self.q[i] = self.q0[i] + self.dt * self.v0[i] + half * self.a0[i]
        self.a[i] = self.a0[i]
    for i in range(self.m):
        self.lam[i] = self.lam0[i]


cdef void correct(void *context, const double *s) noexcept nogil:
    """Equation 10; the velocity follows once, when the step is accepted."""
    cdef March self = <March>context
    cdef ptrdiff_t i
    cdef double factor = 1.0 / self.scale
    for i in range(self.n_free):
        self.q[i] += s[i]
        self.a[i] += factor * s[i]
    for i in range(self.m):
        self.lam[i] += factor * s[self.n_free + i]


cdef void residual(void *context, double *r) noexcept nogil:
    cdef March self = <March>context
    cdef ptrdiff_t i
    self.system.residual(self.system.context, &self.q[0], &self.a[0], &self.lam[0],
                         &self.dead_load[0], self.amplitudes, &self.r[0], &self.phi[0])
    for i in range(self.n_free):
        r[i] = self.scale * self.r[i]
    for i in range(self.m):
        r[self.n_free + i] = self.phi[i]


cdef void matrix(void *context, double *values) noexcept nogil:
    cdef March self = <March>context
    self.system.matrix(self.system.context, 1.0, self.scale, &self.q[0], &self.lam[0],
                       self.amplitudes, values)
