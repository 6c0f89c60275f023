"""The sequence of fallbacks ("ladder") in a step, and its events; included by `_iteration`."""

cdef enum:
    MOST_EVENTS = 1000


cdef void record(Loop *self, Rung rung, int cause) noexcept nogil:
    cdef Event *event
    if self.n_events < MOST_EVENTS:
        event = &self.events[self.n_events]
        event.step, event.rung = self.step, rung
        event.cause = INDEFINITE if self.indefinite and cause != GAINED_ENERGY else cause
        event.contraction = self.contraction
    self.n_events += 1


cdef void tally(Loop *self, ptrdiff_t by) noexcept nogil:
    """Count the step among those recovered by its rung, or undo that."""
    if self.rung == NEW_SEED:
        self.counts.recoveries_reseed += by
    elif self.rung > NEW_SEED:
        self.counts.recoveries_newton += by


cdef bint retreat(Loop *self) noexcept nogil:
    """Restart from the default predictor; return whether it is a different one."""
    cdef ancf_equations *eq = self.equations
    cdef bint leaps = eq.leaps
    eq.leaps = False
    return leaps


cdef int climb(Loop *self, Rung rung, int cause, int *used) noexcept nogil:
    """Try to solve the step by the method of a rung, from its predictor."""
    cdef const ancf_equations *eq = self.equations
    cdef int outcome
    cdef bint damped = rung == DAMPED_NEWTON
    if cause != CONVERGED:
        record(self, rung, cause)
    self.rung = rung
    self.doubtful = rung >= NEWTON
    self.reseed_due = True
    if self.rounded:  # rounding may be the cause of the failure
        self.rounds = False
    used[0] = 0
    if rung == DESCENT:
        eq.restart(eq.context)
        outcome = descend(self, used)
    elif rung == COASTING:
        eq.coast(eq.context)
        outcome = attempt(self, True, False, False, used)
    elif rung == LONG_NEWTON:
        eq.restart(eq.context)
        outcome = attempt(self, True, True, False, used)
    else:
        eq.restart(eq.context)
        outcome = attempt(self, rung != NEW_SEED, damped, rung == NEW_SEED, used)
        self.ran_out |= damped and outcome == TOO_MANY
        if outcome != CONVERGED and rung != NEW_SEED and not (self.newton and self.leapt == eq.leaps):
            # Damping can prevent convergence where full corrections converge, and vice versa.
            eq.restart(eq.context)
            used[0] = 0
            outcome = attempt(self, True, not damped, False, used)
            self.ran_out |= not damped and outcome == TOO_MANY
    if outcome == CONVERGED:
        tally(self, 1)
    if rung != NEW_SEED:
        self.reseed_due = True  # the factor belongs to an intermediate iterate
    return outcome


cdef bint has_saddles(const Loop *self) noexcept nogil:
    """Return True if a matrix of a potential in the current step was indefinite."""
    return self.n == self.equations.n_coordinates and self.counts.indefinite > self.indefinite_before


cdef bint is_saddle(const Loop *self) noexcept nogil:
    """Return True if the last matrix of a potential in the current step was indefinite."""
    return has_saddles(self) and self.indefinite


cdef bint is_worth_longer(const Loop *self) noexcept nogil:
    """Return True if damped Newton ran out of corrections and no other means will be tried.

    Those are shorter steps, and a complete seed.
    """
    return self.ran_out and not self.halves and self.seed.refine == NULL


cdef int go_on(Loop *self, int outcome, int *used) noexcept nogil:
    """Try damped Newton with more corrections from the first predictor, and then from the default one.

    That is tried too where the solution from the first one was rejected.
    """
    if not is_worth_longer(self):
        return outcome
    if self.rung < LONG_NEWTON:
        self.equations.leaps = self.leapt
        outcome = climb(self, LONG_NEWTON, outcome, used)
        if outcome == CONVERGED:
            return CONVERGED
    return climb(self, LONG_NEWTON, outcome, used) if retreat(self) else outcome


