# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""One loop for Newton, modified Newton and quasi-Newton, with the rules for new seeds and recovery.

Its equations are a few functions (restart, correct, residual, matrix), independent of mechanics.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.math cimport INFINITY
from libc.stdlib cimport calloc, free

import numpy as np


include "loop_data.pxi"
include "factor_renewal.pxi"
include "attempt.pxi"
include "potential_descent.pxi"
include "recovery_sequence.pxi"


cdef class Iteration:
    """Solve a sequence of nonlinear systems, reusing seed and pairs from one to the next."""

    cdef ancf_nonlinear interface
    cdef Loop loop
    cdef object kept, owners, arrays
    cdef bint rounds  # whether seeds of the method are rounded, while Newton's are used
    cdef readonly object capsule

    def __cinit__(self, equations, seed, inverse, frame, *,
                  bint rotating, bint compares_frames, bint newton,
                  bint learns, bint carry, bint polishes, bint economical, bint rounds,
                  bint by_correction, int max_iterations, double force_tolerance,
                  double constraint_tolerance, double correction_tolerance, double noise,
                  double cost_iteration, double cost_rotation, double cost_seed,
                  double patience, bint sparing=False, bint sure=False, double share=INFINITY,
                  double work=INFINITY, double floor=0.0):
        cdef Loop *loop = &self.loop
        cdef double[:, ::1] vectors
        cdef double[::1] values
        self.kept = equations, frame
        loop.equations = <ancf_equations *>PyCapsule_GetPointer(
            equations.capsule, "ancf_equations")
        self.take_seed(seed, inverse, rounds, cost_iteration, cost_seed)
        if frame is not None:
            loop.frame = <const ancf_frame *>PyCapsule_GetPointer(frame.capsule, "ancf_frame")
            if loop.equations.q == NULL:
                raise ValueError("a frame needs equations that expose their coordinates")
        loop.rotating, loop.compares_frames = rotating, compares_frames
        loop.n, loop.parts = loop.equations.n, 1
        loop.newton, loop.learns, loop.carry, loop.polishes = newton, learns, carry, polishes
        loop.economical, loop.sparing = economical, sparing
        loop.by_correction, loop.max_iterations, loop.sure = by_correction, max_iterations, sure
        loop.share, loop.work, loop.floor = share, work, floor
        loop.force_tolerance, loop.constraint_tolerance = force_tolerance, constraint_tolerance
        loop.correction_tolerance, loop.noise = correction_tolerance, noise
        loop.cost_rotation, loop.patience = cost_rotation, patience
        loop.events = <Event *>calloc(MOST_EVENTS, sizeof(Event))
        if loop.events == NULL:
            raise MemoryError
        loop.timed = loop.n >= TIMED_FROM
        # Pair and product are not needed while a matrix is assembled: they share its memory.
        self.arrays = np.zeros((2, loop.n)), np.zeros(max(loop.equations.n_values + 1, 3 * loop.n))
        vectors, values = self.arrays
        loop.r, loop.r_new = &vectors[0, 0], &vectors[1, 0]
        loop.s, loop.y, loop.z = &values[0], &values[loop.n], &values[2 * loop.n]
        loop.values = &values[0]
        self.interface.context, self.interface.solve, self.interface.again = loop, solve, again
        self.interface.confirm, self.interface.prefer = confirm, prefer
        self.interface.repeat = repeat
        self.interface.doubtful, self.interface.saddle = &loop.doubtful, &loop.saddle
        self.capsule = PyCapsule_New(&self.interface, "ancf_nonlinear", NULL)

    def __dealloc__(self):
        free(self.loop.events)

    @property
    def seconds(self):
        """Time by part [s]; empty for systems so small that reading the clock would matter."""
        return dict(self.loop.seconds) if self.loop.timed else {}

    @property
    def counts(self):
        """Counts since construction, by name."""
        return dict(self.loop.counts)

    @property
    def max_iterations(self):
        """Largest number of corrections in an attempt."""
        return self.loop.max_iterations

    def set_threads(self, ptrdiff_t threads):
        """Set the number of threads for vector operations."""
        self.loop.parts = threads

    @property
    def events(self):
        """Fallbacks that were used, up to the first thousand.

        Each is ``(step, rung, cause, contraction)``: number of the step, from 1; 1 for a new seed,
        2 for damped Newton, 3 for Newton after a rejected solution, 4 for Newton from a predictor
        without acceleration, 5 for descent; why the previous attempt failed (`nonlinear.outcome`);
        and its last contraction of the residual.
        """
        cdef ptrdiff_t k
        found = []
        for k in range(min(self.loop.n_events, MOST_EVENTS)):
            event = self.loop.events[k]
            found.append((event.step, event.rung, event.cause, event.contraction))
        return found

    def take_events(self):
        """Return the events so far and clear the list, for those of the next steps."""
        found = self.events
        self.loop.n_events = 0
        return found

    @property
    def contraction(self):
        """Ratio of the last two residuals in the last attempt; NaN if there was none."""
        return self.loop.contraction

    @property
    def rate(self):
        """Contraction of the corrections, kept from step to step."""
        return self.loop.rate

    @rate.setter
    def rate(self, double value):
        self.loop.rate = value

    @property
    def measured(self):
        """Length of the first correction in a step that `rate` holds for [m], 0 if unknown."""
        return self.loop.measured

    @measured.setter
    def measured(self, double value):
        self.loop.measured = value

    @property
    def memory(self):
        """Memory for the steps after the next seed: rates and costs, shape (14,).

        It is complete if the seed is stale, since a new seed replaces secant pairs.
        """
        cdef const Loop *loop = &self.loop
        return np.array([loop.newton, loop.rotating, loop.frame_cost[0], loop.frame_cost[1],
                         loop.seeds_since_trial, loop.rate, loop.measured, loop.fresh, loop.extra,
                         loop.cost_since, loop.steps_since, loop.seeded, loop.rounds, self.rounds])

    @memory.setter
    def memory(self, values):
        cdef Loop *loop = &self.loop
        newton, rotating, loop.frame_cost[0], loop.frame_cost[1] = values[:4]
        self.newton, loop.rotating, loop.seeds_since_trial = newton != 0, rotating, values[4]
        loop.rate, loop.measured, loop.fresh, loop.extra, loop.cost_since = values[5:10]
        loop.steps_since, loop.seeded = values[10], values[11] != 0
        loop.rounds, self.rounds = values[12] != 0, values[13] != 0

    def take_seed(self, seed, inverse, bint rounds, double cost_iteration, double cost_seed):
        """Replace the seed by one that has no factor yet, and the inverse by one based on it."""
        cdef Loop *loop = &self.loop
        self.owners = (seed, inverse)
        loop.seed = <const ancf_seed *>PyCapsule_GetPointer(seed.capsule, "ancf_seed")
        loop.inverse = <const ancf_inverse *>PyCapsule_GetPointer(inverse.capsule, "ancf_inverse")
        loop.rounds = rounds and loop.seed.round_to_single != NULL
        loop.cost_iteration, loop.cost_seed = cost_iteration, cost_seed
        loop.seeded, loop.rate, loop.extra = False, SLOW, 0.0
        loop.cost_since, loop.steps_since = 0.0, 0
        loop.frame_cost[0] = loop.frame_cost[1] = 0.0

    def set_costs(self, double cost_iteration, double cost_seed):
        """Set new costs of an iteration and of a new seed."""
        self.loop.cost_iteration, self.loop.cost_seed = cost_iteration, cost_seed

    def mark_seeded(self):
        """Mark the inverse as initialized by the caller (a finite-difference matrix)."""
        assemble(&self.loop)
        hold(&self.loop)
        self.loop.seeded = True

    @property
    def by_correction(self):
        """Return True if convergence is judged by corrections, not by the residual."""
        return bool(self.loop.by_correction)

    def set_tolerance(self, tolerance):
        """Set new tolerances, an object with the attributes of `iteration.Tolerance`."""
        self.loop.by_correction = tolerance.by_correction
        self.loop.correction_tolerance = tolerance.correction
        self.loop.constraint_tolerance = tolerance.constraint
        self.loop.force_tolerance, self.loop.noise = tolerance.force, tolerance.noise
        self.loop.share, self.loop.work = tolerance.share, tolerance.work
        self.loop.floor, self.loop.sure = tolerance.floor, tolerance.sure

    @property
    def step(self):
        """Number of the last step attempted, from 1, as used in events."""
        return self.loop.step

    @step.setter
    def step(self, ptrdiff_t number):
        self.loop.step = number

    @property
    def yields(self):
        """Return True if a step that a new seed does not save is given up at once."""
        return bool(self.loop.yields)

    @yields.setter
    def yields(self, bint value):
        self.loop.yields = value

    @property
    def halves(self):
        """Return True if shorter steps will be tried before descent."""
        return bool(self.loop.halves)

    @halves.setter
    def halves(self, bint value):
        self.loop.halves = value

    @property
    def newton(self):
        """Return True if steps are solved by Newton's method: every correction has a new factor."""
        return bool(self.loop.newton)

    @newton.setter
    def newton(self, bint value):
        cdef Loop *loop = &self.loop
        if value and not loop.newton:
            self.rounds, loop.rounds = loop.rounds, loop.seed.round_to_single != NULL
        elif loop.newton and not value:
            loop.rounds = self.rounds
        loop.newton = value

    def mark_stale(self):
        """Request a new seed because the matrix has changed, for instance with the step size."""
        self.loop.reseed_due = True

    def solve(self):
        """Solve the equations from their predictor; return an outcome (`nonlinear.outcome`)."""
        self.loop.equations.restart(self.loop.equations.context)
        return solve(&self.loop)
