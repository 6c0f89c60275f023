"""Friction of two elements that sticks, by a bristle between them; an include file.

All touching points of two elements a < b act as one, in the mean of their places weighted by their
normal forces.  Between a and b at this place is a spring along the surface with the stiffness K, a
share of the stiffness of the points.  It begins without force, and while a moves by x relative to b,
its force S becomes S + K x, until |S| reaches mu N with the resultant N of the normal forces: then it
slides.  Between two states friction is -(S + K x / 2), so that it never returns more energy than
S^2 / 2 K.

K grows with the overlap, and S remains.  It does not shrink with the overlap: bodies that stick would
creep while overlaps oscillate.  But pairs of elements that continue the axes take over, as they grow, the
part of K beyond the present overlap, with its part of S: an overlap that moves along an axis keeps its
force.  The energy S^2 / 2 K of all can only fall by this, as it is convex in (S, K).

With a static coefficient bristles have a damper, and stick and slide as on obstacles (../../contact/bristles.pxi);
a pair that takes over a part of one that slides slides too.  The damper makes the
reduced mass of two bodies on all their bristles critically damped.
"""

from libc.math cimport INFINITY, atan2, cos, sin


cdef struct Bristle:
    int32_t a, b, next, slot  # elements, the next bristle of a, and its place in the history or -1
    int32_t bodies  # number of the pair of bodies
    double stiffness, before  # K now and in the last accepted state [N/m]
    double surplus  # what others can take over of K
    double pressure, limit  # sum of normal forces, and mu times the size of their resultant [N]
    double mu  # coefficient of the present step
    bint slides, will_slide  # in the last accepted state, and at the end of the step
    double[3] n  # from b to a
    double delay  # damping over the stiffness and the step
    double share  # part of the displacement since the last equilibrium in contact
    double[4] of_a  # weights of control points
    double[4] of_b
    double[2] z  # places on a and b
    double[3] kept  # S in the last accepted state [N]
    double[3] trial  # in the matrix: S as if it did not slide
    double[3] end  # S at the end of the step
    double[3] f  # friction on a [N]


cdef ptrdiff_t find_bristle(const Data *self, int32_t a, int32_t b) noexcept nogil:
    """Return the number of the bristle of two elements a < b, or -1."""
    cdef ptrdiff_t k = self.first_bristle[a]
    while k >= 0 and self.bristle[k].b != b:
        k = self.bristle[k].next
    return k


cdef ptrdiff_t add_bristle(Data *self, int32_t a, int32_t b, int32_t slot) noexcept nogil:
    """Add a bristle without force and return its number, or -1 without memory."""
    cdef Bristle *each
    cdef void *more
    if self.n_bristles == self.room:
        more = realloc(self.bristle, (2 * self.room + 64) * sizeof(Bristle))
        if more == NULL:
            return -1
        self.bristle, self.room = <Bristle *>more, 2 * self.room + 64
    each = self.bristle + self.n_bristles
    memset(each, 0, sizeof(Bristle))
    each.a, each.b, each.slot, each.next = a, b, slot, self.first_bristle[a]
    self.first_bristle[a] = <int32_t>self.n_bristles
    self.n_bristles += 1
    return self.n_bristles - 1


cdef bint add_to_bristles(Data *self, const Touches *list, double share) noexcept nogil:
    """Add sums over touching points to the bristles of their pairs; return False without memory."""
    cdef const Touch *touch
    cdef Bristle *each = NULL
    cdef double[4] w
    cdef double force, sign
    cdef int32_t a, b
    cdef ptrdiff_t k, i
    cdef int c
    for k in range(list.n):
        touch = list.touch + k
        a, b = min(touch.a, touch.b), max(touch.a, touch.b)
        if each == NULL or each.a != a or each.b != b:
            i = find_bristle(self, a, b)
            if i < 0:
                i = add_bristle(self, a, b, -1)
            if i < 0:
                return False
            each = self.bristle + i
        force = share * pressure(touch)
        each.stiffness += self.grip * share * touch.stiffness
        each.pressure += force
        sign = force if touch.a == a else -force
        for c in range(3):
            each.n[c] += sign * touch.n[c]
        bernstein(touch.z if touch.a == a else touch.u, w)
        for c in range(4):
            each.of_a[c] += force * w[c]
        bernstein(touch.u if touch.a == a else touch.z, w)
        for c in range(4):
            each.of_b[c] += force * w[c]
        each.z[0] += force * (touch.z if touch.a == a else touch.u)
        each.z[1] += force * (touch.u if touch.a == a else touch.z)
    return True


