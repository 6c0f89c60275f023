"""A last attempt at a step: down the potential that its solution is a minimum of; text for `_iteration`.

Without multipliers the residual of a step is the gradient of a potential, the kinetic energy of
what the step changes and the strain energy.  Where cables buckle, that has saddles as well, to
which whole corrections lead as readily, or they lead anywhere.  A definite seed always shows a way
down, and the slope along it, the product of correction and residual, tells how far to go.
"""


cdef double LEVEL = 0.5  # share of the slope that may be left the other way, past the lowest point
cdef double SHORTEST = 0.1  # of a step that was too long
cdef enum:
    MOST_SHORTER = 20  # tries
    PATIENT = 4  # times the corrections of another attempt


cdef double walk(Loop *self, double slope) noexcept nogil:
    """Go along z as far as the potential falls; return the share of z, 0 if it falls nowhere."""
    cdef const ancf_equations *eq = self.equations
    cdef double whole = 1.0, shorter, here
    cdef int tried
    eq.correct(eq.context, -1.0, self.z)
    for tried in range(MOST_SHORTER):
        evaluate(self, self.r_new)
        here = dot(self.parts, self.z, self.r_new, self.n)
        if here >= -LEVEL * slope and isfinite(here):
            return whole
        shorter = whole * (fmax(SHORTEST, slope / (slope - here)) if isfinite(here) else SHORTEST)
        eq.correct(eq.context, whole - shorter, self.z)
        whole = shorter
    return 0.0


cdef int descend(Loop *self, int *used) noexcept nogil:
    """Iterate downhill from where the coordinates are; return CONVERGED or the reason why not."""
    cdef const ancf_equations *eq = self.equations
    cdef double *swap
    cdef double slope, share, size, norm, norm_new, bound = 0.0
    cdef int it
    evaluate(self, self.r)
    norm = unbalance(self, self.r)
    for it in range(PATIENT * self.max_iterations):
        if not isfinite(norm):
            return NOT_FINITE
        renew_seed(self, False, 0.0)
        if self.seed.refine != NULL:
            self.seed.refine(self.seed.context, CLOSE)
        multiply(self, self.r)
        slope = dot(self.parts, self.z, self.r, self.n)
        if not slope > 0.0:
            return DIVERGED
        share = walk(self, slope)
        if share == 0.0:
            return DIVERGED
        used[0] += 1
        self.counts.iterations += 1
        size = share * length(self, self.z)
        norm_new = unbalance(self, self.r_new)
        self.contraction = norm_new / norm
        if it == 0:
            bound = bound_of(self, size if eq.mass == NULL else fmin(size, norm))
        swap = self.r
        self.r = self.r_new
        self.r_new = swap
        norm = norm_new
        if (residual_is_small(self, self.r) if not self.by_correction
                else norm <= bound or size <= self.noise):
            return CONVERGED
    return TOO_MANY
