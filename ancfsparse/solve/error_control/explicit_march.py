"""Whole motions by explicit integrators, in equal steps between the breaks of the loads."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InstabilityError, LoadError
from ancfsparse.integrators.explicit.explicit_methods import Explicit, make_explicit
from ancfsparse.nonlinear import Outcome
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.results import RunStats
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.dense.block_inverse import BlockInverse
from ancfsparse.solve.error_control.rank_deficiency import RankDeficiency
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
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
from ancfsparse.solve.stepping.explicit_setup import (
    cheapest_mass_inverse,
    count_forces,
    instability_error,
)
from ancfsparse.solve.stepping.sampled_states import SampledStates
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import ExplicitLoop

Vector = NDArray[np.float64]

# Share of the stable step at the start that is taken: beams that are stretched vibrate faster.
MARGIN = 0.95
# Steps of a run at least: shorter ones must be more of them, and states between need neighbours.
FEWEST = 12
# By how much the fastest vibration is taken to have grown, at least, where a run became unstable.
FASTER, MOST_UNSTABLE = 1.1, 5
# The same with bodies, which turn within the first steps by so much at most [rad]: nothing but
# constraints that cannot be met limits their steps.
MUCH_FASTER, TURN = 2.0, 1.0
# The same at most, to the power of how many runs became unstable: they may end at coordinates far
# from all of the motion, whose vibrations are faster by any factor.
MOST_FASTER = 2.0
# Steps that are taken in one go at most, and coordinates of all of them.
CHUNK, COORDINATES = 2000, 4_000_000


class ExplicitMarch:
    """What whole motions of one scene have in common.

    Parameters
    ----------
    system, t, max_energy_gain
        As `solve_accurately` takes them.
    discontinuities : Breaks
        Where loads jump or kink.
    watch : callable
        Is given the states of a motion whenever there are more of them.
    integrator : Explicit
        One of those that it will march by.

    Attributes
    ----------
    omega : float
        Fastest vibration that steps must resolve [rad/s]; before the set-up, what it has at least.
    force_cost : float
        Modelled cost of an evaluation of the forces.
    failure : InstabilityError or LoadError
        Why it is given up, None if it is not.
    places : LostRank
        Where constraints lost rank in its motions.
    """

    def __init__(
        self,
        system: System,
        t: Vector,
        max_energy_gain: float,
        discontinuities: LoadDiscontinuities,
        watch: Callable[[SampledStates], None],
        integrator: Explicit,
    ) -> None:
        self._system, self._t, self._max_energy_gain = system, t, max_energy_gain
        self._watch = watch
        self._discontinuities, self._spans = discontinuities, discontinuities.spans
        self._length = float(t[-1] - t[0])
        mass = definite_mass(system, system.q0)
        self._seed = SparseSeed(mass.indptr, mass.indices, system.n_free)
        self._saddle = (
            saddle_seed(system) if needs_saddle_point_factor(system, integrator) else None
        )
        self._sizes = None if self._saddle is None else constraint_magnitudes(system)
        self._mass: SparseSeed | BlockInverse | None = None
        self.omega = _slowest_fast(system)
        forces = "residual" if system.damped else "force"
        self.force_cost = 0.1 * system.operations(forces) + _solving(
            system, self._seed, self._saddle
        )
        self._noise = 100.0 * EPSILON * system.energy_scale(system.q0)
        self._interval = MARGIN * integrator.tableau.interval
        self._unstable = 0
        self.places = RankDeficiency(system, self._sizes)
        self.failure: InstabilityError | LoadError | None = None

    @property
    def is_set_up(self) -> bool:
        """Whether the fastest vibration is known."""
        return self._mass is not None

    def set_up(self) -> None:
        """Invert the mass matrix and find the fastest vibration.

        Raises
        ------
        InputError
            If the start leaves the range of floating-point numbers.
        """
        check_energy(self._system)
        self._seed.factor(definite_mass(self._system, self._system.q0).data)
        load, lam = load_amplitudes_at_start(self._system), None
        if self._saddle is None:
            self._mass = cheapest_mass_inverse(self._system, self._seed)
        else:
            lam, self._mass = initial_multipliers(self._system, self._saddle), self._saddle
        self.omega = highest_frequency(self._system, self._seed, self._system.q0, load, lam)
        if lam is not None:
            self.omega = max(self.omega, self._interval * self._turning(lam, load))

    def _turning(self, lam: Vector, load: Vector) -> float:
        """Return how fast bodies turn at the start, and at least in the steps of a run [rad/s]."""
        system = self._system
        none = np.zeros(system.n_multipliers)
        bent, straight = (
            system.assembly.matrix(0.0, 1.0, system.q0, each, load) for each in (lam, none)
        )
        return max(
            highest_frequency_of(system, self._seed, bent - straight) / TURN, FEWEST / self._length
        )

    def step(self, integrator: Explicit, finer: float) -> float:
        """Return a step that is so much shorter than the longest one [s]."""
        stable = MARGIN * integrator.tableau.interval / self.omega
        return min(stable, self._length / FEWEST) / finer

    def cost(self, integrator: Explicit, finer: float) -> float:
        """Return the modelled cost of a motion in such steps."""
        steps = self._length / self.step(integrator, finer) + len(self._spans)
        return steps * integrator.tableau.forces * self.force_cost

    def run(self, integrator: Explicit, finer: float, stats: RunStats) -> SampledStates | None:
        """March through all times asked for; no states if the motion became unstable on the way.

        Then the next run knows of a faster vibration.
        """
        assert self._mass is not None
        system = self._system
        h = self.step(integrator, finer)
        states = SampledStates.empty(self._t, system.n_all, system.n_multipliers)
        self.places.begin()
        system.reset_memory()
        q, v, now = system.q0, system.v0, system.t0
        for (begin, end), last in zip(
            self._spans, [*self._discontinuities.after, self._t[-1]], strict=True
        ):
            load = system.loads.amplitudes(np.array([begin]))[0]
            n = math.ceil((last - now) / h)
            dt = (last - now) / n
            gain, noise = self._max_energy_gain, self._noise
            inputs = self._inputs(np.array([now]), begin, end)[0]
            state = (q, v, inputs, self._mass, gain, noise)
            march = make_explicit(system, dt, integrator, *state, self._sizes)
            if not states.rows:
                states.begin(*march.state)
            span = (now, float(last), n)
            outcome = self._march(march, integrator, span, begin, end, states, stats)
            q, v, _, lam = march.state
            if outcome != Outcome.CONVERGED:
                count_forces(stats, integrator)
                self._unstable += 1
                failed = self._failed_function()
                if self._unstable == MOST_UNSTABLE:
                    self.failure = failed or instability_error(
                        system, march, self._seed, integrator, outcome, stats.steps, now, dt
                    )
                omega = 0.0
                if outcome != Outcome.NOT_FINITE and failed is None:
                    omega = highest_frequency(system, self._seed, q, load, lam)
                faster = FASTER if self._saddle is None and failed is None else MUCH_FASTER
                most = MOST_FASTER**self._unstable
                self.omega *= min(max(omega / self.omega, faster), most)
                return None
            now = last
        count_forces(stats, integrator)
        return states

    def _failed_function(self) -> LoadError | None:
        """Return what a function of the motion has failed with, and let it be called again.

        Steps that are too long lead to coordinates where drag or a stiffening spring overflows.
        """
        try:
            self._system.assembly.check()
        except LoadError as failure:
            self._system.assembly.forget()
            return failure
        return None

    def _inputs(self, times: Vector, begin: float, end: float) -> Vector:
        """Return the loads of an interval where they are smooth, and the prescribed motions."""
        amplitudes = self._system.loads.amplitudes(np.clip(times, begin, end))
        if not self._system.prescribed:
            return amplitudes
        prescribed, failure = self._system.prescribed.tabulate(times, rates=True)
        if failure is not None:
            raise failure
        return np.hstack([amplitudes, prescribed])

    def _march(
        self,
        march: ExplicitLoop,
        integrator: Explicit,
        span: tuple[float, float, int],
        begin: float,
        end: float,
        states: SampledStates,
        stats: RunStats,
    ) -> Outcome:
        """March from one time to another in so many steps.

        Loads are evaluated from the begin to the end of the time in which they are smooth alone.
        """
        start, stop, steps = span
        n, nodes = self._system.n_all, integrator.stages
        chunk = max(1, min(CHUNK, COORDINATES // n, steps))
        widths = (n, n, n, self._system.n_multipliers)
        buffer = [np.zeros((chunk + 1, width)) for width in widths]
        for first in range(0, steps, chunk):
            numbers = np.arange(first, min(first + chunk, steps) + 1, dtype=np.float64)
            mine = np.where(numbers < steps, start + numbers * ((stop - start) / steps), stop)
            for table, row in zip(buffer, march.state, strict=True):
                table[0] = row
            when = mine[:-1, None] + np.diff(mine)[:, None] * nodes
            inputs = self._inputs(when.ravel(), begin, end)
            clock = time.perf_counter()
            taken, code = march.advance(None, len(mine) - 1, inputs, 1, 0, *buffer)
            stats.march_seconds += time.perf_counter() - clock
            stats.steps += taken
            if taken:
                rows = slice(0, taken + 1)
                q, v, a, lam = (table[rows] for table in buffer)
                new = states.fill(mine[rows], q, v, a, lam, resolved=True)
                if new.start < new.stop:
                    inputs = self._inputs(states.t[new], begin, end)
                    # Lines between the ends would miss by far what turns by a radian in a step.
                    march.accelerations_of(
                        states.q[new], states.v[new], inputs, states.a[new], states.lam[new]
                    )
                self.places.look(mine[rows], q, v, lam)
                self._watch(states)
            if code:
                return Outcome(code)
            self._system.assembly.check()
        return Outcome.CONVERGED


def _solving(system: System, mass: SparseSeed, saddle: SparseSeed | None) -> float:
    """Return the modelled cost of the solutions for the accelerations of a stage."""
    if saddle is None:
        solves = 1 if system.constraints.linear else 1 + system.n_multipliers
        return 0.5 * solves * mass.solve_flops
    factors = 0 if system.constraints.linear else saddle.factor_flops
    return 0.5 * (factors + saddle.solve_flops)


def _slowest_fast(system: System) -> float:
    """Return what the fastest vibration has at least, from the diagonals alone [rad/s]."""
    stiffness = system.stiffness_diagonal(system.q0) / system.mass_diagonal
    return math.sqrt(max(float(np.max(stiffness)), np.finfo(float).tiny))
