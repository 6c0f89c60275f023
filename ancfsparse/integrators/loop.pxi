"""The time loop of the implicit integrators; text for the modules that include it.

Such a module brings the formulas of its integrator: before this text a struct ``Scheme`` of what it
alone keeps, after it a class made of `TimeLoop` and the functions ``set_weights``, ``set_load``,
``restart_part``, ``coast``, ``correct_part``, ``evaluate``, ``matrix``, ``material``,
``start_velocity``, ``solve_step`` and ``accept_part``; ``prescribe`` and ``take_prescribed`` for
coordinates that are functions of time, and ``MEAN_FORCES``, whether forces and multipliers are
means over the step.

The dynamic rows are multiplied by ``scale`` and the multipliers divided by it, so the matrix of a
step, ``[M + scale K, phi_q^T; phi_q, 0]``, does not degrade as dt goes to zero.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New

include "../abi/signals.pxi"
include "../abi/outcome.pxi"
include "motion.pxi"


# Arrays that make the next steps, beside the state: the integrator's own acceleration, coordinates
# one step before, where steps start, the course of the loads, and the forces of supports that move.
REMEMBERED = ("b0", "before", "earlier", "phase", "amplitudes0", "rate", "bend", "size", "past",
              "force0")


cdef class TimeLoop:
    """State of a system in time, and the equations of its next step.

    Parameters
    ----------
    system : object with a ``capsule`` "ancf_system"
    dt : float
        Time step [s].
    integrator : Implicit
        The weights.
    q, v, a, b : (n_all,) float
        State at the start: free coordinates first, then fixed ones, which never move; ``b`` is
        the integrator's own acceleration.
    lam : (m,) float
        Multipliers at the start.
    dead_load : (n_all,) float
        Constant applied force.
    amplitudes : (n_amplitudes,) float
        Changing loads at the start.
    largest_gain : float
        Share of the energy exchanged so far by which the energy may exceed what was given.
    noise : float
        Energy that rounding makes [J].
    """

    cdef ancf_equations interface
    cdef Motion motion
    cdef object owner, loads  # the loads are pointed into until the next ones come
    cdef const double[::1] mass
    cdef dict arrays
    cdef readonly object capsule
    cdef readonly ptrdiff_t steps  # accepted so far

    def __cinit__(self, system, double dt, integrator, q, v, a, b, lam, dead_load, amplitudes,
                  double largest_gain, double noise):
        cdef Motion *motion = &self.motion
        cdef dict own = {}
        self.owner, self.arrays = system, own
        motion.system = <const ancf_system *>PyCapsule_GetPointer(system.capsule, "ancf_system")
        motion.n_free, motion.n_all = motion.system.n_free, motion.system.n_all
        motion.m = motion.system.n_multipliers
        # Never empty, so that a pointer to the first multiplier or amplitude always exists.
        lam, amplitudes = np.append(lam, 0.0), np.append(amplitudes, 0.0)
        motion.q0, motion.q = kept(own, "q0", q), kept(own, "q", q)
        motion.a0, motion.a = kept(own, "a0", a), kept(own, "a", a)
        motion.earlier, motion.phase = reserved(own, "earlier", len(q)), reserved(own, "phase", 1)
        motion.lam0, motion.lam = kept(own, "lam0", lam), kept(own, "lam", lam)
        motion.v0 = kept(own, "v0", v)
        if motion.system.damped:
            motion.v = kept(own, "v", v)
        motion.amplitudes0 = kept(own, "amplitudes0", amplitudes)
        motion.jumps.n, motion.jump_share = motion.system.n_amplitudes, integrator.jump_share
        motion.jumps.rate = kept(own, "rate", 0.0 * amplitudes)
        motion.jumps.bend = kept(own, "bend", 0.0 * amplitudes)
        motion.jumps.size = kept(own, "size", abs(amplitudes))
        motion.jumps.past = kept(own, "past", 0.0 * amplitudes)
        motion.jumps.jump = kept(own, "jump", 0.0 * amplitudes)
        motion.dead_load = kept(own, "dead_load", dead_load)
        motion.r = kept(own, "r", np.zeros(len(q)))
        motion.phi = kept(own, "phi", np.zeros(len(lam)))
        self.set_threads(1)
        set_weights(motion, dt, integrator)
        motion.interface, self.interface.context = &self.interface, motion
        self.interface.mass_total = motion.n_free
        self.interface.n, self.interface.n_coordinates = motion.n_free + motion.m, motion.n_free
        self.interface.n_values = motion.system.n_values
        self.interface.restart, self.interface.coast = restart, coast
        self.interface.correct = correct
        self.interface.residual, self.interface.matrix = residual, matrix
        if motion.system.material != NULL:
            self.interface.material = material
        self.interface.q = motion.q
        self.capsule = PyCapsule_New(&self.interface, "ancf_equations", NULL)
        motion.watch.limit, motion.watch.noise = largest_gain, noise
        ancf_watch_start(&motion.watch, motion.system, motion.dead_load, motion.q0, motion.v0,
                         motion.r)
        if motion.system.begin != NULL:
            remember(motion, motion.system.begin)

    def change_step(self, double dt, integrator, change_b, change_v):
        """Go on with another step: its weights, and what a smooth motion asks of ``b``, ``v``."""
        set_weights(&self.motion, dt, integrator)
        self.motion.phase[0] = UNKNOWN
        if "b0" in self.arrays:
            self.arrays["b0"] += change_b
        self.arrays["v0"] += change_v

    def drive(self, ptrdiff_t n, ptrdiff_t n_equations, start, force):
        """Let the last coordinates and the last equations follow functions of time.

        Rows of loads then go on with positions, velocities and accelerations of the coordinates,
        and with what the equations are to have.

        Parameters
        ----------
        n, n_equations : int
            How many coordinates and equations.
        start : (n_equations,) float
            What the equations have at the start [m].
        force : (n,) float
            Of the coordinates on the system there [N].
        """
        cdef Drives *drives = &self.motion.drives
        drives.n, drives.n_equations = n, n_equations
        drives.force0 = kept(self.arrays, "force0", np.append(force, 0.0))
        drives.force = kept(self.arrays, "force", np.append(force, 0.0))
        drives.lead0 = kept(self.arrays, "lead0", np.append(start, 0.0))
        drives.speeds = kept(self.arrays, "speeds", np.zeros(n + 1))

    def may_shorten(self):
        """Let steps that would gain energy be refused: shorter ones may not."""
        self.motion.shortens = True

    def soften(self, double softness):
        """Let multipliers violate their equations by a share of themselves; 0 for not at all.

        The matrix of a step has the same number in its lower right part.

        Parameters
        ----------
        softness : float
            Over the scale of accelerations [1/kg].
        """
        self.motion.softness = softness

    def weigh(self, const double[::1] mass, double total):
        """Measure motions and corrections by mass: that of each coordinate, and of all places."""
        self.mass = mass
        self.interface.mass, self.interface.mass_total = &mass[0], total

    def set_threads(self, ptrdiff_t threads):
        """Set the number of threads for passes over vectors."""
        self.motion.n_parts = threads
        self.motion.squares = kept(self.arrays, "squares", np.zeros(threads))
        self.motion.others = kept(self.arrays, "others", np.zeros(threads))
        self.motion.ways = kept(self.arrays, "ways", np.full(threads, np.nan))

    @property
    def state(self):
        """Last accepted ``(q, v, a, lam)`` as copies."""
        q, v, a, lam = (self.arrays[name].copy() for name in ("q0", "v0", "a0", "lam0"))
        return q, v, a, lam[: self.motion.m]

    @property
    def memory(self):
        """What the next steps depend on beside the state: energy watch, course of the loads."""
        out = {"watch": watch_memory(&self.motion.watch)}
        for name in REMEMBERED:
            if name in self.arrays:
                out[name] = self.arrays[name].copy()
        return out

    def recall(self, memory):
        """Go on with the `memory` of a march that came to the present state."""
        recall_watch(&self.motion.watch, memory["watch"])
        for name in REMEMBERED:
            if name in self.arrays:
                self.arrays[name][:] = memory[name]

    @property
    def unbalanced(self):
        """Residual ``(n_all,)`` [N, N m] and constraints ``(m,)`` [m] of the last iterate."""
        evaluate(&self.motion)
        return self.arrays["r"].copy(), self.arrays["phi"][: self.motion.m].copy()

    @property
    def energy_gain(self):
        """Energy above what was given, and the largest energy exchanged, at the last look [J]."""
        return self.motion.watch.gain, self.motion.watch.exchanged

    @property
    def unsure_work(self):
        """Work that jumps of loads may have done, beyond what was counted [J]."""
        return self.motion.watch.unsure ** 0.5

    @property
    def largest_gain(self):
        """Most energy above what was given, what it is compared with [J], and after which step."""
        cdef const ancf_watch *watch = &self.motion.watch
        return watch.most, ancf_watch_motion(watch), watch.when

    def gained_energy(self):
        """Whether the energy was ever too far above what was given: the last look of a run."""
        measure(&self.motion)
        ancf_watch_remember(&self.motion.watch)
        return bool(ancf_watch_gained(&self.motion.watch))

    def prepare(self, const double[:, ::1] amplitudes):
        """Set the loads of the next step and put its predictor in place."""
        self.loads = amplitudes
        load(&self.motion, &amplitudes[0, 0] if amplitudes.shape[1] > 0 else NULL)
        restart(&self.motion)

    def residual(self):
        """Return the scaled residual ``(n,)`` at the present iterate."""
        out = np.empty(self.interface.n)
        cdef double[::1] view = out
        residual(&self.motion, &view[0])
        return out

    def correct(self, const double[::1] s):
        """Add a correction ``(n,)`` to the present iterate."""
        correct(&self.motion, 1.0, &s[0])

    def matrix(self):
        """Return the values of the scaled iteration matrix at the present iterate."""
        out = np.empty(self.interface.n_values + 1)
        cdef double[::1] view = out
        matrix(&self.motion, &view[0])
        return out[: self.interface.n_values]

    def material(self):
        """Return those of its definite neighbour, without what stresses add."""
        out = np.empty(self.interface.n_values + 1)
        cdef double[::1] view = out
        material(&self.motion, &view[0])
        return out[: self.interface.n_values]

    def advance(self, nonlinear, ptrdiff_t n_steps, const double[:, ::1] amplitudes,
                ptrdiff_t save_every, ptrdiff_t steps_done, double[:, ::1] q_out,
                double[:, ::1] v_out, double[:, ::1] a_out, double[:, ::1] lam_out):
        """Take steps; return ``(steps taken, outcome)``, outcome 0 if all of them were accepted.

        What the handler of a signal raises, such as KeyboardInterrupt, comes out between two steps.
        Then `steps` tells how many were taken, and the outputs hold them.

        Parameters
        ----------
        amplitudes : (n_steps, n_amplitudes)
            Loads at the end of each step.
        save_every, steps_done : int
            Step number k of the run (from 1) is written to row ``k / save_every`` of the outputs.
        """
        cdef const ancf_nonlinear *solver = <const ancf_nonlinear *>PyCapsule_GetPointer(
            nonlinear.capsule, "ancf_nonlinear")
        cdef Motion *motion = &self.motion
        cdef ptrdiff_t k, row
        cdef int outcome = 0
        cdef Signals signals = Signals(0, now())
        self.loads = amplitudes
        with nogil:
            for k in range(n_steps):
                load(motion, &amplitudes[k, 0] if amplitudes.shape[1] > 0 else NULL)
                begin(motion)
                outcome = solve_step(motion, solver)
                if outcome != 0 and outcome != MAY_GROW:
                    break
                accept(motion)
                if (steps_done + k + 1) % save_every == 0:
                    row = (steps_done + k + 1) // save_every
                    memcpy(&q_out[row, 0], motion.q0, motion.n_all * sizeof(double))
                    memcpy(&v_out[row, 0], motion.v0, motion.n_all * sizeof(double))
                    memcpy(&a_out[row, 0], motion.a0, motion.n_all * sizeof(double))
                    memcpy(&lam_out[row, 0], motion.lam0, motion.m * sizeof(double))
                self.steps += 1
                if look(motion):
                    outcome = GAINED_ENERGY
                if outcome != 0:
                    k += 1
                    break
                if due(&signals, motion.n_all):
                    with gil:
                        PyErr_CheckSignals()
            else:
                k = n_steps
        return k, outcome


include "start.pxi"
include "step.pxi"
include "drives.pxi"
