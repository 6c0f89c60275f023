"""Moving supports: prescribed coordinates and time-dependent constraints; included by `loop.pxi`.

The last coordinates of the system are prescribed, with their velocities and accelerations; the last
constraint equations have a right-hand side, ``phi(q) = s(t)``.  The drives do work.
"""


cdef inline bint is_driven(const Motion *self) noexcept nogil:
    return self.drives.n + self.drives.n_equations > 0


cdef inline void lead(Motion *self) noexcept nogil:
    """Subtract the prescribed values from those of the driven equations."""
    cdef const Drives *drives = &self.drives
    cdef ptrdiff_t first = self.m - drives.n_equations, k
    for k in range(drives.n_equations):
        self.phi[first + k] -= drives.row[3 * drives.n + k]


cdef double work_of_drives(Motion *self) noexcept nogil:
    """Work of the drives in the current step [J], whose solution is the iterate.

    The forces on prescribed coordinates follow from equilibrium.  Their work is computed by the
    trapezoidal rule, or with the mean force over the step if the scheme has one.
    """
    cdef Drives *drives = &self.drives
    cdef const double *s = drives.row + 3 * drives.n
    cdef ptrdiff_t base = self.n_all - drives.n, first = self.m - drives.n_equations, i
    cdef double work = 0.0, other
    evaluate(self)
    memcpy(drives.force, self.r + base, drives.n * sizeof(double))
    for i in range(drives.n):
        other = drives.force[i] if MEAN_FORCES else drives.force0[i]
        work += 0.5 * (other + drives.force[i]) * (drives.row[i] - self.q0[base + i])
    for i in range(drives.n_equations):
        other = self.lam[first + i] if MEAN_FORCES else self.lam0[first + i]
        work -= 0.5 * (other + self.lam[first + i]) * (s[i] - drives.lead0[i])
    return work


cdef void accept_drives(Motion *self) noexcept nogil:
    """Accept the prescribed state at the end of the step."""
    cdef Drives *drives = &self.drives
    cdef ptrdiff_t base = self.n_all - drives.n
    memcpy(self.q0 + base, drives.row, drives.n * sizeof(double))
    memcpy(self.v0 + base, drives.row + drives.n, drives.n * sizeof(double))
    memcpy(self.a0 + base, self.a + base, drives.n * sizeof(double))
    memcpy(drives.force0, drives.force, drives.n * sizeof(double))
    memcpy(drives.lead0, drives.row + 3 * drives.n, drives.n_equations * sizeof(double))


cdef void swap_speeds(Motion *self) noexcept nogil:
    """Advance the prescribed velocities to the end of the step, or back."""
    cdef Drives *drives = &self.drives
    cdef ptrdiff_t base = self.n_all - drives.n
    cdef bint back = self.factor < 0.0
    if not back:
        memcpy(drives.speeds, self.v0 + base, drives.n * sizeof(double))
    memcpy(self.v0 + base, drives.speeds if back else drives.row + drives.n,
           drives.n * sizeof(double))
