"""Mean forces between two states; an include file."""

cdef double[3] SIMPSON = [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0]
# Weight of forces between control points in the correction, against pressures: where points slide
# without a change of their penetrations, pressures can do no work.
cdef double ALONG = 1e-3


cdef void add_work(Data *self, Touches *list, double share) noexcept nogil:
    """Turn the normals of touching points to those halfway, and subtract the work of their mean force.

    Squares increase by that of pressures in proportion to the changes of penetrations.
    """
    cdef Touch *each
    cdef BodyPair *pair
    cdef double[3] before
    cdef double[3] after
    cdef double size
    cdef ptrdiff_t k
    cdef int c
    for k in range(list.n):
        each = list.touch + k
        pair = self.bodies.pair + each.bodies
        blend(self.begin, each, before)
        blend(self.end, each, after)
        for c in range(3):
            each.n[c] = before[c] + after[c]
        size = sqrt(dot(each.n, each.n))
        each.change = 0.0
        for c in range(3):
            each.n[c] /= size
            each.change -= each.n[c] * (after[c] - before[c])
        pair.missing -= share * each.stiffness * each.e * each.change
        pair.square += share * each.stiffness * each.change * each.change


cdef void push_all(const Data *self, const Touches *list, double share, double *out) noexcept nogil:
    cdef const Touch *each
    cdef ptrdiff_t k
    for k in range(list.n):
        each = list.touch + k
        push(out, each, share * each.ratio * each.force, each.n)


cdef void set_forces(Data *self, Touches *list, double share) noexcept nogil:
    """Set the forces with the correction and the restitution, and add the loss by the latter."""
    cdef Touch *each
    cdef ptrdiff_t k
    for k in range(list.n):
        each = list.touch + k
        each.force = each.stiffness * (each.e + self.bodies.pair[each.bodies].factor * each.change)
    self.lost += share * restrain(self, list, self.interval)


cdef void add_stored(Data *self, const Touches *list, double sign) noexcept nogil:
    """Add the energies of a state to the missing work."""
    cdef const Touch *each
    cdef ptrdiff_t k
    for k in range(list.n):
        each = list.touch + k
        self.bodies.pair[each.bodies].missing += sign * 0.5 * each.stiffness * each.e * each.e


cdef void set_means(Data *self) noexcept nogil:
    """Set the forces of the touching points for the mean force between two states.

    The work of each pair of bodies is the change of its energy.
    """
    cdef BodyPair *pair
    cdef ptrdiff_t k
    for k in range(self.bodies.n):
        pair = self.bodies.pair + k
        pair.missing = pair.square = pair.factor = 0.0
    add_stored(self, &self.at_end, 1.0)
    add_stored(self, &self.at_begin, -1.0)
    add_work(self, &self.at_begin, SIMPSON[0])
    add_work(self, &self.at_halfway, SIMPSON[1])
    add_work(self, &self.at_end, SIMPSON[2])
    push_along(self, &self.at_begin)
    push_along(self, &self.at_halfway)
    push_along(self, &self.at_end)
    for k in range(self.bodies.n):
        pair = self.bodies.pair + k
        if pair.square > 0.0:
            pair.factor = pair.missing / pair.square
    self.lost = 0.0
    set_forces(self, &self.at_begin, SIMPSON[0])
    set_forces(self, &self.at_halfway, SIMPSON[1])
    set_forces(self, &self.at_end, SIMPSON[2])