cdef int solve(void *context) noexcept nogil:
    """Try in turn the chosen method, a new seed, damped Newton, another predictor, and descent.

    A step that none of them solves is worth a longer attempt if damped Newton ran out of corrections.
    """
    cdef Loop *self = <Loop *>context
    cdef int used = 0
    cdef int outcome
    cdef bint inexact = self.seed.refine != NULL
    cdef ptrdiff_t inside = self.counts.reseeds_inside
    self.step += 1
    self.indefinite_before = self.counts.indefinite
    self.rung, self.doubtful, self.leapt = METHOD, False, self.equations.leaps
    self.compared, self.ran_out = METHOD, False
    outcome = attempt(self, self.newton, False, self.economical, &used)
    if outcome != CONVERGED and not self.newton:
        self.cost_since += attempt_cost(self, used)
        outcome = climb(self, NEW_SEED, outcome, &used)
    if outcome != CONVERGED and self.yields:
        return outcome
    # If the matrix is indefinite, incomplete seeds give descent directions, not Newton's
    # corrections.
    if outcome != CONVERGED and inexact and has_saddles(self):
        outcome = climb(self, DESCENT, outcome, &used)
    if outcome != CONVERGED:
        outcome = climb(self, DAMPED_NEWTON, outcome, &used)
    if outcome != CONVERGED and retreat(self):
        outcome = climb(self, DAMPED_NEWTON, outcome, &used)
    if outcome != CONVERGED and self.equations.coast != NULL:
        outcome = climb(self, COASTING, outcome, &used)
    if outcome != CONVERGED and not inexact and not self.halves and has_saddles(self):
        outcome = climb(self, DESCENT, outcome, &used)
    if outcome != CONVERGED:
        outcome = go_on(self, outcome, &used)
    if outcome != CONVERGED:
        return outcome
    self.saddle = is_saddle(self)
    if self.economical and not self.newton:
        count_cost(self, attempt_cost(self, used))
        # No seed served that step, so the next one would begin far off with the last of them: a pile of
        # 100 cables needs 311 factors and one recovery in place of 447 and seven.
        if self.counts.reseeds_inside >= inside + 2 and not self.reseed_due:
            self.reseed_due = True
            self.counts.reseeds_between += 1
    return CONVERGED


cdef int confirm(void *context) noexcept nogil:
    """Compute the next solution to compare with the one found; it counts only if preferred.

    It is Newton's from the default predictor; then, if there is none or the matrix was indefinite,
    that from the start without acceleration, and a minimum of the potential.
    """
    cdef Loop *self = <Loop *>context
    cdef Rung rung = self.rung
    cdef int used = 0, outcome = GAINED_ENERGY
    cdef bint differs = retreat(self) or not (self.newton or rung > NEW_SEED), missing = False
    if self.compared < NEWTON and differs:
        self.compared = NEWTON
        outcome = climb(self, NEWTON, CONVERGED, &used)
        missing = outcome != CONVERGED
    missing = missing or self.counts.indefinite > self.indefinite_before
    if outcome != CONVERGED and missing and self.compared < COASTING and rung < COASTING:
        self.compared = COASTING
        if self.equations.coast != NULL:
            outcome = climb(self, COASTING, CONVERGED, &used)
    if outcome != CONVERGED and not self.halves and has_saddles(self) and (
            self.compared < DESCENT and rung < DESCENT):
        self.compared = DESCENT
        outcome = climb(self, DESCENT, CONVERGED, &used)
    if outcome == CONVERGED:
        tally(self, -1)
    self.rung, self.doubtful = rung, False
    self.saddle = is_saddle(self)
    return outcome


cdef void prefer(void *context) noexcept nogil:
    """Count the last solution of `confirm` as the recovery of the step."""
    cdef Loop *self = <Loop *>context
    tally(self, -1)
    record(self, self.compared, GAINED_ENERGY)
    self.rung = self.compared
    tally(self, 1)


cdef int again(void *context, int reason) noexcept nogil:
    """Search for another solution: by Newton's method, from another predictor, and by descent.

    A step of rough motion can have several.  Newton's corrections can converge to a saddle point
    from every start, while a minimum gains no energy.  All attempts of `solve` are made, so that one
    method does not miss what another finds.
    """
    cdef Loop *self = <Loop *>context
    cdef int used = 0
    tally(self, -1)
    if self.rung < NEWTON and not (self.newton and self.leapt == self.equations.leaps):
        # By Newton's method too if it retreated: only its damped corrections began at this predictor.
        reason = climb(self, NEWTON, reason, &used)
        if reason == CONVERGED:
            return CONVERGED
    if self.rung < COASTING and retreat(self):
        reason = climb(self, NEWTON, reason, &used)
        if reason == CONVERGED:
            return CONVERGED
    if self.rung < COASTING and self.equations.coast != NULL:
        reason = climb(self, COASTING, reason, &used)
        if reason == CONVERGED:
            return CONVERGED
    if self.rung < DESCENT and not self.halves and has_saddles(self):
        reason = climb(self, DESCENT, reason, &used)
        if reason == CONVERGED:
            return CONVERGED
    return go_on(self, reason, &used)


cdef int repeat(void *context) noexcept nogil:
    """Solve the step with other equations, by the chosen method and a new seed.

    The properties of the solution of the former ones remain, for it may still be accepted.
    """
    cdef Loop *self = <Loop *>context
    cdef Rung rung = self.rung, compared = self.compared
    cdef int doubtful = self.doubtful, saddle = self.saddle, outcome
    cdef bint ran_out = self.ran_out, leapt = self.leapt
    tally(self, -1)
    record(self, NEW_SEED, GAINED_ENERGY)
    retreat(self)
    self.equations.restart(self.equations.context)
    self.reseed_due = True
    self.step -= 1
    outcome = solve(self)
    self.counts.recoveries_reseed += outcome == CONVERGED and self.rung == METHOD
    self.rung, self.compared, self.doubtful, self.saddle = rung, compared, doubtful, saddle
    self.ran_out, self.leapt = ran_out, leapt
    self.reseed_due = True
    return outcome
