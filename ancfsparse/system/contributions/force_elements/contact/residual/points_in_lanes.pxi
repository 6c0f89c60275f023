"""Forces on the points of several cubic elements in space together; included by `_contacts.pyx`.

A `vec` holds a number of as many points as there are lanes.  This applies to obstacles at rest, or turning, without a
frame or restitution; other points have the same forces by `contact_residual.pxi`, one after the other.
"""


cdef inline vec dot_lanes(const vec *a, const vec *b) noexcept nogil:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


cdef inline vec approach_lanes(const Data *self, const vec *x, vec *d) noexcept nogil:
    """Set the vectors from the base; return the distances."""
    cdef vec[3] from_base
    cdef const double *a = self.normal
    cdef ptrdiff_t c
    for c in range(3):
        from_base[c] = x[c] - self.base[c]
        d[c] = from_base[c]
    if not self.is_round:
        return a[0] * d[0] + a[1] * d[1] + a[2] * d[2]
    for c in range(3):
        a = self.projector + 3 * c
        d[c] = a[0] * from_base[0] + a[1] * from_base[1] + a[2] * from_base[2]
    return root(dot_lanes(d, d))


cdef inline void face_lanes(const Data *self, const vec *d, vec distance, vec *n) noexcept nogil:
    """Set the normals."""
    cdef ptrdiff_t c
    cdef vec inverse
    if not self.is_round:
        for c in range(3):
            n[c] = same(self.normal[c])
        return
    inverse = where_above(distance, same(0.0), same(1.0) / distance, same(0.0))
    for c in range(3):
        n[c] = inverse * d[c]


cdef inline vec project_lanes(const vec *n, vec *u) noexcept nogil:
    """Project vectors on the tangent planes; return their components along n."""
    cdef vec normal = dot_lanes(n, u)
    cdef ptrdiff_t c
    for c in range(3):
        u[c] = u[c] - normal * n[c]
    return normal


cdef inline void transport_lanes(const vec *n, vec *u) noexcept nogil:
    """Rotate vectors of other tangent planes into those with the normals n."""
    cdef vec before = dot_lanes(u, u), normal = project_lanes(n, u), after = dot_lanes(u, u)
    cdef vec ratio = root(where_above(after, same(0.0), before / after, same(1.0)))
    cdef ptrdiff_t c
    ratio = where_above(normal * normal, LEVEL * before, ratio, same(1.0))
    for c in range(3):
        u[c] = ratio * u[c]


cdef inline void turn_lanes(const Data *self, const vec *d, double factor, vec *u) noexcept nogil:
    """Add a factor times the velocity of the surface of a turning obstacle."""
    cdef ptrdiff_t c
    cdef const double *a
    if self.omega > 0.0:
        for c in range(3):
            a = self.spin + 3 * c
            u[c] = u[c] + factor * (a[0] * d[0] + a[1] * d[1] + a[2] * d[2])


cdef inline void creep_lanes(const Data *self, ptrdiff_t k, const vec *x, const vec *d,
                             const vec *n, vec *path, vec *normal) noexcept nogil:
    """Set the displacement along the surface since the last accepted state, and the normals halfway."""
    cdef vec[3] begin
    cdef vec[3] middle
    cdef ptrdiff_t c
    load_vectors(self.x0 + 3 * k, begin)
    for c in range(3):
        path[c] = x[c] - begin[c]
        normal[c] = n[c]
    if not self.is_flat:
        approach_lanes(self, begin, middle)
        for c in range(3):
            middle[c] = 0.5 * (middle[c] + d[c])
        face_lanes(self, middle, root(dot_lanes(middle, middle)), normal)
        turn_lanes(self, middle, -self.turn, path)
    project_lanes(normal, path)


cdef inline void shorten_lanes(vec limit, vec *u) noexcept nogil:
    """Scale vectors to limits, if they are longer."""
    cdef vec square = dot_lanes(u, u), ratio
    cdef ptrdiff_t c
    if not any_positive(square - limit * limit):
        return
    ratio = where_above(square, limit * limit, limit / root(square), same(1.0))
    for c in range(3):
        u[c] = ratio * u[c]


