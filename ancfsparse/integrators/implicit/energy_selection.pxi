"""Selection of the solution of a hard step by its energy; included by `_march.pyx`."""


cdef bint settle(Motion *self, const ancf_nonlinear *solver) noexcept nogil:
    """Check the energy of a hard step before it is accepted; return whether a solution passes.

    Such a step can have several solutions.  One whose energy rises is compared with others, and a
    saddle point of the potential gives way to a minimum below it.  One that gains energy is
    rejected while another may not, or the step can be shortened; if all gain energy, the one with
    the smallest gain passes on trial unless that is large, and the next regular check decides.
    Where the size of steps changes, the first that gains energy ends the run.
    """
    cdef ancf_watch before = self.watch, best
    cdef bint varies = self.scheme.jerk.mean == NULL
    cdef bint gains = see(self, solver.doubtful[0])
    cdef bint saddle = solver.saddle[0]
    if not gains and not (varies and ancf_watch_rises(&self.watch, &before)):
        return pass_it(self)
    best = self.watch
    unsee(self, &before)
    if not varies:
        return False
    keep(self, True)
    if not gains:
        while solver.confirm(solver.context) == 0:
            if not see(self, False) and (
                    conserves_better(&self.watch, &best, &before)
                    or (saddle and not solver.saddle[0] and ancf_watch_rises(&best, &self.watch))):
                solver.prefer(solver.context)
                return pass_it(self)
            unsee(self, &before)
        keep(self, False)
        see(self, False)
        return pass_it(self)
    while solver.again(solver.context, GAINED_ENERGY) == 0:
        if not see(self, solver.doubtful[0]):
            return pass_it(self)
        if self.watch.gain < best.gain or best.gain != best.gain:
            keep(self, True)
            best = self.watch
        unsee(self, &before)
    if self.shortens:
        return False
    keep(self, False)
    see(self, False)
    if not ancf_watch_gains_much(&self.watch, self.system.contacts_changed != NULL):
        try_it(self)
        return pass_it(self)
    unsee(self, &before)
    return False


cdef bint is_pending(const Motion *self) noexcept nogil:
    """Return True if a step on trial has gained too much for the energy exchanged up to now."""
    return self.scheme.most_tried > self.watch.limit * self.watch.exchanged


cdef void try_it(Motion *self) noexcept nogil:
    """Note a step whose solutions all gain too much: a run that fails does not keep it.

    In the first steps a motion has exchanged too little energy to judge.
    """
    if self.watch.steps + 1 < WATCH_EVERY or not ancf_watch_gains(&self.watch, False):
        return
    if not is_pending(self):
        self.scheme.tried = self.watch
        self.scheme.most_tried = 0.0
    self.scheme.most_tried = fmax(self.scheme.most_tried, self.watch.beyond)


cdef inline bint conserves_better(const ancf_watch *now, const ancf_watch *best,
                                  const ancf_watch *before) noexcept nogil:
    """Return True if the energy rises by less than in the best solution, and falls by no more."""
    return ancf_watch_rises(best, now) and before.gain - now.gain <= best.gain - before.gain


cdef bint see(Motion *self, bint strict) noexcept nogil:
    """Evaluate the energy after the current step; return whether the gain is too large.

    Neither does a solution pass in which bodies pass through each other.

    The new velocity temporarily takes the place of the old one, which needs no extra memory.
    """
    add_work(self)
    self.factor = 1.0
    in_parts(self.n_parts, push_part, self)
    if is_driven(self):
        swap_speeds(self)
    ancf_watch_measure(&self.watch, self.system, self.dead_load, self.amplitudes, self.q, self.v0,
                       self.r)
    self.scheme.refused = self.watch
    if strict:
        self.scheme.refused.exchanged = self.watch.kinetic
    return ancf_watch_gains(&self.watch, strict) or not is_admitted(self)


cdef void unsee(Motion *self, const ancf_watch *before) noexcept nogil:
    self.factor = -1.0
    in_parts(self.n_parts, push_part, self)
    if is_driven(self):
        swap_speeds(self)
    self.watch = before[0]


cdef bint pass_it(Motion *self) noexcept nogil:
    self.ahead = True
    return True


cdef void keep(Motion *self, bint there) noexcept nogil:
    """Copy the solution aside, or back.

    A solution copied back is evaluated again, since contacts between beams remember the points that
    touched in the last evaluated state.
    """
    cdef double *aside = self.scheme.aside
    cdef double *of[4]
    cdef ptrdiff_t n[4]
    cdef int i, parts = 4 if self.system.damped else 3  # otherwise there are no velocities
    of[0], of[1], of[2], of[3] = self.q, self.a, self.lam, self.v
    n[0] = n[1] = self.n_free
    n[2], n[3] = self.m, self.n_free
    for i in range(parts):
        memcpy(aside if there else of[i], of[i] if there else aside, n[i] * sizeof(double))
        aside += n[i]
    if not there:
        evaluate(self)
