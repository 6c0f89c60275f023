"""Repetition of steps that gain energy in impacts; included by `_newmark_family.pyx`.

An impact that steps do not resolve lasts a single step, and its force acts again in the next one,
since Newmark's formulas contain the acceleration a0 at the start.  With beta = 1/2 and gamma = 1,

    q1 = q0 + dt v0 + dt^2 a1 / 2,   v1 = v0 + dt a1,

a0 is absent, and q1 - q0 = dt (v0 + v1) / 2.  With a constant mass matrix the kinetic energy
changes by the work of the forces at the end of the step along q1 - q0, so the total energy does not
increase if their potential is convex, for any step.  The potential of a half-space is convex, the
ones of a ball and of large bending are not; there a repeated step is used only if it gains less.
Kane, Repetto, Ortiz and Marsden (Comput. Methods Appl. Mech. Eng. 180 (1999) 1-26) use these
formulas for forces of contact in all steps; here they apply to all forces, in steps that would gain
energy otherwise.
"""
from libc.math cimport fmin, isinf


# Energy that an impact can add to a motion, over the energy exchanged.  Without a bound, level
# falls of 0.5 m returned up to 1.0005 of their energy where steps resolve the impact, and 9 times as
# much where they do not and the first touch is in the first step.
cdef double IMPACT_GAIN = 5e-5
# Steps whose energy is checked, the first being the one in which the points in contact change.
# With 1, bodies that begin less than a step before the touch return up to 1.011 of their energy
# with GeneralizedAlpha(.5).
cdef double ALERT_STEPS = 4.0


cdef void take_regular_weights(Motion *self) noexcept nogil:
    self.scheme.weights, self.scale = self.scheme.regular, self.scheme.regular_scale


cdef void take_memoryless_weights(Motion *self) noexcept nogil:
    cdef Weights *w = &self.scheme.weights
    self.scale = w.q_a = 0.5 * self.dt * self.dt
    w.q_b = w.v_b = w.v_a = w.b_b = w.b_a = 0.0
    w.v_new, w.b_new = self.dt, 1.0


cdef bint is_energy_checked(Motion *self) noexcept nogil:
    """Return True in a step in which the points in contact change, and in the next three."""
    cdef const ancf_system *system = self.system
    if system.contacts_changed == NULL or isinf(self.watch.limit):
        return False
    if system.contacts_changed(system.context):
        self.scheme.alert[0] = ALERT_STEPS
    elif self.scheme.alert[0] > 0.0:
        self.scheme.alert[0] -= 1.0
    return self.scheme.alert[0] > 0.0


cdef bint repeat_gaining_step(Motion *self, const ancf_nonlinear *solver, bint final) noexcept nogil:
    """Replace the solution of a step if it gains energy; return whether the step is accepted.

    It is if the solution is replaced, or if it is `final` and gains no more than the limit of the
    run.
    """
    cdef ancf_watch before = self.watch
    cdef double gain
    see(self, False)
    if not self.watch.beyond <= fmin(IMPACT_GAIN, self.watch.limit) * self.watch.exchanged:
        gain = self.watch.gain
        unsee(self, &before)
        keep(self, True)
        take_memoryless_weights(self)
        if solver.repeat(solver.context) == 0 and is_admitted(self):
            see(self, False)
            if self.watch.gain < gain and (
                    final or not ancf_watch_gains(&self.watch, solver.doubtful[0])):
                forget(self)
                return pass_it(self)
            unsee(self, &before)
        take_regular_weights(self)
        keep(self, False)
        see(self, False)
    if final and not ancf_watch_gains(&self.watch, False):
        return pass_it(self)
    unsee(self, &before)
    return False
