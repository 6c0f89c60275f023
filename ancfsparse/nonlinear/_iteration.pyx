# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""One loop for Newton, modified Newton and quasi-Newton, with the rules for new seeds and recovery.

It sees equations as four functions (restart, correct, residual, matrix) and knows no mechanics.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.math cimport fabs, fmax, isfinite, log, sqrt
from libc.string cimport memcpy

import numpy as np


cdef extern from "solver_abi.h":
    ctypedef struct ancf_seed:
        void *context
        ptrdiff_t n
        ptrdiff_t (*factor)(void *, const double *) noexcept nogil
        void (*solve)(void *, const double *, double *) noexcept nogil

    ctypedef struct ancf_equations:
        void *context
        ptrdiff_t n, n_coordinates, n_values
        void (*restart)(void *) noexcept nogil
        void (*correct)(void *, const double *) noexcept nogil
        void (*residual)(void *, double *) noexcept nogil
        void (*matrix)(void *, double *) noexcept nogil

    ctypedef struct ancf_inverse:
        void *context
        ptrdiff_t n
        int (*reseed)(void *) noexcept nogil
        void (*forget)(void *) noexcept nogil
        void (*apply)(void *, const double *, double *) noexcept nogil
        int (*learn)(void *, const double *, const double *, const double *, double *) noexcept nogil

    ctypedef struct ancf_nonlinear:
        void *context
        int (*solve)(void *) noexcept nogil


cdef enum:
    CONVERGED = 0
    TOO_MANY = 1
    DIVERGED = 2
    NOT_FINITE = 3
    SINGULAR = 4

cdef double GROWTH = 1e4  # residual beside the predictor's: past this an attempt is given up
cdef double SLOW = 0.9  # a contraction from which waiting never pays


cdef class Iteration:
    """Solve one set of nonlinear equations after another, reusing seed and pairs between them.

    Attributes
    ----------
    iterations, residual_evaluations, factorizations, skipped_pairs : int
        Counts since construction.
    reseeds_between, reseeds_inside : int
        Why factorisations of quasi-Newton runs were made.
    recoveries_reseed, recoveries_newton : int
        Steps that needed that rung of the ladder.
    indefinite : int
        Factorisations that had a pivot of the wrong sign.
    """

    cdef ancf_nonlinear interface
    cdef const ancf_equations *equations
    cdef const ancf_seed *seed
    cdef const ancf_inverse *inverse
    cdef ptrdiff_t n
    cdef bint newton, carry, economical, learn_last, by_correction
    cdef bint seeded, reseed_due
    cdef int max_iterations
    cdef double force_tolerance, constraint_tolerance, correction_tolerance, noise
    cdef double cost_iteration, cost_seed
    # Bookkeeping of the re-seed rule: cost and steps since the last seed.
    cdef double cost_since, rate
    cdef ptrdiff_t steps_since
    cdef double[::1] r, r_new, s, y, z, values
    cdef readonly ptrdiff_t iterations, residual_evaluations, factorizations, skipped_pairs
    cdef readonly ptrdiff_t solves, reseeds_between, reseeds_inside
    cdef readonly ptrdiff_t recoveries_reseed, recoveries_newton, indefinite
    cdef readonly double contraction
    cdef readonly object capsule, owners

    def __cinit__(self, equations, seed, inverse, *, bint newton, bint carry, bint economical,
                  bint by_correction, int max_iterations, double force_tolerance,
                  double constraint_tolerance, double correction_tolerance, double noise,
                  double cost_iteration, double cost_seed):
        self.owners = (equations, seed, inverse)
        self.equations = <const ancf_equations *>PyCapsule_GetPointer(
            equations.capsule, "ancf_equations")
        self.seed = <const ancf_seed *>PyCapsule_GetPointer(seed.capsule, "ancf_seed")
        self.inverse = <const ancf_inverse *>PyCapsule_GetPointer(inverse.capsule, "ancf_inverse")
        self.n = self.equations.n
        self.newton, self.carry, self.economical = newton, carry, economical
        self.by_correction, self.max_iterations = by_correction, max_iterations
        self.force_tolerance, self.constraint_tolerance = force_tolerance, constraint_tolerance
        self.correction_tolerance, self.noise = correction_tolerance, noise
        self.cost_iteration, self.cost_seed = cost_iteration, cost_seed
        self.rate = SLOW
        self.r, self.r_new, self.s = np.zeros(self.n), np.zeros(self.n), np.zeros(self.n)
        self.y, self.z = np.zeros(self.n), np.zeros(self.n)
        self.values = np.zeros(self.equations.n_values + 1)
        self.interface.context, self.interface.solve = <void *>self, solve
        self.capsule = PyCapsule_New(&self.interface, "ancf_nonlinear", NULL)

    def mark_seeded(self):
        """Tell that the inverse was filled from outside (a finite-difference matrix)."""
        self.seeded = True

    def solve(self):
        """Solve the equations from their predictor; return 0 or a reason (`nonlinear.outcome`)."""
        self.equations.restart(self.equations.context)
        return solve(<void *>self)


