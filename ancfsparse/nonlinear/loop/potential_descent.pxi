"""The last fallback: minimization of the incremental potential of a step; included by `_iteration`.

Without multipliers the residual of a step is the gradient of a potential: the strain energy, and
the kinetic energy of the change of velocity in the step.  Where cables buckle it has saddle points,
to which full corrections converge as readily as to minima, if at all.  A positive definite seed
always gives a direction of descent; the slope along it, the product of correction and residual,
determines the step length.
"""


cdef double LEVEL = 0.5  # largest slope past the minimum, as a fraction of the initial one
cdef double SHORTEST = 0.1  # smallest factor by which a step that is too long is shortened
cdef enum:
    MOST_SHORTER = 20  # trials


cdef double walk(Loop *self, double slope) noexcept nogil:
    """Search along z; return the step length as a fraction of z, 0 if there is no decrease."""
    cdef const ancf_equations *eq = self.equations
    cdef double whole = 1.0, shorter, here
    cdef int tried
    eq.correct(eq.context, -1.0, self.z)
    for tried in range(MOST_SHORTER):
        evaluate(self, self.r_new)
        here = dot_parts(self.parts, self.z, self.r_new, self.n)
        if here >= -LEVEL * slope and isfinite(here):
            return whole
        shorter = whole * (fmax(SHORTEST, slope / (slope - here)) if isfinite(here) else SHORTEST)
        eq.correct(eq.context, whole - shorter, self.z)
        whole = shorter
    return 0.0


cdef int descend(Loop *self, int *used) noexcept nogil:
    """Minimize from the current coordinates; return CONVERGED or the reason of the failure."""
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
        multiply(self, self.r, True)
        slope = dot_parts(self.parts, self.z, self.r, self.n)
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
            bound = bound_of(self, size, norm)
        swap = self.r
        self.r = self.r_new
        self.r_new = swap
        norm = norm_new
        if (residual_is_small(self, self.r) if not self.by_correction
                else norm <= bound or size <= self.noise):
            return CONVERGED
    return TOO_MANY
