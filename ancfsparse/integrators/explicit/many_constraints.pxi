"""Accelerations and projections under any number of constraints; included by the explicit time loop.

With G = phi_q, s(t) the prescribed values of the last equations, and W the mass of the equations (see
``ANCF_EQUATION_MASS``), one factor of

    [ M + G^T W G   G^T ]
    [ G              0  ]

gives the accelerations with ``G a = s'' - (phi_q v)_q v``, and the projections of positions and
velocities on the constraints along ``M^-1 G^T``.  M alone may be singular.
"""

cdef extern from "system_abi.h":
    ctypedef struct ancf_contribution:
        void *context
        void (*residual)(void *, const ancf_state *, double *, double *) noexcept nogil
        void (*rates)(void *, const double *, const double *, double *, double *) noexcept nogil

# Smallest and largest |phi| that count as rounding, over the size of the terms of an equation, and
# the most corrections of positions, each of which must halve |phi|.
cdef double ROUNDED = 1e-15, CLOSE = 1e-9
cdef int MOST_CORRECTIONS = 20


cdef struct Saddle:
    const ancf_system *system
    const ancf_seed *seed
    const ancf_contribution **each  # those that contribute equations
    ptrdiff_t n_each, n, n_all, m
    ptrdiff_t n_led       # equations that follow functions of time, the last ones
    bint straight         # whether G is constant
    bint factored
    const double *size    # (m,) magnitude of the terms of each equation
    const double *weight  # (m,) W
    double *values        # of the matrix
    double *right         # (n + m,) right-hand side, then solution
    double *phi           # (m,)
    double *bend          # (m,) (phi_q v)_q v
    double *none          # (m,) zeros
    double *force         # (n_all,)
    double *lam           # (m,)
    double *moved         # (n,) last projection of the positions


cdef bint saddle_factor(Saddle *self, const double *q) noexcept nogil:
    """Factor the matrix at a position; return whether that succeeded."""
    if not (self.straight and self.factored):
        self.system.matrix(self.system.context, 1.0, 0.0, 0.0, q, NULL, self.none, NULL,
                           self.values)
        self.factored = self.seed.factor(self.seed.context, self.values) == 0
    return self.factored


cdef void saddle_forces(Saddle *self, const double *q, const double *lam,
                        const double *led) noexcept nogil:
    """Set phi, and the forces of multipliers."""
    cdef ancf_state x
    cdef ptrdiff_t k
    x.q, x.v, x.a, x.lam, x.amplitudes = q, NULL, NULL, lam, NULL
    memset(self.force, 0, self.n_all * sizeof(double))
    for k in range(self.n_each):
        self.each[k].residual(self.each[k].context, &x, self.force, self.phi)
    for k in range(self.n_led):
        self.phi[self.m - self.n_led + k] -= led[k]


cdef void saddle_rates(Saddle *self, const double *q, const double *v, double *speed,
                       double *bend) noexcept nogil:
    cdef ptrdiff_t k
    for k in range(self.n_each):
        self.each[k].rates(self.each[k].context, q, v, speed, bend)


cdef bint put_on(Saddle *self, double *q, const double *led) noexcept nogil:
    """Project positions with the last factor, from near by; return whether that converged."""
    cdef double off, last = INFINITY
    cdef ptrdiff_t i, k
    cdef int turn
    memset(self.moved, 0, self.n * sizeof(double))
    for turn in range(MOST_CORRECTIONS):
        saddle_forces(self, q, self.none, led)
        off = 0.0
        for k in range(self.m):
            if not fabs(self.phi[k]) <= off * self.size[k]:
                off = fabs(self.phi[k]) / self.size[k]
        if off <= ROUNDED:
            return True
        if not off < 0.5 * last:
            break
        last = off
        memset(self.right, 0, self.n * sizeof(double))
        for k in range(self.m):
            self.right[self.n + k] = -self.phi[k]
        self.seed.solve(self.seed.context, self.right, self.right)
        for i in range(self.n):
            q[i] += self.right[i]
            self.moved[i] += self.right[i]
    return off <= CLOSE


cdef void aim(Saddle *self, const double *q, double *v, const double *r, double factor,
              const double *led) noexcept nogil:
    """Subtract ``factor M^-1 r`` from velocities, and project them."""
    cdef double *speed = self.right + self.n
    cdef ptrdiff_t i, k
    memset(speed, 0, self.m * sizeof(double))
    saddle_rates(self, q, v, speed, NULL)
    for k in range(self.n_led):
        speed[self.m - self.n_led + k] -= led[self.n_led + k]
    for i in range(self.n):
        self.right[i] = factor * r[i] if factor != 0.0 else 0.0
    self.seed.solve(self.seed.context, self.right, self.right)
    for i in range(self.n):
        v[i] -= self.right[i]


cdef void saddle_accelerate(Saddle *self, const double *q, const double *v, const double *given,
                            const double *led, const double *r, double *rate) noexcept nogil:
    """Set ``rate = -a`` and the multipliers, with the factor at q and the forces ``r``.

    The accelerations ``given`` for prescribed coordinates are included in G a.
    """
    cdef ptrdiff_t n = self.n, m = self.m, k
    memset(self.bend, 0, m * sizeof(double))
    saddle_rates(self, q, v, self.phi, self.bend)
    if given != NULL:
        saddle_rates(self, q, given, self.bend, NULL)
    for k in range(self.n_led):
        self.bend[m - self.n_led + k] -= led[2 * self.n_led + k]
    memcpy(self.right, r, n * sizeof(double))
    memcpy(self.right + n, self.bend, m * sizeof(double))
    self.seed.solve(self.seed.context, self.right, self.right)
    memcpy(rate, self.right, n * sizeof(double))
    for k in range(m):
        self.lam[k] = -self.right[n + k] - self.weight[k] * self.bend[k]


cdef double saddle_power(Saddle *self, ptrdiff_t base, const double *q, const double *v,
                         const double *led) noexcept nogil:
    """Power of the multipliers on prescribed coordinates and equations [W]."""
    cdef double out = 0.0
    cdef ptrdiff_t k
    saddle_forces(self, q, self.lam, led)
    for k in range(base, self.n_all):
        out += self.force[k] * v[k]
    for k in range(self.n_led):
        out -= self.lam[self.m - self.n_led + k] * led[self.n_led + k]
    return out


cdef tuple set_saddle(Saddle *self, constraints, parts, sizes):
    """Set up the matrix with the constraints; return the arrays that must be kept alive."""
    cdef const ancf_contribution *each
    cdef ptrdiff_t n = self.system.n_free, n_all = self.system.n_all, m = len(constraints.offset)
    cdef double[:, ::1] aside = np.zeros((3, max(n_all, m)))
    cdef double[::1] values = np.zeros(self.system.n_values + 1), right = np.zeros(n + m)
    numbers = [np.array(x, dtype=float) for x in (sizes, constraints.mass)]
    self.n, self.n_all, self.m, self.straight = n, n_all, m, constraints.linear
    self.each = <const ancf_contribution **>calloc(len(parts), sizeof(void *))
    if self.each == NULL:
        raise MemoryError
    for part in parts:
        each = <const ancf_contribution *>PyCapsule_GetPointer(part.capsule, "ancf_contribution")
        if each.rates != NULL:
            self.each[self.n_each] = each
            self.n_each += 1
    self.size, self.weight = reals(numbers[0]), reals(numbers[1])
    self.values, self.right = &values[0], &right[0]
    self.bend, self.force, self.moved = &aside[0, 0], &aside[1, 0], &aside[2, 0]
    return numbers, values, right, aside