cdef double largest(const double *x, ptrdiff_t n) noexcept nogil:
    # A NaN must win: `not (a <= m)` lets it in and keeps it.
    cdef double m = 0.0
    cdef ptrdiff_t i
    for i in range(n):
        if not fabs(x[i]) <= m:
            m = fabs(x[i])
            if m != m:
                return m
    return m


cdef double length(const double *x, ptrdiff_t n) noexcept nogil:
    cdef double total = 0.0
    cdef ptrdiff_t i
    for i in range(n):
        total += x[i] * x[i]
    return sqrt(total / n)


cdef int renew_seed(Iteration self) noexcept nogil:
    """Factor the matrix at the current iterate; a wrong pivot sign is counted, a zero pivot fails."""
    cdef ptrdiff_t bad
    self.equations.matrix(self.equations.context, &self.values[0])
    bad = self.seed.factor(self.seed.context, &self.values[0])
    self.factorizations += 1
    if bad != 0:
        self.indefinite += 1
    self.solves += self.inverse.reseed(self.inverse.context)
    self.seeded, self.reseed_due = True, False
    self.rate = SLOW
    self.cost_since, self.steps_since = self.cost_seed, 0
    return CONVERGED


cdef bint residual_is_small(Iteration self, const double *r) noexcept nogil:
    cdef ptrdiff_t nq = self.equations.n_coordinates
    return (largest(r, nq) < self.force_tolerance
            and (self.n == nq or largest(r + nq, self.n - nq) < self.constraint_tolerance))


cdef bint correction_is_small(Iteration self, double size) noexcept nogil:
    return self.rate / (1.0 - self.rate) * size <= self.correction_tolerance


cdef bint waiting_costs_more(Iteration self, double progress, double remaining) noexcept nogil:
    """Whether a new seed now is cheaper than the corrections still needed at this contraction."""
    if progress >= SLOW:
        return True
    return (log(remaining) / -log(progress) * self.cost_iteration
            > self.cost_seed + 2.0 * self.cost_iteration)


