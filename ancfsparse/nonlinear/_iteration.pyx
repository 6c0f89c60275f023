# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""One loop for Newton, modified Newton and quasi-Newton, with the rules for new seeds and recovery.

It sees equations as four functions (restart, correct, residual, matrix) and knows no mechanics.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.stdint cimport int64_t
from libc.math cimport fabs, fmax, fmin, isfinite, log, sqrt

import numpy as np


cdef extern from "<time.h>":
    ctypedef long time_t
    cdef struct timespec:
        time_t tv_sec
        long tv_nsec
    int clock_gettime(int, timespec *) noexcept nogil
    int CLOCK_MONOTONIC

cdef extern from "vectors.h":
    double dot "vec_dot_parts" (ptrdiff_t, const double *, const double *, ptrdiff_t) noexcept nogil
    void scaled "vec_scale_parts" (
        ptrdiff_t, double *, double, const double *, ptrdiff_t) noexcept nogil
    void combined "vec_sum_parts" (
        ptrdiff_t, double *, double, const double *, double, const double *,
        ptrdiff_t) noexcept nogil

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

cdef ptrdiff_t TIMED_FROM = 1000  # unknowns: a look at the clock costs 20 ns, a few in each iteration
cdef double GROWTH = 1e4  # residual beside the predictor's: past this an attempt is given up
cdef double STALE = 1.2  # a contraction that was not measured again is trusted less in each step
cdef double BELIEF = 10.0  # times the tolerance: residual over diagonal that a small correction may leave
cdef double SLOW = 0.9  # a contraction from which waiting never pays


cdef struct Counts:
    ptrdiff_t iterations, residual_evaluations, factorizations, solves, skipped_pairs
    ptrdiff_t reseeds_between, reseeds_inside  # why a quasi-Newton run factored again
    ptrdiff_t recoveries_reseed, recoveries_newton  # steps saved by that rung of the ladder
    ptrdiff_t indefinite  # factors with a pivot of the wrong sign
    ptrdiff_t last_corrections  # by the residual that ended a step, see finish


cdef struct Seconds:
    double force, tangent, factor, solve


cdef struct Loop:
    const ancf_equations *equations
    const ancf_seed *seed
    const ancf_inverse *inverse
    ptrdiff_t n, parts
    bint newton, learns, carry, polishes, economical, by_correction
    int max_iterations
    double force_tolerance, constraint_tolerance, correction_tolerance, noise
    double cost_iteration, cost_seed
    bint seeded, reseed_due
    double rate  # contraction of the corrections, carried from step to step
    double cost_since  # since the last seed, its own cost included
    ptrdiff_t steps_since
    double *r
    double *r_new
    double *s
    double *y
    double *z
    double *values
    double *diagonal  # of the last matrix that was factored
    const int64_t *column_start
    Counts counts
    bint timed
    Seconds seconds


