"""Error estimate and step size control; included by `_march.pyx`."""
from libc.math cimport fmax, sqrt


cdef double NEWEST = 0.25  # weight of the last step in the mean rate of the accelerations


cdef struct Control:
    const ancf_seed *seed  # NULL for steps of fixed length
    double *weight
    double *change  # of the accelerations over the step
    double *filtered
    double *jerk
    double constant, limit, easy, error
    int patience, calm
    ptrdiff_t judged


cdef bint accurate(Control *self, const ancf_system *system, double dt, const double *a0,
                   const double *a, double *scratch) noexcept nogil:
    """Estimate the error of the step just solved; return whether it is within the limit.

    The estimate is a constant times dt^2 and the change of the acceleration, which would be
    dominated by stiff modes that the step does not resolve.  The filter ``S^-1 M``, where S is the
    iteration matrix, leaves slow modes unchanged, damps modes with dt omega >> 1, and respects
    constraints.
    """
    cdef ptrdiff_t i
    cdef double total = 0.0
    for i in range(system.n_all):
        self.change[i] = a[i] - a0[i]
    system.inertia(system.context, self.change, scratch)
    for i in range(system.n_free):
        self.filtered[i] = scratch[i]
    for i in range(system.n_multipliers):
        self.filtered[system.n_free + i] = 0.0
    self.seed.solve(self.seed.context, self.filtered, self.filtered)
    for i in range(system.n_free):
        total += self.weight[i] * self.filtered[i] * self.filtered[i]
    self.error = self.constant * dt * dt * sqrt(total)
    if self.error <= self.limit:
        return True
    self.calm = 0
    return False


cdef bint follow(Control *self, ptrdiff_t n, double dt) noexcept nogil:
    """Update the mean rate of the accelerations; return whether the step size may grow."""
    cdef ptrdiff_t i
    cdef double newest
    # Stiff modes alternate in sign from step to step: averaging over some steps removes them.
    self.judged += 1
    newest = fmax(1.0 / self.judged, NEWEST)
    for i in range(n):
        self.jerk[i] += newest * (self.change[i] / dt - self.jerk[i])
    self.calm = self.calm + 1 if self.error <= self.easy else 0
    if self.calm < self.patience:
        return False
    self.calm = 0
    return True
