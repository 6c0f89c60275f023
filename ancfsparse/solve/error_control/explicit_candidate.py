"""Explicit candidate of an error-controlled run: integrator, steps, and error estimate."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import AccuracyError, InputError, Parameter
from ancfsparse.integrators.explicit.explicit_methods import Explicit
from ancfsparse.integrators.interface.time_grid import MAX_STEPS
from ancfsparse.results import RunStats
from ancfsparse.solve.error_control.explicit_error_estimate import ExplicitErrors
from ancfsparse.solve.error_control.explicit_integration import ExplicitIntegration
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.error_models.modal_error_model import ModalSpectrum
from ancfsparse.solve.error_models.phase_error import (
    DominantFrequency,
    difference_frequency,
    phase_error,
)
from ancfsparse.solve.error_models.stagnation import StagnationCheck
from ancfsparse.solve.stepping.sampled_states import SampledStates, differs_by_rounding, distance
from ancfsparse.system import System

# Steps of the first run over those of the second, by order: the cheapest ratio with an estimate.
FIRST_STEP_RATIOS = {2: 1.35, 4: 1.3, 8: 1.25}
MIN_STEP_RATIO = 1.1  # the same for later runs
MAX_STEP_RATIO = 2.2  # the same
MAX_STAGNANT_RATIO = 1.5  # the same while errors stagnate
MAX_PREDICTED_RATIO = 1.5  # the same where the error is predicted
LOW_ORDER_RATIO = 10.0  # error expected from the motion over that of the lowest order
SAFETY_FACTOR = 0.7  # predicted error of a run over the accuracy
SETUP_FORCES = 100.0  # evaluations of forces that cost as much as the set-up
CHEAP_SETUP_RATIO = 0.05  # cost of the set-up over all cost, below which it does not matter
STEP_RESOLUTION = 1.05  # resolution of step ratios
# A run of lower order may confirm the first one; its own error is then as large as the accuracy.
CONFIRMATION_RATIO = 0.6  # predicted error of the first run over the accuracy
# A long run with a large error that seems to grow from rounding is repeated with slightly shorter
# steps.  If it were the error of steps, both would differ by about the order times a thousandth of
# the error, far less than the limit.
MIN_DOUBTFUL_STEPS = 10_000  # steps
MIN_DOUBTFUL_ERROR = 10.0  # error over the accuracy
REPETITION_RATIO = 1.001  # step over the repeated step
MAX_REPETITION_DIFFERENCE = 0.05  # difference over the error


class ExplicitCandidate:
    """Explicit candidate of an error-controlled run.

    Parameters
    ----------
    system, t, accuracy, max_energy_gain
        As in `solve_accurately`.
    integrators : list of Explicit
        Possible integrators, by ascending order.
    discontinuities : LoadDiscontinuities
        Discontinuities of the loads.
    watch : callable
        Called with the states of a run whenever more are known.
    spectrum : ModalSpectrum or None
        Vibrations of the motion, if they are known.

    Attributes
    ----------
    states : SampledStates
        The best motion so far, None before the first.
    error : float
        Its estimated error [m].
    failure : Exception
        Reason why no further run is possible, if any.
    force_cost : float
        Modelled cost of an evaluation of the forces.
    name, steps
        Integrator and steps of the best motion.
    last_stats : RunStats
        Statistics of the last run.
    """

    def __init__(
        self,
        system: System,
        t: Vector,
        accuracy: float,
        integrators: list[Explicit],
        max_energy_gain: float,
        discontinuities: LoadDiscontinuities,
        watch: Callable[[SampledStates], None],
        spectrum: ModalSpectrum | None,
    ) -> None:
        self._system, self._t_end, self._length = system, float(t[-1]), float(t[-1] - t[0])
        self._spectrum, self._convergence = spectrum, StagnationCheck(accuracy)
        self._accuracy, self._integrators = accuracy, integrators
        self._integration = ExplicitIntegration(
            system, t, max_energy_gain, discontinuities, watch, integrators[-1]
        )
        self._errors = ExplicitErrors(system, self._length, self._integration, spectrum)
        self.force_cost = self._integration.force_cost
        # Integrators and step ratios of the runs, the best last.
        self._completed: list[tuple[Explicit, float]] = []
        self._low_order_suffices = False
        self._other: SampledStates | None = None  # the best motion of another candidate
        # Whether the next run tests for rounding; None while nothing points to it.
        self._rounding: bool | None = None
        self.states: SampledStates | None = None
        self.error = math.inf
        self.failure: Exception | None = None
        self.name = repr(integrators[len(integrators) // 2])
        self.steps, self.last_stats = 0, RunStats()

    def predicted_cost(self) -> float:
        """Return the predicted cost until the accuracy is met, by `CostModel`."""
        if self.failure is not None:
            return math.inf
        cost = self._plan()[2]
        if cost > MAX_STEPS * self.force_cost:
            self.failure = InputError(
                "a run to {end} by {name} would take more than {most:.0e} evaluations of the "
                "forces: use a shorter time",
                end=Parameter("t_end", f"{self._t_end:g} s"),
                name=self.name,
                most=MAX_STEPS,
            )
            return math.inf
        if not self._integration.is_set_up and (
            self._spectrum is not None or SETUP_FORCES * self.force_cost < CHEAP_SETUP_RATIO * cost
        ):
            self._integration.set_up()
            return self._plan()[2]
        return cost

    def warn(self) -> None:
        """Warn of singular configurations, where the error estimates are uncertain."""
        self._integration.rank_deficiency.warn()

    @property
    def dominant(self) -> DominantFrequency | None:
        """Vibration that causes the difference of two runs; None while it is not known."""
        return self._errors.dominant

    def receive(self, content: DominantFrequency | None, states: SampledStates | None) -> None:
        """Take the dominant vibration and the best motion of another candidate."""
        if self._errors.dominant is None:
            self._errors.dominant = content
        self._other = states

    def advance(self, budget: float) -> None:
        """Make the next run, unless the set-up shows that it costs more than the budget."""
        self.last_stats = RunStats(runs=0)
        if not self._integration.is_set_up:
            self._integration.set_up()
            if self.predicted_cost() > budget:
                return
        integrator, ratio, _ = self._plan()
        self.last_stats = RunStats()
        before = self._integration.step(integrator, 1.0)
        states = self._integration.run(integrator, ratio, self.last_stats)
        if states is None:
            self.failure = self._integration.failure
            # Step ratios refer to the stable step, which is shorter now.
            shorter = self._integration.step(integrator, 1.0) / before
            self._completed = [(other, shorter * ratio) for other, ratio in self._completed]
            self._errors.shorten(shorter)
            return
        if self._rounding and self.states is not None:
            self._rounding, difference = False, distance(self._system, self.states, states)
            if difference > max(MAX_REPETITION_DIFFERENCE * self.error, self._accuracy):
                self.failure = AccuracyError(self._accuracy, self.error, len(self._completed) + 1)
            return
        last = self.states
        self._add_run(integrator, ratio, states)
        if self.error < math.inf:
            self.failure = self._convergence.add(self.error)
        is_doubtful = (
            self.steps > MIN_DOUBTFUL_STEPS and self.error > MIN_DOUBTFUL_ERROR * self._accuracy
        )
        if self._rounding is None and last is not None and is_doubtful:
            grew = differs_by_rounding(self._system, last, states, self.steps)
            self._rounding = True if grew else None
        if self._other is not None and self.states is not None:
            # Two candidates have no error in common.
            self.error = min(self.error, distance(self._system, self.states, self._other))

    def _plan(self) -> tuple[Explicit, float, float]:
        """Return integrator and step ratio of the next run, and the cost of all runs from it on."""
        if not self._errors.may_predict:
            # Without information: order 4 if possible, then a second run for comparison.
            default = self._integrators[len(self._integrators) // 2]
            min_ratio = FIRST_STEP_RATIOS[default.tableau.order]
            if self._completed:
                second = (default, min_ratio)
                if self._low_order_suffices:
                    second = (self._integrators[0], 1.0)
                return *second, self._integration.cost(*second)
            both = self._integration.cost(default, 1.0) + self._integration.cost(default, min_ratio)
            return default, 1.0, both
        plans = [self._plan_with(other) for other in self._integrators] + self._confirming()
        plan = min(plans, key=lambda plan: plan[2])
        if self._rounding:
            integrator, ratio = self._completed[-1]
            repetition = integrator, REPETITION_RATIO * ratio
            return *repetition, self._integration.cost(*repetition) + plan[2]
        return plan

    def _confirming(self) -> list[tuple[Explicit, float, float]]:
        """Return plans to confirm an accurate first run by one of lower order.

        Its steps need not be shorter than in the first run, and it is cheaper if these are
        stable ones.
        """
        if len(self._completed) != 1:
            return []
        first, ratio = self._completed[0]
        if self._errors.predicted(first, ratio) > CONFIRMATION_RATIO * self._accuracy:
            return []
        lower = [x for x in self._integrators if x.tableau.order < first.tableau.order]
        steps = [self._required_ratio(x, 1.0) for x in lower]
        costs = [self._integration.cost(*pair) for pair in zip(lower, steps, strict=True)]
        return list(zip(lower, steps, costs, strict=True))

    def _plan_with(self, integrator: Explicit) -> tuple[Explicit, float, float]:
        """Return the plan for an integrator by its predicted error."""
        min_ratio = FIRST_STEP_RATIOS[integrator.tableau.order]
        ratios = [ratio for other, ratio in self._completed if other == integrator]
        required, cost = self._required_ratio(integrator), 0.0
        if not ratios:
            decrease = min_ratio if self._spectrum is None else MAX_PREDICTED_RATIO
            first = max(1.0, required / decrease)
            second = max(min_ratio * first, required)
            both = sum(self._integration.cost(integrator, ratio) for ratio in (first, second))
            return integrator, first, both
        last = max(ratios)
        min_ratio = self._errors.closest(integrator, min_ratio, MIN_STEP_RATIO)
        max_ratio = MAX_STAGNANT_RATIO if self._convergence.stagnant_runs else MAX_STEP_RATIO
        steps = [min(max(required, min_ratio * last), max_ratio * last)]
        while steps[-1] < required:
            steps.append(min(required, max_ratio * steps[-1]))
        cost = sum(self._integration.cost(integrator, ratio) for ratio in steps)
        return integrator, steps[0], cost

    def _required_ratio(self, integrator: Explicit, error_ratio: float = SAFETY_FACTOR) -> float:
        """Return the step ratio at which the predicted error meets a part of the accuracy."""
        ratio, error = 1.0, error_ratio * self._accuracy
        while ratio < 1e6 and self._errors.predicted(integrator, ratio) > error:
            ratio *= STEP_RESOLUTION
        return ratio

    def _add_run(self, integrator: Explicit, ratio: float, states: SampledStates) -> None:
        """Estimate the error of a run, and store it unless its order is lower than the last."""
        error = self._errors.add(integrator, ratio, states)
        if self.states is None:
            self._low_order_suffices = self._does_low_order_suffice(states)
        elif integrator.tableau.order < self._completed[-1][0].tableau.order:
            self._completed.insert(0, (integrator, ratio))
            self.error = error
            return
        self.states, self.error = states, error
        self.name, self.steps = repr(integrator), self.last_stats.steps
        self._completed.append((integrator, ratio))

    def _does_low_order_suffice(self, states: SampledStates) -> bool:
        """Return True if the method of lowest order would do, judged by the motion as a whole."""
        if len(self._integrators) == 1:
            return False
        start = np.broadcast_to(states.q[:1], states.q.shape)
        at_rest = replace(states, q=start, v=np.zeros_like(states.v))
        amplitude = distance(self._system, states, at_rest)
        omega = difference_frequency(self._system, states, at_rest)
        first = self._integrators[0]
        phase = phase_error(first.tableau, omega * self._integration.step(first, 1.0))
        return LOW_ORDER_RATIO * amplitude * phase * omega * self._length < self._accuracy
