"""Pressure with a coefficient of restitution; included by `_contacts.pyx`.

The pressure is p(e) (1 + gamma tanh s), s = e' / (c (e + D)), gamma = (1 - eps^2) / (1 + eps^2).  As |s|
is large except near the largest penetration, where the potential is W, the kinetic energy is
(1 + gamma) W before the impact and (1 - gamma) W after it, and the speed eps times that before.  For
p = k e an impact is the same function of time at all speeds.  Between two states e' is
(e1 - e0) / dt and e the mean of the penetrations; the loss P gamma tanh(s) (e1 - e0) is not negative.
"""


cdef inline double impact_rate(const Data *self, ptrdiff_t k, const Place *here,
                               const double *v) noexcept nogil:
    """Return s in a state."""
    return -separation_rate(self, k, v, here) / (
        self.slow[k] * ((here.e if here.e > 0.0 else 0.0) + self.layer[k]))


cdef inline double force_in_state(const Data *self, ptrdiff_t k, const Place *here,
                                  const double *v) noexcept nogil:
    """Force of the pressure at the end of a step, with all damping."""
    cdef double force = damped_force(self, k, here.e)
    if force > 0.0 and self.gamma > 0.0 and v != NULL:
        force *= 1.0 + self.gamma * tanh(impact_rate(self, k, here, v))
    return force


cdef inline double saved_force(const Data *self, ptrdiff_t k, const Place *here,
                               const double *v) noexcept nogil:
    """Force of the pressure in a state, without the numerical damping of a step."""
    cdef double force = self.stiffness[k] * law_force(here.e, self.layer[k])
    if force > 0.0 and self.gamma > 0.0 and v != NULL:
        force *= 1.0 + self.gamma * tanh(impact_rate(self, k, here, v))
    return force


cdef inline void restrain(const Data *self, ptrdiff_t k, const Place *here, const double *v,
                          double *force, double *slope) noexcept nogil:
    """Multiply the pressure in a state, and set its derivative by the penetration."""
    cdef double s = impact_rate(self, k, here, v), t = tanh(s)
    slope[0] = (1.0 + self.gamma * t) * slope[0] - (
        self.gamma * (1.0 - t * t) * s / (here.e + self.layer[k]) * force[0])
    force[0] *= 1.0 + self.gamma * t


cdef inline double restitution_damping(const Data *self, ptrdiff_t k, const Place *here,
                                       const double *v) noexcept nogil:
    """Derivative of the pressure in a state by e' [N s/m]."""
    cdef double t
    if here.e <= 0.0:
        return 0.0
    t = tanh(impact_rate(self, k, here, v))
    return (self.gamma * (1.0 - t * t) / (self.slow[k] * (here.e + self.layer[k]))
            * self.stiffness[k] * law_force(here.e, self.layer[k]))


cdef inline double force_between(const Data *self, ptrdiff_t k, double e0, double e1,
                                 double *slope) noexcept nogil:
    """Force of the pressure between two states, and twice its derivative by e1 as in `mean_slope`."""
    cdef double force = mean_force(e0, e1, self.layer[k]), depth, rate, s, t
    if slope != NULL:
        slope[0] = self.stiffness[k] * mean_slope(e0, e1, self.layer[k])
    if self.gamma == 0.0 or self.interval == 0.0:
        return self.stiffness[k] * force
    depth = 0.5 * ((e0 if e0 > 0.0 else 0.0) + (e1 if e1 > 0.0 else 0.0)) + self.layer[k]
    rate = 1.0 / (self.interval * self.slow[k] * depth)
    s = (e1 - e0) * rate
    t = tanh(s)
    if slope != NULL:
        if e1 > 0.0:
            rate -= 0.5 * s / depth
        slope[0] = (1.0 + self.gamma * t) * slope[0] + (
            2.0 * self.gamma * (1.0 - t * t) * rate * self.stiffness[k] * force)
    return self.stiffness[k] * (1.0 + self.gamma * t) * force
