"""Parts of the axes of two elements that are closer than a distance; an include file.

The gap is measured from points z of one axis a to their feet u on the other axis b, both from 0 to 1.
Where the foot passes from b to the next element, a point passes through the plane normal to b
there, so the points of a with feet on b lie between two roots of a cubic.

With the numerical damping of impacts the penetration is e + theta a with the approach
a = -n . (da - db) of the point z and its foot u since the last accepted state.
"""
from libc.math cimport NAN, fabs, fmax, fmin, sqrt
from libc.string cimport memcpy

cdef enum:
    LEVELS = 3  # halvings of an element where extrema of the gap are sought
    MOST_OVERLAPS = 64  # overlaps of two elements
    MOST_CORRECTIONS = 60
cdef double EXACT = 1e-13  # of a root, over its interval
# Correction by Newton's method, over the interval, that leaves an error of rounding.  It is the last one:
# those of rounding do not change a number, and would be taken to leave the interval.
cdef double SETTLED = 1e-8
# Distance of the plane between two elements from their node, over the distance of the surfaces.  Axes
# often cross at right angles in a node, and rounding would decide in a plane through it which of both
# elements a point touches.  Distances of points between node and plane are off by 1e-10 of theirs.
cdef double PLANE_SHIFT = 1e-5
# Feet between node and plane lie beyond the end of their element, by at most this part of its length.
# Kept at the node, they would turn the normals of all points there: of cables that cross at nodes of both
# the matrix was wrong, and the last corrections of an equilibrium grew, each by a factor of 1.4 to 4.
cdef double MOST_BEYOND = 1e-3


cdef struct Cubic:
    double[4][3] point  # control points
    double[4][3] factor  # of the powers of the parameter
    double first, last  # places that feet can have, beyond 0 and 1 where another element continues it


cdef struct Foot:
    double u
    double[3] n  # from the foot to the point, of unit length
    double distance


cdef struct Gap:
    double e  # penetration, positive in contact
    double slope  # de/dz


cdef struct Sides:
    const Cubic *a
    const Cubic *b
    double theta  # of the numerical damping of impacts, 0 without it
    Cubic way_a, way_b  # changes of both axes since the last accepted state, where they are damped
    double reach  # distance at which surfaces touch
    double steep  # bound of |da/dz|
    int n, first  # overlaps, and the first one in the present interval
    double[MOST_OVERLAPS][2] part


cdef void expand(const double *points, Cubic *out) noexcept nogil:
    """Set a cubic from its control points, with feet from 0 to 1."""
    cdef int c
    cdef double p0, p1, p2, p3
    memcpy(out.point, points, 12 * sizeof(double))
    out.first, out.last = 0.0, 1.0
    for c in range(3):
        p0, p1, p2, p3 = points[c], points[3 + c], points[6 + c], points[9 + c]
        out.factor[0][c] = p0
        out.factor[1][c] = 3.0 * (p1 - p0)
        out.factor[2][c] = 3.0 * (p2 - 2.0 * p1 + p0)
        out.factor[3][c] = p3 - p0 + 3.0 * (p1 - p2)


cdef inline void place_at(const Cubic *self, double z, double *x) noexcept nogil:
    cdef int c
    for c in range(3):
        x[c] = self.factor[0][c] + z * (
            self.factor[1][c] + z * (self.factor[2][c] + z * self.factor[3][c]))


cdef inline void slope_at(const Cubic *self, double z, double *x) noexcept nogil:
    cdef int c
    for c in range(3):
        x[c] = self.factor[1][c] + z * (2.0 * self.factor[2][c] + 3.0 * z * self.factor[3][c])


cdef inline double foot_residual(const Cubic *b, const double *x, double u, double *offset,
                          double *slope) noexcept nogil:
    """Return (x - b(u)) . b'(u), and set x - b and b'."""
    cdef int c
    place_at(b, u, offset)
    slope_at(b, u, slope)
    for c in range(3):
        offset[c] = x[c] - offset[c]
    return dot(offset, slope)