cdef void average(const Data *self, Bristle *each) noexcept nogil:
    """Divide the sums by the normal force, and set the limit and what others can take over."""
    cdef double size = sqrt(dot(each.n, each.n))
    cdef int c
    each.surplus = fmax(each.before - each.stiffness, 0.0)
    each.limit = self.friction * size
    if each.pressure <= 0.0 or size == 0.0:
        each.limit = 0.0
        return
    for c in range(3):
        each.n[c] /= size
    for c in range(4):
        each.of_a[c] /= each.pressure
        each.of_b[c] /= each.pressure
    each.z[0] /= each.pressure
    each.z[1] /= each.pressure


cdef void take_over(Data *self, Bristle *each, int32_t a, int32_t b, double *gain) noexcept nogil:
    """Take over the surplus of another pair, up to `gain`, and its force."""
    cdef Bristle *other
    cdef double[3] s
    cdef double part
    cdef ptrdiff_t k
    cdef int c
    if a < 0 or b < 0 or a == b:
        return
    k = find_bristle(self, min(a, b), max(a, b))
    if k < 0 or self.bristle[k].surplus <= 0.0:
        return
    other = self.bristle + k
    part = fmin(gain[0], other.surplus)
    each.slides = each.slides or (other.slides and part > 0.0)
    other.surplus -= part
    gain[0] -= part
    part = (part if a < b else -part) / other.before
    for c in range(3):
        s[c] = part * other.kept[c]
    transport(each.n, s)
    for c in range(3):
        each.trial[c] += s[c]


cdef void pass_on(Data *self, Bristle *each) noexcept nogil:
    """Set the part of S that comes from other pairs, in `trial`."""
    cdef const int32_t *of_a = self.following + 2 * each.a
    cdef const int32_t *of_b = self.following + 2 * each.b
    cdef double gain = each.stiffness - each.before
    cdef int i, j
    if gain <= 0.0:
        return
    for i in range(2):
        take_over(self, each, of_a[i], each.b, &gain)
        take_over(self, each, each.a, of_b[i], &gain)
    for i in range(2):
        for j in range(2):
            take_over(self, each, of_a[i], of_b[j], &gain)


cdef void begin_with(const Data *self, Bristle *each) noexcept nogil:
    """Set mu, K, and S at the begin of a step in `trial`, by the history and the parts of other pairs."""
    cdef double ratio = 1.0
    cdef int c
    each.mu = self.friction
    if self.has_two and not each.slides:
        each.mu = self.friction0
        each.limit *= self.friction0 / self.friction
    transport(each.n, each.kept)
    if each.stiffness < each.before:
        each.stiffness += each.surplus
        ratio = each.stiffness / each.before
    for c in range(3):
        each.trial[c] += ratio * each.kept[c]


cdef void blended(const double *points, int32_t e, const double *w, double *x) noexcept nogil:
    """Set the mean of the control points of an element."""
    cdef int k, c
    for c in range(3):
        x[c] = 0.0
        for k in range(4):
            x[c] += w[k] * points[12 * e + 3 * k + c]


cdef void direction(const double *points, int32_t e, double z, const double *n,
                    double *t) noexcept nogil:
    """Set the part of the unit tangent of an axis along the surface."""
    cdef double y = 1.0 - z, size, normal
    cdef double[3] w
    cdef int k, c
    w[0], w[1], w[2] = y * y, 2.0 * y * z, z * z
    for c in range(3):
        t[c] = 0.0
        for k in range(3):
            t[c] += w[k] * (points[12 * e + 3 * k + 3 + c] - points[12 * e + 3 * k + c])
    size, normal = sqrt(dot(t, t)), dot(t, n)
    for c in range(3):
        t[c] = (t[c] - normal * n[c]) / size


