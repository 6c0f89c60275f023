"""Implicit candidate of an error-controlled run: a controlled first run, and its divided steps.

Runs whose steps are those of another, each divided by one whole number, have errors in a fixed
ratio: the error follows from their difference and can be subtracted (Richardson).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import EnergyIncreaseError, StepError
from ancfsparse.integrators import Implicit
from ancfsparse.nonlinear import Method, ModifiedNewton, Outcome, QuasiNewton
from ancfsparse.nonlinear.iteration import describe
from ancfsparse.results import Event, RunStats
from ancfsparse.solve.error_control.step_size_controller import (
    ITERATION_RATIO,
    BudgetExceeded,
    Pattern,
    StepSizeController,
    divide_steps,
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

# A coarse first run is cheap, and shows the cost of finer ones with its divided steps.
FIRST_ERROR_RATIO = 2e-3  # intended error of the first run over the size of the scene
# Steps with an error A in total have A / N each, and their number N grows with the root of 1 / A.
FIRST_LOCAL_RATIO = 0.5  # local error over the error of the run and the root of its relative error
MIN_STEP_RATIO = 1.8  # steps over those of the last run, below which the difference is mostly noise
MAX_STEP_RATIO = 5.0  # the same, above which the order has not been observed
MIN_GAIN_RATIO = 1.5  # ratio of steps below which no run is made for extrapolation alone
MIN_EXTRA_RATIO = 2.5  # steps of such a run over the last run
SAFETY_FACTOR = 0.5  # error for which the next run is planned, over the accuracy
SECOND_RUN_FACTOR = 1.5  # assumed error of the second run over the estimate by its difference
STAGNANT_STEP_RATIO = 3.0  # steps over the steps of the last run if errors stagnate
# An error d of a position by the iteration in a step h causes 2 d / h of its velocity.  If every
# step has an error k h^2 of one sign, as of rotating rigid bodies, an unconstrained motion is off
# by k t^2 after a time t, whatever its steps are.  In soft beams signs vary, and 0.5 caused at most
# 0.06 in 160 random scenes.  With one d for steps of all lengths it was up to 5.2.
ITERATIONS_RATIO = 0.03  # error of positions by all iterations over the accuracy
ELASTIC_ITERATIONS_RATIO = 0.5  # the same where all bodies are elastic, if all signs were equal
MAX_ATTEMPTS = 6  # runs that gain energy or cannot be solved
RESTART_ERROR_RATIO = 27.0  # local error over the one of a restart, for steps a third as long
# The first run may cost a part of another candidate, depending on its error.  A dearer one is tried
# again when the other has become dearer.
FIRST_COST_RATIO = 0.4  # cost over the cost of the other candidate
MIN_FIRST_COST_RATIO = 0.1  # the same
COST_GROWTH = 3.0  # growth of the cost of the other candidate
NEAR_ERROR_RATIO = 10.0  # error of the first run over the accuracy, up to which it is near
MIN_FORCES = 900.0  # evaluations of forces that the first steps of any run cost
ASSUMED_ORDER = 1.25  # assumed order of the error after extrapolation, if all of it is resolved
UNRESOLVED_ORDER = 0.75  # the same if not
MIN_REMAINING = 1.0 / 12.0  # remaining error over the difference of two runs
EXTRAPOLATION_WEIGHT = 0.5  # weight of that in addition to the error of second order
RESOLVED_PHASE = 0.1  # phase error of resolved vibrations [rad]
MAX_IRREGULARITY = 1.5  # differences over those of second order, up to which extrapolation is valid


class ImplicitCandidate:
    """Implicit candidate of an error-controlled run.

    Parameters
    ----------
    system, t, accuracy, integrator, solver, max_energy_gain, threads
        As in `solve_accurately`.
    discontinuities : LoadDiscontinuities
        Discontinuities of the loads.
    watch : callable
        Called with the states of a run whenever more are known.
    force_cost : float, optional
        Modelled cost of an evaluation of the forces, if there is another candidate.

    Attributes
    ----------
    states : SampledStates
        The best motion so far, None before the first.
    error : float
        Its estimated error [m].
    failure : Exception
        Reason why no further run is possible, if any.
    name, steps
        Integrator, and steps of the best motion.
    last_stats : RunStats
        Statistics of the last run.
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
        # The error estimate takes the factor for one in fixed directions.
        method = ModifiedNewton() if isinstance(solver, str) else solver
        if isinstance(method, ModifiedNewton | QuasiNewton):
            method = replace(method, seed_frame="fixed")
        self._solver = method
        size = float(np.max(np.abs(system.q0)))
        error = max(accuracy, FIRST_ERROR_RATIO * size)
        self._first_error = error  # intended for the first run [m]
        self._local_error = FIRST_LOCAL_RATIO * error * math.sqrt(error / size)
        self._pattern: Pattern = []
        self._base = 0  # steps of the first run
        self._runs: list[tuple[float, SampledStates]] = []
        self._extrapolated: tuple[SampledStates, float] | None = None
        self._attempts, self._convergence = 0, StagnationCheck(accuracy)
        self._extrapolated_error = math.inf
        # Cost of the first run, and of all before it.
        self._cost, self._expected = 0.0, MIN_FORCES * force_cost
        self.states: SampledStates | None = None
        self.error = self._plain_error = math.inf
        self.failure: Exception | None = None
        self.dominant: DominantFrequency | None = None
        self.steps, self.last_stats = 0, RunStats()
        self.name = f"{integrator!r} with {describe(self._solver)}"

    def predicted_cost(self) -> float:
        """Return the predicted cost until the accuracy is met, by `CostModel`."""
        if self.failure is not None:
            return math.inf
        if not self._runs:
            return self._expected
        if len(self._runs) == 1:
            # At least as if the error decreased with the fourth power of the step from now on.
            decrease = math.sqrt(math.sqrt(self._first_error / self._accuracy))
            return 2.0 * self._cost * max(1.0, decrease)
        total, divisor = 0.0, self._runs[-1][0]
        required = self._required_divisor()
        while divisor < required:
            divisor = self._next_divisor(divisor, required)
            total += divisor * self._cost
        return total

    def receive(self, content: DominantFrequency | None, states: SampledStates | None) -> None:
        """Ignore the results of another candidate."""

    def warn(self) -> None:
        """Do nothing: steps are adapted to the error at singular configurations."""

    def advance(self, budget: float) -> None:
        """Make the next run; end a first one that costs too much compared with the budget."""
        if not self._runs:
            nearness = min(1.0, NEAR_ERROR_RATIO * self._accuracy / self._first_error)
            ratio = FIRST_COST_RATIO * nearness ** (1.0 / 3.0)
            self._first_run(max(ratio, MIN_FIRST_COST_RATIO) * budget, budget)
            return
        divisor = 2
        if len(self._runs) > 1:
            divisor = self._next_divisor(self._runs[-1][0], self._required_divisor())
        pattern = divide_steps(self._pattern, divisor)
        iteration_error = ITERATION_RATIO * self._local_error / divisor**3
        controller = self._controller(pattern=pattern, iteration_error=iteration_error)
        try:
            self._add_run(divisor, controller.run())
        except (EnergyIncreaseError, StepError) as stop:
            self._restart(stop, controller)
        self.steps = controller.stats.steps

    def _iteration_error_rate(self, error: float) -> float:
        """Return the remaining error of the iteration over the square of the step [m/s^2].

        All steps of a run together cause a fraction of its error [m].
        """
        scene = self._system.scene
        is_elastic = len(scene.beams) == len(scene.bodies)
        ratio = ELASTIC_ITERATIONS_RATIO if is_elastic else ITERATIONS_RATIO
        return ratio * error / float(self._t[-1] - self._t[0]) ** 2

    def _first_run(self, budget: float, others: float) -> None:
        controller = self._controller(budget=budget)
        try:
            states = controller.run()
        except BudgetExceeded:
            self._expected = COST_GROWTH * others
        except (EnergyIncreaseError, StepError) as stop:
            self._restart(stop, controller)
        else:
            self._pattern, self._base = controller.pattern, controller.stats.steps
            self._cost = controller.cost_model.of_run(controller.stats)
            self._runs, self.states, self.steps = [(1, states)], states, self._base

    def _restart(self, stop: StepError, controller: StepSizeController) -> None:
        """Restart with a first run of shorter steps, or fail."""
        self._count_attempt(stop, controller)
        if self._attempts == MAX_ATTEMPTS or (
            not isinstance(stop, EnergyIncreaseError) and not self._runs
        ):
            self.failure = stop
        self._local_error /= RESTART_ERROR_RATIO
        self._runs, self._extrapolated = [], None

    def _count_attempt(self, stop: StepError, controller: StepSizeController) -> None:
        """Count and list a run that did not complete."""
        self._attempts += 1
        cause = (
            CAUSE_NAMES[Outcome.GAINED_ENERGY]
            if isinstance(stop, EnergyIncreaseError)
            else "failed"
        )
        controller.note([Event(stop.step, stop.time, "shorter steps", cause, math.nan)])

    def _controller(self, **options: object) -> StepSizeController:
        local = self._local_error
        error = self._accuracy if "pattern" in options else self._first_error
        controller = StepSizeController(
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
            iteration_error_rate=self._iteration_error_rate(error),
            **options,  # type: ignore[arg-type]
        )
        self.last_stats = controller.stats
        return controller

    def _add_run(self, divisor: float, states: SampledStates) -> None:
        """Estimate the error of the last run, and of its extrapolation with the one before."""
        before, coarse = self._runs[-1]
        difference = max(distance(self._system, states, coarse), np.finfo(float).tiny)
        plain = self._plain_error = difference / ((divisor / before) ** 2 - 1.0)
        self.dominant = self._dominant_frequency(difference, states, coarse, before, divisor)
        extrapolated = states.extrapolated(coarse, 1.0 / ((divisor / before) ** 2 - 1.0))
        self._extrapolated_error = math.inf
        if self._extrapolated is None:
            plain *= SECOND_RUN_FACTOR
        else:
            earlier, last_difference = self._extrapolated
            first = self._runs[0][0]
            expected = (first**-2 - before**-2) / (before**-2 - divisor**-2)
            near = distance(self._system, extrapolated, earlier)
            # Extrapolation reduces the difference, or it has not removed the error.
            ratio = last_difference / difference / expected
            is_regular = 1.0 / MAX_IRREGULARITY < ratio < MAX_IRREGULARITY and near < difference
            content = self._dominant_frequency(near, extrapolated, earlier, before, divisor)
            is_resolved = content.phase_error < RESOLVED_PHASE
            self._power = ASSUMED_ORDER if is_regular and is_resolved else UNRESOLVED_ORDER
            remaining = max(1.0 / ((divisor / first) ** self._power - 1.0), MIN_REMAINING)
            # Of waves at a frequency w the remaining part is the phase error, up to 1, which grows
            # with w^3.  By their velocity v they differ by v / w, so none remains by more than at
            # the frequency of phase error 1.
            remaining = max(remaining, min(1.0, math.cbrt(content.phase_error)))
            self._extrapolated_error = near * remaining if is_regular else near
            plain += EXTRAPOLATION_WEIGHT * near * remaining
        # The finer run has this phase error of waves, whose amplitude is about the difference if
        # the coarser run has lost them.
        plain = max(plain, min(1.0, self.dominant.phase_error) * difference)
        error, best = min((plain, 0), (self._extrapolated_error, 1))
        error = max(error, self._common_error(difference, before, divisor))
        is_stagnant = False
        if self._extrapolated is not None:
            is_stagnant = MIN_DECREASE * self._extrapolated[1] < difference
        self.failure = self._convergence.add(error, is_stagnant)
        self._extrapolated = (extrapolated, difference)
        self.error, self.states = error, (states, extrapolated)[best]
        self._runs = [(before, coarse), (divisor, states)]

    def _common_error(self, difference: float, coarse: float, fine: float) -> float:
        """Return the error that two runs have in common [m]."""
        return 0.0

    def _dominant_frequency(
        self,
        difference: float,
        one: SampledStates,
        other: SampledStates,
        coarse: float,
        fine: float,
    ) -> DominantFrequency:
        length = float(self._t[-1] - self._t[0])
        omega = difference_frequency(self._system, one, other)
        z = omega * length / self._base
        errors = [trapezoidal_phase_error(z / divisor) for divisor in (coarse, fine)]
        return DominantFrequency.of(difference, omega, length, *errors)

    def _required_divisor(self) -> float:
        """Return the required divisor of the steps of the first run."""
        divisor = self._runs[-1][0]
        plain = divisor * math.sqrt(self._plain_error / (SAFETY_FACTOR * self._accuracy))
        if self._extrapolated_error < math.inf:
            ratio = self._extrapolated_error / (SAFETY_FACTOR * self._accuracy)
            return min(plain, divisor * math.pow(ratio, 0.5 / self._power))
        # The error after extrapolation is larger the less waves are resolved.
        assert self.dominant is not None
        z = self.dominant.omega * float(self._t[-1] - self._t[0]) / (self._base * divisor)
        ratio = self._plain_error * z**2 / (SAFETY_FACTOR * self._accuracy)
        extrapolated = divisor * math.sqrt(math.sqrt(ratio))
        if plain < MIN_GAIN_RATIO * extrapolated:
            return plain
        return max(extrapolated, MIN_EXTRA_RATIO * divisor)

    def _next_divisor(self, divisor: float, required: float) -> int:
        if self._convergence.stagnant_runs:
            return math.ceil(STAGNANT_STEP_RATIO * divisor)
        return math.ceil(min(max(required, MIN_STEP_RATIO * divisor), MAX_STEP_RATIO * divisor))


def first_step(system: System, length: float, local_error: float) -> float:
    """Return a first step that is certainly short; steps grow from it.

    At most a thousandth of the run, and so short that the allowed error bounds the displacement by
    the velocity and by a unit rate of acceleration [s].
    """
    speed = float(np.max(np.abs(system.v0)))
    step = 1e-3 * length
    if speed > 0.0:
        step = min(step, np.cbrt(local_error / speed))
    return float(min(step, np.cbrt(local_error)))