cdef void push_along(Data *self, const Touches *list) noexcept nogil:
    """Add forces between the control points of touching elements, in proportion to their approach.

    Squares increase by their work for the factor 1.
    """
    cdef const Touch *each
    cdef const double *p
    cdef const double *s
    cdef double[3] before
    cdef double[3] after
    cdef BodyPair *pair
    cdef double one, two, stiffness, size
    cdef ptrdiff_t k, i, j
    cdef int c
    for k in range(list.n):
        each = list.touch + k
        if k > 0 and each.a == list.touch[k - 1].a and each.b == list.touch[k - 1].b:
            continue
        pair = self.bodies.pair + each.bodies
        stiffness = ALONG / 16.0 * self.stiffness * self.length[each.a]
        for i in range(12 * each.a, 12 * each.a + 12, 3):
            for j in range(12 * each.b, 12 * each.b + 12, 3):
                for c in range(3):
                    before[c] = self.begin[i + c] - self.begin[j + c]
                    after[c] = self.end[i + c] - self.end[j + c]
                one, two = sqrt(dot(before, before)), sqrt(dot(after, after))
                if one + two == 0.0:
                    continue
                pair.square += stiffness * (two - one) * (two - one)
                size = pair.factor * stiffness * (two - one) / (one + two)
                for c in range(3):
                    self.push[i + c] -= size * (before[c] + after[c])
                    self.push[j + c] += size * (before[c] + after[c])


cdef bint is_at(const Data *self, const double *points) noexcept nogil:
    """Return True if the present control points are others, to the last bit."""
    return memcmp(self.now, points, 12 * self.n * sizeof(double)) == 0


cdef bint list_between(Data *self, const double *q0, const double *q1) noexcept nogil:
    """List the touching points for the mean force between two states; return if that succeeds."""
    set_points(self, q0, self.now)
    set_points(self, q1, self.end)
    return list_way(self)


cdef bint list_way(Data *self) noexcept nogil:
    """The same between the control points `now` and `end`."""
    cdef bint same
    cdef ptrdiff_t k
    same = self.stepped and is_at(self, self.begin)
    memcpy(self.begin, self.now, 12 * self.n * sizeof(double))
    for k in range(12 * self.n):
        self.halfway[k] = 0.5 * (self.begin[k] + self.end[k])
    self.stepped = (cover(&self.search, self.begin, self.end)
                    and (same or collect(self, self.begin, NULL, &self.at_begin))
                    and collect(self, self.halfway, NULL, &self.at_halfway)
                    and collect(self, self.end, NULL, &self.at_end))
    self.ended = self.stepped
    return self.stepped


cdef bint take_means(Data *self, const ancf_state *x) noexcept nogil:
    """Set the mean forces of the step to an accepted state, if the last residual did not."""
    set_points(self, x.q, self.now)
    if is_at(self, self.end) and memcmp(
            self.before, self.begin, 12 * self.n * sizeof(double)) == 0:
        return True
    memcpy(self.end, self.now, 12 * self.n * sizeof(double))
    memcpy(self.now, self.before, 12 * self.n * sizeof(double))
    if not list_way(self):
        return False
    set_means(self)
    return True


cdef void between(void *context, const double *q0, const double *q1, const ancf_state *x,
                  double *r, double *phi) noexcept nogil:
    cdef Data *self = <Data *>context
    set_points(self, x.q, self.middle)
    if not list_between(self, q0, q1):
        fail(self, r)
        return
    if self.at_begin.n + self.at_halfway.n + self.at_end.n == 0:
        self.n_bristles, self.lost = 0, 0.0
        return
    list_pairs(self, &self.at_begin)
    list_pairs(self, &self.at_halfway)
    list_pairs(self, &self.at_end)
    set_means(self)
    memset(self.push, 0, 12 * self.n * sizeof(double))
    push_all(self, &self.at_begin, SIMPSON[0], self.push)
    push_all(self, &self.at_halfway, SIMPSON[1], self.push)
    push_all(self, &self.at_end, SIMPSON[2], self.push)
    push_along(self, &self.at_begin)
    push_along(self, &self.at_halfway)
    push_along(self, &self.at_end)
    if self.grip > 0.0:
        if not set_bristles(self, True):
            fail(self, r)
            return
        push_bristles(self, self.push)
    elif self.friction > 0.0 and x.v != NULL:
        set_points(self, x.v, self.speed)
        rub(self, &self.at_begin, SIMPSON[0], self.push)
        rub(self, &self.at_halfway, SIMPSON[1], self.push)
        rub(self, &self.at_end, SIMPSON[2], self.push)
    distribute(self, r)
