"""State of the nonlinear loop, and its vector and matrix operations; included by `_iteration`."""
from libc.math cimport fabs, fmax, sqrt


include "../../abi/signals.pxi"
include "../../abi/vectors.pxi"
include "../../abi/solver_abi.pxi"
include "../../abi/outcome.pxi"


cdef ptrdiff_t TIMED_FROM = 1000  # unknowns: a few clock readings per iteration cost 20 ns each


cdef struct Counts:
    ptrdiff_t iterations, residual_evaluations, factorizations, solves, pairs, skipped_pairs
    ptrdiff_t reseeds_between, reseeds_inside  # new factors between steps and within a step
    ptrdiff_t recoveries_reseed, recoveries_newton  # steps recovered by these fallbacks
    ptrdiff_t indefinite  # factors with a pivot of the wrong sign
    ptrdiff_t material_seeds  # those replaced by a factor of the material part, with correct signs
    ptrdiff_t shifted_seeds  # incomplete ones that broke down and got a larger diagonal
    ptrdiff_t refinements  # incomplete ones with solves more accurate than one sweep
    ptrdiff_t rotating_seeds  # rotated with the body
    ptrdiff_t single_seeds  # stored in single precision
    ptrdiff_t last_corrections  # with the last residual of a step, see finish


cdef struct Seconds:
    double force, tangent, factor, solve


cdef struct Event:
    ptrdiff_t step
    int rung, cause
    double contraction


cdef struct Loop:
    ancf_equations *equations
    const ancf_seed *seed
    const ancf_inverse *inverse
    const ancf_frame *frame  # NULL if seeds do not rotate
    ptrdiff_t n, parts
    bint yields  # whether a step that a new seed does not save is given back
    bint halves  # whether shorter steps will be tried before descent
    bint newton, learns, sparing, carry, polishes, economical, by_correction, sure
    int max_iterations
    double force_tolerance, constraint_tolerance, correction_tolerance, noise
    double share, work, floor
    double cost_iteration, cost_rotation, cost_seed
    double patience  # iterations in excess of the mean per step at which a new seed is due
    bint seeded, reseed_due, indefinite
    bint rounds, rounded  # whether seeds are stored in single precision, and whether this one is
    bint rotating, compares_frames
    double frame_cost[2]  # of a step with a fixed and with a rotating seed, 0 if not known
    ptrdiff_t seeds_since_trial
    double rate  # contraction of the corrections, kept from step to step
    double measured  # length of the first correction that it holds for
    double fresh  # first contraction measured with an incomplete seed, 0 if none
    double extra, extra_before  # cost of the last solve beyond a sweep; of all before this attempt
    double cost_since  # cost since the last seed, including that of the seed
    ptrdiff_t steps_since
    ptrdiff_t step
    ptrdiff_t indefinite_before  # factors with a pivot of the wrong sign before this step
    Rung rung  # the last fallback used in this step
    Rung compared  # the last one whose solution was compared with the one found
    bint ran_out  # whether damped Newton had too few corrections in this step
    int doubtful
    int saddle  # whether the solution is a saddle point, by the last matrix
    bint leapt  # whether the first attempt at this step did not start from the default predictor
    double contraction  # of the residual, the last one measured
    ptrdiff_t n_events
    Event *events
    double squares  # of the last residual, over the masses
    double *r
    double *r_new
    double *s
    double *y
    double *z
    double *values
    Counts counts
    bint timed
    Seconds seconds


cdef inline double clock(const Loop *self) noexcept nogil:
    return now() if self.timed else 0.0


cdef inline double extra_so_far(const Loop *self) noexcept nogil:
    return self.seed.extra[0] if self.seed.extra != NULL else 0.0


cdef void evaluate(Loop *self, double *r) noexcept nogil:
    cdef double start = clock(self)
    self.squares = self.equations.residual(self.equations.context, r)
    self.counts.residual_evaluations += 1
    self.seconds.force += clock(self) - start


cdef void multiply(Loop *self, const double *r, bint newton) noexcept nogil:
    """z = H r, with the seed itself in place of the inverse H for Newton's corrections."""
    cdef double start = clock(self), before = extra_so_far(self)
    if newton:
        self.seed.solve(self.seed.context, r, self.z)
    else:
        self.inverse.apply(self.inverse.context, r, self.z)
    self.extra = extra_so_far(self) - before
    self.counts.solves += 1
    self.seconds.solve += clock(self) - start


cdef void learn(Loop *self, const double *r_new) noexcept nogil:
    """Update with the pair (s, y) and set z = H r_new."""
    cdef double start = clock(self)
    self.counts.pairs += 1
    self.counts.skipped_pairs += 1 - self.inverse.learn(
        self.inverse.context, self.s, self.y, r_new, self.z)
    self.counts.solves += 1
    self.seconds.solve += clock(self) - start


cdef bint all_below(const double *x, ptrdiff_t n, double bound) noexcept nogil:
    cdef ptrdiff_t i, begin = 0, end
    cdef bint below = True
    while begin < n and below:  # in pieces without branches
        end = min(begin + 16, n)
        for i in range(begin, end):
            below &= fabs(x[i]) < bound  # false for NaN
        begin = end
    return below


cdef inline double length(const Loop *self, const double *x) noexcept nogil:
    """Norm of a correction [m]: root mean square of positions and slopes, weighted by mass."""
    cdef const ancf_equations *eq = self.equations
    if eq.mass == NULL:
        return sqrt(dot_parts(self.parts, x, x, eq.n_coordinates) / eq.n_coordinates)
    return sqrt(weigh_parts(self.parts, eq.mass, x, eq.n_coordinates) / eq.mass_total)


cdef inline double unbalance(const Loop *self, const double *r) noexcept nogil:
    """Norm of the last residual, ``r`` [m].

    It is the displacement if there were only inertia, and the violation of constraints.
    """
    cdef const ancf_equations *eq = self.equations
    cdef ptrdiff_t nq = eq.n_coordinates, m = self.n - nq
    if eq.mass == NULL:
        return sqrt(dot_parts(self.parts, r, r, self.n) / self.n)
    return sqrt(self.squares / eq.mass_total
                + (dot_parts(1, r + nq, r + nq, m) / nq if m else 0.0))


cdef void assemble(Loop *self) noexcept nogil:
    cdef double start = clock(self)
    self.equations.matrix(self.equations.context, self.values)
    self.seconds.tangent += clock(self) - start


cdef void hold(Loop *self) noexcept nogil:
    """Make the current iterate the reference state of the seed's rotation."""
    if self.frame != NULL:
        self.frame.hold(self.frame.context, self.equations.q)


cdef bint factor(Loop *self) noexcept nogil:
    """Factor the values; return whether all pivots have the required signs."""
    cdef double start = clock(self)
    cdef ptrdiff_t bad = self.seed.factor(self.seed.context, self.values)
    self.seconds.factor += clock(self) - start
    self.counts.factorizations += 1
    self.counts.indefinite += bad != 0
    return bad == 0
