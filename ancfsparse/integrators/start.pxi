"""Where a step starts: its predictor, and whether accelerations alternate; text for `loop.pxi`.

Vibrations that steps do not resolve change sides in each: there the acceleration before the last is
nearer to the next one than the last is.  It is kept and compared only where steps are hard.
"""

cdef enum:
    UNKNOWN, KEPT, ALTERNATES  # phases: no acceleration before the last; one; it is the better start

# Corrections from which a step is hard enough for another start to pay.
cdef ptrdiff_t HARD_TO_START = 3
# Squared distance from the acceleration before the last, over that from the last, at which it is the
# better start.  At 1 smooth motions change to and fro, which costs Newton up to 8 %.
cdef double NEARER = 0.5


cdef void predict(Motion *self, const double *a) noexcept nogil:
    """The predictor with an acceleration, and with the multipliers of the last step (equation 4)."""
    self.start = a
    in_parts(self.n_parts, restart_part, self)
    self.interface.moved = sqrt(total(self, self.squares) / self.interface.mass_total)
    self.elsewhere = a != self.a0
    memcpy(self.lam, self.lam0, self.m * sizeof(double))
    self.corrected = False
    self.corrections = 0


cdef void restart(void *context) noexcept nogil:
    """The predictor, the sure one if the solver has chosen it.

    A step can have several solutions, to each of which leads another start.
    """
    cdef Motion *self = <Motion *>context
    predict(self, self.earlier if self.interface.leaps else self.a0)


cdef void begin(Motion *self) noexcept nogil:
    """The predictor that is likely the nearest."""
    self.interface.leaps = self.phase[0] == ALTERNATES
    restart(self)


cdef void compare_part(void *context, ptrdiff_t part) noexcept nogil:
    """Compare the accelerations of the step with both before, and keep the last."""
    cdef Motion *self = <Motion *>context
    cdef ptrdiff_t begin = share(self, part), n = share(self, part + 1) - begin
    cdef const double *mass = self.interface.mass + begin
    if self.phase[0] != UNKNOWN:
        self.squares[part] = weigh_apart(mass, self.a + begin, self.a0 + begin, n)
        self.others[part] = weigh_apart(mass, self.a + begin, self.earlier + begin, n)
    memcpy(self.earlier + begin, self.a0 + begin, n * sizeof(double))


cdef void choose_start(Motion *self) noexcept nogil:
    """Choose where the next step starts: which start would have been nearer in this one."""
    if self.interface.mass == NULL or (
            self.phase[0] != ALTERNATES and self.corrections < HARD_TO_START):
        self.phase[0] = UNKNOWN
        return
    in_parts(self.n_parts, compare_part, self)
    if self.phase[0] != UNKNOWN and total(self, self.others) < NEARER * total(self, self.squares):
        self.phase[0] = ALTERNATES
    else:
        self.phase[0] = KEPT
