"""Implicit candidate of an error-controlled run: runs with steps in one ratio.

Their errors are in a fixed ratio as well: the error follows from their difference and can be
subtracted (Richardson).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ancfsparse.errors import EnergyIncreaseError, StepError
from ancfsparse.integrators import Implicit
from ancfsparse.nonlinear import Method, ModifiedNewton, Outcome, QuasiNewton
from ancfsparse.nonlinear.iteration import describe
from ancfsparse.results import Event, RunStats
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.error_control.motion_task import MotionTask
from ancfsparse.solve.error_control.step_size_controller import (
    BudgetExceeded,
    Pattern,
    StepSizeController,
)
from ancfsparse.solve.error_control.step_sources import DividedSteps, EqualSteps
from ancfsparse.solve.error_models.modal_spectrum import MIN_SCALE, ModalSpectrum, Scheme
from ancfsparse.solve.error_models.run_differences import (
    assumed_order,
    difference_frequency,
    remaining_error,
)
from ancfsparse.solve.error_models.stagnation import MIN_DECREASE, StagnationCheck
from ancfsparse.solve.error_models.step_count_selection import (
    ASSUMED_ORDER,
    EXTRA_STEPS,
    StepPlan,
    min_steps,
)
from ancfsparse.solve.stepping.implicit_setup import iteration_costs
from ancfsparse.solve.stepping.outcome_reporting import CAUSE_NAMES
from ancfsparse.solve.stepping.sampled_states import SampledStates, distance

# An error d of a position by the iteration in a step h causes 2 d / h of its velocity.  If every
# step has an error k h^2 of one sign, as of rotating rigid bodies, an unconstrained motion is off
# by k t^2 after a time t, whatever its steps are.  In soft beams signs vary, and 0.5 caused at most
# 0.06 in 160 random scenes.  With one d for steps of all lengths it was up to 5.2.
ITERATIONS_RATIO = 0.03  # error of positions by all iterations over the accuracy
ELASTIC_ITERATIONS_RATIO = 0.5  # the same where all bodies are elastic, if all signs were equal
# A first run whose steps are controlled may cost this part of the predicted cost of another
# candidate, and less the farther its error is from the accuracy: otherwise a free top that rotates
# for 10 s takes 1200 implicit steps before 370 explicit ones.  It is tried again when the other has
# become dearer by its inverse.
FIRST_COST_RATIO = 0.4
# Steps over the steps of the last run if errors stagnate: with half as many, runs of an arm with a
# beam in axial vibration ended without the accuracy.
STAGNANT_STEP_RATIO = 3.0
MAX_ATTEMPTS = 6  # runs that gain energy or cannot be solved
MAX_IRREGULARITY = 1.5  # differences over those of second order, up to which extrapolation is valid


class ImplicitCandidate:
    """Implicit candidate of an error-controlled run.

    Parameters
    ----------
    task : MotionTask
        The motion.
    integrator, solver, threads
        As in `simulate`.
    force_cost : float, optional
        Modelled cost of an evaluation of the forces, if there is another candidate.

    Attributes
    ----------
    states, error, failure, name, steps, last_stats
        As of `ExplicitCandidate`.
    dominant : ModalSpectrum or None
        Vibration that causes the difference of two runs; None while it is not known.
    """

    def __init__(
        self,
        task: MotionTask,
        integrator: Implicit,
        solver: Method | str,
        threads: int,
        force_cost: float = 0.0,
    ) -> None:
        self._task, self._integrator, self._threads = task, integrator, threads
        # The error estimate takes the factor for one in fixed directions.
        method = ModifiedNewton() if isinstance(solver, str) else solver
        if isinstance(method, ModifiedNewton | QuasiNewton):
            method = replace(method, seed_frame="fixed")
        self._solver = method
        self._source = self._step_source(force_cost)
        self._step_cost, self._min_cost = 0.0, 0.0
        self._runs: list[tuple[int, SampledStates]] = []  # the last two, by their steps
        self._extrapolated: tuple[SampledStates, float] | None = None
        self._attempts, self._convergence = 0, StagnationCheck(task.accuracy)
        # Error over the predicted one, and after extrapolation in addition.
        self._scale, self._excess = 1.0, 1.0
        self.states: SampledStates | None = None
        self.error = math.inf
        self.failure: Exception | None = None
        self.dominant: ModalSpectrum | None = None
        self.steps, self.last_stats = 0, RunStats()
        self.name = f"{integrator!r} with {describe(self._solver)}"

    def _step_source(self, force_cost: float) -> EqualSteps | DividedSteps:
        """Return equal steps if vibrations are known, and loads do not require short steps."""
        task, system = self._task, self._task.system
        if task.spectrum is None:
            return DividedSteps(task, self._integrator, force_cost)
        steps = min_steps(task.discontinuities, task.length)
        if steps == math.inf:
            return DividedSteps(task, self._integrator, force_cost)
        pattern = system.pattern
        seed = SparseSeed(pattern.indptr, pattern.indices, system.n_free, self._threads)
        plan = StepPlan(task.spectrum, self._integrator, task.length, steps)
        return EqualSteps(task, plan, iteration_costs(system, self._integrator, seed, None))

    def predicted_cost(self) -> float:
        """Return the predicted cost until the accuracy is met, in the unit of `Costs`."""
        if self.failure is not None:
            return math.inf
        return (
            self._plan()[1] * self._step_cost
            if self._runs
            else max(self._source.first_cost, self._min_cost)
        )

    def receive(self, dominant: ModalSpectrum | None, states: SampledStates | None) -> None:
        """Ignore the results of another candidate."""

    def warn(self) -> None:
        """Do nothing: steps are adapted to the error at singular configurations."""

    def advance(self, budget: float) -> None:
        """Make the next run; end a first one that costs too much compared with the budget."""
        steps, last = (self._plan()[0], self._runs[-1][0]) if self._runs else (0, 0)
        pattern = self._source.pattern(steps, last)
        limit = math.inf
        if pattern is None:
            nearness = (self._task.accuracy / self._source.first_error) ** (1.0 / 6.0)
            limit = FIRST_COST_RATIO * nearness * budget
        controller = self._controller(pattern, limit)
        try:
            states = controller.run()
        except BudgetExceeded:
            self._min_cost = budget / FIRST_COST_RATIO
            return
        except (EnergyIncreaseError, StepError) as stop:
            self._restart(stop, controller, pattern)
            return
        finally:
            self.steps = n = controller.stats.steps
        self._step_cost = controller.cost() / (n + EXTRA_STEPS)
        if self._runs:
            self._add_run(n, states)
        else:
            self._source.begin(controller.pattern)
            self._runs, self.states = [(n, states)], states

    def _plan(self) -> tuple[int, float]:
        """Return the steps of the next run, and the cost of all that follow in steps."""
        accuracy, runs = self._task.accuracy, [steps for steps, _ in self._runs]
        plan = self._source.plan(self.dominant)
        if plan is not None:
            steps, total = plan.next(runs, accuracy / self._scale, self._excess)
            if self._convergence.stagnant_runs:
                steps = max(steps, round(STAGNANT_STEP_RATIO * runs[-1]))
            return steps, max(total, steps)
        # At least as if the error decreased with the fourth power of the step from now on.
        decrease = math.sqrt(math.sqrt(self._source.first_error / accuracy))
        return 2 * runs[0], 2.0 * runs[0] * max(1.0, decrease)

    def _restart(
        self, stop: StepError, controller: StepSizeController, pattern: Pattern | None
    ) -> None:
        """Plan shorter steps after a run that did not complete, or fail."""
        gained = isinstance(stop, EnergyIncreaseError)
        cause = CAUSE_NAMES[Outcome.GAINED_ENERGY] if gained else "failed"
        controller.note([Event(stop.step, stop.time, "shorter steps", cause, math.nan)])
        self._attempts += 1
        if self._attempts == MAX_ATTEMPTS or (pattern is None and not gained):
            self.failure = stop
        n = 0 if pattern is None else sum(steps for rows in pattern for _, steps in rows)
        if not self._source.shorten(n):
            self._runs, self._extrapolated, self.dominant = [], None, None

    def _controller(self, pattern: Pattern | None, budget: float = math.inf) -> StepSizeController:
        """Return a run with given steps, or with the allowed error of a step."""
        task, local_error = self._task, self._source.local_error
        scene = task.system.scene
        is_elastic = len(scene.beams) == len(scene.bodies)
        ratio = ELASTIC_ITERATIONS_RATIO if is_elastic else ITERATIONS_RATIO
        # All steps of a run together cause a fraction of its error.
        error = ratio * (self._source.first_error if pattern is None else task.accuracy)
        controller = StepSizeController(
            task.system,
            self._integrator,
            self._solver,
            local_error,
            first_step(task, local_error),
            task.t,
            task.max_energy_gain,
            self._threads,
            discontinuities=task.discontinuities,
            watch=task.watch,
            pattern=pattern,
            iteration_error_rate=error / task.length**2,
            budget=budget,
        )
        self.last_stats = controller.stats
        return controller

    def _add_run(self, n: int, states: SampledStates) -> None:
        """Estimate the error of the last run, and of its extrapolation with the one before."""
        before, coarse = self._runs[-1]
        difference = self._distance(states, coarse)
        second_order = 1.0 / ((n / before) ** 2 - 1.0)
        plain = difference * second_order
        self.dominant = self._dominant(difference, states, coarse, before, n)
        extrapolated, best = states.extrapolated(coarse, second_order), states
        # The finer run has this phase error of waves, whose amplitude is about the difference if
        # the coarser run has lost them.
        phase = float(self.dominant.phase_errors(self._scheme(n))[0])
        order = assumed_order(self._integrator.order, phase)
        error, is_stagnant = difference * remaining_error(n / before, order, 0.0), False
        extrapolated_error, lost = math.inf, min(1.0, phase) * difference
        if self._extrapolated is not None:
            earlier, last_difference = self._extrapolated
            first = self._runs[0][0]
            near = self._distance(extrapolated, earlier)
            # Extrapolation reduces the difference, or it has not removed the error.
            expected = (first**-2 - before**-2) / (before**-2 - n**-2)
            ratio = last_difference / difference / expected
            is_regular = 1.0 / MAX_IRREGULARITY < ratio < MAX_IRREGULARITY and near < difference
            content = self._dominant(near, extrapolated, earlier, before, n)
            phase = float(content.phase_errors(self._scheme(n))[0])
            remaining = remaining_error(n / first, ASSUMED_ORDER)
            # Of waves at a frequency w the remaining part is the phase error, up to 1, which grows
            # with w^3.  By their velocity v they differ by v / w, so none remains by more than at
            # the frequency of phase error 1.
            remaining = max(remaining, min(1.0, math.cbrt(phase)))
            extrapolated_error = near * remaining if is_regular else near
            error = plain + near * remaining
            is_stagnant = MIN_DECREASE * last_difference < difference
        error = max(error, lost)
        if extrapolated_error < error:
            error, best = extrapolated_error, extrapolated
        pair = self._scheme(before), self._scheme(n)
        if self._task.spectrum is not None and isinstance(self._source, EqualSteps):
            error = max(error, self._task.spectrum.common_error(*pair))
        plan = self._source.plan(self.dominant)
        assert plan is not None
        self._scale = max(plan.spectrum.scale(difference, *pair), MIN_SCALE)
        if extrapolated_error < math.inf:
            predicted = self._scale * plan.spectrum.extrapolated_error(*pair)
            self._excess = max(1.0, extrapolated_error / max(predicted, np.finfo(float).tiny))
        self.failure = self._convergence.add(error, is_stagnant)
        self._extrapolated = (extrapolated, difference)
        self.error, self.states = error, best
        self._runs = [(before, coarse), (n, states)]

    def _dominant(
        self, difference: float, one: SampledStates, other: SampledStates, coarse: int, fine: int
    ) -> ModalSpectrum:
        omega = difference_frequency(self._task.system, one, other)
        pair = self._scheme(coarse), self._scheme(fine)
        return ModalSpectrum.of_difference(difference, omega, self._task.length, *pair)

    def _scheme(self, steps: int) -> Scheme:
        return self._integrator, self._task.length / steps

    def _distance(self, one: SampledStates, other: SampledStates) -> float:
        return max(distance(self._task.system, one, other), np.finfo(float).tiny)


def first_step(task: MotionTask, local_error: float) -> float:
    """Return a first step that is certainly short; steps grow from it.

    At most a thousandth of the run, and so short that the allowed error bounds the displacement by
    the velocity and by a unit rate of acceleration [s].
    """
    speed = max(float(np.max(np.abs(task.system.v0))), np.finfo(float).tiny)
    return float(min(1e-3 * task.length, np.cbrt(local_error / speed), np.cbrt(local_error)))