cdef void find_foot(const Cubic *b, const double *x, double guess, Foot *out) noexcept nogil:
    """Find the point of an axis nearest to x: where x - b is normal to b, or an end."""
    cdef double[3] offset
    cdef double[3] slope
    cdef double[3] bend
    cdef double low = b.first, high = b.last, u = guess, h, change, curved
    cdef int k, c
    cdef double before = foot_residual(b, x, low, offset, slope)
    cdef double after = foot_residual(b, x, high, offset, slope)
    if before <= 0.0 or after >= 0.0:
        u = low if before <= 0.0 else high
        if before <= 0.0 and after >= 0.0 and (
                distance(x, b.point[3]) < distance(x, b.point[0])):
            u = high
    else:
        if not low < u < high:
            u = low + before / (before - after) * (high - low)
        for k in range(MOST_CORRECTIONS):
            h = foot_residual(b, x, u, offset, slope)
            if h > 0.0:
                low = u
            else:
                high = u
            for c in range(3):
                bend[c] = 2.0 * b.factor[2][c] + 6.0 * u * b.factor[3][c]
            curved = dot(slope, slope) - dot(offset, bend)
            change = h / curved if curved > 0.0 else high - low
            if fabs(change) <= SETTLED:
                u = fmin(fmax(u + change, low), high)
                break
            if not low < u + change < high:
                change = 0.5 * (low + high) - u
            u += change
    foot_residual(b, x, u, offset, slope)
    out.u, out.distance = u, sqrt(dot(offset, offset))
    for c in range(3):
        out.n[c] = offset[c] / out.distance


cdef inline double distance(const double *a, const double *b) noexcept nogil:
    cdef double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2]
    return sqrt(x * x + y * y + z * z)


cdef Gap gap_at(const Sides *self, double z, double *guess) noexcept nogil:
    cdef Gap out
    cdef Foot foot
    cdef double[3] x
    place_at(self.a, z, x)
    find_foot(self.b, x, guess[0], &foot)
    guess[0] = foot.u
    slope_at(self.a, z, x)
    out.e, out.slope = self.reach - foot.distance, -dot(foot.n, x)
    if self.theta > 0.0:
        out.e += self.theta * approach(self, z, &foot)
        out.slope += self.theta * approach_slope(self, z, &foot, x)
    return out


cdef double approach(const Sides *self, double z, const Foot *foot) noexcept nogil:
    """Return the approach of a point and its foot along the normal since the last accepted state."""
    cdef double[3] of_a
    cdef double[3] of_b
    place_at(&self.way_a, z, of_a)
    place_at(&self.way_b, foot.u, of_b)
    return dot(foot.n, of_b) - dot(foot.n, of_a)


cdef double approach_slope(const Sides *self, double z, const Foot *foot,
                           const double *slope_a) noexcept nogil:
    """Return the derivative of the approach by z, where the foot and the normal move as well."""
    cdef double[3] way
    cdef double[3] of_b
    cdef double[3] turn
    cdef double[3] slope_b
    cdef double rate = 0.0, along, curved, out
    cdef int c
    slope_at(self.b, foot.u, slope_b)
    if self.b.first < foot.u < self.b.last:
        curved = dot(slope_b, slope_b)
        for c in range(3):
            curved -= foot.distance * foot.n[c] * (
                2.0 * self.b.factor[2][c] + 6.0 * foot.u * self.b.factor[3][c])
        rate = dot(slope_a, slope_b) / curved if curved > 0.0 else 0.0
    for c in range(3):
        turn[c] = slope_a[c] - rate * slope_b[c]
    along = dot(turn, foot.n)
    for c in range(3):
        turn[c] = (turn[c] - along * foot.n[c]) / foot.distance
    place_at(&self.way_a, z, way)
    place_at(&self.way_b, foot.u, of_b)
    out = dot(turn, of_b) - dot(turn, way)
    slope_at(&self.way_a, z, way)
    slope_at(&self.way_b, foot.u, of_b)
    return out + rate * dot(foot.n, of_b) - dot(foot.n, way)


