"""Gauss points of overlaps, and their forces on elements; an include file."""
from libc.math cimport M_PI
from libc.string cimport memcmp

cdef enum:
    GAUSS = 5  # points of an overlap
cdef double[GAUSS] GAUSS_PLACE = [
    0.046910077030668, 0.230765344947158455, 0.5, 0.769234655052841545, 0.953089922969332]
cdef double[GAUSS] GAUSS_WEIGHT = [
    0.118463442528094544, 0.239314335249683234, 0.284444444444444444, 0.239314335249683234,
    0.118463442528094544]


cdef struct Touch:
    int32_t a, b, bodies  # both elements, and the number of their pair of bodies
    double z, u  # places of the point on a, and of its foot on b
    double[3] n  # from the foot to the point
    double e  # penetration, at the end of a step with the numerical damping of impacts
    double depth  # penetration without it
    double theta  # of that damping
    double stiffness  # times the length of the point [N/m]
    double change  # of the penetration in a step, or its rate in a state
    double force  # without restitution [N]
    double ratio, s  # of the force with restitution to it, and what sets it


cdef struct Touches:
    Touch *touch
    ptrdiff_t n, room


cdef struct BodyPair:  # two bodies, or a body and itself, that have touched
    int32_t other, next  # the higher body, and the next pair of the lower one, or -1
    double mass  # reduced mass [kg]
    double stiffness  # of all their points or bristles [N/m]
    double missing, square, factor  # of the correction of mean forces


cdef struct BodyPairs:
    ptrdiff_t n, room
    BodyPair *pair
    int32_t *first  # of the pairs with a body as the lower one, or -1


cdef struct Coupling:
    ancf_coupling list
    ptrdiff_t room
    int32_t *pair
    int32_t *first  # of the pairs with an element as the lower one, -1 if none
    int32_t *next  # of them
    int32_t *touches  # whether a pair touches


cdef struct Bristle


cdef struct Data:
    ptrdiff_t n, dim
    const int32_t *place  # (n, 4, dim)
    const int32_t *slot
    const double *length
    const int32_t *straight
    const int32_t *tips
    const double *mass  # per length, of the elements [kg/m]
    double stiffness
    double friction, slip_speed
    double friction0  # static coefficient of friction
    bint has_two  # whether it is larger
    double gamma  # share of forces that changes its sign in an impact, 0 without restitution
    double slow  # rate of penetrations below which forces change less, over the rate of impacts
    const int32_t *body  # of each element
    const double *body_mass  # of each body [kg]
    BodyPairs bodies
    double settling  # twice the damping ratio of two bodies on bristles
    double lost  # energy that restitution takes in the step [J]
    double *spent  # of turning, 0, and losses as of ../contact/_contacts.pyx; saved with the states
    double loss  # by friction in the step of the last `work` [J]
    double grip  # stiffness of bristles over that of their points, 0 without them
    double *slots  # their history
    ptrdiff_t width  # numbers of a slot
    ptrdiff_t n_slots, crowded  # slots, and the number of pairs if they were too few
    const int32_t *following  # (n, 2): elements that continue an axis before and after, or -1
    Bristle *bristle  # of the last step, or of a state
    ptrdiff_t n_bristles, room
    int32_t *first_bristle  # of each element, or -1
    double interval  # since the last accepted state, 0 in a state of its own [s]
    const double *start  # control points in that state
    bint is_static  # whether bristles are deflected by displacements between equilibria
    bint is_sticking  # whether the matrix of a state contains the bristles of its history
    double dt  # length of the step, 0 outside of one [s]
    Search search
    double *tight  # (n, 6): boxes of the axes in one state or two
    # Control points (n, 4, 3) of a state, their velocities, and forces on them.
    double *now
    double *speed
    double *push
    Touches at_now
    ptrdiff_t n_parts  # of threads
    Touches *of_part  # which they find
    # Largest penetration of an accepted state of the run [m], the elements of the point and its foot,
    # and their places.
    double *deepest
    double *before  # in the last accepted state
    double *braked  # forces of the damping of impacts on them there
    double *braking  # and at the end of a step
    double *rubbed  # friction on them there
    double *ahead  # as far behind a state as that is before it
    # In the last step between two states, with its midpoint also as rounded by the integrator, or
    # else the end of a step in the last residual.
    bint stepped, ended
    double *begin
    double *halfway
    double *end
    double *middle
    Touches at_begin, at_halfway, at_end
    Coupling coupling
    ptrdiff_t touching, changes  # touching points of the last accepted state, steps with other numbers


