"""Prediction of the next acceleration from its last changes; included by `loop.pxi`.

The changes of the accelerations in the last step, d, and in the one before, e, predict the next one as
x d + y e, where x and y would have been best in the last step: least squares, weighted by mass.  That
is used after steps in which it was close, or would have been, with x and y from the step before.
"""
from libc.math cimport fmax, isfinite, rint


# Square of the share of a change that a prediction may miss to be close.
cdef double MISSED = 0.25
# Square of the sine of the angle between changes below which they are parallel: single precision.
cdef double PARALLEL = 1e-10
# Parts of one to which x and y are rounded, so that steps start from the same numbers whatever the
# order of sums was.
cdef double PARTS = 1024.0


cdef void forget(Motion *self) noexcept nogil:
    """Drop the changes, since the next step is not like the last ones."""
    cdef Trend *trend = &self.trend
    trend.near = False
    trend.x = trend.y = trend.squares = trend.product = trend.squares_before = 0.0


cdef inline void extrapolate(const Motion *self, ptrdiff_t begin, ptrdiff_t n) noexcept nogil:
    """Predict a range of accelerations."""
    vec_follow(self.a + begin, self.a0 + begin, self.trend.x, self.trend.last + begin,
               self.trend.y, self.trend.before + begin, n)


cdef double extrapolated_square(const Motion *self) noexcept nogil:
    """Square, weighted by mass, of the predicted change."""
    cdef const Trend *trend = &self.trend
    return fmax(0.0, trend.x * trend.x * trend.squares + 2.0 * trend.x * trend.y * trend.product
                + trend.y * trend.y * trend.squares_before)


cdef inline void note(Motion *self, ptrdiff_t part, ptrdiff_t begin, ptrdiff_t n) noexcept nogil:
    """Store the change in a solved step, in a range about to be accepted, and add up products."""
    if self.trend.used:
        vec_changes(self.interface.mass + begin, self.a + begin, self.a0 + begin,
                    self.trend.last + begin, self.trend.before + begin, n,
                    self.trend.sums + 3 * part)


cdef void extend_trend(Motion *self) noexcept nogil:
    """Find what predicts the next change, from the products that `note` has added up."""
    cdef Trend *trend = &self.trend
    cdef double[3] s  # square of the change, and its products with the last and the one before
    cdef double missed, area
    cdef ptrdiff_t k, part
    if not trend.used:
        return
    for k in range(3):
        s[k] = 0.0
        for part in range(self.n_parts):
            s[k] += trend.sums[3 * part + k]
            trend.sums[3 * part + k] = 0.0
    trend.last, trend.before = trend.before, trend.last
    missed = s[0] - 2.0 * (trend.x * s[1] + trend.y * s[2]) + extrapolated_square(self)
    area = trend.squares * trend.squares_before - trend.product * trend.product
    trend.x = trend.y = 0.0
    if area > PARALLEL * trend.squares * trend.squares_before:
        trend.x = (s[1] * trend.squares_before - s[2] * trend.product) / area
        trend.y = (s[2] * trend.squares - s[1] * trend.product) / area
    elif trend.squares > 0.0:
        trend.x = s[1] / trend.squares
    trend.x, trend.y = rint(PARTS * trend.x) / PARTS, rint(PARTS * trend.y) / PARTS
    trend.near = missed < MISSED * s[0] and isfinite(trend.x) and isfinite(trend.y)
    if self.interface.sudden:
        forget(self)
        return
    trend.squares_before = trend.squares
    trend.squares, trend.product = s[0], s[1]
