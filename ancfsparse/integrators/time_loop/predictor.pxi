"""The predictor of a step, and detection of alternating accelerations; included by `loop.pxi`.

Vibrations that steps do not resolve alternate in sign: the next acceleration is then closer to the
one before the last than to the last one.  It is stored and compared only where steps are hard.
"""

cdef enum:
    # Phases: the acceleration before the last is not stored; stored; the better start.
    UNKNOWN, KEPT, ALTERNATES

# Number of corrections from which a step is hard enough for another start to pay off.
cdef ptrdiff_t HARD_TO_START = 3
# Squared distance from the acceleration before the last, over that from the last, at which it is
# the better start.  With 1, smooth motions switch back and forth, which costs Newton up to 8 %.
cdef double NEARER = 0.5


cdef void predict(Motion *self, const double *a) noexcept nogil:
    """Set the predictor from an acceleration and the multipliers of the last step (equation 4).

    The acceleration is the last one, an earlier one, or in the place of the iterate the predicted one.
    """
    self.start = a
    in_parts(self.n_parts, restart_part, self)
    self.interface.moved = sqrt(total(self, self.squares) / self.interface.mass_total)
    self.elsewhere = a != self.a0
    memcpy(self.lam, self.lam0, self.m * sizeof(double))
    self.interface.shift = 0.0
    if a == self.a:
        self.interface.shift = self.scale * sqrt(extrapolated_square(self) / self.interface.mass_total)
    self.corrected = False
    self.corrections = 0


cdef void restart(void *context) noexcept nogil:
    """Set the predictor: the default one if the solver has cleared ``leaps``.

    A step can have several solutions, which are reached from different starts.
    """
    cdef Motion *self = <Motion *>context
    if not self.interface.leaps:
        predict(self, self.a0)
    elif self.trend.near and self.phase[0] != ALTERNATES:
        predict(self, self.a)
    else:
        predict(self, self.earlier)


cdef void begin(Motion *self) noexcept nogil:
    """Set the predictor that is likely to be the closest."""
    self.interface.leaps = self.phase[0] == ALTERNATES or (
        self.trend.near and not self.interface.sudden)
    restart(self)


cdef void compare_part(void *context, ptrdiff_t part) noexcept nogil:
    """Compare the accelerations of the step with the last two, and store the last."""
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t begin = share(self, part), n = share(self, part + 1) - begin
    cdef const double *mass = self.interface.mass + begin
    if self.phase[0] == UNKNOWN:
        memcpy(self.earlier + begin, self.a0 + begin, n * sizeof(double))
    else:
        vec_compare(mass, self.a + begin, self.a0 + begin, self.earlier + begin, n,
                    &self.squares[part], &self.others[part])


cdef void choose_start(Motion *self) noexcept nogil:
    """Choose the predictor of the next step: the one that would have been closer in this step."""
    if self.interface.mass == NULL or (
            self.phase[0] != ALTERNATES and self.corrections < HARD_TO_START):
        self.phase[0] = UNKNOWN
        return
    in_parts(self.n_parts, compare_part, self)
    if self.phase[0] != UNKNOWN and total(self, self.others) < NEARER * total(self, self.squares):
        self.phase[0] = ALTERNATES
    else:
        self.phase[0] = KEPT
