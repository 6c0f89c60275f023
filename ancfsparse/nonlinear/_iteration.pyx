# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""One loop for Newton, modified Newton and quasi-Newton, with the rules for new seeds and recovery.

It sees equations as a few functions (restart, correct, residual, matrix) and knows no mechanics.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.math cimport NAN, fabs, fmax, fmin, isfinite, log, sqrt
from libc.stdint cimport int64_t
from libc.stdlib cimport calloc, free

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

include "../kernels/solver_abi.pxi"


cdef enum:
    CONVERGED = 0
    TOO_MANY = 1
    DIVERGED = 2
    NOT_FINITE = 3
    GAINED_ENERGY = 4  # a solution that the time loop refused
    INDEFINITE = 7  # the cause of one of these, where the factor had a wrong sign

cdef enum Rung:
    METHOD = 0
    NEW_SEED = 1
    DAMPED_NEWTON = 2
    NEWTON = 3
    COASTING = 4

cdef enum:
    MOST_EVENTS = 1000
    TRIAL = 12  # seeds after which the frame that cost more is tried again

cdef ptrdiff_t TIMED_FROM = 1000  # unknowns: a look at the clock costs 20 ns, a few in each iteration
cdef double GROWTH = 1e4  # residual beside the predictor's: past this an attempt is given up
cdef double STALE = 1.2  # a contraction that was not measured again is trusted less in each step
cdef double BELIEF = 2.0  # times the tolerance: residual over diagonal that a small correction may leave
cdef double SLOW = 0.9  # a contraction from which waiting never pays
cdef double MARGIN = 0.98  # of the mean cost that a change of frame must undercut


cdef struct Counts:
    ptrdiff_t iterations, residual_evaluations, factorizations, solves, skipped_pairs
    ptrdiff_t reseeds_between, reseeds_inside  # why a quasi-Newton run factored again
    ptrdiff_t recoveries_reseed, recoveries_newton  # steps saved by that rung of the ladder
    ptrdiff_t indefinite  # factors with a pivot of the wrong sign
    ptrdiff_t material_seeds  # those replaced by a factor of the material part, with right signs
    ptrdiff_t rotating_seeds  # taken to be turned with the body
    ptrdiff_t single_seeds  # kept in single precision
    ptrdiff_t last_corrections  # by the residual that ended a step, see finish


cdef struct Seconds:
    double force, tangent, factor, solve


cdef struct Event:
    ptrdiff_t step
    int rung, cause
    double contraction


