"""Residual, work and work bound of loads that depend on the coordinates.

The file that includes this has a structure `Data` with `n_all`, and `add`, which subtracts the forces
at q from r.
"""


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    add(<const Data *>context, x.q, x.amplitudes, r)


cdef double work(void *context, const ancf_state *x0, const ancf_state *x1,
                 double *scratch) noexcept nogil:
    """The mean of the forces in both states times the displacement; the residual is -f."""
    cdef const Data *self = <const Data *>context
    cdef double total = 0.0
    cdef ptrdiff_t i
    memset(scratch, 0, self.n_all * sizeof(double))
    add(self, x0.q, x0.amplitudes, scratch)
    add(self, x1.q, x1.amplitudes, scratch)
    for i in range(self.n_all):
        total -= 0.5 * scratch[i] * (x1.q[i] - x0.q[i])
    return total


cdef double reach(void *context, const double *q0, const double *q1, const double *amplitudes,
                  double *scratch) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef double total = 0.0
    cdef ptrdiff_t i
    memset(scratch, 0, self.n_all * sizeof(double))
    add(self, q1, amplitudes, scratch)
    for i in range(self.n_all):
        total += fabs(scratch[i] * (q1[i] - q0[i]))
    return total
