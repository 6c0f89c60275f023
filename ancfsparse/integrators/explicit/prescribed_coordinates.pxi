"""Coordinates that are functions of time; included by the explicit time loop.

The last coordinates of the system are prescribed.  Each stage takes their positions, velocities and
accelerations from its row of inputs; the accelerations couple to the other coordinates by inertia.
The work W of the driving forces is integrated like another component of the motion, from their
power W' and to the order of the method: a step adds h sum_j b_j W'_j.
"""


cdef struct Drives:
    ptrdiff_t n, base  # number of prescribed coordinates, and index of the first
    ptrdiff_t column  # of inputs: the first of positions, before velocities and accelerations
    double *given     # (n_all,) accelerations of the current stage: zero except for prescribed ones
    double *moved     # (n_all,) those of the other coordinates
    double *inertia   # (n_all,) inertia forces of the latter
    double power      # of the last stage [W]
    double power0     # of the last accepted state [W]


cdef void follow(Drives *self, const double *inputs, double *q, double *v) noexcept nogil:
    """Set the prescribed coordinates and velocities of a state, and their accelerations."""
    cdef const double *row = inputs + self.column
    cdef ptrdiff_t size = self.n * sizeof(double)
    memcpy(q + self.base, row, size)
    memcpy(v + self.base, row + self.n, size)
    memcpy(self.given + self.base, row + 2 * self.n, size)


cdef double power_of_drives(Drives *self, const ancf_system *system, const double *v,
                            const double *rate, const double *r) noexcept nogil:
    """Power of the forces on driven coordinates without those of constraints [W].

    The forces follow from equilibrium: the residual ``r`` with the accelerations of the driven
    coordinates only, and the inertia forces of the others, ``-rate``.
    """
    cdef ptrdiff_t k, n = system.n_free
    cdef double out = 0.0
    for k in range(n):
        self.moved[k] = -rate[k]
    system.inertia(system.context, self.moved, self.inertia)
    for k in range(self.base, self.base + self.n):
        out += (r[k] + self.inertia[k]) * v[k]
    return out


cdef double power_of_held(const Drives *self, const Held *held, const double *q,
                          const double *v) noexcept nogil:
    """Power of constraint forces on driven coordinates [W]."""
    cdef ptrdiff_t i, j, k
    cdef double out = 0.0, force
    for k in range(held.terms):
        i, j = held.i[k], held.j[k]
        force = held.lam[held.row[k]] * held.coefficient[k]
        if i >= self.base:
            out += force * (1.0 if j < 0 else q[j] - held.about[k]) * v[i]
        if j >= self.base:
            out += force * (q[i] - held.about[k]) * v[j]
    return out