cdef int attempt(Iteration self, bint newton, bint damped, int *used) noexcept nogil:
    """Iterate from the predictor; return CONVERGED or the reason why not."""
    cdef const ancf_equations *eq = self.equations
    cdef const ancf_inverse *inverse = self.inverse
    cdef double *r = &self.r[0]
    cdef double *r_new = &self.r_new[0]
    cdef double *s = &self.s[0]
    cdef double *y = &self.y[0]
    cdef double *z = &self.z[0]
    cdef double *swap
    cdef ptrdiff_t n = self.n, i
    cdef int it, halvings
    cdef double size, last_size = 0.0, norm, norm_new, start, theta, last_theta = 0.0, remaining
    cdef double target
    eq.residual(eq.context, r)
    self.residual_evaluations += 1
    norm = start = length(r, n)
    if not isfinite(norm):
        return NOT_FINITE
    if residual_is_small(self, r) and not self.by_correction:
        return CONVERGED
    if newton or not self.seeded or self.reseed_due:
        renew_seed(self)
    elif not self.carry:
        inverse.forget(inverse.context)
    inverse.apply(inverse.context, r, z)
    self.solves += 1
    for it in range(self.max_iterations):
        for i in range(n):
            s[i] = -z[i]
        eq.correct(eq.context, s)
        used[0] += 1
        self.iterations += 1
        size = length(s, eq.n_coordinates)
        if it > 0 and last_size > 0.0:
            self.contraction = size / last_size
            self.rate = fmax(0.3 * self.rate, self.contraction) if it > 1 else self.contraction
            if self.rate > 0.99:
                self.rate = 0.99
        last_size = size
        if (self.by_correction and n == eq.n_coordinates and not damped
                and (correction_is_small(self, size) or size < self.noise)):
            return CONVERGED
        eq.residual(eq.context, r_new)
        self.residual_evaluations += 1
        norm_new = length(r_new, n)
        if damped:
            # Halve a step that makes the residual larger; the last try is kept whatever it does.
            halvings = 0
            while not norm_new <= norm and halvings < 6:
                halvings += 1
                for i in range(n):
                    s[i] *= -0.5
                eq.correct(eq.context, s)
                for i in range(n):
                    s[i] = -s[i]
                eq.residual(eq.context, r_new)
                self.residual_evaluations += 1
                norm_new = length(r_new, n)
        if not isfinite(norm_new):
            return NOT_FINITE
        for i in range(n):
            y[i] = r_new[i] - r[i]
        if self.by_correction:
            if (n > eq.n_coordinates and (correction_is_small(self, size) or size < self.noise)
                    and largest(r_new + eq.n_coordinates, n - eq.n_coordinates)
                    < self.constraint_tolerance):
                return CONVERGED
        elif residual_is_small(self, r_new):
            if self.carry and not newton:
                self.skipped_pairs += 1 - inverse.learn(inverse.context, s, y, r_new, z)
                self.solves += 1
            return CONVERGED
        if norm_new > GROWTH * start and it > 0 and not damped:
            return DIVERGED
        theta = norm_new / norm
        swap = r
        r = r_new
        r_new = swap
        norm = norm_new
        if newton:
            renew_seed(self)
            inverse.apply(inverse.context, r, z)
            self.solves += 1
            continue
        if self.economical and (it > 0 or theta > 0.7):
            target = self.correction_tolerance if self.by_correction else self.force_tolerance
            remaining = (size if self.by_correction else largest(r, eq.n_coordinates)) / target
            if remaining > 1.0 and waiting_costs_more(
                    self, sqrt(theta * last_theta) if it > 0 else theta, remaining):
                self.reseeds_inside += 1
                renew_seed(self)
                inverse.apply(inverse.context, r, z)
                self.solves += 1
                last_theta = theta
                continue
        last_theta = theta
        self.skipped_pairs += 1 - inverse.learn(inverse.context, s, y, r, z)
        self.solves += 1
    return TOO_MANY


cdef int solve(void *context) noexcept nogil:
    """Walk the ladder: the chosen method, the same with a new seed, damped Newton."""
    cdef Iteration self = <Iteration>context
    cdef const ancf_equations *eq = self.equations
    cdef int used = 0
    cdef int outcome = attempt(self, self.newton, False, &used)
    cdef double cost
    if outcome != CONVERGED and not self.newton:
        eq.restart(eq.context)
        self.reseed_due = True
        used = 0
        outcome = attempt(self, False, False, &used)
        self.recoveries_reseed += outcome == CONVERGED
    if outcome != CONVERGED:
        eq.restart(eq.context)
        used = 0
        outcome = attempt(self, True, True, &used)
        self.recoveries_newton += outcome == CONVERGED
        self.reseed_due = True
    if outcome != CONVERGED:
        return outcome
    if self.economical and not self.newton:
        cost = used * self.cost_iteration
        if self.steps_since > 0 and cost > self.cost_since / self.steps_since:
            self.reseed_due = True
            self.reseeds_between += 1
        self.cost_since += cost
        self.steps_since += 1
    return CONVERGED