cdef struct Loop:
    const ancf_equations *equations
    const ancf_seed *seed
    const ancf_inverse *inverse
    const ancf_frame *frame  # NULL if seeds do not turn
    ptrdiff_t n, parts
    bint newton, learns, carry, polishes, economical, by_correction
    int max_iterations
    double force_tolerance, constraint_tolerance, correction_tolerance, noise
    double cost_iteration, cost_rotation, cost_seed
    double patience  # iterations above the mean that a step may take before a new seed is due
    bint seeded, reseed_due, indefinite
    bint rounds, rounded  # whether seeds are kept in single precision, and this one is
    bint rotating, compares_frames
    double frame_cost[2]  # of a step with a fixed and with a rotating seed, 0 if not known
    ptrdiff_t seeds_since_trial
    double rate  # contraction of the corrections, carried from step to step
    double cost_since  # since the last seed, its own cost included
    ptrdiff_t steps_since
    ptrdiff_t step
    Rung rung  # the last one climbed in this step
    int doubtful
    double contraction  # of the residual, the last one seen
    ptrdiff_t n_events
    Event *events
    double *r
    double *r_new
    double *s
    double *y
    double *z
    double *values
    double *diagonal  # of the last matrix that was factored
    const double *softest  # what the matrix has at least in each coordinate, NULL if not known
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

    def __cinit__(self, equations, seed, inverse, frame, const int64_t[::1] column_start, *,
                  bint rotating, bint compares_frames, bint newton,
                  bint learns, bint carry, bint polishes, bint economical, bint rounds,
                  bint by_correction, int max_iterations, double force_tolerance,
                  double constraint_tolerance, double correction_tolerance, double noise,
                  double cost_iteration, double cost_rotation, double cost_seed,
                  double patience, const double[::1] softest=None):
        cdef Loop *loop = &self.loop
        cdef double[:, ::1] vectors
        cdef double[::1] values
        self.owners = (equations, seed, inverse, frame, column_start, softest)
        loop.equations = <const ancf_equations *>PyCapsule_GetPointer(
            equations.capsule, "ancf_equations")
        loop.seed = <const ancf_seed *>PyCapsule_GetPointer(seed.capsule, "ancf_seed")
        loop.inverse = <const ancf_inverse *>PyCapsule_GetPointer(inverse.capsule, "ancf_inverse")
        if frame is not None:
            loop.frame = <const ancf_frame *>PyCapsule_GetPointer(frame.capsule, "ancf_frame")
            if loop.equations.q == NULL:
                raise ValueError("a frame needs equations that show their coordinates")
        loop.rotating, loop.compares_frames = rotating, compares_frames
        loop.n, loop.parts = loop.equations.n, 1
        loop.rounds = rounds and loop.seed.round_to_single != NULL
        loop.newton, loop.learns, loop.carry, loop.polishes = newton, learns, carry, polishes
        loop.economical = economical
        loop.by_correction, loop.max_iterations = by_correction, max_iterations
        loop.force_tolerance, loop.constraint_tolerance = force_tolerance, constraint_tolerance
        loop.correction_tolerance, loop.noise = correction_tolerance, noise
        loop.cost_iteration, loop.cost_seed = cost_iteration, cost_seed
        loop.cost_rotation, loop.patience = cost_rotation, patience
        loop.events = <Event *>calloc(MOST_EVENTS, sizeof(Event))
        if loop.events == NULL:
            raise MemoryError
        loop.rate = SLOW
        loop.timed = loop.n >= TIMED_FROM
        # The pair and the product are done with whenever a matrix is assembled: they share its room.
        self.arrays = np.zeros((3, loop.n)), np.zeros(max(loop.equations.n_values + 1, 3 * loop.n))
        vectors, values = self.arrays
        loop.r, loop.r_new, loop.diagonal = &vectors[0, 0], &vectors[1, 0], &vectors[2, 0]
        loop.s, loop.y, loop.z = &values[0], &values[loop.n], &values[2 * loop.n]
        loop.values, loop.column_start = &values[0], &column_start[0]
        if softest is not None:
            if len(softest) < loop.equations.n_coordinates:
                raise ValueError("softest needs a number for each coordinate")
            loop.softest = &softest[0]
        self.interface.context, self.interface.solve, self.interface.again = loop, solve, again
        self.interface.doubtful = &loop.doubtful
        self.capsule = PyCapsule_New(&self.interface, "ancf_nonlinear", NULL)

    def __dealloc__(self):
        free(self.loop.events)

    @property
    def seconds(self):
        """Time by part [s], empty for systems so small that looking at the clock would count."""
        return dict(self.loop.seconds) if self.loop.timed else {}

    @property
    def counts(self):
        """Counts since construction, by name."""
        return dict(self.loop.counts)

    @property
    def max_iterations(self):
        """Corrections that an attempt may take."""
        return self.loop.max_iterations

    def set_threads(self, ptrdiff_t threads):
        """Set the number of threads for passes over vectors."""
        self.loop.parts = threads

    @property
    def events(self):
        """Rungs of the ladder that were climbed, the first thousand.

        Each as ``(step, rung, cause, contraction)``: number of the step from 1; 1 for a new seed,
        2 for damped Newton, 3 for Newton after a solution that was refused, 4 for Newton from a
        start without acceleration; why the attempt before failed (`nonlinear.outcome`); the
        contraction of the residual it ended with.
        """
        cdef ptrdiff_t k
        found = []
        for k in range(min(self.loop.n_events, MOST_EVENTS)):
            event = self.loop.events[k]
            found.append((event.step, event.rung, event.cause, event.contraction))
        return found

    def take_events(self):
        """Return the events so far and forget them, to make room for those of the next steps."""
        found = self.events
        self.loop.n_events = 0
        return found

    @property
    def contraction(self):
        """Last ratio of two residuals in the last attempt; not a number if there was none."""
        return self.loop.contraction

    def mark_seeded(self):
        """Tell that the inverse was filled from outside (a finite-difference matrix)."""
        assemble(&self.loop)
        hold(&self.loop)
        self.loop.seeded = True

    @property
    def by_correction(self):
        """Whether corrections are judged, and not the residual."""
        return bool(self.loop.by_correction)

    def set_tolerance(self, tolerance):
        """Judge steps by other bounds, an object with the attributes of `iteration.Tolerance`."""
        self.loop.by_correction = tolerance.by_correction
        self.loop.correction_tolerance = tolerance.correction
        self.loop.constraint_tolerance = tolerance.constraint
        self.loop.force_tolerance, self.loop.noise = tolerance.force, tolerance.noise

    @property
    def step(self):
        """Number of the last step that was attempted, from 1, as events are listed under."""
        return self.loop.step

    @step.setter
    def step(self, ptrdiff_t number):
        self.loop.step = number

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
    cdef double start = clock(self)
    self.equations.matrix(self.equations.context, self.values)
    self.seconds.tangent += clock(self) - start
    keep_diagonal(self)


