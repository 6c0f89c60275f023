"""The time loop of the implicit integrators, included by their modules.

Such a module supplies the formulas of its integrator: before this file a struct ``Scheme`` with its
own data, after it a subclass of `TimeLoop` and the functions ``set_weights``, ``set_load``,
``restart_part``, ``coast``, ``correct_part``, ``evaluate``, ``matrix``, ``material``,
``start_velocity``, ``solve_step`` and ``accept_part``; ``prescribe`` and ``take_prescribed`` for
coordinates that are functions of time; and ``MEAN_FORCES``, which is true if forces and multipliers
are means over the step.

The dynamic rows are multiplied by ``scale`` and the multipliers divided by it, so the iteration
matrix ``[M + scale K, phi_q^T; phi_q, 0]`` stays well conditioned as dt goes to zero.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New

include "../../abi/signals.pxi"
include "../../abi/outcome.pxi"
include "loop_data.pxi"


# Arrays that determine the next steps, besides the state: the integrator's own acceleration,
# coordinates one step before, the choice of predictor, history of loads, forces of moving supports,
# steps since an impact (older files have none).
REMEMBERED = ("b0", "before", "earlier", "phase", "amplitudes0", "rate", "bend", "size", "past",
              "lead0", "force0", "alert")


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
        Initial state: free coordinates first, then fixed ones, which never change; ``b`` is the
        integrator's own acceleration.
    lam : (m,) float
        Multipliers at the start.
    dead_load : (n_all,) float
        Constant applied force.
    amplitudes : (n_amplitudes,) float
        Changing loads at the start.
    largest_gain : float
        Largest energy gain, as a fraction of the energy exchanged so far.
    noise, rounding : float
        Energy due to rounding [J]; root of the energy of the errors in a step [J^(1/2)].
    """

    cdef ancf_equations interface
    cdef Motion motion
    cdef object owner, loads  # kept alive: pointers refer to the loads until new ones are set
    cdef const double[::1] mass, dead_load
    cdef dict arrays
    cdef double[:, ::1] histories
    cdef readonly object capsule
    cdef readonly ptrdiff_t steps  # accepted so far

    def __cinit__(self, system, double dt, integrator, q, v, a, b, lam, dead_load, amplitudes,
                  double largest_gain, double noise, double rounding):
        cdef Motion *motion = &self.motion
        cdef dict own = {}
        self.owner, self.arrays, self.histories = system, own, np.empty((0, 0))
        motion.system = <const ancf_system *>PyCapsule_GetPointer(system.capsule, "ancf_system")
        motion.n_free, motion.n_all = motion.system.n_free, motion.system.n_all
        motion.m = motion.system.n_multipliers
        # Never empty, so that the address of the first multiplier or amplitude is always valid.
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
        motion.jumps.first = integrator.first_jump
        motion.jumps.rate = kept(own, "rate", np.full(len(amplitudes), np.nan))
        motion.jumps.bend = kept(own, "bend", 0.0 * amplitudes)
        motion.jumps.size = kept(own, "size", abs(amplitudes))
        motion.jumps.past = kept(own, "past", 0.0 * amplitudes)
        motion.jumps.jump = kept(own, "jump", 0.0 * amplitudes)
        self.dead_load = dead_load
        motion.dead_load = &self.dead_load[0]
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
        motion.watch.rounding = rounding
        ancf_watch_start(&motion.watch, motion.system, motion.dead_load, motion.amplitudes0,
                         motion.q0, motion.v0, motion.r)
        if motion.system.begin != NULL:
            remember(motion, motion.system.begin)

    def change_step(self, double dt, integrator, change_b, change_v):
        """Change the step size: set the weights, and ``b`` and ``v`` as for a smooth motion."""
        set_weights(&self.motion, dt, integrator)
        self.motion.phase[0] = UNKNOWN
        forget(&self.motion)
        if "b0" in self.arrays:
            self.arrays["b0"] += change_b
        self.arrays["v0"] += change_v

    def move(self, start, before, lead, force):
        """Continue from another state, reached by other means.

        Parameters
        ----------
        start : Start
            The state, and the loads at its time.
        before : (n_all,) float
            Coordinates one step before.
        lead, force : (n_equations,) float, (n,) float
            Right-hand sides of driven equations, and forces of prescribed coordinates.
        """
        own = self.arrays
        values = {"q0": start.q, "q": start.q, "v0": start.v, "a0": start.a, "a": start.a,
                  "b0": start.b, "before": before, "lam0": start.lam, "lam": start.lam,
                  "amplitudes0": start.amplitudes, "lead0": lead, "force0": force}
        for name, value in values.items():
            if name in own:
                own[name][:len(value)] = value
        self.motion.phase[0] = UNKNOWN
        forget(&self.motion)

    def drive(self, ptrdiff_t n, ptrdiff_t n_equations, start, force):
        """Declare the last coordinates and the last equations functions of time.

        Rows of loads are then extended by positions, velocities and accelerations of the
        coordinates, and by the right-hand sides of the equations.

        Parameters
        ----------
        n, n_equations : int
            Number of these coordinates and equations.
        start : (n_equations,) float
            Initial right-hand sides of the equations [m].
        force : (n,) float
            Initial forces of the coordinates on the system [N].
        """
        cdef Drives *drives = &self.motion.drives
        drives.n, drives.n_equations = n, n_equations
        drives.force0 = kept(self.arrays, "force0", np.append(force, 0.0))
        drives.force = kept(self.arrays, "force", np.append(force, 0.0))
        drives.lead0 = kept(self.arrays, "lead0", np.append(start, 0.0))
        drives.speeds = kept(self.arrays, "speeds", np.zeros(n + 1))

    def may_shorten(self):
        """Reject steps that would gain energy, as shorter ones may not."""
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

    def weigh(self, const double[::1] mass, double total, bint measures=True,
              bint extrapolates=False):
        """Weight the norms by mass: the mass of each coordinate, and that of all positions.

        ``measures`` is whether the displacement of each step is measured, which bounds on
        corrections depend on; ``extrapolates`` whether accelerations are, from their changes.
        """
        cdef Motion *motion = &self.motion
        motion.measures, motion.trend.used = measures, extrapolates
        if extrapolates:
            motion.trend.last = reserved_singles(self.arrays, "last", len(mass))
            motion.trend.before = reserved_singles(self.arrays, "before_last", len(mass))
        self.mass = mass
        self.interface.mass, self.interface.mass_total = &mass[0], total
        self.interface.inverse_mass = kept(self.arrays, "inverse_mass", 1.0 / np.asarray(mass))

    def set_threads(self, ptrdiff_t threads):
        """Set the number of threads for vector operations."""
        self.motion.n_parts = threads
        self.motion.squares = kept(self.arrays, "squares", np.zeros(threads))
        self.motion.others = kept(self.arrays, "others", np.zeros(threads))
        self.motion.ways = kept(self.arrays, "ways", np.full(threads, np.nan))
        self.motion.trend.sums = kept(self.arrays, "sums", np.zeros(3 * threads))

    @property
    def state(self):
        """Last accepted ``(q, v, a, lam)`` as copies."""
        q, v, a, lam = (self.arrays[name].copy() for name in ("q0", "v0", "a0", "lam0"))
        return q, v, a, lam[: self.motion.m]

    @property
    def memory(self):
        """Return the memory of the loop besides the state: energy watch, history of the loads.

        The arrays are not copied, since copies would set the peak of large runs: no step may follow.
        """
        out = {name: self.arrays[name] for name in REMEMBERED if name in self.arrays}
        return out | {"watch": watch_memory(&self.motion.watch)}

    def recall(self, memory):
        """Restore the `memory` of a time loop that reached the current state."""
        recall_watch(&self.motion.watch, memory["watch"])
        for name in REMEMBERED:
            if name in self.arrays and name in memory:
                self.arrays[name][:] = memory[name]

    @property
    def unbalanced(self):
        """Residual ``(n_all,)`` [N, N m] and constraints ``(m,)`` [m] of the last iterate."""
        evaluate(&self.motion)
        return self.arrays["r"].copy(), self.arrays["phi"][: self.motion.m].copy()

    @property
    def energy_gain(self):
        """Energy gain, and the largest energy exchanged, at the last check [J]."""
        return self.motion.watch.gain, self.motion.watch.exchanged

    @property
    def unsure_work(self):
        """Uncertainty of the work of loads, due to their jumps [J]."""
        return self.motion.watch.unsure ** 0.5

    @property
    def largest_gain(self):
        """Largest energy gain, the energy it is compared with [J], and the step it occurred in."""
        cdef const ancf_watch *watch = &self.motion.watch
        return watch.most, ancf_watch_motion(watch), watch.when

    def withdraw(self):
        """Return how many of the last steps a failed run must not keep."""
        return 0

    def gained_energy(self):
        """Return True if the energy gain was ever too large: the final check of a run."""
        measure(&self.motion)
        ancf_watch_remember(&self.motion.watch)
        return bool(ancf_watch_gained(&self.motion.watch))

    def save_history(self, double[:, ::1] rows):
        """Write history variables of the system to rows of this table, as `advance` does states."""
        self.histories = rows

    def prepare(self, const double[:, ::1] amplitudes):
        """Set the loads of the next step and evaluate its predictor."""
        self.loads = amplitudes
        load(&self.motion, &amplitudes[0, 0] if amplitudes.shape[1] > 0 else NULL)
        restart(&self.motion)

    def residual(self):
        """Return the scaled residual ``(n,)`` at the current iterate."""
        out = np.empty(self.interface.n)
        cdef double[::1] view = out
        residual(&self.motion, &view[0])
        return out

    def correct(self, const double[::1] s):
        """Add a correction ``(n,)`` to the current iterate."""
        correct(&self.motion, 1.0, &s[0])

    def matrix(self):
        """Return the values of the scaled iteration matrix at the current iterate."""
        out = np.empty(self.interface.n_values + 1)
        cdef double[::1] view = out
        matrix(&self.motion, &view[0])
        return out[: self.interface.n_values]

    def material(self):
        """Return the same for the positive definite approximation, without geometric stiffness."""
        out = np.empty(self.interface.n_values + 1)
        cdef double[::1] view = out
        material(&self.motion, &view[0])
        return out[: self.interface.n_values]

    def advance(self, nonlinear, ptrdiff_t n_steps, const double[:, ::1] amplitudes,
                ptrdiff_t save_every, ptrdiff_t steps_done, double[:, ::1] q_out,
                double[:, ::1] v_out, double[:, ::1] a_out, double[:, ::1] lam_out):
        """Take steps; return ``(steps taken, outcome)``, outcome 0 if all of them were accepted.

        Exceptions from signal handlers, such as KeyboardInterrupt, are raised between two steps.
        `steps` is then the number of completed steps, which the outputs contain.

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
                if outcome != 0:
                    break
                accept(motion)
                if (steps_done + k + 1) % save_every == 0:
                    row = (steps_done + k + 1) // save_every
                    memcpy(&q_out[row, 0], motion.q0, motion.n_all * sizeof(double))
                    memcpy(&v_out[row, 0], motion.v0, motion.n_all * sizeof(double))
                    memcpy(&a_out[row, 0], motion.a0, motion.n_all * sizeof(double))
                    memcpy(&lam_out[row, 0], motion.lam0, motion.m * sizeof(double))
                    if row < self.histories.shape[0]:
                        motion.system.history(motion.system.context, &self.histories[row, 0])
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
            set_step(motion, 0.0)
        return k, outcome


include "acceleration_trend.pxi"
include "predictor.pxi"
include "step.pxi"
include "prescribed_motion.pxi"
