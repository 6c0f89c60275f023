"""Accelerations at states other than the ends of explicit steps; included by `_explicit.pyx`."""


cdef accelerations_at(Explicit self, const double[:, ::1] q, const double[:, ::1] v,
                      const double[:, ::1] inputs, double[:, ::1] a_out, double[:, ::1] lam_out):
    """Set accelerations and multipliers of states between steps, by the forces there.

    The march goes on as without this.  Rows without an acceleration stay as they are.

    Parameters
    ----------
    q, v : (k, n_all) float
        The states; of the velocities those of free coordinates count.
    inputs : (k, n_amplitudes + 3 n_driven + 3 n_led) float
        Loads and prescribed motions at their times.
    """
    cdef ptrdiff_t k, j, other = 1 - self.now, base = self.drives.base
    cdef ptrdiff_t given = self.drives.column + 2 * self.drives.n
    cdef double power0 = self.drives.power0
    cdef double *rate = self.stage(0)
    cdef const double[::1] load = self.load
    rates, multipliers = np.array(self.rate[self.first]), np.array(self.lam)
    for k in range(len(q)):
        if inputs.shape[1] > 0:
            load = inputs[k]
        memcpy(&self.q[other, 0], &q[k, 0], self.n_all * sizeof(double))
        memcpy(&self.v[other, 0], &v[k, 0], self.n * sizeof(double))
        if not self.accelerate(0, other, &load[0]):
            continue
        for j in range(self.n):
            a_out[k, j] = -rate[j]
        for j in range(self.drives.n):
            a_out[k, base + j] = load[given + j]
        for j in range(self.system.n_multipliers):
            lam_out[k, j] = self.lam[j]
    self.look_again()  # the factor of the current state again
    np.asarray(self.rate[self.first])[:], np.asarray(self.lam)[:] = rates, multipliers
    self.drives.power0 = power0