cdef void keep_diagonal(Loop *self) noexcept nogil:
    cdef ptrdiff_t i
    for i in range(self.n):  # each column starts with its diagonal
        self.diagonal[i] = self.values[self.column_start[i]]


cdef void hold(Loop *self) noexcept nogil:
    """Make the current iterate the state that the seed is turned from."""
    if self.frame != NULL:
        self.frame.hold(self.frame.context, self.equations.q)


cdef bint factor(Loop *self) noexcept nogil:
    """Factor the values; return whether all pivots have the signs they must have."""
    cdef double start = clock(self)
    cdef ptrdiff_t bad = self.seed.factor(self.seed.context, self.values)
    self.seconds.factor += clock(self) - start
    self.counts.factorizations += 1
    self.counts.indefinite += bad != 0
    return bad == 0


cdef inline double iteration_cost(const Loop *self) noexcept nogil:
    return self.cost_iteration + (self.cost_rotation if self.rotating else 0.0)


cdef void compare_frames(Loop *self, double unfinished) noexcept nogil:
    """Choose whether the next seed turns: what cost less per step, and now and then the other.

    ``unfinished`` is what the step under way has cost so far.
    """
    cdef ptrdiff_t steps = self.steps_since + (unfinished > 0.0)
    cdef bint other = not self.rotating
    cdef double mean
    if steps == 0:
        return
    mean = (self.cost_since + unfinished) / steps
    if self.frame_cost[self.rotating] > 0.0:
        mean = 0.5 * (self.frame_cost[self.rotating] + mean)
    self.frame_cost[self.rotating] = mean
    self.seeds_since_trial += 1
    if self.seeds_since_trial >= TRIAL or self.frame_cost[other] < MARGIN * mean:
        self.rotating = other
        self.seeds_since_trial = 0


cdef void renew_seed(Loop *self, bint newton, double unfinished) noexcept nogil:
    """Factor the matrix at the current iterate; a wrong sign of a pivot is counted.

    A seed that is kept is better definite: then the material part of the stiffness takes the place
    of an indefinite tangent.  Newton's own corrections are right whatever the signs.  It also is
    solved with more than once, so that rounding it to single precision pays.
    """
    cdef double start
    assemble(self)
    self.indefinite = not factor(self)
    if self.indefinite and not newton and self.equations.material != NULL:
        start = clock(self)
        self.equations.material(self.equations.context, self.values)
        self.seconds.tangent += clock(self) - start
        keep_diagonal(self)
        self.indefinite = not factor(self)
        self.counts.material_seeds += not self.indefinite
    if self.compares_frames and self.seeded and not newton:
        compare_frames(self, unfinished)
    self.counts.rotating_seeds += self.rotating and not newton
    self.rounded = self.rounds and not newton and not self.indefinite
    if self.rounded:
        start = clock(self)
        self.seed.round_to_single(self.seed.context)
        self.seconds.factor += clock(self) - start
        self.counts.single_seeds += 1
    hold(self)
    self.counts.solves += self.inverse.reseed(self.inverse.context)
    self.seeded, self.reseed_due = True, False
    if not self.newton:
        self.rate = SLOW
    self.cost_since, self.steps_since = self.cost_seed, 0


cdef void start_from_seed(Loop *self) noexcept nogil:
    """Turn the seed to the predictor; drop pairs that are not carried from step to step."""
    if self.rotating:
        self.frame.turn(self.frame.context, self.equations.q)
    if not self.carry:
        self.inverse.forget(self.inverse.context)


