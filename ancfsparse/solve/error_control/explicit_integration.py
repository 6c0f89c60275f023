"""Integrate whole motions by explicit methods, with equal steps between load discontinuities."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InstabilityError, LoadError
from ancfsparse.integrators.explicit.explicit_methods import Explicit, make_explicit
from ancfsparse.nonlinear import Outcome
from ancfsparse.nonlinear.iteration import Costs
from ancfsparse.results import RunStats
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.dense.block_inverse import BlockInverse
from ancfsparse.solve.error_control.motion_task import MotionTask
from ancfsparse.solve.error_control.rank_deficiency import RankDeficiency
from ancfsparse.solve.initial_conditions.consistent_accelerations import load_amplitudes_at_start
from ancfsparse.solve.initial_conditions.consistent_state import check_energy
from ancfsparse.solve.linearization.matrices import (
    constraint_magnitudes,
    definite_mass,
    highest_frequency,
    highest_frequency_of,
    initial_multipliers,
    needs_saddle_point_factor,
    saddle_seed,
)
from ancfsparse.solve.stepping.energy_rounding import estimate_energy_rounding
from ancfsparse.solve.stepping.explicit_setup import (
    cheapest_mass_inverse,
    count_forces,
    instability_error,
)
from ancfsparse.solve.stepping.sampled_states import SampledStates, steps_at_once
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import ExplicitLoop


STABILITY_RATIO = 0.95  # step over the stable one at the start: stretched beams vibrate faster
# Steps of a run, and between discontinuities at the ratio 1: with one step, 6 of 12 cantilevers at
# rest seemed to gain energy from a short signal and stopped, with 6 steps one did, with 8 none.
MIN_STEPS = 12
MAX_UNSTABLE_RUNS = 5  # unstable runs
# Growth of the highest frequency after an unstable run if it was not too high: with bodies, whose
# steps only constraints limit, and where steps resolve loads or waves too little for a balance of
# energy.  With 1.1, 12 of 30 runs of cantilevers under a sine of 999 Hz or a force of 60 us
# stopped, with 1.5 one, with 2 none.  Also the largest growth, to the power of the number of
# unstable runs, which may end at coordinates far from all of the motion.
UNSTABLE_GROWTH = 2.0


class ExplicitIntegration:
    """Explicit runs of one scene.

    Parameters
    ----------
    task : MotionTask
        The motion.
    integrator : Explicit
        One of the integrators of the runs.

    Attributes
    ----------
    omega : float
        Highest frequency that steps must resolve [rad/s].
    force_cost : float
        Modelled cost of an evaluation of the forces.
    failure : InstabilityError or LoadError
        Reason why no further run is possible, if any.
    rank_deficiency : RankDeficiency
        Singular configurations in the runs.
    """

    def __init__(self, task: MotionTask, integrator: Explicit) -> None:
        self._task, self._system = task, task.system
        self._spans, system = task.discontinuities.analytic_spans, task.system
        resolving = task.discontinuities.longest_step, task.resolving_step()
        self._longest_step = min(task.length / MIN_STEPS, *resolving)
        mass = definite_mass(system, system.q0)
        self._seed = SparseSeed(mass.indptr, mass.indices, system.n_free)
        self._saddle = (
            saddle_seed(system) if needs_saddle_point_factor(system, integrator) else None
        )
        self._sizes = None if self._saddle is None else constraint_magnitudes(system)
        self.force_cost = _force_cost(system, self._seed, self._saddle)
        self._stiffness = system.stiffness_diagonal(system.q0)
        self._unstable = 0
        self.rank_deficiency = RankDeficiency(system, self._sizes)
        self.failure: InstabilityError | LoadError | None = None
        check_energy(system)
        self._seed.factor(mass.data)
        self._mass: SparseSeed | BlockInverse = self._saddle or cheapest_mass_inverse(
            system, self._seed
        )
        self.omega = self._highest_frequency(STABILITY_RATIO * integrator.tableau.interval)

    def _highest_frequency(self, interval: float) -> float:
        """Return the highest frequency at the start, at least of a radian in the motion [rad/s]."""
        load, lam = load_amplitudes_at_start(self._system), None
        if self._saddle is not None:
            lam = initial_multipliers(self._system, self._saddle)
        omega = highest_frequency(self._system, self._seed, self._system.q0, load, lam)
        if lam is not None:
            omega = max(omega, interval * self._turning(lam, load))
        return max(omega, 1.0 / self._task.length)

    def _turning(self, lam: Vector, load: Vector) -> float:
        """Return the frequency of rotation of bodies, at most a radian per step [rad/s]."""
        system = self._system
        zero = np.zeros(system.n_multipliers)
        stressed, free = (system.assembly.matrix(0.0, 1.0, system.q0, x, load) for x in (lam, zero))
        return max(
            highest_frequency_of(system, self._seed, stressed - free),
            MIN_STEPS / self._task.length,
        )

    def step(self, integrator: Explicit, ratio: float) -> float:
        """Return a step that is shorter than the longest one by a ratio [s]."""
        stable = STABILITY_RATIO * integrator.tableau.interval / self.omega
        return min(stable, self._longest_step) / ratio

    def cost(self, integrator: Explicit, ratio: float) -> float:
        """Return the modelled cost of a run with such steps."""
        h = self.step(integrator, ratio)
        steps = sum(max((end - begin) / h + 1.0, MIN_STEPS * ratio) for begin, end in self._spans)
        return steps * integrator.tableau.forces * self.force_cost

    def run(self, integrator: Explicit, ratio: float, stats: RunStats) -> SampledStates | None:
        """Integrate the motion; return its states, or None if it became unstable.

        After that the highest frequency is assumed to be larger.
        """
        system = self._system
        h = self.step(integrator, ratio)
        sizes = system.n_all, system.n_multipliers, system.assembly.n_history
        states = SampledStates.empty(self._task.t, *sizes)
        self.rank_deficiency.begin()
        system.reset_memory()
        q, v, now = system.q0, system.v0, system.t0
        ends = [*(begin for begin, _ in self._spans[1:]), float(self._task.t[-1])]
        for (begin, end), last in zip(self._spans, ends, strict=True):
            load = system.loads.amplitudes(np.array([begin]))[0]
            n = math.ceil(max((last - now) / h, MIN_STEPS * ratio))
            dt = (last - now) / n
            gain = self._task.max_energy_gain
            rounding = estimate_energy_rounding(system, self._stiffness, dt)
            inputs = self._inputs(np.array([now]), begin, end)[0]
            state = (q, v, inputs, self._mass, gain, *rounding)
            history = system.assembly.history
            time_loop = make_explicit(system, dt, integrator, *state, self._sizes)
            if states.rows:
                system.set_history(history)
            else:
                states.begin(*time_loop.state, system.assembly.history)
            span = (now, last, n)
            outcome = self._integrate(time_loop, integrator, span, begin, end, states, stats)
            q, v, _, lam = time_loop.state
            if outcome != Outcome.CONVERGED:
                count_forces(stats, integrator)
                self._unstable += 1
                failed = self._failed_function()
                if self._unstable == MAX_UNSTABLE_RUNS:
                    self.failure = failed or instability_error(
                        system, time_loop, self._seed, integrator, outcome, stats.steps, now, dt
                    )
                omega = 0.0
                if outcome != Outcome.NOT_FINITE and failed is None:
                    omega = highest_frequency(system, self._seed, q, load, lam)
                is_too_fast = self._saddle is None and STABILITY_RATIO * omega > self.omega
                growth = omega / self.omega if is_too_fast else UNSTABLE_GROWTH
                self.omega *= min(growth, UNSTABLE_GROWTH**self._unstable)
                return None
            now = last
        count_forces(stats, integrator)
        return states

    def _failed_function(self) -> LoadError | None:
        """Return the failure of a function of the motion, and let it be called again.

        Too long steps lead to coordinates at which drag or a stiffening spring overflows.
        """
        try:
            self._system.assembly.check()
        except LoadError as failure:
            self._system.assembly.forget()
            return failure
        return None

    def _inputs(self, times: Vector, begin: float, end: float) -> Vector:
        """Return the loads of a smooth interval, and the prescribed motions."""
        amplitudes = self._system.loads.amplitudes(np.clip(times, begin, end))
        if not self._system.prescribed:
            return amplitudes
        prescribed, failure = self._system.prescribed.tabulate(times, rates=True)
        if failure is not None:
            raise failure
        return np.hstack([amplitudes, prescribed])

    def _integrate(
        self,
        time_loop: ExplicitLoop,
        integrator: Explicit,
        span: tuple[float, float, int],
        begin: float,
        end: float,
        states: SampledStates,
        stats: RunStats,
    ) -> Outcome:
        """Integrate over an interval with a number of steps.

        Loads are evaluated only in the interval in which they are smooth.
        """
        start, stop, steps = span
        n, nodes = self._system.n_all, integrator.stages
        chunk = min(steps_at_once(n), steps)
        widths = (n, n, n, self._system.n_multipliers, self._system.assembly.n_history)
        buffer = [np.zeros((chunk + 1, width)) for width in widths]
        if widths[-1]:
            time_loop.save_history(buffer[-1])
        for first in range(0, steps, chunk):
            numbers = np.arange(first, min(first + chunk, steps) + 1, dtype=np.float64)
            times = np.where(numbers < steps, start + numbers * ((stop - start) / steps), stop)
            state = *time_loop.state, self._system.assembly.history
            for table, row in zip(buffer, state, strict=True):
                table[0] = row
            when = times[:-1, None] + np.diff(times)[:, None] * nodes
            inputs = self._inputs(when.ravel(), begin, end)
            clock = time.perf_counter()
            taken, code = time_loop.advance(None, len(times) - 1, inputs, 1, 0, *buffer[:4])
            stats.march_seconds += time.perf_counter() - clock
            stats.steps += taken
            if taken:
                rows = slice(0, taken + 1)
                q, v, a, lam, history = (table[rows] for table in buffer)
                new = states.fill(times[rows], q, v, a, lam, history, resolved=True)
                if new.start < new.stop:
                    inputs = self._inputs(states.t[new], begin, end)
                    # Linear interpolation would be far off for rotations of a radian in a step.
                    time_loop.accelerations_of(
                        states.q[new], states.v[new], inputs, states.a[new], states.lam[new]
                    )
                self.rank_deficiency.examine(times[rows], q, v, lam)
                self._task.watch(states)
            if code:
                return Outcome(code)
            self._system.assembly.check()
        return Outcome.CONVERGED


def _force_cost(system: System, mass: SparseSeed, saddle: SparseSeed | None) -> float:
    """Return the modelled cost of the forces and accelerations of a stage."""
    forces = system.operations("residual" if system.damped else "force")
    costs = Costs.from_counts(forces, 0, mass if saddle is None else saddle)
    is_linear = system.constraints.linear
    if saddle is None:
        return costs.total(1, 1 if is_linear else 1 + system.n_multipliers, 0)
    return costs.total(1, 1, 0 if is_linear else 1)
