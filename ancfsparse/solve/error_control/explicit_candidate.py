"""Explicit candidate of an error-controlled run: integrator, steps, and error estimate."""

from __future__ import annotations

import math

from ancfsparse.errors import AccuracyError, InputError, Parameter
from ancfsparse.integrators.explicit.explicit_methods import Explicit
from ancfsparse.integrators.interface.time_grid import MAX_STEPS
from ancfsparse.results import RunStats
from ancfsparse.solve.error_control.explicit_error_estimate import ExplicitErrors
from ancfsparse.solve.error_control.explicit_integration import ExplicitIntegration
from ancfsparse.solve.error_control.motion_task import MotionTask
from ancfsparse.solve.error_models.modal_spectrum import ModalSpectrum
from ancfsparse.solve.error_models.stagnation import StagnationCheck
from ancfsparse.solve.error_models.step_count_selection import find_smallest
from ancfsparse.solve.stepping.sampled_states import SampledStates, differs_by_rounding, distance

# Steps of a run over those of the next: the cheapest ratio with an error estimate.  A third run is
# compared with two, so the root suffices.
STEP_RATIO = 1.3
# The same for the first run where its error is predicted: it saves 1 % of the work.
PREDICTED_STEP_RATIO = 1.5
MAX_STEP_RATIO = 2.2  # the same, above which the observed order need not hold
SAFETY_FACTOR = 0.7  # predicted error of a run over the accuracy
# A long run with a large error that seems to grow from rounding is repeated with slightly shorter
# steps.  If it were the error of steps, both would differ by about the order times a thousandth of
# the error, far less than the limit.  With such runs only counted as stagnant, a chaotic double
# pendulum takes 4.0 million forces in place of less than 2.
MIN_DOUBTFUL_ERROR = 10.0  # error over the accuracy
REPETITION_RATIO = 1.001  # step over the repeated step
MAX_REPETITION_DIFFERENCE = 0.05  # difference over the error

Plan = tuple[Explicit, float, float]
"""Integrator and step ratio of the next run, and the cost of all runs from it on."""


