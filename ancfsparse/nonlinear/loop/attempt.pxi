"""One attempt at a step: iteration from the predictor to convergence; included by `_iteration`."""
from libc.math cimport NAN, fmin, isfinite, ldexp


cdef double GROWTH = 1e4  # ratio of residuals to the predictor's at which an attempt is abandoned
# Factor in length between first corrections of one smooth motion.  With 1, steps alternate between
# one and two corrections, and step size control takes that for errors and rejects four times as many.
cdef double LONGER = 2.0
cdef double STALE = 1.2  # growth per step of a contraction that has not been measured again
cdef double TRUST = 0.1  # smallest contraction that is assumed without evaluating the residual
# Share of its bound at which a residual needs no last correction: at a tenth what was left made a
# steel rod lose 5 % more energy than exact steps do.
cdef double SPARED = 0.01
cdef double SLUGGISH = 0.2  # contraction of the residual above which pairs save more than they cost
cdef double SHAKY = 10.0  # times the bound: residual allowed where corrections are rounding error
# Newton's corrections that converge leave c |r|^2 of a residual r, so every contraction is the square
# of the last: if that was a half, five more leave less than rounding, 0.5^(2 + 4 + 8 + 16 + 32).
# They are a fifth of the iterations by default, and of fewer iterations a fifth at most.
cdef double HALVED = 0.5
# Contraction of residuals that are not yet rounding.  With 0.1 the error of 40 linkages is 1.4e-6 m
# after 6 s in steps of 0.1 ms, and 8e-7 m with 0.5, a sixteenth of that in steps of 0.4 ms.
cdef double DECREASING = 0.5
cdef enum:
    CLOSING = 5
    # Factor on the number of corrections in descent and in the last attempt by damped Newton.  Of 700
    # random runs with contact 30 failed without that attempt and 21 with it: points that slip or stick
    # by turns make the residual fall slowly.
    PATIENT = 4


cdef bint residual_is_small(Loop *self, const double *r) noexcept nogil:
    cdef ptrdiff_t nq = self.equations.n_coordinates
    return (all_below(r, nq, self.force_tolerance)
            and all_below(r + nq, self.n - nq, self.constraint_tolerance))


cdef inline double bound_of(const Loop *self, double size, double norm) noexcept nogil:
    """Allowed error of the iteration in a step [m], from its first correction and residual.

    The error of the integrator in the step is a fixed fraction of the change from the default
    predictor: the first correction, or the least that it leaves of a change predicted otherwise.  And
    the remaining residual does work along the displacement.
    """
    cdef const ancf_equations *eq = self.equations
    cdef double first = size if eq.mass == NULL else fmin(size, norm)
    cdef double change = fmax(first - eq.shift, eq.shift - size), way = eq.moved + first
    return fmax(self.floor, fmin(self.correction_tolerance,
                                 fmin(self.share * change, self.work * way)))


cdef inline double rate_of(const Loop *self, double size) noexcept nogil:
    """Contraction to expect after a first correction of a length.

    It was measured in earlier steps, and is proportional to the length where equations curve.  It
    holds for no load that jumps: motions along a straight beam are linear, those across it are not.
    """
    if self.equations.sudden:
        return 0.99
    if size <= LONGER * self.measured:
        return self.rate
    return fmin(self.rate * size / self.measured, 0.99) if self.measured > 0.0 else 0.99


cdef bint finish(Loop *self, double size, bint needed, bint newton) noexcept nogil:
    """Update with the last pair, and correct once more with the residual already computed.

    Return whether that correction is made.

    This costs no further residual, but a solve, unless the update takes it; so it is left out where it
    is not needed.  Davidon's inverse may be far off in a new direction, so its correction could not
    be trusted without a residual; nor is one trusted that is longer than the last.  Newton's
    corrections neither teach an inverse nor depend on one.
    """
    cdef ptrdiff_t n = self.n
    cdef bint polishes = self.polishes or newton
    if self.carry and not newton:
        combined(self.parts, self.y, 1.0, self.r_new, -1.0, self.r, n)
        learn(self, self.r_new)
    elif not needed:
        return False
    elif polishes:
        multiply(self, self.r_new, newton)
    if polishes and length(self, self.z) <= size:
        self.equations.correct(self.equations.context, -1.0, self.z)
        self.counts.last_corrections += 1
        return True
    return False