cdef void turn(const double *n, double angle, double *s) noexcept nogil:
    """Rotate a vector of the tangent plane about its normal."""
    cdef double[3] across
    cdef double one = cos(angle), other = sin(angle)
    cdef int c
    if angle == 0.0:
        return
    across[0] = n[1] * s[2] - n[2] * s[1]
    across[1] = n[2] * s[0] - n[0] * s[2]
    across[2] = n[0] * s[1] - n[1] * s[0]
    for c in range(3):
        s[c] = one * s[c] + other * across[c]


cdef double spin(const Bristle *each, const double *start, const double *end) noexcept nogil:
    """Return the mean angle by which both axes rotate about the normal in a step."""
    cdef double[3] before
    cdef double[3] after
    cdef double across = 0.0, along = 0.0
    cdef double[3] n
    cdef int i
    n[0], n[1], n[2] = each.n[0], each.n[1], each.n[2]
    for i in range(2):
        direction(start, each.a if i == 0 else each.b, each.z[i], n, before)
        direction(end, each.a if i == 0 else each.b, each.z[i], n, after)
        along += dot(before, after)
        across += (n[0] * (before[1] * after[2] - before[2] * after[1])
                   + n[1] * (before[2] * after[0] - before[0] * after[2])
                   + n[2] * (before[0] * after[1] - before[1] * after[0]))
    return atan2(across, along) if across != 0.0 else 0.0


cdef double touching_share(const Data *self, const Bristle *each, const double *x) noexcept nogil:
    """Return the part of a displacement since the last equilibrium during which a pair touches.

    Penetrations change linearly from there, where `x` is the vector from b to a.
    """
    cdef double gap = dot(x, each.n) - self.search.radius[each.a] - self.search.radius[each.b]
    cdef double depth = self.grip * each.pressure / each.stiffness
    if not self.is_static or each.before > 0.0 or gap <= 0.0:
        return 1.0
    return depth / (depth + gap)


cdef void stretch(Data *self, Bristle *each, const double *start, const double *end,
                  bint is_mean) noexcept nogil:
    """Set friction and the forces S of a bristle in a step, or in a state of its own."""
    cdef double[3] x
    cdef double[3] of_b
    cdef double[3] before
    cdef double angle = 0.0, share = 0.5 if is_mean else 1.0, normal, square
    cdef int c
    if each.limit == 0.0:
        for c in range(3):
            each.f[c] = each.trial[c] = each.end[c] = 0.0
        each.will_slide = False
        return
    x[0] = x[1] = x[2] = 0.0
    each.share = 1.0
    if self.interval > 0.0:
        blended(end, each.a, each.of_a, x)
        blended(end, each.b, each.of_b, of_b)
        for c in range(3):
            x[c] -= of_b[c]
        blended(start, each.a, each.of_a, before)
        blended(start, each.b, each.of_b, of_b)
        for c in range(3):
            before[c] -= of_b[c]
            x[c] -= before[c]
        normal, each.share = dot(x, each.n), touching_share(self, each, before)
        for c in range(3):
            x[c] = each.stiffness * each.share * (x[c] - normal * each.n[c])
        angle = spin(each, start, end)
    square = dot(each.trial, each.trial)
    turn(each.n, share * angle, each.trial)
    if is_mean:
        shorten(each.limit, each.trial)
    memcpy(each.end, each.trial, sizeof(each.end))
    each.will_slide = stretch_by(
        x, share + each.delay, each.delay, each.limit, each.slides, square, each.end)
    for c in range(3):
        each.trial[c] += (share + each.delay) * x[c]
        each.f[c] = -each.trial[c]
    shorten(each.limit, each.f)
    turn(each.n, (1.0 - share) * angle, each.end)


cdef bint set_bristles(Data *self, bint is_mean) noexcept nogil:
    """Set the friction of all bristles; return False without memory or if there are too many.

    Touching points are in the last lists of a step between two states or to its end.
    """
    if not recall(self):
        return False
    if is_mean:
        if not (add_to_bristles(self, &self.at_begin, SIMPSON[0])
                and add_to_bristles(self, &self.at_halfway, SIMPSON[1])
                and add_to_bristles(self, &self.at_end, SIMPSON[2])):
            return False
    elif not add_to_bristles(self, &self.at_end, 1.0):
        return False
    if is_mean:
        return stretch_all(self, self.begin, self.end, True)
    return stretch_all(self, self.start, self.end, False)


