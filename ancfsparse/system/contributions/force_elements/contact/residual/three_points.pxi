"""Forces on the three points of a cubic element in space together; included by `_contacts.pyx`.

A row holds a number of each of them.  This applies to obstacles at rest, or turning, without a frame or restitution;
other points have the same forces by `contact_residual.pxi`, one after the other.
"""


cdef extern from "vectors.h":
    ctypedef double row "vec_four"
    row same "vec_row_same" (double) noexcept nogil
    row load_row "vec_row_load" (const double *) noexcept nogil
    row row_of "vec_row_of" (const double *, ptrdiff_t) noexcept nogil
    row where_above "vec_row_where" (row, row, row, row) noexcept nogil
    row root "vec_row_sqrt" (row) noexcept nogil
    bint any_positive "vec_row_any_positive" (row) noexcept nogil
    void store_row "vec_row_store" (double *, row) noexcept nogil
    void load_points "vec_row_load_points" (const double *, ptrdiff_t, row *) noexcept nogil
    void store_points "vec_row_store_points" (double *, const row *) noexcept nogil
    void sum_three "vec_row_sum" (
        const double *, const int32_t *, const double *, row *) noexcept nogil
    void subtract_three "vec_row_subtract" (
        const double *, const int32_t *, const row *, double *) noexcept nogil


cdef inline row dot_three(const row *a, const row *b) noexcept nogil:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


cdef inline row approach_three(const Data *self, const row *x, row *d) noexcept nogil:
    """Set the vectors from the base; return the distances."""
    cdef row[3] from_base
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
    return root(dot_three(d, d))


cdef inline void face_three(const Data *self, const row *d, row distance, row *n) noexcept nogil:
    """Set the normals."""
    cdef ptrdiff_t c
    cdef row inverse
    if not self.is_round:
        for c in range(3):
            n[c] = same(self.normal[c])
        return
    inverse = where_above(distance, same(0.0), same(1.0) / distance, same(0.0))
    for c in range(3):
        n[c] = inverse * d[c]


cdef inline row project_three(const row *n, row *u) noexcept nogil:
    """Project vectors on the tangent planes; return their components along n."""
    cdef row normal = dot_three(n, u)
    cdef ptrdiff_t c
    for c in range(3):
        u[c] = u[c] - normal * n[c]
    return normal


cdef inline void transport_three(const row *n, row *u) noexcept nogil:
    """Rotate vectors of other tangent planes into those with the normals n."""
    cdef row before = dot_three(u, u), normal = project_three(n, u), after = dot_three(u, u)
    cdef row ratio = root(where_above(after, same(0.0), before / after, same(1.0)))
    cdef ptrdiff_t c
    ratio = where_above(normal * normal, LEVEL * before, ratio, same(1.0))
    for c in range(3):
        u[c] = ratio * u[c]


cdef inline void turn_three(const Data *self, const row *d, double factor, row *u) noexcept nogil:
    """Add a factor times the velocity of the surface of a turning obstacle."""
    cdef ptrdiff_t c
    cdef const double *a
    if self.omega > 0.0:
        for c in range(3):
            a = self.spin + 3 * c
            u[c] = u[c] + factor * (a[0] * d[0] + a[1] * d[1] + a[2] * d[2])


cdef inline void creep_three(const Data *self, ptrdiff_t k, const row *x, const row *d,
                             const row *n, row *path, row *normal) noexcept nogil:
    """Set the displacement along the surface since the last accepted state, and the normals halfway."""
    cdef row[3] begin
    cdef row[3] middle
    cdef ptrdiff_t c
    load_points(self.x0 + 4 * k, 4, begin)
    for c in range(3):
        path[c] = x[c] - begin[c]
        normal[c] = n[c]
    if not self.is_flat:
        approach_three(self, begin, middle)
        for c in range(3):
            middle[c] = 0.5 * (middle[c] + d[c])
        face_three(self, middle, root(dot_three(middle, middle)), normal)
        turn_three(self, middle, -self.turn, path)
    project_three(normal, path)


cdef inline void shorten_three(row limit, row *u) noexcept nogil:
    """Scale vectors to limits, if they are longer."""
    cdef row square = dot_three(u, u), ratio
    cdef ptrdiff_t c
    if not any_positive(square - limit * limit):
        return
    ratio = where_above(square, limit * limit, limit / root(square), same(1.0))
    for c in range(3):
        u[c] = ratio * u[c]


cdef inline void stick_three(Data *self, ptrdiff_t k, const row *x, const row *d, const row *n,
                             row depth, row *f) noexcept nogil:
    """Set the friction of bristles at the end of a step, or between its states, as `stick` does.

    The depth is the pressure over the stiffness.
    """
    cdef row[3] path
    cdef row[3] normal
    cdef const row *place = n
    cdef row limit = same(self.friction / self.grip), share = same(0.5 if self.is_mean else 1.0)
    cdef ptrdiff_t c
    if self.slides != NULL:
        limit = where_above(load_row(self.slides + k), same(0.0), limit,
                            same(self.friction0 / self.grip))
    limit = limit * depth
    load_points(self.z + 3 * k, 3, f)
    if self.is_mean:
        shorten_three(limit, f)
    if self.interval > 0.0:
        creep_three(self, k, x, d, n, path, normal)
        if not self.is_flat:
            if self.is_mean:
                place = normal
            else:
                transport_three(n, path)
            transport_three(place, f)
        if self.slides != NULL:
            share = share + load_row(self.settling + k) / same(self.interval)
        for c in range(3):
            f[c] = f[c] + share * path[c]
    elif not self.is_flat:
        transport_three(n, f)
    store_points(self.trial + 3 * k, f)
    shorten_three(limit, f)
    for c in range(3):
        f[c] = -self.grip * load_row(self.stiffness + k) * f[c]