cdef inline void stick_lanes(Data *self, ptrdiff_t k, ptrdiff_t like, ptrdiff_t size, const vec *x, const vec *d,
                             const vec *n, vec stiffness, vec depth, vec *f) noexcept nogil:
    """Set the friction of bristles at the end of a step, or between its states, as `stick` does.

    The depth is the pressure over the stiffness.
    """
    cdef vec[3] path
    cdef vec[3] normal
    cdef const vec *place = n
    cdef vec limit = same(self.friction / self.grip), share = same(0.5 if self.is_mean else 1.0)
    cdef ptrdiff_t c
    if self.slides != NULL:
        limit = where_above(load(self.slides + k), same(0.0), limit,
                            same(self.friction0 / self.grip))
    limit = limit * depth
    load_vectors(self.z + 3 * k, f)
    if self.is_mean:
        shorten_lanes(limit, f)
    if self.interval > 0.0:
        creep_lanes(self, k, x, d, n, path, normal)
        if not self.is_flat:
            if self.is_mean:
                place = normal
            else:
                transport_lanes(n, path)
            transport_lanes(place, f)
        if self.slides != NULL:
            share = share + load(self.settling + like) / same(self.interval)
        for c in range(3):
            f[c] = f[c] + share * path[c]
    elif not self.is_flat:
        transport_lanes(n, f)
    store_vectors(self.trial + 3 * k, f, size)
    shorten_lanes(limit, f)
    for c in range(3):
        f[c] = -self.grip * stiffness * f[c]


cdef inline void rub_lanes(const Data *self, const vec *d, const vec *n, vec pressure,
                           vec *f) noexcept nogil:
    """Replace velocities by the friction that depends on them, as `rub` does."""
    cdef vec factor
    cdef ptrdiff_t c
    turn_lanes(self, d, -1.0, f)
    project_lanes(n, f)
    factor = -self.friction * pressure / root(self.slip_speed * self.slip_speed + dot_lanes(f, f))
    for c in range(3):
        f[c] = factor * f[c]


cdef inline ptrdiff_t block_size(const Data *self, ptrdiff_t g, ptrdiff_t last) noexcept nogil:
    """Number of groups from one on, and before the last, that are evaluated together; 0 if one is evaluated alone."""
    cdef ptrdiff_t n = 0
    if not self.is_plain or self.is_static:
        return 0
    while n < LANES and g + n < last and self.groups.alike[g + n] >= 0:
        n += 1
    return n


cdef inline ptrdiff_t take_block(const Data *self, ptrdiff_t g, ptrdiff_t n, Block *block) noexcept nogil:
    """Set a block of n groups; return a point from which on the constants of their points are read."""
    cdef const Groups *groups = &self.groups
    cdef ptrdiff_t same = groups.alike[g], k
    if n == LANES and groups.alike[g + n - 1] == same:
        k = groups.first[same]
        repeat_block(block, same, g - same, groups.place + 3 * groups.term[same],
                     self.points.weight + self.points.start[k])
    else:
        k = groups.first[g]
        set_block(block, n, groups.place + 3 * groups.term[g],
                  self.points.weight + self.points.start[k])
    return k


cdef inline void clear_lanes(vec *f) noexcept nogil:
    f[0] = f[1] = f[2] = same(0.0)


cdef void press_block(Data *self, ptrdiff_t g, ptrdiff_t n, Block *block, const ancf_state *state,
                      double *r) noexcept nogil:
    """Subtract the forces on n groups of three points in a state from the residual."""
    cdef ptrdiff_t k = self.groups.first[g], size = 3 * n, t, like
    cdef vec[9] x
    cdef vec[9] f  # velocities, then forces
    cdef bint is_pressed = False
    like = take_block(self, g, n, block)
    sum_points(block, state.q, x)
    if self.grip == 0.0 and self.friction > 0.0 and state.v != NULL:
        sum_points(block, state.v, f)
    for t in range(3):
        if t * LANES < size:
            is_pressed |= press_lanes(self, k + t * LANES, like + t * LANES, size - t * LANES, state,
                                      x + 3 * t, f + 3 * t)
        else:
            clear_lanes(f + 3 * t)
    if is_pressed:
        subtract_forces(block, f, r)


