# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Points that slide along the axes of beams, see `scene.kinematics.sliding_curve`: terms of equations.

The nearest point of the axis is sought from that of the last accepted step.
"""
from libc.math cimport NAN, fabs, sqrt

include "../contribution.pxi"


# Corrections of the nearest point, and share of the lateral direction that must be across the axis.
cdef int MOST = 60
cdef double ACROSS = 1e-3
# Vectors of a point and of an element.
cdef enum:
    VECTORS = 8


cdef struct Data:
    ptrdiff_t n_elements, dim, n_points, width, n_slots
    const int32_t *ends  # (n_elements, 4, dim)
    const double *arcs   # (n_elements + 1)
    const int32_t *point  # (n_points, dim)
    const double *weights
    const double *lateral
    const int32_t *row   # (dim - 1)
    const int32_t *slot  # (n_elements, n_slots): pairs of equations and coordinates
    double *s            # of the last accepted step [m]
    double off           # where the point has left the axis, or NaN


cdef struct Spot:
    ptrdiff_t element
    double s, square
    double[3] apart  # p - r
    double[3] slope
    double[3] bend
    double[VECTORS] weight  # of the vectors of the point and the element in p - r
    double[VECTORS] change  # its derivative by s
    double[2][3] normal


cdef class Tracks(CompiledContribution):
    """A point on a beam.

    Parameters
    ----------
    arrays : mapping
        ``ends``, ``arcs``, ``point``, ``weights`` and ``lateral`` of the track; ``row`` of its
        equations, ``slot`` of the pairs of equations, the point's coordinates and those of each
        element; ``s`` at the start.
    failure : callable
        Makes the error of a point that leaves the axis, from its arc coordinate.
    """

    cdef Data data
    cdef object failure

    def __cinit__(self, arrays, failure):
        cdef Data *data = &self.data
        self.failure = failure
        data.n_elements, data.dim = len(arrays["ends"]), arrays["ends"].shape[2]
        data.n_points, data.n_slots = len(arrays["point"]), arrays["slot"].shape[1]
        data.width = data.n_points + 4
        data.ends, data.arcs = integers(arrays["ends"]), reals(arrays["arcs"])
        data.point, data.weights = integers(arrays["point"]), reals(arrays["weights"])
        data.lateral, data.row = reals(arrays["lateral"]), integers(arrays["row"])
        data.slot, data.s, data.off = integers(arrays["slot"]), self.copy(arrays["s"]), NAN
        self.interface.context = data
        self.interface.n_memory, self.interface.memory = 1, data.s
        self.interface.residual, self.interface.between = residual, between
        self.interface.matrix = matrix
        self.interface.begin, self.interface.accept = accept, accept

    @property
    def error(self):
        """The failure: the point has left the axis; None if it has not."""
        return None if self.data.off != self.data.off else self.failure(self.data.off)


cdef inline double dot(const double *a, const double *b, ptrdiff_t n) noexcept nogil:
    cdef double sum = 0.0
    cdef ptrdiff_t c
    for c in range(n):
        sum += a[c] * b[c]
    return sum


cdef void look(const Data *self, const double *q, double s, Spot *x) noexcept nogil:
    """Set what there is at an arc coordinate; beyond the ends the last cubic goes on."""
    cdef ptrdiff_t low = 0, high = self.n_elements, middle, c, i
    cdef const int32_t *ends
    cdef double l, z, value
    cdef double[4] w
    cdef double[4] dw
    cdef double[4] ddw
    while high - low > 1:
        middle = (low + high) // 2
        if self.arcs[middle] <= s:
            low = middle
        else:
            high = middle
    l = self.arcs[low + 1] - self.arcs[low]
    z = (s - self.arcs[low]) / l
    w[0], w[1] = 1.0 - z * z * (3.0 - 2.0 * z), l * z * (1.0 - z) * (1.0 - z)
    w[2], w[3] = z * z * (3.0 - 2.0 * z), l * z * z * (z - 1.0)
    dw[0], dw[1] = 6.0 * z * (z - 1.0) / l, 1.0 + z * (3.0 * z - 4.0)
    dw[2], dw[3] = -dw[0], z * (3.0 * z - 2.0)
    ddw[0], ddw[1] = (12.0 * z - 6.0) / (l * l), (6.0 * z - 4.0) / l
    ddw[2], ddw[3] = -ddw[0], (6.0 * z - 2.0) / l
    x.element, x.s = low, s
    for c in range(3):
        x.apart[c] = x.slope[c] = x.bend[c] = 0.0
    for i in range(self.n_points):
        x.weight[i], x.change[i] = self.weights[i], 0.0
        for c in range(self.dim):
            x.apart[c] += self.weights[i] * q[self.point[self.dim * i + c]]
    for i in range(4):
        x.weight[self.n_points + i], x.change[self.n_points + i] = -w[i], -dw[i]
        ends = self.ends + (4 * low + i) * self.dim
        for c in range(self.dim):
            value = q[ends[c]]
            x.apart[c] -= w[i] * value
            x.slope[c] += dw[i] * value
            x.bend[c] += ddw[i] * value
    x.square = dot(x.slope, x.slope, 3)


cdef void normals_of(const Data *self, Spot *x) noexcept nogil:
    """Set the normals of the axis; not a number where the lateral direction is along it."""
    cdef double size = sqrt(x.square), along, length
    cdef double *n = x.normal[0]
    cdef ptrdiff_t c
    if self.dim == 2:
        n[0], n[1], n[2] = -x.slope[1] / size, x.slope[0] / size, 0.0
        return
    along = dot(self.lateral, x.slope, 3) / x.square
    for c in range(3):
        n[c] = self.lateral[c] - along * x.slope[c]
    length = sqrt(dot(n, n, 3))
    for c in range(3):
        n[c] = n[c] / length if length > ACROSS else NAN
    x.normal[1][0] = (x.slope[1] * n[2] - x.slope[2] * n[1]) / size
    x.normal[1][1] = (x.slope[2] * n[0] - x.slope[0] * n[2]) / size
    x.normal[1][2] = (x.slope[0] * n[1] - x.slope[1] * n[0]) / size


cdef void find(const Data *self, const double *q, Spot *x) noexcept nogil:
    """Find the nearest point of the axis, from that of the last accepted step on."""
    cdef double s = self.s[0], change, reach, whole = self.arcs[self.n_elements]
    cdef ptrdiff_t k
    for k in range(MOST + 4 * self.n_elements):  # half an element at a time
        look(self, q, s, x)
        change = dot(x.slope, x.apart, 3)
        change /= max(x.square - dot(x.bend, x.apart, 3), 0.1 * x.square)
        reach = 0.5 * (self.arcs[x.element + 1] - self.arcs[x.element])
        change = min(max(change, -reach), reach)
        s += change
        if fabs(change) <= 1e-15 * whole:
            break
    look(self, q, s, x)
    normals_of(self, x)


cdef inline int32_t place_of(const Data *self, const Spot *x, ptrdiff_t i, ptrdiff_t c) noexcept nogil:
    """The place in q of a component of vector i."""
    if i < self.n_points:
        return self.point[self.dim * i + c]
    return self.ends[(4 * x.element + i - self.n_points) * self.dim + c]


cdef void push(const Data *self, const Spot *x, const double *lam, double *r) noexcept nogil:
    cdef ptrdiff_t k, i, c
    for k in range(self.dim - 1):
        for i in range(self.width):
            for c in range(self.dim):
                r[place_of(self, x, i, c)] += lam[self.row[k]] * x.weight[i] * x.normal[k][c]


cdef inline void set_phi(const Data *self, const Spot *x, double *phi) noexcept nogil:
    cdef ptrdiff_t k
    for k in range(self.dim - 1):
        # A point that has left the axis makes the step fail.
        phi[self.row[k]] += dot(x.normal[k], x.apart, 3) if self.off != self.off else NAN


cdef void residual(void *context, const ancf_state *x, double *r, double *phi) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef Spot spot
    find(self, x.q, &spot)
    set_phi(self, &spot, phi)
    push(self, &spot, x.lam, r)


cdef void between(void *context, const double *q0, const double *q1, const ancf_state *x,
                  double *r, double *phi) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef Spot spot
    find(self, q1, &spot)
    set_phi(self, &spot, phi)
    find(self, x.q, &spot)
    push(self, &spot, x.lam, r)


cdef void matrix(void *context, int part, const ancf_state *x, double *values) noexcept nogil:
    cdef const Data *self = <const Data *>context
    cdef Spot spot
    cdef double[3] push_along
    cdef double bent = 0.0, mine, other
    cdef double[VECTORS][3] turn
    cdef double[VECTORS][3] along
    cdef const int32_t *slot
    cdef ptrdiff_t rows = self.dim - 1, k, i, j, c, e
    if part != STIFFNESS and part != EQUATIONS:
        return
    find(self, x.q, &spot)
    for c in range(3):
        push_along[c] = 0.0
    if part == STIFFNESS:
        for k in range(rows):
            for c in range(self.dim):
                push_along[c] += x.lam[self.row[k]] * spot.normal[k][c]
        bent = dot(push_along, spot.bend, 3)
        for i in range(self.width):
            for c in range(self.dim):
                turn[i][c] = spot.change[i] * push_along[c]
                along[i][c] = spot.weight[i] * spot.slope[c] / spot.square
    # Pairs by rows: equations first, then the coordinates.
    slot = self.slot + spot.element * self.n_slots + rows * (rows + 1) // 2
    for i in range(self.width):
        for c in range(self.dim):
            for k in range(rows):
                if part == EQUATIONS:
                    values[slot[0]] += spot.weight[i] * spot.normal[k][c]
                slot += 1
            for j in range(i + 1):
                for e in range(self.dim if j < i else c + 1):
                    if part == STIFFNESS:
                        values[slot[0]] += (turn[i][c] * along[j][e] + along[i][c] * turn[j][e]
                                            - bent * along[i][c] * along[j][e])
                    slot += 1


cdef void accept(void *context, const ancf_state *x) noexcept nogil:
    cdef Data *self = <Data *>context
    cdef Spot spot
    cdef double whole = self.arcs[self.n_elements]
    find(self, x.q, &spot)
    self.s[0] = spot.s
    if not -1e-9 * whole <= spot.s <= (1.0 + 1e-9) * whole:
        self.off = spot.s