cdef inline void rub_three(const Data *self, ptrdiff_t g, const double *v, const row *d,
                           const row *n, row pressure, row *f) noexcept nogil:
    """Set the friction that depends on the velocity, as `rub` does."""
    cdef row factor
    cdef ptrdiff_t c
    sum_three(self.groups.three + self.groups.weight_of_three[g],
              self.groups.place + 3 * self.groups.term[g], v, f)
    turn_three(self, d, -1.0, f)
    project_three(n, f)
    factor = -self.friction * pressure / root(self.slip_speed * self.slip_speed + dot_three(f, f))
    for c in range(3):
        f[c] = factor * f[c]


cdef inline void press_three(Data *self, ptrdiff_t g, const ancf_state *state, double *r) noexcept nogil:
    """Subtract the forces on a group of three points in a state from the residual."""
    cdef const double *weight = self.groups.three + self.groups.weight_of_three[g]
    cdef const int32_t *place = self.groups.place + 3 * self.groups.term[g]
    cdef ptrdiff_t k = self.groups.first[g], c
    cdef row[3] x
    cdef row[3] d
    cdef row[3] n
    cdef row[3] rubbing
    cdef row distance, e, approached, theta, s, depth, force, layer = load_row(self.layer + k)
    sum_three(weight, place, state.q, x)
    distance = approach_three(self, x, d)
    e = load_row(self.reach + k) - distance
    store_row(self.at + k, e)
    theta = self.dt * load_row(self.rate + k)
    theta = theta * theta
    theta = where_above(theta, same(1.0), same(1.0), theta)
    approached = e + theta * (e - load_row(self.before + k))
    if not any_positive(approached):
        store_row(self.force + k, same(0.0))
        store_row(self.slope + k, same(0.0))
        return
    s = approached / layer
    s = where_above(s, same(1.0), same(1.0), where_above(s, same(0.0), s, same(0.0)))
    depth = approached - layer
    depth = where_above(depth, same(0.0), depth, same(0.0)) + layer * s * s * s * (1.0 - 0.5 * s)
    force = load_row(self.stiffness + k) * depth
    store_row(self.force + k, force)
    store_row(self.slope + k, (1.0 + theta) * load_row(self.stiffness + k) * s * s * (3.0 - 2.0 * s))
    face_three(self, d, distance, n)
    if self.grip > 0.0:
        stick_three(self, k, x, d, n, depth, rubbing)
    elif self.friction > 0.0 and state.v != NULL:
        rub_three(self, g, state.v, d, n, force, rubbing)
    else:
        clear_three(rubbing)
    for c in range(3):
        rubbing[c] = rubbing[c] + force * n[c]
    subtract_three(weight, place, rubbing, r)


cdef inline void clear_three(row *f) noexcept nogil:
    cdef ptrdiff_t c
    for c in range(3):
        f[c] = same(0.0)


cdef inline void press_three_between(Data *self, ptrdiff_t g, const double *q0, const double *q1,
                                     const ancf_state *state, double *r) noexcept nogil:
    """Subtract the forces on a group of three points between two states."""
    cdef const double *weight = self.groups.three + self.groups.weight_of_three[g]
    cdef const int32_t *place = self.groups.place + 3 * self.groups.term[g]
    cdef ptrdiff_t k = self.groups.first[g], c, p
    cdef row[3] x
    cdef row[3] begin
    cdef row[3] end
    cdef row[3] middle
    cdef row[3] n
    cdef row[3] rubbing
    cdef double[3] e0
    cdef double[3] e1
    cdef row distance, before, after, deeper, force, reach = load_row(self.reach + k)
    sum_three(weight, place, q0, x)
    before = approach_three(self, x, begin)
    sum_three(weight, place, q1, x)
    after = approach_three(self, x, end)
    store_row(e0, reach - before)
    store_row(e1, reach - after)
    deeper = reach - where_above(before, after, after, before)
    if not any_positive(deeper):
        store_row(self.at + k, same(NAN))
        store_row(self.force + k, same(0.0))
        return
    sum_three(weight, place, state.q, rubbing)
    distance = approach_three(self, rubbing, middle)
    store_row(self.at + k, where_above(deeper, same(0.0), reach - distance, same(NAN)))
    for p in range(3):
        self.force[k + p] = force_between(self, k + p, e0[p], e1[p], &self.slope[k + p])
    force = row_of(self.force + k, 1)
    if self.grip > 0.0:
        face_three(self, end, after, n)
        stick_three(self, k, x, end, n, force / load_row(self.stiffness + k), rubbing)
    elif self.friction > 0.0 and state.v != NULL:
        face_three(self, middle, distance, n)
        rub_three(self, g, state.v, middle, n, force, rubbing)
    else:
        clear_three(rubbing)
    if self.is_round:
        for c in range(3):
            begin[c] = begin[c] + end[c]
    face_three(self, begin, before + after, n)
    for c in range(3):
        rubbing[c] = rubbing[c] + force * n[c]
    subtract_three(weight, place, rubbing, r)
