"""Blocks of the matrix that couple pairs of elements in contact; an include file.

A pair is listed when it touches in a residual, and left out again after an accepted step in which it
does not, once such pairs are the majority.
"""

# Pairs of an element on average that are coupled; memory is used up to the largest number only.
cdef enum:
    MOST_COUPLED = 16
    MOST_IDLE = 8  # pairs that do not touch, besides as many as do, before they are left out


cdef inline ptrdiff_t find_pair(const Coupling *self, int32_t a, int32_t b) noexcept nogil:
    """Return the index of a pair, or -1."""
    cdef int32_t low = min(a, b), high = max(a, b), k = self.first[low]
    while k >= 0 and self.pair[2 * k + 1] != high:
        k = self.next[k]
    return k


cdef void append_pair(Coupling *self, int32_t low, int32_t high) noexcept nogil:
    cdef int32_t k = <int32_t>self.list.n
    self.pair[2 * k], self.pair[2 * k + 1] = low, high
    self.next[k], self.first[low] = self.first[low], k
    self.touches[k] = True
    self.list.n += 1
    self.list.changes += 1


cdef bint were_near(const Data *self, int32_t a, int32_t b) noexcept nogil:
    """Return whether boxes of two elements were within the search's skin in the last accepted state."""
    cdef double[6] box
    cdef double[6] other
    cdef double reach = self.search.radius[a] + self.search.radius[b] + self.search.skin
    cdef int c
    for c in range(3):
        box[c] = box[3 + c] = self.before[12 * a + c]
        other[c] = other[3 + c] = self.before[12 * b + c]
    bounds(self.before + 12 * a, box, box + 3)
    bounds(self.before + 12 * b, other, other + 3)
    for c in range(3):
        if box[c] > other[3 + c] + reach or other[c] > box[3 + c] + reach:
            return False
    return True


cdef void list_pairs(Data *self, const Touches *touches) noexcept nogil:
    """List the pairs of all touching points until the list is full.

    Those that touch in a trial far from the last accepted state are left out.
    """
    cdef Coupling *coupling = &self.coupling
    cdef const Touch *each
    cdef ptrdiff_t k
    if not coupling.list.used:
        return
    for k in range(touches.n):
        each = touches.touch + k
        if k > 0 and each.a == touches.touch[k - 1].a and each.b == touches.touch[k - 1].b:
            continue
        if (coupling.list.n < coupling.room and find_pair(coupling, each.a, each.b) < 0
                and were_near(self, each.a, each.b)):
            append_pair(coupling, min(each.a, each.b), max(each.a, each.b))


cdef void empty_list(Coupling *self) noexcept nogil:
    cdef ptrdiff_t k
    for k in range(self.list.n):
        self.first[self.pair[2 * k]] = -1
    self.list.changes += self.list.n > 0
    self.list.n = 0


cdef void leave_out_idle_pairs(Coupling *self, const Touches *touches) noexcept nogil:
    """Shorten the list to the pairs that touch, if these are the minority."""
    cdef const Touch *each
    cdef ptrdiff_t k, where, active = 0, n = self.list.n
    cdef int32_t low, high
    if n == 0:
        return
    memset(self.touches, 0, n * sizeof(int32_t))
    for k in range(touches.n):
        each = touches.touch + k
        where = find_pair(self, each.a, each.b)
        if where >= 0 and not self.touches[where]:
            self.touches[where] = True
            active += 1
    if n <= 2 * active + MOST_IDLE:
        return
    empty_list(self)
    for k in range(n):
        if self.touches[k]:
            low, high = self.pair[2 * k], self.pair[2 * k + 1]
            append_pair(self, low, high)


cdef double *block_of(const Data *self, int32_t a, int32_t b, double *values) noexcept nogil:
    """Return the block that couples two elements, or NULL."""
    cdef ptrdiff_t where
    if not self.coupling.list.used:
        return NULL
    where = find_pair(&self.coupling, a, b)
    return NULL if where < 0 else (
        values + self.coupling.list.first + where * self.coupling.list.size)


cdef void add_coupling(const Data *self, int32_t low, int32_t high, const double *g,
                       const double *h, double stiffness, double *values) noexcept nogil:
    """Add - s g h^T of two elements."""
    cdef double *block = block_of(self, low, high, values)
    cdef ptrdiff_t i, j, n = 4 * self.dim
    if block == NULL:
        return
    for i in range(n):
        for j in range(n):
            block[n * i + j] -= stiffness * g[i] * h[j]


cdef void add_weighted_coupling(const Data *self, int32_t a, int32_t b, const double *of_a,
                                const double *of_b, const double *block,
                                double *values) noexcept nogil:
    """Add - S_a^T B S_b of two elements, for a symmetric B (3, 3)."""
    cdef double *out = block_of(self, a, b, values)
    cdef const double *of_low = of_a if a < b else of_b
    cdef const double *of_high = of_b if a < b else of_a
    cdef ptrdiff_t dim = self.dim, n = 4 * dim, i, j
    if out == NULL:
        return
    for i in range(n):
        for j in range(n):
            out[n * i + j] -= of_low[i // dim] * of_high[j // dim] * block[3 * (i % dim) + j % dim]
