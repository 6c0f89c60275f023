"""Coordinates that follow functions of time; text for the explicit time loop.

The last coordinates of the system are prescribed.  Each stage takes their positions, velocities and
accelerations from its row of inputs; the latter act on the others by their inertia.  With W' the
power of the forces that this takes, work is one more component of the motion, and what a step adds
to it is of the order of the method: h sum_j b_j W'_j.
"""


cdef struct Drives:
    ptrdiff_t n, base  # how many, and the place of the first
    ptrdiff_t column  # of inputs, where their positions begin; velocities and accelerations follow
    double *given     # (n_all,) accelerations of the stage under way: zero but for driven ones
    double *moved     # (n_all,) those of the others
    double *inertia   # (n_all,) forces of the latter
    double power      # of the last stage [W]
    double power0     # of the last accepted state [W]


cdef void follow(Drives *self, const double *inputs, double *q, double *v) noexcept nogil:
    """Set what is prescribed in a state, and its accelerations."""
    cdef const double *row = inputs + self.column
    cdef ptrdiff_t size = self.n * sizeof(double)
    memcpy(q + self.base, row, size)
    memcpy(v + self.base, row + self.n, size)
    memcpy(self.given + self.base, row + 2 * self.n, size)


cdef double power_of_drives(Drives *self, const ancf_system *system, const Held *held,
                            const double *q, const double *v, const double *rate,
                            const double *r) noexcept nogil:
    """Power of the forces on driven coordinates [W].

    They are what is missing for equilibrium there: of the residual ``r`` with the accelerations of
    the driven coordinates alone, of the inertia of the others, ``-rate``, and of constraints.
    """
    cdef ptrdiff_t i, j, k, n = system.n_free
    cdef double out = 0.0, force
    for k in range(n):
        self.moved[k] = -rate[k]
    system.inertia(system.context, self.moved, self.inertia)
    for k in range(self.base, self.base + self.n):
        out += (r[k] + self.inertia[k]) * v[k]
    if held.m == 0:
        return out
    for k in range(held.terms):
        i, j = held.i[k], held.j[k]
        force = held.lam[held.row[k]] * held.coefficient[k]
        if i >= self.base:
            out += force * (1.0 if j < 0 else q[j] - held.about[k]) * v[i]
        if j >= self.base:
            out += force * (q[i] - held.about[k]) * v[j]
    return out
