"""A march whose step follows the motion: grown, cut and tried again by a local error estimate.

What steps it took is a pattern, which another run can take with each step divided.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, Parameter
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.interface.time_grid import MOST_STEPS
from ancfsparse.nonlinear import Method, Outcome
from ancfsparse.results import Event, RunStats
from ancfsparse.seeds import Seed
from ancfsparse.solve.error_models.cost_model import CostModel
from ancfsparse.solve.error_models.cost_per_step import StepCostMonitor
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.initial_conditions.prescribed_start import inputs_at
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.solve.stepping.outcome_reporting import (
    CAUSE_NAMES,
    count_costs,
    recovery_events,
    step_error,
)
from ancfsparse.solve.stepping.remedies import hint_for_accuracy
from ancfsparse.solve.stepping.sampled_states import SampledStates
from ancfsparse.solve.stepping.step_size_change import StepSizeChange
from ancfsparse.system import System

Vector = NDArray[np.float64]
# Steps of one length in a row, (step [s], how many), for each span of smooth loads.
Pattern = list[list[tuple[float, int]]]

# Steps change by powers of the root of two, and seldom: the seed of a step serves the next ones.
RATIO = math.sqrt(2.0)
# Steps in a row that must be easy before they grow, and steps that are taken in one go at most.
PATIENCE, CHUNK, COORDINATES = 8, 500, 4_000_000
# So many steps before the end of a span they are made such that the last one ends there.
LANDING = 8
# A step may grow if the larger one would have this share of the error allowed.
SAFETY = 0.7
# In the first steps a step may grow by so many powers at once.
OPENING, MOST_LEVELS = 64, 2
# Steps that are given are taken in so many parts at least, so that there is something to hand on.
PARTS = 8
# Steps from one look at their cost to the next.
LOOK = 16
# Share of a step's error that the iteration may leave.
ITERATION_SHARE = 0.03
SHORTEST = 1e-10  # a step, over the length of the run
MOST_EVENTS = 1000  # that are kept, as where steps have one length
WHOLE = 1e-9  # rounding of a number of steps, over it


class OverBudget(Exception):
    """A run has cost what it may."""


class StepSizeController:
    """One run with a local error per step, or with the steps of another run, divided.

    Parameters
    ----------
    system : System
        What moves.
    integrator : Implicit
        A scheme of second order.
    solver : Method or "auto"
        How steps are solved.
    local_error : float
        Error that a step may make, root mean square weighted by mass [m].
    dt : float
        First step [s].
    t : (k,) float
        Times asked for, the first one that of the start [s].
    max_energy_gain, threads
        As in `simulate`.
    discontinuities : Breaks, optional
        Times that steps end at because the loads jump or kink there.
    watch : callable, optional
        Is given the states whenever there are more of them.
    pattern : list, optional
        Steps to take, with no regard to their error.
    left : float, optional
        Error that the iteration of a step may leave [m]; by default a small share of its own.
    kept : float, optional
        The same over the square of the step [m/s^2], where it must fall with it.
    budget : float, optional
        Cost, as `CostModel` models it, at which the run ends with `OverBudget`.

    Attributes
    ----------
    pattern : list
        The steps that were taken.
    cost_model : Price
        Of an evaluation, a solution, a factor.
    """

    def __init__(
        self,
        system: System,
        integrator: Implicit,
        solver: Method | str,
        local_error: float,
        dt: float,
        t: Vector,
        max_energy_gain: float,
        threads: int = 1,
        *,
        discontinuities: LoadDiscontinuities | None = None,
        watch: Callable[[SampledStates], None] | None = None,
        pattern: Pattern | None = None,
        left: float | None = None,
        kept: float = math.inf,
        budget: float = math.inf,
    ) -> None:
        begin = time.perf_counter()
        self.system, self.integrator = system, integrator
        self.local_error, self.max_energy_gain = local_error, max_energy_gain
        self.dt = dt if pattern is None else pattern[0][0][0]
        self._given, self.pattern = pattern, list[list[tuple[float, int]]]()
        self._discontinuities, self._watch, self._budget = discontinuities, watch, budget
        self.seed: Seed
        self.march, self.iteration, self.seed, self.criterion, why, a, _ = prepare_implicit(
            system, self.dt, integrator, solver, "default", max_energy_gain, threads
        )
        self.cost_model = CostModel.of(system, integrator, self.seed)
        self._left = ITERATION_SHARE * local_error if left is None else left
        self._kept = kept
        self._bound(self.dt)
        error = abs(integrator.velocity_constant)  # the position's is the same, 1/12 + shift^2 / 4
        limit, easy = local_error, SAFETY * local_error / RATIO**3
        if pattern is not None:
            limit, easy = math.inf, -1.0
        self.march.control(self.seed, _weights(system), error, limit, easy, PATIENCE)
        q, _, _, lam = self.march.state
        self.states = SampledStates.empty(t, system.n_all, system.n_multipliers)
        self.states.begin(q, system.v0, a, lam)
        self._passage = StepSizeChange(system, integrator, self.march, self.seed)
        self._effort = StepCostMonitor(self.cost_model, RATIO)
        self.stats = RunStats(solver=why, seconds={"set-up": time.perf_counter() - begin})
        chunk = max(1, min(CHUNK, COORDINATES // system.n_all))
        widths = (*(system.n_all,) * 3, system.n_multipliers)
        self._buffer = [np.empty((chunk + 1, width)) for width in widths]

    def run(self) -> SampledStates:
        """March through all times asked for.

        Raises
        ------
        StepError, EnergyIncreaseError
            Without a trajectory.
        OverBudget
            If the run has cost what it may.
        """
        t_end = float(self.states.t[-1])
        t_start = self.system.t0
        spans = [(t_start, t_end)] if self._discontinuities is None else self._discontinuities.spans
        try:
            now = t_start
            for k, (begin, end) in enumerate(spans):
                upto = t_end if k + 1 == len(spans) else spans[k + 1][0]
                self.pattern.append([])
                if self._given is None:
                    self._follow(now, upto, begin, end)
                else:
                    self._repeat(self._given[k], now, upto, begin, end)
                now = upto
                if k + 1 < len(spans):
                    self._passage.jump(self.dt, end, now)
                    self._go_on(self.dt)
            if self.march.gained_energy():
                raise self._stopped(Outcome.HAD_GAINED, now)
        finally:
            self._count()
        return self.states

    def _count(self) -> None:
        count_costs(self.stats, self.iteration, self.seed)
        self.stats.factorizations += self._passage.factors
        self.stats.solves += self._passage.factors

    def _follow(self, now: float, upto: float, begin: float, end: float) -> None:
        """Take steps of the error allowed through a span of smooth loads."""
        cruise = self.dt
        while now < upto:
            if (upto - now) / self.dt > MOST_STEPS:
                raise InputError(
                    "a run to {end} would take more than {most:.0e} steps of {dt:.2g} s: ask for "
                    "a shorter time",
                    end=Parameter("t_end", f"{self.states.t[-1]:g} s"),
                    most=MOST_STEPS,
                    dt=self.dt,
                )
            n = math.ceil((upto - now) / self.dt * (1.0 - WHOLE))
            if n <= LANDING:
                if abs(n * self.dt - (upto - now)) > WHOLE * (upto - now):
                    cruise = max(cruise, self.dt)
                    self._change((upto - now) / n, now)
                wanted = n
            else:
                wanted, cruise = n - LANDING, self.dt
            now, outcome = self._advance(now, min(wanted, LOOK), n, upto, begin, end)
            fine = outcome in (Outcome.CONVERGED, Outcome.MAY_GROW)
            if fine and n > LANDING and self._hard():
                self._change(self.dt / RATIO, now)
                continue
            if outcome == Outcome.CONVERGED:
                continue
            shortest = SHORTEST * (self.states.t[-1] - self.states.t[0])
            hopeless = self.dt < shortest and outcome != Outcome.MAY_GROW
            if outcome in (Outcome.GAINED_ENERGY, Outcome.HAD_GAINED) or hopeless:
                raise self._stopped(outcome, now)
            if outcome == Outcome.MAY_GROW and upto - now < LANDING * self.dt * RATIO:
                continue
            dt = self._grown() if outcome == Outcome.MAY_GROW else self._shorter(outcome)
            if dt == self.dt:
                continue
            if outcome not in (Outcome.MAY_GROW, Outcome.TOO_INACCURATE):
                what, step = f"step of {dt:.3g} s", self.stats.steps + 1
                rate = self.iteration.contraction
                self.note([Event(step, now + self.dt, what, CAUSE_NAMES[outcome], rate)])
            self._change(dt, now)
            cruise = dt
        if cruise != self.dt and upto < self.states.t[-1]:
            self._change(cruise, now)

    def _repeat(
        self, rows: list[tuple[float, int]], now: float, upto: float, begin: float, end: float
    ) -> None:
        """Take the steps given through a span of smooth loads."""
        for k, (dt, steps) in enumerate(rows):
            if dt != self.dt:
                self._change(dt, now)
            last = now + steps * dt if k + 1 < len(rows) else upto
            part = max(LOOK, steps // PARTS)
            while steps:
                taken = self.stats.steps
                now, outcome = self._advance(now, min(steps, part), steps, last, begin, end)
                steps -= self.stats.steps - taken
                if outcome != Outcome.CONVERGED:
                    raise self._stopped(outcome, now)

    def _advance(
        self, now: float, wanted: int, left: int, upto: float, begin: float, end: float
    ) -> tuple[float, Outcome]:
        """Take steps, of those that are left to a time; return the time after them.

        Loads are evaluated between the begin and the end of their span alone.
        """
        wanted = min(wanted, len(self._buffer[0]) - 1)
        times = now + self.dt * np.arange(wanted + 1.0, dtype=np.float64)
        if wanted == left:
            times[-1] = upto
        for table, start in zip(self._buffer, self.march.state, strict=True):
            table[0] = start
        amplitudes = inputs_at(self.system, np.clip(times[1:], begin, end))
        self.iteration.step, before = self.stats.steps, now - self.stats.steps * self.dt
        clock = time.perf_counter()
        taken, code = self.march.advance(self.iteration, wanted, amplitudes, 1, 0, *self._buffer)
        self.stats.march_seconds += time.perf_counter() - clock
        if self.seed.error is not None:
            raise self.seed.error
        if code:
            self.system.assembly.check()
        self.note(recovery_events(self.iteration.take_events(), before, self.dt))
        if taken:
            rows = slice(0, taken + 1)
            self.states.fill(times[rows], *(table[rows] for table in self._buffer))
            self.stats.steps += taken
            mine = self.pattern[-1]
            if mine and mine[-1][0] == self.dt:
                mine[-1] = (self.dt, mine[-1][1] + taken)
            else:
                mine.append((self.dt, taken))
            if self._watch is not None:
                self._watch(self.states)
        self._count_budget()
        return float(times[taken]), Outcome(code)

    def _count_budget(self) -> None:
        if self._budget < math.inf:
            self._count()
            if self.cost_model.of_run(self.stats) > self._budget:
                raise OverBudget

    def note(self, found: list[Event]) -> None:
        """List events, the first thousand."""
        self.stats.events += found[: MOST_EVENTS - len(self.stats.events)]

    def _stopped(self, outcome: Outcome, now: float) -> Exception:
        return step_error(
            self.system,
            self.march,
            self.iteration,
            outcome,
            self.stats.steps,
            now,
            self.dt,
            self.max_energy_gain,
            None,
            hint_for_accuracy(self.system.scene, self.integrator),
        )

    def _grown(self) -> float:
        """Return the step after easy ones: longer, unless such steps were hard to solve."""
        if not self._effort.may_grow(self.stats.steps):
            return self.dt
        levels = 1
        if self.stats.rejected_steps == 0 and self.stats.steps < OPENING:
            levels = max(1, min(MOST_LEVELS, self._levels()))
        return self.dt * RATIO**levels

    def _hard(self) -> bool:
        """Whether the last steps cost so much that more and shorter ones may cost less."""
        self._count()
        return self._effort.too_large(self.stats)

    def _levels(self) -> int:
        """Return by how many roots of two the step may change for the error of the last one."""
        error = max(self.march.step_error, np.finfo(float).tiny)
        ratio = (SAFETY * self.local_error / error) ** (1.0 / 3.0)
        return math.floor(math.log(ratio, RATIO))

    def _shorter(self, outcome: Outcome) -> float:
        """Return the step to try again with."""
        if outcome == Outcome.TOO_INACCURATE:
            self.stats.rejected_steps += 1
            return self.dt * RATIO ** max(-6, min(-1, self._levels()))
        return self.dt / 2.0

    def _change(self, dt: float, now: float) -> None:
        self._passage.change(self.dt, dt, now)
        self._go_on(dt)

    def _go_on(self, dt: float) -> None:
        """Take up steps of a length after the factor was used for something else."""
        self._bound(dt)
        self.iteration.mark_stale()
        self.dt = dt

    def _bound(self, dt: float) -> None:
        """Set what the iteration of a step of this length may leave."""
        left = min(self._left, self._kept * dt**2)
        self.iteration.set_tolerance(self.criterion.at(dt, left))


def divided(pattern: Pattern, by: int) -> Pattern:
    """Return a pattern with each step divided."""
    return [[(dt / by, n * by) for dt, n in rows] for rows in pattern]


def _weights(system: System) -> Vector:
    """Return weights of the squares of coordinates that make a mean over the mass, (n_free,)."""
    mass = system.mass_diagonal
    places = system.positions
    total = float(mass[places[places < system.n_free]].sum())
    if total == 0.0:  # all nodes are held: the mass between them moves by the slopes alone
        along = np.zeros(system.n_all)
        along[places[:: system.dim]] = 1.0
        total = float(along @ system.assembly.inertia(along))
    return np.asarray(mass / total)