cdef bint stretch_all(Data *self, const double *start, const double *end,
                      bint is_mean) noexcept nogil:
    cdef ptrdiff_t k, n_touching = 0
    cdef Bristle *each
    cdef double rate
    clear_stiffness(self)
    for k in range(self.n_bristles):
        each = self.bristle + k
        average(self, each)
        n_touching += each.limit > 0.0
        each.bodies = find_bodies(self, each.a, each.b)
        if each.bodies < 0:
            return False
        self.bodies.pair[each.bodies].stiffness += each.stiffness
    for k in range(self.n_bristles):
        each = self.bristle + k
        rate = rate_of(self.bodies.pair + each.bodies)
        each.delay = 0.0
        if self.has_two and self.interval > 0.0 and rate > 0.0:
            each.delay = self.settling / (rate * self.interval)
    if n_touching > self.n_slots:
        self.crowded = n_touching
        return False
    for k in range(self.n_bristles):
        pass_on(self, self.bristle + k)
    for k in range(self.n_bristles):
        begin_with(self, self.bristle + k)
        stretch(self, self.bristle + k, start, end, is_mean)
    return True


cdef void push_bristles(const Data *self, double *out) noexcept nogil:
    """Add the friction of bristles to forces on control points."""
    cdef const Bristle *each
    cdef ptrdiff_t k
    cdef int i, c
    for k in range(self.n_bristles):
        each = self.bristle + k
        for i in range(4):
            for c in range(3):
                out[12 * each.a + 3 * i + c] += each.of_a[i] * each.f[c]
                out[12 * each.b + 3 * i + c] -= each.of_b[i] * each.f[c]


cdef void weigh_nodes(const Data *self, ptrdiff_t e, const double *w,
                      double *of_nodes) noexcept nogil:
    """Set weights of position and slope at both ends of an element from those of control points."""
    if self.straight[e]:
        of_nodes[0], of_nodes[1] = w[0] + (2.0 * w[1] + w[2]) / 3.0, 0.0
        of_nodes[2], of_nodes[3] = w[3] + (w[1] + 2.0 * w[2]) / 3.0, 0.0
    else:
        of_nodes[0], of_nodes[1] = w[0] + w[1], self.length[e] / 3.0 * w[1]
        of_nodes[2], of_nodes[3] = w[2] + w[3], -self.length[e] / 3.0 * w[2]


cdef void bristle_block(const Data *self, const Bristle *each, double *block) noexcept nogil:
    """Set the derivative of the friction of a bristle by the displacement x, (3, 3)."""
    cdef double square = dot(each.trial, each.trial), factor = each.share * each.stiffness
    cdef double share = 0.0, limit = each.limit
    cdef int c, e
    factor *= 1.0 + (2.0 if self.stepped else 1.0) * each.delay
    if self.is_sticking:
        limit *= 1.0 - SLIDING_RATIO
    if square > limit * limit:
        factor, share = factor * fmin(each.limit / sqrt(square), 1.0), 1.0 / square
    for c in range(3):
        for e in range(3):
            block[3 * c + e] = factor * ((c == e) - each.n[c] * each.n[e]
                                         - share * each.trial[c] * each.trial[e])


cdef void add_bristle_blocks(const Data *self, double *values) noexcept nogil:
    """Add the derivative of the friction of bristles by places."""
    cdef const Bristle *each
    cdef double[9] block
    cdef double[4] of_a
    cdef double[4] of_b
    cdef ptrdiff_t k
    for k in range(self.n_bristles):
        each = self.bristle + k
        if each.limit == 0.0:
            continue
        bristle_block(self, each, block)
        weigh_nodes(self, each.a, each.of_a, of_a)
        weigh_nodes(self, each.b, each.of_b, of_b)
        add_pair_blocks(self, each.a, each.b, of_a, of_b, block, values)