cdef bint residual_is_small(Loop *self, const double *r) noexcept nogil:
    cdef ptrdiff_t nq = self.equations.n_coordinates
    return (all_below(r, nq, self.force_tolerance)
            and all_below(r + nq, self.n - nq, self.constraint_tolerance))


cdef bint waiting_costs_more(Loop *self, double progress, double remaining) noexcept nogil:
    """Whether a new seed now is cheaper than the corrections still needed at this contraction."""
    if progress >= SLOW:
        return True
    return (log(remaining) / -log(progress) * iteration_cost(self)
            > self.cost_seed + 2.0 * iteration_cost(self))


cdef bint residual_agrees(const Loop *self, const double *r) noexcept nogil:
    """Whether a small correction can be believed: an inverse that learned may be nearly singular.

    The residual over the diagonal of the last matrix is a correction that owes nothing to learning.
    But a stiff bar is stiff in all coordinates and soft across itself: where the least that the
    matrix can have is known, the mass, the geometric mean of both takes the place of the diagonal,
    unless what is left is rounding.
    """
    cdef ptrdiff_t nq = self.equations.n_coordinates, i
    cdef double weak = 0.0, strong = 0.0, noise = BELIEF * self.noise
    cdef double bound = BELIEF * self.correction_tolerance
    for i in range(nq):
        weak += (r[i] / self.diagonal[i]) * (r[i] / self.diagonal[i])
    if self.softest != NULL:
        for i in range(nq):
            strong += r[i] * r[i] / fabs(self.diagonal[i] * self.softest[i])
    else:
        strong = weak
    return ((strong <= bound * bound * nq or weak <= noise * noise * nq)
            and all_below(r + nq, self.n - nq, self.constraint_tolerance))


cdef void finish(Loop *self, double size) noexcept nogil:
    """Learn from the last pair, and correct once more by the residual that is known anyway.

    This costs no residual.  Davidon's inverse may be far off in a direction it has not seen, so its
    correction would need a residual to be believed; nor is one believed that is longer than the last.
    Judged by the correction, one on a sparse seed would cost more than it gives.
    """
    cdef ptrdiff_t n = self.n
    cdef bint polishes = self.polishes and (self.carry or not self.by_correction)
    if self.carry:
        scaled(self.parts, self.s, -1.0, self.z, n)
        combined(self.parts, self.y, 1.0, self.r_new, -1.0, self.r, n)
        learn(self, self.r_new)
    elif polishes:
        multiply(self, self.r_new)
    if polishes and rms(self, self.z, self.equations.n_coordinates) <= size:
        self.equations.correct(self.equations.context, -1.0, self.z)
        self.counts.last_corrections += 1


cdef int attempt(Loop *self, bint newton, bint damped, bint economical, int *used) noexcept nogil:
    """Iterate from the predictor; return CONVERGED or the reason why not.

    If economical, a new seed is taken wherever waiting would cost more.
    """
    cdef const ancf_equations *eq = self.equations
    cdef double *z = self.z
    cdef double *swap
    cdef ptrdiff_t n = self.n
    cdef int it, halvings
    cdef bint small, learns = not newton and self.learns
    cdef double size, last_size = 0.0, norm, norm_new, start, theta, last_theta = 0.0, remaining
    self.contraction = NAN
    evaluate(self, self.r)
    norm = start = rms(self, self.r, n)
    if not isfinite(norm):
        return NOT_FINITE
    if residual_is_small(self, self.r) and not self.by_correction:
        return CONVERGED
    if newton or not self.seeded or self.reseed_due:
        renew_seed(self, newton, 0.0)
    else:
        start_from_seed(self)
    multiply(self, self.r)
    for it in range(self.max_iterations):
        size = sqrt(eq.correct(eq.context, -1.0, z) / eq.n_coordinates)
        used[0] += 1
        self.counts.iterations += 1
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
                eq.correct(eq.context, 0.5**halvings, z)
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
        theta = self.contraction = norm_new / norm
        if learns:
            scaled(self.parts, self.s, -1.0, z, n)
            combined(self.parts, self.y, 1.0, self.r_new, -1.0, self.r, n)
        swap = self.r
        self.r = self.r_new
        self.r_new = swap
        norm = norm_new
        if newton:
            renew_seed(self, newton, 0.0)
            multiply(self, self.r)
            continue
        if economical and (it > 0 or theta > 0.7):
            if self.by_correction:
                remaining = size / self.correction_tolerance
            else:
                remaining = largest(self.r, eq.n_coordinates) / self.force_tolerance
            if remaining > 1.0 and waiting_costs_more(
                    self, sqrt(theta * last_theta) if it > 0 else theta, remaining):
                self.counts.reseeds_inside += 1
                renew_seed(self, newton, used[0] * iteration_cost(self))
                multiply(self, self.r)
                last_theta = theta
                continue
        last_theta = theta
        if learns:
            learn(self, self.r)
        else:
            multiply(self, self.r)
    return TOO_MANY


