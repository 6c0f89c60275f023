"""History of the bristles of pairs of elements, from one accepted step to the next; an include file.

A pair has its code, K and S of forces.pxi in one slot while it touches; with a static coefficient also 1 if it slides.
"""


cdef inline double code_of(const Data *self, const Bristle *each) noexcept nogil:
    """Return an odd number for two elements."""
    return 2.0 * (<double>each.a * self.n + each.b) + 1.0


cdef bint recall(Data *self) noexcept nogil:
    """Set the bristles of the last accepted state; return False without memory.

    Half a code is of the mean of two states, in one of which the pair does not touch.
    """
    cdef const double *slot
    cdef Bristle *each
    cdef ptrdiff_t k, i, c, width = self.width
    cdef double code
    memset(self.first_bristle, -1, self.n * sizeof(int32_t))
    self.n_bristles = 0
    for k in range(self.n_slots):
        slot = self.slots + k * width
        if slot[0] == 0.0:
            continue
        code = 0.5 * ((slot[0] if slot[0] == floor(slot[0]) else 2.0 * slot[0]) - 1.0)
        i = add_bristle(self, <int32_t>(code / self.n),
                        <int32_t>(<ptrdiff_t>code % self.n), <int32_t>k)
        if i < 0:
            return False
        each = self.bristle + i
        each.before = slot[1]
        each.slides = self.has_two and slot[2 + self.dim] > 0.0
        for c in range(self.dim):
            each.kept[c] = slot[2 + c]
    return True


cdef void keep_bristles(Data *self) noexcept nogil:
    """Write the history of an accepted state; new pairs take slots that were free before."""
    cdef const Bristle *each
    cdef double *slot
    cdef ptrdiff_t k, c, cursor = 0, width = self.width
    cdef bint is_full = False
    for k in range(self.n_bristles):
        each = self.bristle + k
        if each.limit == 0.0:
            continue
        if each.slot < 0:
            while cursor < self.n_slots and self.slots[cursor * width] != 0.0:
                cursor += 1
            if cursor == self.n_slots and not is_full:
                is_full, cursor = True, 0
                clear_slots(self)
                while cursor < self.n_slots and self.slots[cursor * width] != 0.0:
                    cursor += 1
            slot = self.slots + cursor * width
        else:
            slot = self.slots + each.slot * width
        slot[0], slot[1] = code_of(self, each), each.stiffness
        for c in range(self.dim):
            slot[2 + c] = each.end[c]
        if self.has_two:
            slot[2 + self.dim] = each.will_slide
    clear_slots(self)


cdef void clear_slots(Data *self) noexcept nogil:
    """Free the slots of pairs that touch no longer."""
    cdef const Bristle *each
    cdef ptrdiff_t k, width = self.width
    for k in range(self.n_bristles):
        each = self.bristle + k
        if each.slot >= 0 and each.limit == 0.0 and (
                self.slots[each.slot * width] == code_of(self, each)):
            memset(self.slots + each.slot * width, 0, width * sizeof(double))


cdef void settle(Data *self, const ancf_state *x) noexcept nogil:
    """Move the history to an accepted state, and set the friction on control points there."""
    cdef bint is_mean = self.stepped
    self.crowded = 0
    if not is_mean:
        set_friction(self, x, self.rubbed)
        keep_bristles(self)
        return
    if take_means(self, x) and set_bristles(self, True):
        keep_bristles(self)