cdef int attempt(Loop *self, bint newton, bint damped, bint economical, int *used) noexcept nogil:
    """Iterate from the predictor; return CONVERGED or the reason of the failure.

    From the guess without acceleration a few more corrections follow, if they converge when their
    number is used up.
    If economical, a new seed is computed wherever continuing without it would cost more.
    """
    cdef const ancf_equations *eq = self.equations
    cdef double *z = self.z
    cdef double *swap
    cdef ptrdiff_t n = self.n
    cdef int it, halvings, most = self.max_iterations, more = 0
    cdef bint done, small, closer, pairs, learns = not newton and self.learns, always = not self.sparing
    # Whether the residual is evaluated after every correction, or estimated from the contraction.
    cdef bint looks = ((learns and always) or damped or self.sure or n > eq.n_coordinates
                       or not self.by_correction)
    cdef double size, last_size = 0.0, norm, last_norm = 0.0, norm_new, start, bound = 0.0
    cdef double left, allowed = 0.0
    cdef double theta, last_theta = 0.0, remaining, progress, rate
    self.contraction = NAN
    self.extra_before = extra_so_far(self)
    evaluate(self, self.r)
    norm = start = unbalance(self, self.r)
    if not isfinite(norm):
        return NOT_FINITE
    if residual_is_small(self, self.r) and not self.by_correction:
        return CONVERGED
    if newton or not self.seeded or self.reseed_due:
        renew_seed(self, newton, 0.0)
    else:
        start_from_seed(self)
    multiply(self, self.r, newton)
    if self.rung == COASTING:
        more = min(CLOSING, most // CLOSING)
    elif self.rung == LONG_NEWTON:
        most *= PATIENT
    for it in range(most + more):
        size = sqrt(eq.correct(eq.context, -1.0, z) / eq.mass_total)
        used[0] += 1
        self.counts.iterations += 1
        if it == 0:
            bound = bound_of(self, size, norm)
            rate = rate_of(self, size)
        else:
            theta = size / last_size
            if not newton:
                theta = fmax(theta, norm / last_norm)
            rate = self.rate = fmin(fmax(0.3 * self.rate, theta), 0.99)
            if it == 1:
                self.measured = last_size
                # Behind a predicted change the first correction was enough: this one only measured,
                # and is no sign of a seed that is out of date.
                if eq.shift > 0.0 and not newton and (
                        theta * fmax(last_size, last_norm) <= (1.0 - theta) * bound):
                    used[0] -= 1
        last_size, last_norm = size, norm
        left = rate / (1.0 - rate) * (size if newton else fmax(size, norm))
        small = self.by_correction and (left <= bound or size <= self.noise)
        if small and not looks:
            if it == 0:
                self.rate = fmin(STALE * self.rate, SLOW)
                self.measured *= STALE
            return CONVERGED
        evaluate(self, self.r_new)
        norm_new = unbalance(self, self.r_new)
        if damped:
            # Halve a step that increases the residual; the last trial is accepted in any case.
            halvings = 0
            while not norm_new <= norm and halvings < 6 and not small:
                halvings += 1
                eq.correct(eq.context, ldexp(1.0, -halvings), z)
                evaluate(self, self.r_new)
                norm_new = unbalance(self, self.r_new)
        if not isfinite(norm_new):
            return NOT_FINITE
        theta = norm_new / norm
        # If pairs are used sparingly, conjugate gradients and sweeps that contract well use none.
        pairs = learns and (always or (theta > SLUGGISH and self.extra == 0.0))
        if pairs or (learns and self.carry):
            scaled(self.parts, self.s, -1.0, z, n)
        done = False
        if not self.by_correction:
            done = residual_is_small(self, self.r_new)
        elif looks:
            left = norm_new
            allowed = bound
            if self.sure:  # a first correction may be far too long; now the displacement is known
                allowed = fmax(self.floor, fmin(bound, self.work * eq.moved))
            if (newton or (self.polishes and not self.carry)) and not self.sure and theta < 0.5:
                left *= fmax(theta / (1.0 - theta), TRUST)  # after the last correction, see finish
            # With an inverse that is nearly singular by chance, any correction is small.
            done = ((left <= allowed or (size <= self.noise and norm_new <= SHAKY * allowed))
                    and all_below(self.r_new + eq.n_coordinates, n - eq.n_coordinates,
                                  fmax(self.constraint_tolerance, bound)))
            # The floor is an upper bound of rounding.  For a tolerance below it residuals decrease
            # until they are rounding: errors of the floor add up near singular configurations.
            if (done and self.correction_tolerance < self.floor and theta < DECREASING
                    and it + 1 < most):
                done = False
        if done and (self.by_correction or not newton) and size > self.noise:
            done = (finish(self, size, self.sure or norm_new > SPARED * allowed, newton)
                    or norm_new <= allowed or not self.by_correction)
        if done:
            return CONVERGED
        if norm_new > GROWTH * start and it > 0 and not damped:
            return DIVERGED
        self.contraction = theta
        swap = self.r
        self.r = self.r_new
        self.r_new = swap
        norm = norm_new
        if newton:
            renew_seed(self, newton, 0.0)
            if it + 1 >= most and theta >= HALVED:
                break
            multiply(self, self.r, newton)
            continue
        if economical and (it > 0 or theta > 0.7):
            if self.by_correction:
                remaining = norm / bound
            else:
                remaining = largest(self.r, eq.n_coordinates) / self.force_tolerance
            progress = sqrt(theta * last_theta) if last_theta > 0.0 else theta
            closer = remaining > 1.0 and solves_closer(self, progress)
            if closer or (remaining > 1.0 and waiting_costs_more(self, progress, remaining)):
                if not closer:
                    self.counts.reseeds_inside += 1
                    renew_seed(self, newton, attempt_cost(self, used[0]))
                multiply(self, self.r, newton)
                # The contraction of the old seed does not count for the new one, except with secant
                # pairs, which improve it later: else a four-bar linkage needed 30 factors, not 9.
                last_theta = theta if learns else 0.0
                continue
        last_theta = theta
        if pairs:
            combined(self.parts, self.y, 1.0, self.r, -1.0, self.r_new, n)
            learn(self, self.r)
        else:
            multiply(self, self.r, newton)
    return TOO_MANY
