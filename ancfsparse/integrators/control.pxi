"""The error of a step and what follows from it for the next one; text for `_march.pyx`."""
from libc.math cimport fmax, sqrt


cdef double NEWEST = 0.25  # share of the last step in the mean rate of the accelerations


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
    """Estimate the error of the step just solved; say whether it is one that it may have.

    It is a constant times dt^2 and the change of the acceleration, which stiff modes that the step
    does not resolve would fill: ``S^-1 M``, S the matrix of the step, leaves slow modes alone and
    takes modes of dt omega >> 1 for what they are, and keeps what constraints allow.
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
    """Take the step just judged into the mean rate of the accelerations; say if steps may grow."""
    cdef ptrdiff_t i
    cdef double newest
    # Stiff modes change sides with every step: a mean over some steps leaves little of them.
    self.judged += 1
    newest = fmax(1.0 / self.judged, NEWEST)
    for i in range(n):
        self.jerk[i] += newest * (self.change[i] / dt - self.jerk[i])
    self.calm = self.calm + 1 if self.error <= self.easy else 0
    if self.calm < self.patience:
        return False
    self.calm = 0
    return True