cdef void set_points(const Data *self, const double *q, double *points) noexcept nogil:
    """Set the control points of all elements."""
    cdef ptrdiff_t e, c
    cdef const int32_t *place
    cdef double *x
    cdef double third
    for e in range(self.n):
        place, x, third = self.place + 4 * self.dim * e, points + 12 * e, self.length[e] / 3.0
        for c in range(self.dim):
            x[c], x[9 + c] = q[place[c]], q[place[2 * self.dim + c]]
            if self.straight[e]:
                x[3 + c] = (2.0 * x[c] + x[9 + c]) / 3.0
                x[6 + c] = (x[c] + 2.0 * x[9 + c]) / 3.0
            else:
                x[3 + c] = x[c] + third * q[place[self.dim + c]]
                x[6 + c] = x[9 + c] - third * q[place[3 * self.dim + c]]


cdef inline void bernstein(double z, double *w) noexcept nogil:
    """Set the weights of control points."""
    cdef double y = 1.0 - z
    w[0], w[1], w[2], w[3] = y * y * y, 3.0 * y * y * z, 3.0 * y * z * z, z * z * z


cdef void blend(const double *points, const Touch *each, double *d) noexcept nogil:
    """Set the vector from the foot of a touching point to it, in another state."""
    cdef double[4] of_a
    cdef double[4] of_b
    cdef int k, c
    bernstein(each.z, of_a)
    bernstein(each.u, of_b)
    for c in range(3):
        d[c] = 0.0
        for k in range(4):
            d[c] += of_a[k] * points[12 * each.a + 3 * k + c]
            d[c] -= of_b[k] * points[12 * each.b + 3 * k + c]


cdef int32_t find_bodies(Data *self, int32_t a, int32_t b) noexcept nogil:
    """Return the number of the pair of bodies of two elements, or -1 without memory."""
    cdef BodyPairs *pairs = &self.bodies
    cdef int32_t one = self.body[a], other = self.body[b]
    cdef int32_t low = min(one, other), high = max(one, other), k = pairs.first[low]
    cdef BodyPair *each
    cdef void *more
    while k >= 0 and pairs.pair[k].other != high:
        k = pairs.pair[k].next
    if k >= 0:
        return k
    if pairs.n == pairs.room:
        more = realloc(pairs.pair, (2 * pairs.room + 16) * sizeof(BodyPair))
        if more == NULL:
            return -1
        pairs.pair, pairs.room = <BodyPair *>more, 2 * pairs.room + 16
    each = pairs.pair + pairs.n
    memset(each, 0, sizeof(BodyPair))
    each.other, each.next, pairs.first[low] = high, pairs.first[low], <int32_t>pairs.n
    each.mass = 1.0 / (1.0 / self.body_mass[low] + 1.0 / self.body_mass[high])
    pairs.n += 1
    return <int32_t>(pairs.n - 1)


cdef void clear_stiffness(const Data *self) noexcept nogil:
    """Let sums of stiffnesses begin."""
    cdef ptrdiff_t k
    for k in range(self.bodies.n):
        self.bodies.pair[k].stiffness = 0.0


cdef void sum_stiffness(const Data *self, const Touches *list) noexcept nogil:
    """Set the stiffness of all touching points of each pair."""
    cdef ptrdiff_t k
    clear_stiffness(self)
    for k in range(list.n):
        self.bodies.pair[list.touch[k].bodies].stiffness += list.touch[k].stiffness


cdef inline double rate_of(const BodyPair *self) noexcept nogil:
    """Return sqrt(K / m), the rate of impacts [1/s]."""
    return sqrt(self.stiffness / self.mass)


cdef inline double damping_ratio(const Data *self, ptrdiff_t a, ptrdiff_t b) noexcept nogil:
    """Theta of the numerical damping of an impact, whose duration is pi sqrt(reduced mass / k)."""
    cdef double ratio = STEPS_PER_IMPACT * self.dt / M_PI
    if self.dt == 0.0:
        return 0.0
    return fmin(1.0, ratio * ratio * self.stiffness * (1.0 / self.mass[a] + 1.0 / self.mass[b]))


