"""Friction of points that touch along both axes, and its work; an include file.

It opposes the relative velocity of a point of one axis and its foot on the other one, along the surface.
"""


cdef double slide(const Data *self, const Touch *each, double *u) noexcept nogil:
    """Set the sliding velocity u of a point relative to its foot; return sqrt(u^2 + slip_speed^2)."""
    cdef double normal
    cdef int c
    blend(self.speed, each, u)
    normal = dot(u, each.n)
    for c in range(3):
        u[c] -= normal * each.n[c]
    return sqrt(dot(u, u) + self.slip_speed * self.slip_speed)


cdef void rub(const Data *self, const Touches *list, double share, double *out) noexcept nogil:
    """Add a share of the friction to forces on control points that have the velocities `speed`."""
    cdef const Touch *each
    cdef double[3] u
    cdef double size
    cdef ptrdiff_t k
    if self.friction == 0.0:
        return
    for k in range(list.n):
        each = list.touch + k
        size = slide(self, each, u)
        push(out, each, -self.friction * share * pressure(each) / size, u)


cdef bint find_end(Data *self, const double *q, const double *v) noexcept nogil:
    """List the touching points at the end of a step, if the last residual did not; v can be NULL.

    Returns whether that succeeds.
    """
    set_points(self, q, self.now)
    if not (self.ended and not self.stepped and is_at(self, self.end)):
        memcpy(self.end, self.now, 12 * self.n * sizeof(double))
        self.stepped, self.ended = False, list_damped(self, self.end, &self.at_end)
    restrain_state(self, &self.at_end, v)
    return self.ended


cdef void set_friction(Data *self, const ancf_state *x, double *out) noexcept nogil:
    """Set the friction on control points at the end of a step."""
    memset(out, 0, 12 * self.n * sizeof(double))
    if self.grip > 0.0:
        if find_end(self, x.q, x.v) and set_bristles(self, False):
            push_bristles(self, out)
    elif x.v != NULL and find_end(self, x.q, x.v):
        set_points(self, x.v, self.speed)
        rub(self, &self.at_end, 1.0, out)


cdef double work(void *context, const ancf_state *x0, const ancf_state *x1,
                 double *scratch) noexcept nogil:
    """Work of friction: of `between`, or by the trapezoidal rule from both states."""
    cdef Data *self = <Data *>context
    self.loss = -friction_work(self, x0, x1, self.stepped)
    return -self.loss


cdef double stored_energy(const Data *self) noexcept nogil:
    """Energy of the bristles in the last accepted state."""
    cdef const double *slot
    cdef double square, sum = 0.0
    cdef ptrdiff_t k, c
    if self.grip == 0.0:
        return 0.0
    for k in range(self.n_slots):
        slot = self.slots + k * self.width
        if slot[0] != 0.0 and slot[1] > 0.0:
            square = 0.0
            for c in range(self.dim):
                square += slot[2 + c] * slot[2 + c]
            sum += 0.5 * square / slot[1]
    return sum


cdef double friction_work(Data *self, const ancf_state *x0, const ancf_state *x1,
                          bint is_mean) noexcept nogil:
    """Work of friction in a step; by the trapezoidal rule no more than bristles have stored.

    In a step that does not resolve the motion the scheme gains the rest.
    """
    cdef double sum = 0.0
    cdef ptrdiff_t k
    if self.grip == 0.0 and x1.v == NULL:
        return 0.0
    if not is_mean:
        set_friction(self, x1, self.push)
        for k in range(12 * self.n):
            sum += 0.5 * (self.rubbed[k] + self.push[k]) * (self.end[k] - self.before[k])
        return min(sum, stored_energy(self))
    if not list_between(self, x0.q, x1.q):
        return NAN
    set_means(self)
    memset(self.push, 0, 12 * self.n * sizeof(double))
    if self.grip > 0.0:
        if not set_bristles(self, True):
            return NAN
        push_bristles(self, self.push)
    else:
        set_points(self, x0.v, self.now)
        set_points(self, x1.v, self.speed)
        for k in range(12 * self.n):
            self.speed[k] = 0.5 * (self.now[k] + self.speed[k])
        rub(self, &self.at_begin, SIMPSON[0], self.push)
        rub(self, &self.at_halfway, SIMPSON[1], self.push)
        rub(self, &self.at_end, SIMPSON[2], self.push)
    for k in range(12 * self.n):
        sum += self.push[k] * (self.end[k] - self.begin[k])
    return sum


cdef void add_sliding_blocks(const Data *self, const Touches *list, double share,
                             double *values) noexcept nogil:
    """Add the derivative of friction by velocities."""
    cdef const Touch *each
    cdef double[3] u
    cdef double[9] block
    cdef double[4] of_a
    cdef double[4] of_b
    cdef double size, speed
    cdef ptrdiff_t k
    cdef int c, e
    if self.slip_speed == 0.0:
        return
    for k in range(list.n):
        each = list.touch + k
        speed = slide(self, each, u)
        size = self.friction * share * pressure(each) / speed
        for c in range(3):
            for e in range(3):
                block[3 * c + e] = size * ((c == e) - each.n[c] * each.n[e]
                                           - u[c] * u[e] / (speed * speed))
        weigh(self, each.a, each.z, of_a)
        weigh(self, each.b, each.u, of_b)
        add_pair_blocks(self, each.a, each.b, of_a, of_b, block, values)


cdef void add_pair_blocks(const Data *self, int32_t a, int32_t b, const double *of_a,
                          const double *of_b, const double *block, double *values) noexcept nogil:
    """Add (S_a, -S_b)^T B (S_a, -S_b) of two elements to the matrix, for a symmetric B (3, 3)."""
    add_weighted_block(self, a, of_a, block, values)
    add_weighted_block(self, b, of_b, block, values)
    add_weighted_coupling(self, a, b, of_a, of_b, block, values)


cdef void add_weighted_block(const Data *self, ptrdiff_t e, const double *of_nodes,
                             const double *block, double *values) noexcept nogil:
    """Add S^T B S of one element to the matrix."""
    cdef ptrdiff_t dim = self.dim, i, j
    cdef const int32_t *slot = self.slot + e * (2 * dim * (4 * dim + 1))
    for i in range(4 * dim):
        for j in range(i + 1):
            values[slot[0]] += of_nodes[i // dim] * of_nodes[j // dim] * block[3 * (i % dim) + j % dim]
            slot += 1
