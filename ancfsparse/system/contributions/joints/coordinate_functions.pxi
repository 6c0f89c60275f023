"""Angles, lengths and displacements of joints, see `scene.kinematics.joint_coordinates`: h(x, y), x = A . B,
y = A . C; text for the contributions that use them.

Between two states derivatives are taken in the middle, and those of h so that their product with
the changes of x and y is the change of h: exact then for every measure, as x and y are quadratic.
"""
from libc.math cimport atan2, remainder, sqrt


cdef double TURN = 6.283185307179586476925287


cdef enum Kind:
    ANGLE, LENGTH, ALONG


cdef struct Measures:
    ptrdiff_t n
    const int32_t *kind
    const int32_t *start  # of the coordinates of each
    const int32_t *place
    const double *weight  # of each coordinate, in 9 components of A, B and C
    const double *constant  # (n, 9)


cdef struct Vectors:
    double[9] each  # A, B, C
    double x, y
    double[2] h  # derivatives by x and y
    double[9] g  # by the components of A, B and C


cdef take(Measures *self, arrays):
    """Set the pointers into arrays that their owner keeps."""
    self.n = len(arrays["kind"])
    self.kind, self.start = integers(arrays["kind"]), integers(arrays["start"])
    self.place = integers(arrays["place"])
    self.weight, self.constant = reals(arrays["weight"]), reals(arrays["constant"])


cdef inline void vectors_of(const Measures *self, ptrdiff_t k, const double *q,
                            Vectors *a) noexcept nogil:
    cdef const double *weight
    cdef double value
    cdef ptrdiff_t c, i
    for c in range(9):
        a.each[c] = self.constant[9 * k + c]
    for i in range(self.start[k], self.start[k + 1]):
        weight, value = self.weight + 9 * i, q[self.place[i]]
        for c in range(9):
            a.each[c] += weight[c] * value
    a.x = a.y = 0.0
    for c in range(3):
        a.x += a.each[c] * a.each[3 + c]
        a.y += a.each[c] * a.each[6 + c]


cdef inline double h_of(int kind, const Vectors *a, double near) noexcept nogil:
    """The measure; an angle that is nearest to another one."""
    if kind == ANGLE:
        return near + remainder(atan2(a.y, a.x) - near, TURN)
    return sqrt(a.x) if kind == LENGTH else a.x


cdef inline void slopes_of(int kind, Vectors *a) noexcept nogil:
    """Set the derivatives of h by x and y."""
    cdef double x = a.x, y = a.y, square = x * x + y * y
    if kind == ANGLE:
        a.h[0], a.h[1] = -y / square, x / square
    else:
        a.h[0], a.h[1] = 0.5 / sqrt(x) if kind == LENGTH else 1.0, 0.0


cdef inline double change_of(int kind, Vectors *a, const Vectors *b) noexcept nogil:
    """Return the change of h from a to b; set in a the derivatives whose product that is."""
    cdef double dx = b.x - a.x, dy = b.y - a.y, x = 0.5 * (a.x + b.x), y = 0.5 * (a.y + b.y)
    cdef double across = x * dy - y * dx, turn, ratio
    if kind == ANGLE:
        # The angle between (x0, y0) and (x1, y1), without a difference of two angles.
        turn = atan2(across, a.x * b.x + a.y * b.y)
        ratio = turn / across if across != 0.0 else 1.0 / (x * x + y * y)
        a.h[0], a.h[1] = -y * ratio, x * ratio
        return turn
    a.h[0], a.h[1] = 1.0 / (sqrt(a.x) + sqrt(b.x)) if kind == LENGTH else 1.0, 0.0
    return a.h[0] * dx


cdef inline void gradient_of(Vectors *a) noexcept nogil:
    """Set the derivatives by the components of A, B and C."""
    cdef ptrdiff_t c
    for c in range(3):
        a.g[c] = a.h[0] * a.each[3 + c] + a.h[1] * a.each[6 + c]
        a.g[3 + c], a.g[6 + c] = a.h[0] * a.each[c], a.h[1] * a.each[c]


cdef inline void differentiate(const Measures *self, ptrdiff_t k, const double *q,
                               Vectors *a) noexcept nogil:
    """Set the vectors of measure k and its derivatives."""
    vectors_of(self, k, q, a)
    slopes_of(self.kind[k], a)
    gradient_of(a)


cdef inline double along(const Measures *self, ptrdiff_t i, const double *g) noexcept nogil:
    """The derivative by coordinate i, from those by A, B and C."""
    cdef const double *weight = self.weight + 9 * i
    cdef double sum = 0.0
    cdef ptrdiff_t c
    for c in range(9):
        sum += weight[c] * g[c]
    return sum


cdef inline void push(const Measures *self, ptrdiff_t k, double factor, const double *g,
                      double *r) noexcept nogil:
    cdef ptrdiff_t i
    for i in range(self.start[k], self.start[k + 1]):
        r[self.place[i]] += factor * along(self, i, g)


cdef inline double rate_of(const Measures *self, ptrdiff_t k, const double *g,
                           const double *v) noexcept nogil:
    cdef double sum = 0.0
    cdef ptrdiff_t i
    for i in range(self.start[k], self.start[k + 1]):
        sum += along(self, i, g) * v[self.place[i]]
    return sum


cdef void second_of(int kind, const Vectors *a, double s[9][9]) noexcept nogil:
    """Second derivatives by the components of A, B and C."""
    cdef double square = a.x * a.x + a.y * a.y
    cdef double xx = 0.0, xy = 0.0, yy = 0.0
    cdef const double *A = a.each
    cdef const double *B = a.each + 3
    cdef const double *C = a.each + 6
    cdef ptrdiff_t c, e
    if kind == ANGLE:
        xx = 2.0 * a.x * a.y / (square * square)
        xy = (a.y * a.y - a.x * a.x) / (square * square)
        yy = -xx
    elif kind == LENGTH:
        xx = -0.25 / (a.x * sqrt(a.x))
    for c in range(3):
        for e in range(3):
            s[c][e] = xx * B[c] * B[e] + xy * (B[c] * C[e] + C[c] * B[e]) + yy * C[c] * C[e]
            s[3 + c][e] = A[c] * (xx * B[e] + xy * C[e]) + (a.h[0] if c == e else 0.0)
            s[6 + c][e] = A[c] * (xy * B[e] + yy * C[e]) + (a.h[1] if c == e else 0.0)
            s[e][3 + c], s[e][6 + c] = s[3 + c][e], s[6 + c][e]
            s[3 + c][3 + e], s[6 + c][6 + e] = xx * A[c] * A[e], yy * A[c] * A[e]
            s[3 + c][6 + e] = s[6 + e][3 + c] = xy * A[c] * A[e]


cdef void add_pairs(const Measures *self, ptrdiff_t k, const double s[9][9], const double *g,
                    double of_second, double of_square, const int32_t *slot,
                    double *values) noexcept nogil:
    """Add ``of_second h_qq + of_square h_q h_q^T``, the lower triangle by rows."""
    cdef ptrdiff_t begin = self.start[k], end = self.start[k + 1], i, j, c, e
    cdef const double *weight
    cdef double[9] row
    cdef double mine, sum
    for i in range(begin, end):
        weight, mine = self.weight + 9 * i, along(self, i, g)
        for e in range(9):
            row[e] = of_square * mine * g[e]
            for c in range(9):
                row[e] += of_second * weight[c] * s[c][e]
        for j in range(begin, i + 1):
            weight, sum = self.weight + 9 * j, 0.0
            for e in range(9):
                sum += weight[e] * row[e]
            values[slot[0]] += sum
            slot += 1
