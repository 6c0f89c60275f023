"""Renewal of the seed by operation counts, and choice of its frame; included by `_iteration`."""
from libc.math cimport log10  # not log, which needs a newer glibc than wheels for all of Linux


cdef enum:
    TRIAL = 12  # number of seeds after which the more expensive frame is tried again

cdef double SLOW = 0.9  # contraction above which keeping the seed never pays off
# Relative residual of solves with an incomplete seed: if more corrections follow, and for Newton's.
cdef double LOOSE = 0.1, CLOSE = 0.01
cdef double TIRED = 0.6  # contraction by sweeps above which conjugate gradients pay off
cdef double MARGIN = 0.98  # fraction of the mean cost below which the frame is changed


cdef inline double iteration_cost(const Loop *self) noexcept nogil:
    """Cost of the next iteration, estimated from the last one."""
    return self.cost_iteration + (self.cost_rotation if self.rotating else 0.0) + self.extra


cdef inline double attempt_cost(const Loop *self, int used) noexcept nogil:
    """Cost of the corrections in an attempt."""
    return (used * (self.cost_iteration + (self.cost_rotation if self.rotating else 0.0))
            + extra_so_far(self) - self.extra_before)


cdef void compare_frames(Loop *self, double unfinished) noexcept nogil:
    """Choose whether the next seed rotates, by the cost per step; at times try the other frame.

    ``unfinished`` is the cost of the current step so far.
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
    """Factor the matrix at the current iterate; pivots of the wrong sign are counted.

    A seed that is kept should be definite: the material part of the stiffness replaces an
    indefinite tangent.  Newton's own corrections are correct for any signs.  A kept seed is also
    used for several solves, so rounding it to single precision pays off.
    """
    cdef double start
    assemble(self)
    self.indefinite = not factor(self)
    if self.indefinite and not newton and self.equations.material != NULL:
        start = clock(self)
        self.equations.material(self.equations.context, self.values)
        self.seconds.tangent += clock(self) - start
        self.indefinite = not factor(self)
        self.counts.material_seeds += not self.indefinite
    if self.indefinite and self.seed.mend != NULL:
        start = clock(self)
        self.seed.mend(self.seed.context, self.values)
        self.seconds.factor += clock(self) - start
        self.counts.shifted_seeds += 1
        self.indefinite = newton
    if newton and self.seed.refine != NULL:
        self.seed.refine(self.seed.context, CLOSE)
    if self.compares_frames and self.seeded and not newton:
        compare_frames(self, unfinished)
    self.counts.rotating_seeds += self.rotating and not newton
    self.rounded = self.rounds and not newton and not self.indefinite
    if self.rounded:
        start = clock(self)
        self.seed.round_to_single(self.seed.context)
        self.seconds.factor += clock(self) - start
        self.counts.single_seeds += 1
    self.fresh = 0.0
    hold(self)
    if not newton:
        self.counts.solves += self.inverse.reseed(self.inverse.context)
        self.rate = SLOW
    self.seeded, self.reseed_due = True, False
    self.cost_since, self.steps_since = self.cost_seed, 0


cdef bint solves_closer(Loop *self, double progress) noexcept nogil:
    """Tighten the solves with an incomplete seed if corrections by sweeps contract too slowly."""
    if (self.seed.refine == NULL or progress < TIRED
            or not self.seed.refine(self.seed.context, LOOSE)):
        return False
    self.inverse.forget(self.inverse.context)
    self.fresh = 0.0
    self.counts.refinements += 1
    return True


cdef void start_from_seed(Loop *self) noexcept nogil:
    """Rotate the seed to the predictor; drop pairs that are not kept from step to step."""
    if self.rotating:
        self.frame.turn(self.frame.context, self.equations.q)
    if not self.carry:
        self.inverse.forget(self.inverse.context)


cdef bint waiting_costs_more(Loop *self, double progress, double remaining) noexcept nogil:
    """Return True if a new seed is cheaper than the corrections still needed at this contraction.

    A new seed needs two corrections; an incomplete one, as many as at its first contraction.
    """
    cdef double needed = 2.0
    if progress >= SLOW:
        return True
    if self.seed.refine != NULL:
        if self.fresh == 0.0:
            self.fresh = progress
        needed = fmax(needed, log10(remaining) / -log10(self.fresh))
    return (log10(remaining) / -log10(progress) * iteration_cost(self)
            > self.cost_seed + needed * iteration_cost(self))


cdef void count_cost(Loop *self, double cost) noexcept nogil:
    """Record the cost of a step; return whether it exceeds the mean since the last seed."""
    if self.steps_since > 0 and (cost - self.patience * iteration_cost(self)
                                 > self.cost_since / self.steps_since):
        self.reseed_due = True
        self.counts.reseeds_between += 1
    self.cost_since += cost
    self.steps_since += 1