cdef bint list_damped(Data *self, const double *points, Touches *out) noexcept nogil:
    """List the touching points at the end of a step, with the numerical damping of impacts."""
    cdef ptrdiff_t k
    if self.dt == 0.0:
        return cover(&self.search, points, NULL) and collect(self, points, NULL, out)
    for k in range(12 * self.n):
        self.ahead[k] = 2.0 * points[k] - self.before[k]
    return cover(&self.search, points, self.ahead) and collect(self, points, self.ahead, out)


cdef void set_boxes(const Data *self, const double *one, const double *other) noexcept nogil:
    """Set the boxes of the axes in two states, or one and null."""
    cdef ptrdiff_t e
    cdef int c
    for e in range(self.n):
        for c in range(3):
            self.tight[6 * e + c] = self.tight[6 * e + 3 + c] = one[12 * e + c]
        bounds(one + 12 * e, self.tight + 6 * e, self.tight + 6 * e + 3)
        if other != NULL:
            bounds(other + 12 * e, self.tight + 6 * e, self.tight + 6 * e + 3)


cdef bint collect(Data *self, const double *points, const double *ahead,
                  Touches *out) noexcept nogil:
    """List the touching points of all pairs in a state; return False if memory is lacking.

    Those at the end of a damped step are given the points `ahead` as well.
    """
    cdef Collection call
    cdef ptrdiff_t part, total = 0
    cdef void *more
    set_boxes(self, points, ahead)
    call.data, call.points, call.ahead = self, points, ahead
    in_parts(self.n_parts, collect_part, &call)
    out.n = 0
    for part in range(self.n_parts):
        if self.of_part[part].n < 0:
            return False
        total += self.of_part[part].n
    if total > out.room:
        more = realloc(out.touch, 2 * total * sizeof(Touch))
        if more == NULL:
            return False
        out.touch, out.room = <Touch *>more, 2 * total
    for part in range(self.n_parts):  # in the order of the pairs, for any number of parts
        if self.of_part[part].n > 0:
            memcpy(out.touch + out.n, self.of_part[part].touch, self.of_part[part].n * sizeof(Touch))
            out.n += self.of_part[part].n
    return name_bodies(self, out)


cdef bint name_bodies(Data *self, Touches *list) noexcept nogil:
    """Set the pairs of bodies of all touching points; return False if memory is lacking."""
    cdef Touch *each
    cdef ptrdiff_t k
    for k in range(list.n):
        each = list.touch + k
        if k > 0 and each.a == list.touch[k - 1].a and each.b == list.touch[k - 1].b:
            each.bodies = list.touch[k - 1].bodies
            continue
        each.bodies = find_bodies(self, each.a, each.b)
        if each.bodies < 0:
            return False
    return True


cdef struct Collection:  # of touching points in parts
    const Data *data
    const double *points
    const double *ahead


