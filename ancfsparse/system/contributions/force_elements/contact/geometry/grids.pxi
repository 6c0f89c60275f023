"""Distances sampled on a grid, by tricubic B-splines; included by `_contacts.pyx`.

The distance of a point outside the grid is the value at the closest point of the grid plus the
distance from that point, so that it is continuous.
"""


cdef inline void weigh_nodes(double s, int order, double *w) noexcept nogil:
    """Set the B-splines of four nodes, or their derivatives, at the fraction s of a cell."""
    cdef double t = 1.0 - s
    if order == 0:
        w[0], w[3] = t * t * t / 6.0, s * s * s / 6.0
        w[1], w[2] = 2.0 / 3.0 - s * s * (1.0 - 0.5 * s), 2.0 / 3.0 - t * t * (1.0 - 0.5 * t)
    elif order == 1:
        w[0], w[3] = -0.5 * t * t, 0.5 * s * s
        w[1], w[2] = s * (1.5 * s - 2.0), -t * (1.5 * t - 2.0)
    else:
        w[0], w[1], w[2], w[3] = t, 3.0 * s - 2.0, 3.0 * t - 2.0, s


cdef double interpolate(const Data *self, const double *y, double *e, double *h) noexcept nogil:
    """Return the distance; set its derivatives e, and the second ones h (3, 3) unless that is null."""
    cdef ptrdiff_t c, a, b, i, j, l, dim = self.points.dim
    cdef ptrdiff_t[3] first
    cdef double[36] w  # of each direction and derivative, four
    cdef double part, outside = 0.0, sum = 0.0
    cdef const double *node
    cdef double[3] at
    cdef double[3] rows
    for c in range(dim):
        at[c] = min(max(y[c], self.bounds[c]), self.bounds[dim + c])
        outside += (y[c] - at[c]) * (y[c] - at[c])
        part = (at[c] - self.bounds[c]) / self.cell
        first[c] = <ptrdiff_t>part
        if first[c] > self.shape[c] - 4:
            first[c] = self.shape[c] - 4
        part -= first[c]
        for a in range(2 if h == NULL else 3):
            weigh_nodes(part, a, &w[12 * c + 4 * a])
        e[c] = 0.0
    if h != NULL:
        for c in range(9):
            h[c] = 0.0
    for i in range(4):
        for j in range(4):
            node = self.grid + ((first[0] + i) * self.shape[1] + first[1] + j) * self.shape[2]
            for a in range(3):
                rows[a] = 0.0
            if dim == 2:
                rows[0] = node[0]
            else:
                node += first[2]
                for l in range(4):
                    rows[0] += w[24 + l] * node[l]
                    rows[1] += w[28 + l] * node[l]
                    if h != NULL:
                        rows[2] += w[32 + l] * node[l]
            sum += w[i] * w[12 + j] * rows[0]
            e[0] += w[4 + i] * w[12 + j] * rows[0]
            e[1] += w[i] * w[16 + j] * rows[0]
            if dim == 3:
                e[2] += w[i] * w[12 + j] * rows[1]
            if h != NULL:
                h[0] += w[8 + i] * w[12 + j] * rows[0]
                h[1] += w[4 + i] * w[16 + j] * rows[0]
                h[4] += w[i] * w[20 + j] * rows[0]
                if dim == 3:
                    h[2] += w[4 + i] * w[12 + j] * rows[1]
                    h[5] += w[i] * w[16 + j] * rows[1]
                    h[8] += w[i] * w[12 + j] * rows[2]
    outside = sqrt(outside)
    for c in range(dim):
        e[c] /= self.cell
        if y[c] != at[c]:
            e[c] = (y[c] - at[c]) / outside
    if h != NULL:
        h[3], h[6], h[7] = h[1], h[2], h[5]
        for a in range(dim):
            for b in range(dim):
                h[3 * a + b] /= self.cell * self.cell
                if y[a] != at[a] or y[b] != at[b]:
                    h[3 * a + b] = 0.0
                    if y[a] != at[a] and y[b] != at[b]:
                        h[3 * a + b] = ((1.0 if a == b else 0.0) - e[a] * e[b]) / outside
    return sum + outside
