"""Rate of the accelerations, for changes of the step size; included by `_newmark_family.pyx`."""
from libc.math cimport fmax


cdef double NEWEST = 0.25  # weight of the last step in the mean rate


cdef struct MeanJerk:
    double *mean  # NULL for steps of fixed length
    ptrdiff_t steps


cdef void follow(MeanJerk *self, const double *a0, const double *a, ptrdiff_t n,
                 double dt) noexcept nogil:
    """Update the mean rate by an accepted step."""
    cdef ptrdiff_t i
    cdef double newest
    # Stiff modes alternate in sign from step to step: averaging over some steps removes them.
    self.steps += 1
    newest = fmax(1.0 / self.steps, NEWEST)
    for i in range(n):
        self.mean[i] += newest * ((a[i] - a0[i]) / dt - self.mean[i])