cdef inline bint press_lanes(Data *self, ptrdiff_t k, ptrdiff_t like, ptrdiff_t size,
                             const ancf_state *state, const vec *x, vec *f) noexcept nogil:
    """Set the forces on points from one on, at most `size`, from velocities; return whether any is pressed."""
    cdef ptrdiff_t c
    cdef vec[3] d
    cdef vec[3] n
    cdef vec distance, e, approached, theta, s, depth, force, layer = load(self.layer + like)
    cdef vec stiffness = first_of(load(self.stiffness + like), size)
    distance = approach_lanes(self, x, d)
    e = load(self.reach + like) - distance
    store(self.at + k, e, size)
    theta = self.dt * load(self.rate + like)
    theta = theta * theta
    theta = where_above(theta, same(1.0), same(1.0), theta)
    approached = e + theta * (e - load(self.before + k))
    if not any_positive(approached):
        store(self.force + k, same(0.0), size)
        store(self.slope + k, same(0.0), size)
        clear_lanes(f)
        return False
    s = share_of_layer(approached, same(1.0) / layer)
    depth = law_forces(approached, s, layer)
    force = stiffness * depth
    store(self.force + k, force, size)
    store(self.slope + k, (1.0 + theta) * stiffness * law_slopes(s), size)
    face_lanes(self, d, distance, n)
    if self.grip > 0.0:
        stick_lanes(self, k, like, size, x, d, n, stiffness, depth, f)
    elif self.friction > 0.0 and state.v != NULL:
        rub_lanes(self, d, n, force, f)
    else:
        clear_lanes(f)
    for c in range(3):
        f[c] = f[c] + force * n[c]
    return True


cdef void press_block_between(Data *self, ptrdiff_t g, ptrdiff_t n, Block *block, const double *q0,
                              const double *q1, const ancf_state *state, double *r) noexcept nogil:
    """Subtract the forces on n groups of three points between two states."""
    cdef ptrdiff_t k = self.groups.first[g], size = 3 * n, t, at, like
    cdef vec[9] x0
    cdef vec[9] x1
    cdef vec[9] x
    cdef vec[9] f  # velocities, then forces
    cdef bint is_pressed = False
    like = take_block(self, g, n, block)
    sum_points(block, q0, x0)
    sum_points(block, q1, x1)
    for t in range(3):
        if t * LANES < size:
            is_pressed |= touch_between(self, k + t * LANES, like + t * LANES, size - t * LANES, x0 + 3 * t,
                                        x1 + 3 * t)
    if not is_pressed:
        return
    sum_points(block, state.q, x)
    if self.grip == 0.0 and self.friction > 0.0 and state.v != NULL:
        sum_points(block, state.v, f)
    for t in range(3):
        if t * LANES < size:
            press_lanes_between(self, k + t * LANES, like + t * LANES, size - t * LANES, state, x0 + 3 * t,
                                x1 + 3 * t, x + 3 * t, f + 3 * t)
        else:
            clear_lanes(f + 3 * t)
    subtract_forces(block, f, r)


cdef inline bint touch_between(Data *self, ptrdiff_t k, ptrdiff_t like, ptrdiff_t size, const vec *x0,
                               const vec *x1) noexcept nogil:
    """Set the forces on points to zero; return whether any of them touches in one of two states."""
    cdef vec[3] d
    cdef vec before = approach_lanes(self, x0, d), after = approach_lanes(self, x1, d)
    store(self.at + k, same(NAN), size)
    store(self.force + k, same(0.0), size)
    return any_positive(load(self.reach + like) - where_above(before, after, after, before))


cdef inline void press_lanes_between(
        Data *self, ptrdiff_t k, ptrdiff_t like, ptrdiff_t size, const ancf_state *state, const vec *x0,
        const vec *x1, const vec *x, vec *f) noexcept nogil:
    """Set the forces on points between two states, as `press_lanes` does in one."""
    cdef ptrdiff_t c
    cdef vec[3] begin
    cdef vec[3] end
    cdef vec[3] middle
    cdef vec[3] n
    cdef vec before = approach_lanes(self, x0, begin), after = approach_lanes(self, x1, end)
    cdef vec distance = approach_lanes(self, x, middle), e0, e1, depth, force, slope
    cdef vec reach = load(self.reach + like), stiffness = first_of(load(self.stiffness + like), size)
    e0, e1 = reach - before, reach - after
    store(self.at + k, where_above(where_above(e0, e1, e0, e1), same(0.0), reach - distance, same(NAN)), size)
    mean_law(e0, e1, load(self.layer + like), &depth, &slope)
    force = stiffness * depth
    store(self.force + k, force, size)
    store(self.slope + k, stiffness * slope, size)
    if self.grip > 0.0:
        face_lanes(self, end, after, n)
        stick_lanes(self, k, like, size, x1, end, n, stiffness, depth, f)
    elif self.friction > 0.0 and state.v != NULL:
        face_lanes(self, middle, distance, n)
        rub_lanes(self, middle, n, force, f)
    else:
        clear_lanes(f)
    if self.is_round:
        for c in range(3):
            begin[c] = begin[c] + end[c]
    face_lanes(self, begin, before + after, n)
    for c in range(3):
        f[c] = f[c] + force * n[c]