class ExplicitCandidate:
    """Explicit candidate of an error-controlled run.

    Parameters
    ----------
    task : MotionTask
        The motion.
    integrators : list of Explicit
        Possible integrators, by ascending order.

    Attributes
    ----------
    states : SampledStates
        The best motion, None before the first.
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

    def __init__(self, task: MotionTask, integrators: list[Explicit]) -> None:
        self._task, self._integrators = task, integrators
        self._convergence = StagnationCheck(task.accuracy)
        self._integration = ExplicitIntegration(task, integrators[-1])
        self._errors = ExplicitErrors(task, self._integration)
        self.force_cost = self._integration.force_cost
        # Integrators and step ratios of the runs, the best last.
        self._completed: list[tuple[Explicit, float]] = []
        self._other: SampledStates | None = None  # the best motion of another candidate
        # Whether the next run tests for rounding; None without a reason.
        self._rounding: bool | None = None
        self.states: SampledStates | None = None
        self.error = math.inf
        self.failure: Exception | None = None
        self.name = repr(self._default)
        self.steps, self.last_stats = 0, RunStats()

    def predicted_cost(self) -> float:
        """Return the predicted cost until the accuracy is met, in the unit of `Costs`."""
        if self.failure is not None:
            return math.inf
        cost = self._plan()[2]
        if cost > MAX_STEPS * self.force_cost:
            self.failure = InputError(
                "a run to {end} by {name} would take more than {most:.0e} evaluations of the "
                "forces: use a shorter time",
                end=Parameter("t_end", f"{self._task.t[-1]:g} s"),
                name=self.name,
                most=MAX_STEPS,
            )
            return math.inf
        return cost

    def warn(self) -> None:
        """Warn of singular configurations, where the error estimates are uncertain."""
        self._integration.rank_deficiency.warn()

    @property
    def dominant(self) -> ModalSpectrum | None:
        """Vibration that causes the difference of two runs; None while it is not known."""
        return self._errors.dominant

    def receive(self, dominant: ModalSpectrum | None, states: SampledStates | None) -> None:
        """Take the dominant vibration and the best motion of another candidate."""
        if self._errors.dominant is None:
            self._errors.dominant = dominant
        self._other = states

    def advance(self) -> None:
        """Make the next run."""
        integrator, ratio, _ = self._plan()
        self.last_stats = RunStats()
        before = self._integration.step(integrator, 1.0)
        states = self._integration.run(integrator, ratio, self.last_stats)
        if states is None:
            self.failure = self._integration.failure
            if self.failure is not None and self._integration.rank_deficiency.time is not None:
                # Estimates of implicit runs are not reliable there either.
                runs = len(self._completed)
                self.failure = AccuracyError(self._task.accuracy, self.error, runs)
            # Step ratios refer to the stable step, which is shorter now.
            shorter = self._integration.step(integrator, 1.0) / before
            self._completed = [(other, shorter * ratio) for other, ratio in self._completed]
            self._errors.shorten(shorter)
        elif self._rounding and self.states is not None:
            self._rounding, difference = False, self._distance(states)
            if difference > max(MAX_REPETITION_DIFFERENCE * self.error, self._task.accuracy):
                error, runs = max(self.error, difference), len(self._completed) + 1
                self.failure = AccuracyError(self._task.accuracy, error, runs)
        else:
            self._add_run(integrator, ratio, states)

    def _add_run(self, integrator: Explicit, ratio: float, states: SampledStates) -> None:
        """Estimate the error of a run, and store it unless its order is lower than the last."""
        self.error, last = self._errors.add(integrator, ratio, states), self.states
        if last is not None and integrator.order < self._completed[-1][0].order:
            self._completed.insert(0, (integrator, ratio))
        else:
            self.states = states
            self.name, self.steps = repr(integrator), self.last_stats.steps
            self._completed.append((integrator, ratio))
        if last is None:
            return
        self.failure = self._convergence.add(self.error)
        is_doubtful = self.error > MIN_DOUBTFUL_ERROR * self._task.accuracy
        if self._rounding is None and is_doubtful and not self._task.has_contact:
            grew = differs_by_rounding(self._task.system, last, states, self.steps)
            self._rounding = True if grew else None
        if self._other is not None:
            # Two candidates have no error in common.
            self.error = min(self.error, self._distance(self._other))

    def _distance(self, other: SampledStates) -> float:
        assert self.states is not None
        return distance(self._task.system, self.states, other)

    @property
    def _default(self) -> Explicit:
        """The integrator of the first run if nothing is known: of order 4 if possible."""
        return self._integrators[len(self._integrators) // 2]

    def _plan(self) -> Plan:
        """Return the cheapest plan."""
        if not self._errors.may_predict:
            if self._completed:
                return self._plan_runs(self._default, [STEP_RATIO])
            return self._plan_runs(self._default, [1.0, STEP_RATIO])
        # Further runs of lower order than the best do not replace it: two runs of orders 8 and 4
        # agreed by chance to 1.4 times the accuracy, and both had errors of 2.5 to 3.
        lowest = self._completed[-1][0].order if self._completed else 0
        plans = [self._plan_with(other) for other in self._integrators if other.order >= lowest]
        plans += self._confirming()
        plan = min(plans, key=lambda plan: plan[2])
        if self._rounding:
            integrator, ratio = self._completed[-1]
            integrator, ratio, cost = self._plan_runs(integrator, [REPETITION_RATIO * ratio])
            return integrator, ratio, cost + plan[2]
        return plan

    def _plan_runs(self, integrator: Explicit, ratios: list[float]) -> Plan:
        """Return the plan of runs with some step ratios."""
        return integrator, ratios[0], sum(self._integration.cost(integrator, x) for x in ratios)

    def _confirming(self) -> list[Plan]:
        """Return plans to confirm an accurate first run by one of lower order.

        Its steps need not be shorter than in the first run, and it is cheaper if these are
        stable ones.  Its error is at most the accuracy.
        """
        if len(self._completed) != 1:
            return []
        first, ratio = self._completed[0]
        if self._errors.predicted(first, ratio) > SAFETY_FACTOR * self._task.accuracy:
            return []
        lower = [x for x in self._integrators if x.order < first.order]
        return [self._plan_runs(x, [self._required_ratio(x, 1.0)]) for x in lower]

    def _plan_with(self, integrator: Explicit) -> Plan:
        """Return the plan for an integrator by its predicted error."""
        runs = [ratio for other, ratio in self._completed if other == integrator]
        required = self._required_ratio(integrator, SAFETY_FACTOR)
        if not runs:
            is_predicted = self._task.spectrum is not None
            first = max(1.0, required / (PREDICTED_STEP_RATIO if is_predicted else STEP_RATIO))
            return self._plan_runs(integrator, [first, max(STEP_RATIO * first, required)])
        minimum = (STEP_RATIO if len(runs) == 1 else math.sqrt(STEP_RATIO)) * runs[-1]
        steps = [min(max(required, minimum), MAX_STEP_RATIO * runs[-1])]
        while steps[-1] < required:
            steps.append(min(required, MAX_STEP_RATIO * steps[-1]))
        return self._plan_runs(integrator, steps)

    def _required_ratio(self, integrator: Explicit, error_ratio: float) -> float:
        """Return the step ratio at which the predicted error meets a part of the accuracy."""
        error = error_ratio * self._task.accuracy
        return find_smallest(lambda ratio: self._errors.predicted(integrator, ratio) <= error, 1.0)