cdef double steepest(const Cubic *a) noexcept nogil:
    """Return a bound of |da/dz|."""
    cdef double slope = 0.0
    cdef int k
    for k in range(3):
        slope = fmax(slope, 3.0 * distance(a.point[k], a.point[k + 1]))
    return slope


cdef double steepest_gap(const Sides *self) noexcept nogil:
    """Return a bound of |de/dz|, with damping for axes that are bent little within their distance."""
    cdef double slope = steepest(self.a), farthest = 0.0, along
    cdef double[3] way
    cdef int i, j, c
    if self.theta == 0.0:
        return slope
    for i in range(4):
        for j in range(4):
            for c in range(3):
                way[c] = self.way_a.point[i][c] - self.way_b.point[j][c]
            farthest = fmax(farthest, dot(way, way))
    along = slope / fmax(distance(self.b.point[0], self.b.point[3]), EXACT * self.reach)
    return slope + self.theta * (slope * sqrt(farthest) / self.reach + steepest(&self.way_a)
                                + along * steepest(&self.way_b))


cdef double zero_of(const Sides *self, double low, double high, bint of_slope, bint rising,
                    double guess) noexcept nogil:
    """Find the zero of the penetration, or a maximum of it or a place of contact near one."""
    cdef double z = 0.5 * (low + high), value, next_z, last = 1.0, width = high - low
    cdef double other_z = 0.0, other = 0.0
    cdef Gap gap
    cdef int k
    for k in range(MOST_CORRECTIONS):
        gap = gap_at(self, z, &guess)
        if of_slope and gap.e > 0.0:
            return z
        value = gap.slope if of_slope else gap.e
        if (value < 0.0) == rising:
            low = z
        else:
            high = z
        if of_slope:  # secants, as the derivative of the slope is unknown
            next_z = z - value * (z - other_z) / (value - other) if k and value != other else NAN
            other_z, other = z, value
        else:
            next_z = z - value / gap.slope if gap.slope != 0.0 else NAN
        if fabs(next_z - z) <= SETTLED * width:
            return fmin(fmax(next_z, low), high)
        if not low < next_z < high or fabs(next_z - z) > 0.5 * last * width:
            next_z = 0.5 * (low + high)
        last = fabs(next_z - z) / width
        z = next_z
        if high - low <= EXACT * width:
            break
    return z


cdef void add_part(Sides *self, double begin, double end) noexcept nogil:
    """Add an overlap, or extend the last one."""
    if self.n > self.first and begin <= self.part[self.n - 1][1]:
        self.part[self.n - 1][1] = end
    elif self.n < MOST_OVERLAPS:
        self.part[self.n][0], self.part[self.n][1] = begin, end
        self.n += 1


cdef void search(Sides *self, double low, Gap at_low, double high, Gap at_high, int level,
                 double guess) noexcept nogil:
    """Add the parts of [low, high] in contact; no point is nearer than its way from the ends allows."""
    cdef double middle = 0.5 * (low + high), most = 0.5 * self.steep * (high - low)
    cdef double mean = 0.5 * (at_low.e + at_high.e)
    cdef Gap gap
    if mean + most <= 0.0:
        return
    if mean - most >= 0.0:
        add_part(self, low, high)
        return
    if level < LEVELS:
        gap = gap_at(self, middle, &guess)
        search(self, low, at_low, middle, gap, level + 1, guess)
        search(self, middle, gap, high, at_high, level + 1, guess)
    elif at_low.e > 0.0 and at_high.e > 0.0:
        add_part(self, low, high)
    elif at_low.e > 0.0:
        add_part(self, low, zero_of(self, low, high, False, False, guess))
    elif at_high.e > 0.0:
        add_part(self, zero_of(self, low, high, False, True, guess), high)
    elif at_low.slope > 0.0 and at_high.slope < 0.0:
        middle = zero_of(self, low, high, True, False, guess)
        gap = gap_at(self, middle, &guess)
        if gap.e > 0.0:
            add_part(self, zero_of(self, low, middle, False, True, guess),
                     zero_of(self, middle, high, False, False, guess))