cdef void collect_part(void *context, ptrdiff_t part) noexcept nogil:
    """List the touching points of a part of the pairs; set a negative number if memory is lacking."""
    cdef const Collection *call = <const Collection *>context
    cdef const Data *self = call.data
    cdef Touches *out = self.of_part + part
    cdef const int32_t *pair
    cdef const double *box
    cdef const double *other
    cdef double reach
    cdef ptrdiff_t k
    cdef int c
    cdef bint is_separated
    cdef Cubic a
    cdef Cubic b
    out.n = 0
    for k in range(self.search.n_pairs * part // self.n_parts,
                   self.search.n_pairs * (part + 1) // self.n_parts):
        pair = self.search.pair + 2 * k
        box, other = self.tight + 6 * pair[0], self.tight + 6 * pair[1]
        reach = self.search.radius[pair[0]] + self.search.radius[pair[1]]
        is_separated = False
        for c in range(3):
            is_separated = is_separated or box[c] > other[3 + c] + reach or other[c] > box[3 + c] + reach
        if is_separated:
            continue
        expand_element(self, pair[0], call.points, &a)
        expand_element(self, pair[1], call.points, &b)
        if not (add_touches(self, &a, &b, pair[0], pair[1], reach, call.ahead, out)
                and add_touches(self, &b, &a, pair[1], pair[0], reach, call.ahead, out)):
            out.n = -1
            return


cdef inline void expand_element(const Data *self, ptrdiff_t e, const double *points,
                                Cubic *out) noexcept nogil:
    """Set the axis of an element, with feet beyond the ends that another one continues."""
    expand(points + 12 * e, out)
    if not self.tips[2 * e]:
        out.first = -MOST_BEYOND
    if not self.tips[2 * e + 1]:
        out.last = 1.0 + MOST_BEYOND


cdef void set_way(const double *now, const double *ahead, Cubic *out) noexcept nogil:
    """Set the change of an axis since the last accepted state."""
    cdef double[12] way
    cdef int k
    for k in range(12):
        way[k] = ahead[k] - now[k]
    expand(way, out)


cdef bint add_touches(const Data *self, const Cubic *a, const Cubic *b, int32_t of_a, int32_t of_b,
                      double reach, const double *ahead, Touches *out) noexcept nogil:
    """Add the Gauss points on axis a in its overlaps with axis b."""
    cdef Sides sides
    cdef Foot foot
    cdef Touch *each
    cdef void *more
    cdef double[3] x
    cdef double span, guess = 0.5
    cdef int i, k
    sides.a, sides.b, sides.reach, sides.theta = a, b, reach, 0.0
    if ahead != NULL:
        sides.theta = damping_ratio(self, of_a, of_b)
        set_way(a.point[0], ahead + 12 * of_a, &sides.way_a)
        set_way(b.point[0], ahead + 12 * of_b, &sides.way_b)
    find_overlaps(&sides)
    for i in range(sides.n):
        span = sides.part[i][1] - sides.part[i][0]
        for k in range(GAUSS):
            if out.n == out.room:
                more = realloc(out.touch, (2 * out.room + 64) * sizeof(Touch))
                if more == NULL:
                    return False
                out.touch, out.room = <Touch *>more, 2 * out.room + 64
            each = out.touch + out.n
            each.a, each.b, each.z = of_a, of_b, sides.part[i][0] + span * GAUSS_PLACE[k]
            place_at(a, each.z, x)
            find_foot(b, x, guess, &foot)
            guess = each.u = foot.u
            each.e = each.depth = reach - foot.distance
            each.theta = sides.theta
            if sides.theta > 0.0:
                each.e += sides.theta * approach(&sides, each.z, &foot)
            if each.e <= 0.0:
                continue
            memcpy(each.n, foot.n, 3 * sizeof(double))
            each.stiffness = 0.5 * self.stiffness * self.length[of_a] * span * GAUSS_WEIGHT[k]
            each.stiffness *= side_weight(&sides, each.z, &foot)
            each.force, each.ratio, each.s = each.stiffness * each.e, 1.0, 0.0
            out.n += 1
    return True


cdef inline double pressure(const Touch *self) noexcept nogil:
    """Return the normal force of a touching point, between two states without the correction."""
    return self.ratio * self.stiffness * self.e


cdef double stored(const Touches *self) noexcept nogil:
    """Return the energy of a state."""
    cdef double sum = 0.0
    cdef ptrdiff_t k
    for k in range(self.n):
        sum += 0.5 * self.touch[k].stiffness * self.touch[k].e * self.touch[k].e
    return sum


cdef void push(double *out, const Touch *each, double size, const double *way) noexcept nogil:
    """Add a force along a direction to those on the control points of both elements."""
    cdef double[4] w
    cdef int k, c
    bernstein(each.z, w)
    for k in range(4):
        for c in range(3):
            out[12 * each.a + 3 * k + c] += w[k] * size * way[c]
    bernstein(each.u, w)
    for k in range(4):
        for c in range(3):
            out[12 * each.b + 3 * k + c] -= w[k] * size * way[c]


cdef void distribute(const Data *self, double *r) noexcept nogil:
    """Subtract the forces on control points from a residual."""
    cdef ptrdiff_t e, c, dim = self.dim
    cdef const int32_t *place
    cdef const double *f
    cdef double third
    for e in range(self.n):
        place, f, third = self.place + 4 * dim * e, self.push + 12 * e, self.length[e] / 3.0
        for c in range(dim):
            if self.straight[e]:
                r[place[c]] -= f[c] + (2.0 * f[3 + c] + f[6 + c]) / 3.0
                r[place[2 * dim + c]] -= f[9 + c] + (f[3 + c] + 2.0 * f[6 + c]) / 3.0
            else:
                r[place[c]] -= f[c] + f[3 + c]
                r[place[dim + c]] -= third * f[3 + c]
                r[place[2 * dim + c]] -= f[6 + c] + f[9 + c]
                r[place[3 * dim + c]] += third * f[6 + c]
