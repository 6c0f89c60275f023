"""When a seed is renewed, in counts, and whether it turns with the body; text for `_iteration`."""
from libc.math cimport log


cdef enum:
    TRIAL = 12  # seeds after which the frame that cost more is tried again

cdef double SLOW = 0.9  # a contraction from which waiting never pays
# Share of the residual that an incomplete seed may leave: where other corrections follow, and Newton's.
cdef double LOOSE = 0.1, CLOSE = 0.01
cdef double TIRED = 0.6  # a contraction by sweeps from which conjugate gradients pay
cdef double MARGIN = 0.98  # of the mean cost that a change of frame must undercut


cdef inline double iteration_cost(const Loop *self) noexcept nogil:
    """What the next iteration will cost, as far as the last one tells."""
    return self.cost_iteration + (self.cost_rotation if self.rotating else 0.0) + self.extra


cdef inline double attempt_cost(const Loop *self, int used) noexcept nogil:
    """What the corrections of an attempt have cost."""
    return (used * (self.cost_iteration + (self.cost_rotation if self.rotating else 0.0))
            + extra_so_far(self) - self.extra_before)


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
    self.counts.solves += self.inverse.reseed(self.inverse.context)
    self.seeded, self.reseed_due = True, False
    if not self.newton:
        self.rate = SLOW
    self.cost_since, self.steps_since = self.cost_seed, 0


cdef bint solves_closer(Loop *self, double progress) noexcept nogil:
    """Let an incomplete seed leave less from now on, if corrections by sweeps contract too slowly."""
    if (self.seed.refine == NULL or progress < TIRED
            or not self.seed.refine(self.seed.context, LOOSE)):
        return False
    self.inverse.forget(self.inverse.context)
    self.fresh = 0.0
    self.counts.refinements += 1
    return True


cdef void start_from_seed(Loop *self) noexcept nogil:
    """Turn the seed to the predictor; drop pairs that are not carried from step to step."""
    if self.rotating:
        self.frame.turn(self.frame.context, self.equations.q)
    if not self.carry:
        self.inverse.forget(self.inverse.context)


cdef bint waiting_costs_more(Loop *self, double progress, double remaining) noexcept nogil:
    """Whether a new seed now is cheaper than the corrections still needed at this contraction.

    A new seed needs two corrections; an incomplete one as many as it did when it was new.
    """
    cdef double needed = 2.0
    if progress >= SLOW:
        return True
    if self.seed.refine != NULL:
        if self.fresh == 0.0:
            self.fresh = progress
        needed = fmax(needed, log(remaining) / -log(self.fresh))
    return (log(remaining) / -log(progress) * iteration_cost(self)
            > self.cost_seed + needed * iteration_cost(self))


cdef void count_cost(Loop *self, double cost) noexcept nogil:
    """Take in the cost of a step; say whether steps now cost more than the mean since the seed."""
    if self.steps_since > 0 and (cost - self.patience * iteration_cost(self)
                                 > self.cost_since / self.steps_since):
        self.reseed_due = True
        self.counts.reseeds_between += 1
    self.cost_since += cost
    self.steps_since += 1
