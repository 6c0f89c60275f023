"""Accelerations under a few constraints; included by the explicit time loop.

With G = phi_q and gamma = (phi_q v)_q v, the constraints require G a = -gamma:

    a = -M^-1 (r + G^T lam),    (G M^-1 G^T) lam = gamma - G M^-1 r.

This takes one solve with M per constraint, and a dense matrix of their number.
"""


cdef struct Held:
    const ancf_seed *seed
    ptrdiff_t n, m, terms
    bint straight  # no equation is quadratic: G is constant
    # One entry per term of a constraint, as in `system.coordinates.constraint_terms`.
    const int32_t *row
    const int32_t *i
    const int32_t *j
    const double *coefficient
    const double *about
    double *gradient  # (m, n) G
    double *response  # (m, n) M^-1 G^T
    double *root      # (m, m) lower factor of G M^-1 G^T
    double *lam       # (m,)


cdef void gradient(Held *self, const double *q) noexcept nogil:
    """Set G at a position; its entries are zero except those of the terms."""
    cdef ptrdiff_t k, i, j
    cdef double c, a
    cdef double *row
    for k in range(self.terms):
        row = self.gradient + self.row[k] * self.n
        i, j = self.i[k], self.j[k]
        if i < self.n:
            row[i] = 0.0
        if 0 <= j < self.n:
            row[j] = 0.0
    for k in range(self.terms):
        row = self.gradient + self.row[k] * self.n
        i, j, c, a = self.i[k], self.j[k], self.coefficient[k], self.about[k]
        if i < self.n:
            row[i] += c if j < 0 else c * (q[j] - a)
        if 0 <= j < self.n:
            row[j] += c * (q[i] - a)


cdef bint held_factor(Held *self, const double *q) noexcept nogil:
    """Factor G M^-1 G^T at a position; return whether it is positive definite."""
    cdef ptrdiff_t n = self.n, m = self.m, i, j, k
    cdef double value, whole
    cdef double *row
    gradient(self, q)
    for i in range(m):
        self.seed.solve(self.seed.context, self.gradient + i * n, self.response + i * n)
    for i in range(m):
        row = self.root + i * m
        for j in range(i + 1):
            value = whole = dot(self.gradient + i * n, self.response + j * n, n)
            for k in range(j):
                value -= row[k] * self.root[j * m + k]
            if j < i:
                row[j] = value / self.root[j * m + j]
            elif value > DEPENDENT * whole:
                row[i] = sqrt(value)
            else:
                return False
    return True


cdef bint hold(Held *self, const double *q, const double *v, const double *given,
               double *rate) noexcept nogil:
    """Replace M^-1 r, with r from the forces only, by -a; set the multipliers; return success.

    The accelerations ``given`` for prescribed coordinates are included in G a.
    """
    cdef ptrdiff_t n = self.n, m = self.m, i, j, k
    cdef double about, value
    cdef double *lam = self.lam
    if not self.straight and not held_factor(self, q):
        return False
    for i in range(m):
        lam[i] = -dot(self.gradient + i * n, rate, n)
    for k in range(self.terms):
        if self.j[k] >= 0:
            lam[self.row[k]] += 2.0 * self.coefficient[k] * v[self.i[k]] * v[self.j[k]]
    if given != NULL:
        for k in range(self.terms):
            i, j = self.i[k], self.j[k]
            about = self.about[k]
            value = given[i] if j < 0 else (q[j] - about) * given[i] + (q[i] - about) * given[j]
            lam[self.row[k]] += self.coefficient[k] * value
    for i in range(m):
        for j in range(i):
            lam[i] -= self.root[i * m + j] * lam[j]
        lam[i] /= self.root[i * m + i]
    for i in range(m - 1, -1, -1):
        for j in range(i + 1, m):
            lam[i] -= self.root[j * m + i] * lam[j]
        lam[i] /= self.root[i * m + i]
        for k in range(n):
            rate[k] += lam[i] * self.response[i * n + k]
    return True


cdef tuple set_held(Held *self, const ancf_seed *seed, ptrdiff_t n, constraints, const double *q,
                    double *lam):
    """Set up the constraints at a position; return the arrays that must be kept alive."""
    cdef ptrdiff_t m = len(constraints.offset), width = max(m, 1)
    cdef double[:, ::1] rows = np.zeros((2 * width, n)), root = np.zeros((width, width))
    tables = [np.array(x, dtype=np.int32) for x in (constraints.row, constraints.i, constraints.j)]
    numbers = [np.array(x, dtype=float) for x in (constraints.coefficient, constraints.about)]
    self.seed, self.n, self.m, self.lam = seed, n, m, lam
    self.terms, self.straight = len(constraints.row), constraints.linear
    self.gradient, self.response, self.root = &rows[0, 0], &rows[width, 0], &root[0, 0]
    if m:
        self.row, self.i, self.j = integers(tables[0]), integers(tables[1]), integers(tables[2])
        self.coefficient, self.about = reals(numbers[0]), reals(numbers[1])
        held_factor(self, q)
    return tables, numbers, rows, root
