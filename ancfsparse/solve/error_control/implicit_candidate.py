"""Whole motions by an implicit integrator, whose steps follow the first of them, and are divided.

Runs whose steps are those of another, each divided by the same whole number, have errors in fixed
proportion: the error follows from their difference, and can be subtracted (Richardson).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import EnergyIncreaseError, StepError
from ancfsparse.integrators import Implicit
from ancfsparse.nonlinear import Method, ModifiedNewton, Outcome, QuasiNewton
from ancfsparse.nonlinear.iteration import describe
from ancfsparse.results import Event, RunStats
from ancfsparse.solve.error_control.step_size_controller import (
    ITERATION_SHARE,
    OverBudget,
    Pattern,
    StepSizeController,
    divided,
)
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.error_models.phase_error import (
    DominantFrequency,
    difference_frequency,
    trapezoidal_phase_error,
)
from ancfsparse.solve.error_models.stagnation import MIN_DECREASE, StagnationCheck
from ancfsparse.solve.stepping.outcome_reporting import CAUSE_NAMES
from ancfsparse.solve.stepping.sampled_states import SampledStates, distance
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Intended error of the first run, over the size of the scene: coarse runs are cheap, and show what
# finer ones cost, whose steps are theirs, divided.
COARSE = 2e-3
# Error of a step in the first run, over its error and the root of its share of the scene: steps
# that add up to an error A have A / N each, and their number N goes with the root of 1 / A.
FIRST = 0.5
# Steps of a run are shorter than those of the last by these factors at least and at most: closer,
# and the difference of two runs is mostly noise; further, and the order has not been observed.
LEAST, MOST = 1.8, 5.0
# So much shorter steps without what can be taken off are no reason to make a run for it alone.
WORTH = 1.5
ONCE_MORE = 2.5  # how much shorter they are at least where one is made for it
SAFETY = 0.5  # share of the accuracy that the next run is planned for
# What the error of the second run is taken for, over a third of its distance from the first.
UNSEEN = 1.5
STRIDE = 3.0  # how much shorter steps are made where errors do not decrease
# Share of the accuracy that the iterations of all steps together may leave of places.  Where they
# leave d of a place, they leave 2 d / h of its velocity.  In a motion that nothing holds that adds
# up to 2 d n^1.5 / 3^0.5 in n steps, as signs vary.  So the share falls with the root of the steps
# beyond so many, which keeps that sum below a fifth of the accuracy.
ITERATIONS_SHARE, FEW = 0.03, 30.0
# How often a run that gains energy or cannot be solved is begun with shorter steps.
MOST_ATTEMPTS = 6
SHORTER = 27.0  # so much less error of a step makes steps a third as long
# The first run may cost this share of what another way would: the more the closer its error will be
# to the accuracy, and at least the second.  One that costs more is not tried again until the other
# way has become dearer by a factor.
PILOT, LEAST_PILOT, DEARER = 0.4, 0.1, 3.0
# Errors of the first run up to so many times the accuracy are close to it.
NEAR = 10.0
# No way is cheaper than so many evaluations of the forces: the first steps alone take them.
LEAST_FORCES = 900.0
# Power of the step with which the error of what is left once the second power is taken off falls,
# as far as it is believed: where steps resolve all that is left, and where not.
BELIEVED, UNRESOLVED = 1.25, 0.75
LEAST_LEFT = 1.0 / 12.0  # share of a difference that is always left
HALF = 0.5  # share of it that counts beside the error of the second power
# Phase that may be lost of what is resolved [rad].
RESOLVED = 0.1
# The distances of runs may differ from those of a second-order scheme by this factor, or what is
# taken off is not believed.
REGULAR = 1.5


class ImplicitCandidate:
    """One way to an accuracy.

    Parameters
    ----------
    system, t, accuracy, integrator, solver, max_energy_gain, threads
        As `solve_accurately` takes them.
    discontinuities : Breaks
        Where loads jump or kink.
    watch : callable
        Is given the states of a run whenever there are more of them.
    force_cost : float, optional
        Modelled cost of an evaluation of the forces, where there is another way.

    Attributes
    ----------
    states : States
        The best motion so far, None before there is one.
    error : float
        Its estimated error [m].
    failure : Exception
        Why there is no way on, None if there is one.
    name, steps
        The integrator, and the steps of the best motion.
    running : RunStats
        Counts of the last run.
    """

    def __init__(
        self,
        system: System,
        t: Vector,
        accuracy: float,
        integrator: Implicit,
        solver: Method | str,
        max_energy_gain: float,
        threads: int,
        discontinuities: LoadDiscontinuities,
        watch: Callable[[SampledStates], None],
        force_cost: float = 0.0,
    ) -> None:
        self._system, self._t, self._accuracy = system, t, accuracy
        self._integrator, self._threads = integrator, threads
        self._max_energy_gain = max_energy_gain
        self._discontinuities, self._watch = discontinuities, watch
        # The estimate of errors takes the factor for one of the body as it lies.
        method = ModifiedNewton() if isinstance(solver, str) else solver
        if isinstance(method, ModifiedNewton | QuasiNewton):
            method = replace(method, seed_frame="fixed")
        self._solver = method
        size = float(np.max(np.abs(system.q0)))
        self._aim = max(accuracy, COARSE * size)  # error of the first run intended [m]
        self._local = FIRST * self._aim * math.sqrt(self._aim / size)
        self._pattern: Pattern = []
        self._base = 0  # steps of the first run
        self._runs: list[tuple[float, SampledStates]] = []
        self._mixed: tuple[SampledStates, float] | None = None
        self._attempts, self._convergence = 0, StagnationCheck(accuracy)
        self._mixed_error = math.inf
        # Cost of the first run; of all where there is none.
        self._cost, self._expected = 0.0, LEAST_FORCES * force_cost
        self.states: SampledStates | None = None
        self.error = self._raw = math.inf
        self.failure: Exception | None = None
        self.content: DominantFrequency | None = None
        self.steps, self.running = 0, RunStats()
        self.name = f"{integrator!r} with {describe(self._solver)}"

    def forecast(self) -> float:
        """Return what is yet to be spent until the accuracy is met, as `Price` models it."""
        if self.failure is not None:
            return math.inf
        if not self._runs:
            return self._expected
        if len(self._runs) == 1:
            # No less than if the error fell with the fourth power of the step from now on.
            return 2.0 * self._cost * max(1.0, math.sqrt(math.sqrt(self._aim / self._accuracy)))
        total, by = 0.0, self._runs[-1][0]
        wanted = self._wanted()
        while by < wanted:
            by = self._following(by, wanted)
            total += by * self._cost
        return total

    def receive(self, content: DominantFrequency | None, states: SampledStates | None) -> None:
        """Take what another way has found: nothing that is used here."""

    def warn(self) -> None:
        """Warn of nothing: steps are as short as the error needs wherever it arises."""

    def advance(self, budget: float) -> None:
        """Make the next run, if another way would cost so much; end a first one that is dear."""
        if not self._runs:
            share = PILOT * min(1.0, NEAR * self._accuracy / self._aim) ** (1.0 / 3.0)
            self._first(max(share, LEAST_PILOT) * budget, budget)
            return
        last, wanted = self._runs[-1][0], 2.0 if len(self._runs) == 1 else self._wanted()
        by = 2 if len(self._runs) == 1 else self._following(last, wanted)
        pattern = divided(self._pattern, by)
        left = min(ITERATION_SHARE * self._local / by**3, self._left(by * self._base))
        stepper = self._stepper(pattern=pattern, left=left)
        try:
            self._take(by, stepper.run())
        except (EnergyIncreaseError, StepError) as stop:
            self._restart(stop, stepper)
        self.steps = stepper.stats.steps

    def _left(self, steps: int) -> float:
        """Return what the iteration of a step may leave, of so many [m]."""
        return ITERATIONS_SHARE * self._accuracy / steps * math.sqrt(min(1.0, FEW / steps))

    def _kept(self, error: float) -> float:
        """Return what the iteration of a step may leave, over the square of the step [m/s^2].

        Elastic forces bound what it does.  A rigid body keeps the velocity that it gets, 2 l / h
        where l is left; if every step leaves k h^2 in one direction, it moves by k t^2.
        """
        if len(self._system.scene.beams) == len(self._system.scene.bodies):
            return math.inf
        return ITERATIONS_SHARE * error / float(self._t[-1] - self._t[0]) ** 2

    def _first(self, budget: float, others: float) -> None:
        stepper = self._stepper(budget=budget)
        try:
            states = stepper.run()
        except OverBudget:
            self._expected = DEARER * others
        except (EnergyIncreaseError, StepError) as stop:
            self._restart(stop, stepper)
        else:
            self._pattern, self._base = stepper.pattern, stepper.stats.steps
            self._cost = stepper.cost_model.of_run(stepper.stats)
            self._runs, self.states, self.steps = [(1, states)], states, self._base

    def _restart(self, stop: StepError, stepper: StepSizeController) -> None:
        """Let the first run be one of shorter steps, or give up."""
        self._count_attempt(stop, stepper)
        if self._attempts == MOST_ATTEMPTS or (
            not isinstance(stop, EnergyIncreaseError) and not self._runs
        ):
            self.failure = stop
        self._local /= SHORTER
        self._runs, self._mixed = [], None

    def _count_attempt(self, stop: StepError, stepper: StepSizeController) -> None:
        """Count a run that did not complete, and list why."""
        self._attempts += 1
        cause = (
            CAUSE_NAMES[Outcome.GAINED_ENERGY]
            if isinstance(stop, EnergyIncreaseError)
            else "failed"
        )
        stepper.note([Event(stop.step, stop.time, "shorter steps", cause, math.nan)])

    def _stepper(self, **options: object) -> StepSizeController:
        local = self._local
        error = self._accuracy if "pattern" in options else self._aim
        stepper = StepSizeController(
            self._system,
            self._integrator,
            self._solver,
            local,
            first_step(self._system, float(self._t[-1] - self._t[0]), local),
            self._t,
            self._max_energy_gain,
            self._threads,
            discontinuities=self._discontinuities,
            watch=self._watch,
            kept=self._kept(error),
            **options,  # type: ignore[arg-type]
        )
        self.running = stepper.stats
        return stepper

    def _take(self, by: float, states: SampledStates) -> None:
        """Estimate the error of the last run, and of what it is together with the one before."""
        before, coarse = self._runs[-1]
        apart = max(distance(self._system, states, coarse), np.finfo(float).tiny)
        plain = self._raw = apart / ((by / before) ** 2 - 1.0)
        self.content = self._content(apart, states, coarse, before, by)
        mixed = states.extrapolated(coarse, 1.0 / ((by / before) ** 2 - 1.0))
        self._mixed_error = math.inf
        if self._mixed is None:
            plain *= UNSEEN
        else:
            earlier, parted = self._mixed
            first = self._runs[0][0]
            expected = (first**-2 - before**-2) / (before**-2 - by**-2)
            near = distance(self._system, mixed, earlier)
            # What is taken off brings motions closer together, or it is not their error.
            regular = 1.0 / REGULAR < parted / apart / expected < REGULAR and near < apart
            left = self._content(near, mixed, earlier, before, by)
            self._power = BELIEVED if regular and left.phase_error < RESOLVED else UNRESOLVED
            share = max(1.0 / ((by / first) ** self._power - 1.0), LEAST_LEFT)
            if left.phase_error > 1.0:  # they may be as far from the motion as from each other
                share = 1.0
            self._mixed_error = near * share if regular else near
            plain += HALF * near * share
        # The finer run has lost that share of waves, which are about the distance where the coarser
        # one has lost them whole.
        plain = max(plain, min(1.0, self.content.phase_error) * apart)
        error, best = min((plain, 0), (self._mixed_error, 1))
        error = max(error, self._unseen(apart, before, by))
        still = self._mixed is not None and MIN_DECREASE * self._mixed[1] < apart
        self.failure = self._convergence.add(error, still)
        self._mixed = (mixed, apart)
        self.error, self.states = error, (states, mixed)[best]
        self._runs = [(before, coarse), (by, states)]

    def _unseen(self, apart: float, coarse: float, fine: float) -> float:
        """Return what two runs are both off, so that their distance does not show it [m]."""
        return 0.0

    def _content(
        self, apart: float, one: SampledStates, other: SampledStates, coarse: float, fine: float
    ) -> DominantFrequency:
        length = float(self._t[-1] - self._t[0])
        omega = difference_frequency(self._system, one, other)
        z = omega * length / self._base
        lost = [trapezoidal_phase_error(z / by) for by in (coarse, fine)]
        return DominantFrequency.of(apart, omega, length, *lost)

    def _wanted(self) -> float:
        """Return the number by which steps of the first run must be divided."""
        by = self._runs[-1][0]
        plain = by * math.sqrt(self._raw / (SAFETY * self._accuracy))
        if self._mixed_error < math.inf:
            share = self._mixed_error / (SAFETY * self._accuracy)
            return min(plain, by * math.pow(share, 0.5 / self._power))
        # What remains after the second power of the step is the more the less waves are resolved.
        assert self.content is not None
        z = self.content.omega * float(self._t[-1] - self._t[0]) / (self._base * by)
        mixed = by * math.sqrt(math.sqrt(self._raw * z**2 / (SAFETY * self._accuracy)))
        return plain if plain < WORTH * mixed else max(mixed, ONCE_MORE * by)

    def _following(self, by: float, wanted: float) -> int:
        if self._convergence.stuck:
            return math.ceil(STRIDE * by)
        return math.ceil(min(max(wanted, LEAST * by), MOST * by))


def first_step(system: System, length: float, local_error: float) -> float:
    """Return a step that is surely short; good ones grow from it.

    It moves no faster point than the root of what a step of the error allowed and of unit rate of
    acceleration would, and is a thousandth of the run [s] at most.
    """
    speed = float(np.max(np.abs(system.v0)))
    step = 1e-3 * length
    if speed > 0.0:
        step = min(step, np.cbrt(local_error / speed))
    return float(min(step, np.cbrt(local_error)))