cdef class Iteration:
    """Solve one set of nonlinear equations after another, reusing seed and pairs between them."""

    cdef ancf_nonlinear interface
    cdef Loop loop
    cdef object owners, arrays
    cdef readonly object capsule

    def __cinit__(self, equations, seed, inverse, const int64_t[::1] column_start, *, bint newton,
                  bint learns, bint carry, bint polishes, bint economical,
                  bint by_correction, int max_iterations, double force_tolerance,
                  double constraint_tolerance, double correction_tolerance, double noise,
                  double cost_iteration, double cost_seed):
        cdef Loop *loop = &self.loop
        cdef double[:, ::1] vectors
        cdef double[::1] values
        self.owners = (equations, seed, inverse, column_start)
        loop.equations = <const ancf_equations *>PyCapsule_GetPointer(
            equations.capsule, "ancf_equations")
        loop.seed = <const ancf_seed *>PyCapsule_GetPointer(seed.capsule, "ancf_seed")
        loop.inverse = <const ancf_inverse *>PyCapsule_GetPointer(inverse.capsule, "ancf_inverse")
        loop.n, loop.parts = loop.equations.n, 1
        loop.newton, loop.learns, loop.carry, loop.polishes = newton, learns, carry, polishes
        loop.economical = economical
        loop.by_correction, loop.max_iterations = by_correction, max_iterations
        loop.force_tolerance, loop.constraint_tolerance = force_tolerance, constraint_tolerance
        loop.correction_tolerance, loop.noise = correction_tolerance, noise
        loop.cost_iteration, loop.cost_seed = cost_iteration, cost_seed
        loop.rate = SLOW
        loop.timed = loop.n >= TIMED_FROM
        # The pair and the product are done with whenever a matrix is assembled: they share its room.
        self.arrays = np.zeros((3, loop.n)), np.zeros(max(loop.equations.n_values + 1, 3 * loop.n))
        vectors, values = self.arrays
        loop.r, loop.r_new, loop.diagonal = &vectors[0, 0], &vectors[1, 0], &vectors[2, 0]
        loop.s, loop.y, loop.z = &values[0], &values[loop.n], &values[2 * loop.n]
        loop.values, loop.column_start = &values[0], &column_start[0]
        self.interface.context, self.interface.solve = loop, solve
        self.capsule = PyCapsule_New(&self.interface, "ancf_nonlinear", NULL)

    @property
    def seconds(self):
        """Time by part [s], empty for systems so small that looking at the clock would count."""
        return dict(self.loop.seconds) if self.loop.timed else {}

    @property
    def counts(self):
        """Counts since construction, by name."""
        return dict(self.loop.counts)

    def set_threads(self, ptrdiff_t threads):
        """Set the number of threads for passes over vectors."""
        self.loop.parts = threads

    def mark_seeded(self):
        """Tell that the inverse was filled from outside (a finite-difference matrix)."""
        assemble(&self.loop)
        self.loop.seeded = True

    def set_tolerance(self, double correction, double constraint):
        """Judge corrections by another bound [m], and constraints by another [m]."""
        self.loop.correction_tolerance, self.loop.constraint_tolerance = correction, constraint

    def mark_stale(self):
        """Tell that the matrix has changed for another reason than motion: a step of other length."""
        self.loop.reseed_due = True

    def solve(self):
        """Solve the equations from their predictor; return 0 or a reason (`nonlinear.outcome`)."""
        self.loop.equations.restart(self.loop.equations.context)
        return solve(&self.loop)


cdef inline double clock(const Loop *self) noexcept nogil:
    cdef timespec t
    if not self.timed:
        return 0.0
    clock_gettime(CLOCK_MONOTONIC, &t)
    return t.tv_sec + 1e-9 * t.tv_nsec


cdef void evaluate(Loop *self, double *r) noexcept nogil:
    cdef double start = clock(self)
    self.equations.residual(self.equations.context, r)
    self.counts.residual_evaluations += 1
    self.seconds.force += clock(self) - start


cdef void multiply(Loop *self, const double *r) noexcept nogil:
    """z = H r."""
    cdef double start = clock(self)
    self.inverse.apply(self.inverse.context, r, self.z)
    self.counts.solves += 1
    self.seconds.solve += clock(self) - start


cdef void learn(Loop *self, const double *r_new) noexcept nogil:
    """Take in the pair (s, y) and set z = H r_new."""
    cdef double start = clock(self)
    self.counts.skipped_pairs += 1 - self.inverse.learn(
        self.inverse.context, self.s, self.y, r_new, self.z)
    self.counts.solves += 1
    self.seconds.solve += clock(self) - start


cdef bint all_below(const double *x, ptrdiff_t n, double bound) noexcept nogil:
    cdef ptrdiff_t i
    for i in range(n):
        if not fabs(x[i]) < bound:  # a NaN is not below anything
            return False
    return True


cdef double largest(const double *x, ptrdiff_t n) noexcept nogil:
    cdef double m = 0.0
    cdef ptrdiff_t i
    for i in range(n):
        m = fmax(m, fabs(x[i]))
    return m