cdef int add_roots(const Cubic *a, const double *normal, const double *origin, double *z,
                   int n) noexcept nogil:
    """Add where an axis passes through a plane, in (0, 1)."""
    cdef double[4] f
    cdef double[4] stop
    cdef double low, high, middle, at_low, value, root
    cdef int k, i, n_stops = 1
    for k in range(4):
        f[k] = dot(a.factor[k], normal)
    f[0] -= dot(origin, normal)
    # Between its extrema a cubic has one root at most.
    stop[0] = 0.0
    value = f[2] * f[2] - 3.0 * f[3] * f[1]
    if value > 0.0:
        value = -f[2] - (sqrt(value) if f[2] > 0.0 else -sqrt(value))
        low = f[1] / value if value != 0.0 else -1.0
        high = value / (3.0 * f[3]) if f[3] != 0.0 else -1.0
        if 0.0 < fmin(low, high) < 1.0:
            stop[n_stops] = fmin(low, high)
            n_stops += 1
        if 0.0 < fmax(low, high) < 1.0 and low != high:
            stop[n_stops] = fmax(low, high)
            n_stops += 1
    stop[n_stops] = 1.0
    for i in range(n_stops):
        low, high = stop[i], stop[i + 1]
        at_low = cubic(f, low)
        if (at_low < 0.0) == (cubic(f, high) < 0.0):
            continue
        root = 0.5 * (low + high)
        for k in range(MOST_CORRECTIONS):
            value = cubic(f, root)
            if (value < 0.0) == (at_low < 0.0):
                low = root
            else:
                high = root
            middle = f[1] + root * (2.0 * f[2] + 3.0 * root * f[3])
            middle = root - value / middle if middle != 0.0 else NAN
            if fabs(middle - root) <= SETTLED:
                root = fmin(fmax(middle, low), high)
                break
            root = middle if low < middle < high else 0.5 * (low + high)
        z[n] = root
        n += 1
    return n


cdef inline double cubic(const double *f, double z) noexcept nogil:
    return f[0] + z * (f[1] + z * (f[2] + z * f[3]))


cdef void shift_plane(const double *node, const double *normal, double way,
                      double *origin) noexcept nogil:
    """Set a point of the plane at a distance from a node, along its normal."""
    cdef double size = sqrt(dot(normal, normal))
    cdef int c
    for c in range(3):
        origin[c] = node[c] + (way / size * normal[c] if size > 0.0 else 0.0)


cdef void find_overlaps(Sides *self) noexcept nogil:
    """Find the parts of axis a that are closer to axis b than their reach.

    Only points with a foot on b count; where b has a free end, also those beyond that end.
    """
    cdef double[3] first
    cdef double[3] last
    cdef double[3] x
    cdef double[8] z
    cdef double swap, guess = 0.5
    cdef double[3] origin
    cdef double[3] tip
    cdef Gap at_low
    cdef Gap at_high
    cdef bint starts = self.b.first == 0.0, ends = self.b.last == 1.0
    cdef int n = 1, i, k
    self.n, self.steep, z[0] = 0, steepest_gap(self), 0.0
    slope_at(self.b, 0.0, first)
    slope_at(self.b, 1.0, last)
    shift_plane(self.b.point[0], first, PLANE_SHIFT * self.reach, origin)
    shift_plane(self.b.point[3], last, PLANE_SHIFT * self.reach, tip)
    n = add_roots(self.a, first, origin, z, n)
    n = add_roots(self.a, last, tip, z, n)
    for i in range(2, n):
        for k in range(i, 1, -1):
            if z[k] < z[k - 1]:
                swap = z[k]
                z[k] = z[k - 1]
                z[k - 1] = swap
    z[n] = 1.0
    for i in range(n):
        place_at(self.a, 0.5 * (z[i] + z[i + 1]), x)
        if z[i + 1] - z[i] > EXACT and (
                starts or dot(x, first) >= dot(origin, first)) and (
                ends or dot(x, last) < dot(tip, last)):
            self.first = self.n  # the gap is smooth only between two planes
            at_low = gap_at(self, z[i], &guess)
            at_high = gap_at(self, z[i + 1], &guess)
            search(self, z[i], at_low, z[i + 1], at_high, 0, guess)