cdef void record(Loop *self, Rung rung, int cause) noexcept nogil:
    cdef Event *event
    if self.n_events < MOST_EVENTS:
        event = &self.events[self.n_events]
        event.step, event.rung = self.step, rung
        event.cause = INDEFINITE if self.indefinite and cause != GAINED_ENERGY else cause
        event.contraction = self.contraction
    self.n_events += 1


cdef void tally(Loop *self, ptrdiff_t by) noexcept nogil:
    """Count the step among those that its rung saved, or take it out again."""
    if self.rung == NEW_SEED:
        self.counts.recoveries_reseed += by
    elif self.rung > NEW_SEED:
        self.counts.recoveries_newton += by


cdef int climb(Loop *self, Rung rung, int cause, int *used) noexcept nogil:
    """Try to solve the step in the way of a rung, from the start that belongs to it."""
    cdef const ancf_equations *eq = self.equations
    cdef int outcome
    record(self, rung, cause)
    self.rung = rung
    self.doubtful = rung >= NEWTON
    self.reseed_due = True
    if self.rounded:  # it may be why the step was lost
        self.rounds = False
    used[0] = 0
    if rung == COASTING:
        eq.coast(eq.context)
        outcome = attempt(self, True, False, False, used)
    else:
        eq.restart(eq.context)
        outcome = attempt(self, rung != NEW_SEED, rung == DAMPED_NEWTON, rung == NEW_SEED, used)
        if outcome != CONVERGED and rung != NEW_SEED and not self.newton:
            # Damping can hold back what whole corrections solve, and the other way round.
            eq.restart(eq.context)
            used[0] = 0
            outcome = attempt(self, True, rung == NEWTON, False, used)
    if outcome == CONVERGED:
        tally(self, 1)
    if rung != NEW_SEED:
        self.reseed_due = True  # a factor of an iterate on the way
    return outcome


cdef int solve(void *context) noexcept nogil:
    """Walk the ladder: the chosen method, the same with a new seed, damped Newton, another start."""
    cdef Loop *self = <Loop *>context
    cdef int used = 0
    cdef int outcome
    self.step += 1
    self.rung, self.doubtful = METHOD, False
    outcome = attempt(self, self.newton, False, self.economical, &used)
    if outcome != CONVERGED and not self.newton:
        self.cost_since += used * iteration_cost(self)
        outcome = climb(self, NEW_SEED, outcome, &used)
    if outcome != CONVERGED:
        outcome = climb(self, DAMPED_NEWTON, outcome, &used)
    if outcome != CONVERGED and self.equations.coast != NULL:
        outcome = climb(self, COASTING, outcome, &used)
    if outcome != CONVERGED:
        return outcome
    if self.economical and not self.newton:
        count_cost(self, used * iteration_cost(self))
    return CONVERGED


cdef int again(void *context, int reason) noexcept nogil:
    """Look for another solution of the step: the one of Newton, then the one of another start.

    A step of rough motion can have several; which one an iteration finds is its own affair.
    """
    cdef Loop *self = <Loop *>context
    cdef int used = 0
    tally(self, -1)
    if self.rung < NEWTON and not self.newton:
        reason = climb(self, NEWTON, reason, &used)
        if reason == CONVERGED:
            return CONVERGED
    if self.rung < COASTING and self.equations.coast != NULL:
        return climb(self, COASTING, reason, &used)
    return reason


cdef void count_cost(Loop *self, double cost) noexcept nogil:
    """Take in the cost of a step; say whether steps now cost more than the mean since the seed."""
    if self.steps_since > 0 and (cost - self.patience * iteration_cost(self)
                                 > self.cost_since / self.steps_since):
        self.reseed_due = True
        self.counts.reseeds_between += 1
    self.cost_since += cost
    self.steps_since += 1