cdef inline double rms(const Loop *self, const double *x, ptrdiff_t n) noexcept nogil:
    return sqrt(dot(self.parts, x, x, n) / n)


cdef void assemble(Loop *self) noexcept nogil:
    cdef ptrdiff_t i
    cdef double start = clock(self)
    self.equations.matrix(self.equations.context, self.values)
    self.seconds.tangent += clock(self) - start
    for i in range(self.n):  # each column starts with its diagonal
        self.diagonal[i] = self.values[self.column_start[i]]


cdef void renew_seed(Loop *self) noexcept nogil:
    """Factor the matrix at the current iterate; a wrong sign of a pivot is counted."""
    cdef ptrdiff_t bad
    cdef double start
    assemble(self)
    start = clock(self)
    bad = self.seed.factor(self.seed.context, self.values)
    self.seconds.factor += clock(self) - start
    self.counts.factorizations += 1
    if bad != 0:
        self.counts.indefinite += 1
    self.counts.solves += self.inverse.reseed(self.inverse.context)
    self.seeded, self.reseed_due = True, False
    if not self.newton:
        self.rate = SLOW
    self.cost_since, self.steps_since = self.cost_seed, 0


cdef bint residual_is_small(Loop *self, const double *r) noexcept nogil:
    cdef ptrdiff_t nq = self.equations.n_coordinates
    return (all_below(r, nq, self.force_tolerance)
            and all_below(r + nq, self.n - nq, self.constraint_tolerance))


cdef bint waiting_costs_more(Loop *self, double progress, double remaining) noexcept nogil:
    """Whether a new seed now is cheaper than the corrections still needed at this contraction."""
    if progress >= SLOW:
        return True
    return (log(remaining) / -log(progress) * self.cost_iteration
            > self.cost_seed + 2.0 * self.cost_iteration)


cdef bint residual_agrees(const Loop *self, const double *r) noexcept nogil:
    """Whether a small correction can be believed: an inverse that learned may be nearly singular.

    The residual over the diagonal of the last matrix is a correction that owes nothing to learning.
    """
    cdef ptrdiff_t nq = self.equations.n_coordinates, i
    cdef double total = 0.0, bound = BELIEF * fmax(self.correction_tolerance, self.noise)
    for i in range(nq):
        total += (r[i] / self.diagonal[i]) * (r[i] / self.diagonal[i])
    return (total <= bound * bound * nq
            and all_below(r + nq, self.n - nq, self.constraint_tolerance))


cdef void finish(Loop *self, double size) noexcept nogil:
    """Learn from the last pair, and correct once more by the residual that is known anyway.

    This costs no residual.  Davidon's inverse may be far off in a direction it has not seen, so its
    correction would need a residual to be believed; nor is one believed that is longer than the last.
    """
    cdef ptrdiff_t n = self.n
    if self.carry:
        combined(self.parts, self.y, 1.0, self.r_new, -1.0, self.r, n)
        learn(self, self.r_new)
    elif self.polishes:
        multiply(self, self.r_new)
    if self.polishes and rms(self, self.z, self.equations.n_coordinates) <= size:
        scaled(self.parts, self.s, -1.0, self.z, n)
        self.equations.correct(self.equations.context, self.s)
        self.counts.last_corrections += 1


