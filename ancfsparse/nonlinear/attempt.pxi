"""One attempt at a step: corrections from the predictor until they are small; text for `_iteration`."""
from libc.math cimport NAN, fmin, isfinite


cdef double GROWTH = 1e4  # residual beside the predictor's: past this an attempt is given up
cdef double STALE = 1.2  # a contraction that was not measured again is trusted less in each step
cdef double BELIEF = 2.0  # times the tolerance: residual over diagonal that a small correction may leave


cdef bint residual_is_small(Loop *self, const double *r) noexcept nogil:
    cdef ptrdiff_t nq = self.equations.n_coordinates
    return (all_below(r, nq, self.force_tolerance)
            and all_below(r + nq, self.n - nq, self.constraint_tolerance))


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
