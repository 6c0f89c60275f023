"""Contribution of contact between beams to the iteration matrix; an include file."""


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    """Add the block of each element by itself, where the last residual was evaluated as there."""
    cdef Data *self = <Data *>context
    cdef bint damps = part == DAMPING and x.v != NULL and (self.slip_speed > 0.0 or self.gamma > 0.0)
    if part != STIFFNESS and part != MATERIAL and not damps:
        return
    if (self.is_static or self.is_sticking) and not damps:
        if set_bristles_at(self, x.q):
            add_blocks(self, &self.at_end, 1.0, values)
            add_bristle_blocks(self, values)
        return
    set_points(self, x.q, self.now)
    if damps:
        add_damping(self, x.v, values)
    elif self.stepped and is_at(self, self.middle):
        add_blocks(self, &self.at_halfway, 2.0 * SIMPSON[1] * 0.5, values)
        add_blocks(self, &self.at_end, 2.0 * SIMPSON[2], values)
        if self.interval > 0.0:
            add_ratio_blocks(self, &self.at_begin, 2.0 * SIMPSON[0] / self.interval, 0.0, values)
            add_ratio_blocks(self, &self.at_halfway, 2.0 * SIMPSON[1] / self.interval,
                             2.0 * SIMPSON[1] * 0.5, values)
            add_ratio_blocks(self, &self.at_end, 2.0 * SIMPSON[2] / self.interval,
                             2.0 * SIMPSON[2], values)
        add_bristle_blocks(self, values)
    elif self.stepped and is_at(self, self.begin):
        add_blocks(self, &self.at_begin, 1.0, values)
    elif self.ended and is_at(self, self.end):
        add_blocks(self, &self.at_end, 1.0, values)
        if not self.stepped:
            add_ratio_blocks(self, &self.at_end, 0.0, 1.0, values)
            add_bristle_blocks(self, values)
    elif cover(&self.search, self.now, NULL) and collect(self, self.now, NULL, &self.at_now):
        add_blocks(self, &self.at_now, 1.0, values)


cdef void add_damping(Data *self, const double *v, double *values) noexcept nogil:
    """Add the derivatives of friction and of a restitution by the velocities v; `now` is the state.

    Between two states the restitution depends on their coordinates alone.
    """
    if self.stepped and is_at(self, self.middle):
        set_points(self, v, self.speed)
        add_sliding_blocks(self, &self.at_begin, SIMPSON[0], values)
        add_sliding_blocks(self, &self.at_halfway, SIMPSON[1], values)
        add_sliding_blocks(self, &self.at_end, SIMPSON[2], values)
    elif self.stepped and is_at(self, self.begin):
        set_points(self, v, self.speed)
        add_sliding_blocks(self, &self.at_begin, 1.0, values)
    elif self.ended and not self.stepped and is_at(self, self.end):
        add_damping_of(self, &self.at_end, v, values)
    elif cover(&self.search, self.now, NULL) and collect(self, self.now, NULL, &self.at_now):
        add_damping_of(self, &self.at_now, v, values)


cdef void add_damping_of(Data *self, Touches *list, const double *v, double *values) noexcept nogil:
    restrain_state(self, list, v)
    set_points(self, v, self.speed)
    add_sliding_blocks(self, list, 1.0, values)
    add_ratio_blocks(self, list, 1.0, 0.0, values)


cdef void add_blocks(const Data *self, const Touches *list, double factor,
                     double *values) noexcept nogil:
    cdef const Touch *each
    cdef double[12] g
    cdef double[12] h
    cdef ptrdiff_t k
    for k in range(list.n):
        each = list.touch + k
        set_gradient(self, each.a, each.z, each.n, g)
        set_gradient(self, each.b, each.u, each.n, h)
        add_pair(self, each.a, each.b, g, h,
                 factor * (1.0 + each.theta) * each.ratio * each.stiffness, values)


cdef void add_pair(const Data *self, int32_t a, int32_t b, const double *g, const double *h,
                   double stiffness, double *values) noexcept nogil:
    """Add s (g, -h) (g, -h)^T of two elements to the matrix."""
    add_block(self, a, g, stiffness, values)
    add_block(self, b, h, stiffness, values)
    if a < b:
        add_coupling(self, a, b, g, h, stiffness, values)
    else:
        add_coupling(self, b, a, h, g, stiffness, values)


cdef inline void weigh(const Data *self, ptrdiff_t e, double z, double *of_nodes) noexcept nogil:
    """Set the weights of position and slope at both ends of an element in one of its points."""
    cdef double[4] w
    bernstein(z, w)
    if self.straight[e]:
        of_nodes[0], of_nodes[1], of_nodes[2], of_nodes[3] = 1.0 - z, 0.0, z, 0.0
    else:
        of_nodes[0], of_nodes[1] = w[0] + w[1], self.length[e] / 3.0 * w[1]
        of_nodes[2], of_nodes[3] = w[2] + w[3], -self.length[e] / 3.0 * w[2]


cdef inline void set_gradient(const Data *self, ptrdiff_t e, double z, const double *n,
                              double *g) noexcept nogil:
    """Set S^T n of a point of an element."""
    cdef double[4] of_nodes
    cdef ptrdiff_t i, j
    weigh(self, e, z, of_nodes)
    for i in range(4):
        for j in range(self.dim):
            g[self.dim * i + j] = of_nodes[i] * n[j]


cdef void add_block(const Data *self, ptrdiff_t e, const double *g, double stiffness,
                    double *values) noexcept nogil:
    """Add s g g^T of one element to the matrix."""
    cdef ptrdiff_t dim = self.dim, i, j
    cdef const int32_t *slot = self.slot + e * (2 * dim * (4 * dim + 1))
    for i in range(4 * dim):
        for j in range(i + 1):
            values[slot[0]] += stiffness * g[i] * g[j]
            slot += 1


cdef void add_ratio_blocks(const Data *self, const Touches *list, double by_change, double by_place,
                           double *values) noexcept nogil:
    """Add the derivatives of ratios by changes of penetrations over an interval, and by penetrations."""
    cdef const Touch *each
    cdef double[12] g
    cdef double[12] h
    cdef double energy, t, rate
    cdef ptrdiff_t i, end, k = 0
    if self.gamma == 0.0:
        return
    sum_stiffness(self, list)
    while k < list.n:
        memset(g, 0, sizeof(g))
        memset(h, 0, sizeof(h))
        end, energy, each = end_of_pair(list, k), 0.0, list.touch + k
        rate = self.slow * rate_of(self.bodies.pair + each.bodies)
        for i in range(k, end):
            energy += list.touch[i].stiffness * list.touch[i].e * list.touch[i].e
            add_gradients(self, each, list.touch + i, g, h)
        t = (each.ratio - 1.0) / self.gamma
        add_pair(self, each.a, each.b, g, h,
                 self.gamma * (1.0 - t * t) / energy * (by_change / rate - by_place * each.s), values)
        k = end


cdef void add_gradients(const Data *self, const Touch *first, const Touch *each, double *g,
                        double *h) noexcept nogil:
    """Add f S^T n of both elements of a point, in the order of the first point of its pair."""
    cdef double[12] own
    cdef ptrdiff_t i
    cdef double force = each.force if each.a == first.a else -each.force
    set_gradient(self, first.a, each.z if each.a == first.a else each.u, each.n, own)
    for i in range(4 * self.dim):
        g[i] += force * own[i]
    set_gradient(self, first.b, each.u if each.a == first.a else each.z, each.n, own)
    for i in range(4 * self.dim):
        h[i] += force * own[i]