cdef int attempt(Loop *self, bint newton, bint damped, int *used) noexcept nogil:
    """Iterate from the predictor; return CONVERGED or the reason why not."""
    cdef const ancf_equations *eq = self.equations
    cdef const ancf_inverse *inverse = self.inverse
    cdef double *s = self.s
    cdef double *z = self.z
    cdef double *swap
    cdef ptrdiff_t n = self.n
    cdef int it, halvings
    cdef bint small, learns = not newton and self.learns
    cdef double size, last_size = 0.0, norm, norm_new, start, theta, last_theta = 0.0, remaining
    evaluate(self, self.r)
    norm = start = rms(self, self.r, n)
    if not isfinite(norm):
        return NOT_FINITE
    if residual_is_small(self, self.r) and not self.by_correction:
        return CONVERGED
    if newton or not self.seeded or self.reseed_due:
        renew_seed(self)
    elif not self.carry:
        inverse.forget(inverse.context)
    multiply(self, self.r)
    for it in range(self.max_iterations):
        scaled(self.parts, s, -1.0, z, n)
        eq.correct(eq.context, s)
        used[0] += 1
        self.counts.iterations += 1
        size = rms(self, s, eq.n_coordinates)
        if last_size > 0.0:
            self.rate = fmin(fmax(0.3 * self.rate, size / last_size), 0.99)
        last_size = size
        small = self.by_correction and (
            self.rate / (1.0 - self.rate) * size <= self.correction_tolerance
            or size <= self.noise)
        if small and it == 0:
            self.rate = fmin(STALE * self.rate, SLOW)
        if small and not learns and not damped and n == eq.n_coordinates:
            return CONVERGED
        evaluate(self, self.r_new)
        norm_new = rms(self, self.r_new, n)
        if damped:
            # Halve a step that makes the residual larger; the last try is kept whatever it does.
            halvings = 0
            while not norm_new <= norm and halvings < 6 and not small:
                halvings += 1
                scaled(self.parts, s, -0.5, s, n)
                eq.correct(eq.context, s)
                scaled(self.parts, s, -1.0, s, n)
                evaluate(self, self.r_new)
                norm_new = rms(self, self.r_new, n)
        if not isfinite(norm_new):
            return NOT_FINITE
        if residual_agrees(self, self.r_new) if small else (
                not self.by_correction and residual_is_small(self, self.r_new)):
            if not newton and size > self.noise:
                finish(self, size)
            return CONVERGED
        if small:
            self.rate = SLOW
        if norm_new > GROWTH * start and it > 0 and not damped:
            return DIVERGED
        theta = norm_new / norm
        if not newton:
            combined(self.parts, self.y, 1.0, self.r_new, -1.0, self.r, n)
        swap = self.r
        self.r = self.r_new
        self.r_new = swap
        norm = norm_new
        if newton:
            renew_seed(self)
            multiply(self, self.r)
            continue
        if self.economical and (it > 0 or theta > 0.7):
            if self.by_correction:
                remaining = size / self.correction_tolerance
            else:
                remaining = largest(self.r, eq.n_coordinates) / self.force_tolerance
            if remaining > 1.0 and waiting_costs_more(
                    self, sqrt(theta * last_theta) if it > 0 else theta, remaining):
                self.counts.reseeds_inside += 1
                renew_seed(self)
                multiply(self, self.r)
                last_theta = theta
                continue
        last_theta = theta
        learn(self, self.r)
    return TOO_MANY


cdef int solve(void *context) noexcept nogil:
    """Walk the ladder: the chosen method, the same with a new seed, damped Newton."""
    cdef Loop *self = <Loop *>context
    cdef const ancf_equations *eq = self.equations
    cdef int used = 0
    cdef int outcome = attempt(self, self.newton, False, &used)
    cdef double cost
    if outcome != CONVERGED and not self.newton:
        eq.restart(eq.context)
        self.reseed_due = True
        used = 0
        outcome = attempt(self, False, False, &used)
        self.counts.recoveries_reseed += outcome == CONVERGED
    if outcome != CONVERGED:
        eq.restart(eq.context)
        used = 0
        outcome = attempt(self, True, True, &used)
        self.counts.recoveries_newton += outcome == CONVERGED
        self.reseed_due = True
    if outcome != CONVERGED:
        return outcome
    if self.economical and not self.newton:
        cost = used * self.cost_iteration
        if self.steps_since > 0 and cost > self.cost_since / self.steps_since:
            self.reseed_due = True
            self.counts.reseeds_between += 1
        self.cost_since += cost
        self.steps_since += 1
    return CONVERGED
