"""Successive trial runs, each with half the step and a finer mesh, and the error of the last one.

The difference of two runs is about three quarters of the error of the first.  With two runs the
orders of the methods are assumed in part, with three they are observed, and where differences
decrease irregularly, as after load jumps, four runs bound the error.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, repeat

from ancfsparse.errors import PlanError
from ancfsparse.plans.discretization_error.error_model import SAFETY_FRACTION
from ancfsparse.plans.discretization_error.mesh_error import GROWTH
from ancfsparse.plans.discretization_error.richardson import (
    ASYMPTOTIC_RANGE,
    MIN_ORDER,
    Estimate,
    estimate,
)
from ancfsparse.plans.discretization_error.run_estimates import (
    RunEstimates,
    elements_of,
    is_close,
    may_be_compared,
    mesh_orders,
)
from ancfsparse.plans.discretization_error.vibrations import (
    describe_vibration,
    resolves_vibrations,
)
from ancfsparse.plans.trial_runs.run_differences import (
    absolute_tolerances,
    differences_over_time,
    goal_differences,
    history_differences,
)
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns
from ancfsparse.scene import Beam

LOW_ORDER = 2  # in the length of the elements, of strings and of section forces
STEP_GROWTH = 2  # ratio of the numbers of steps; of elements too, if they are of low order
# Fraction of the order with which errors are assumed to decrease.
UNOBSERVED_FRACTION = 0.75  # for two runs
# With a mass at .34 of a taut line, meshes of 5 and 7 elements agreed to .3 of the tolerance; the
# error was 1.8 tolerances.
UNEVEN_FRACTION = 0.2  # for two runs with nodes at given positions, whose error is irregular
# Peaks of a velocity differed by .005 and .02 of the motions; their error was 2 tolerances.
MIN_REQUESTED_RATIO = 0.3  # of an error of peaks or final values to that at any time
# Vibrations of a pulled cable differed by 2.6, 3 and 2.4 tolerances from mesh to mesh; with this
# order alone it was refused after 8 s, not 1.5.
TARGET_ORDER = 2  # by which the work of reaching the tolerance is predicted
# Energies after .006 of it differed by more than runs before; the plan met its tolerance.
MIN_SPENT_FRACTION = 0.1  # of the budget, after which differences that hardly decrease count
RUN_GROWTH = GROWTH * STEP_GROWTH  # of the work of successive runs
MAX_LOG = 600.0  # of a ratio of work, below overflow
MAX_BOUND_ORDER = 1.0  # in the steps, that a bound relies on
N_BOUND = 4  # runs of which a bound is made
MAX_NEAR_EXCESS = 2.0  # over that, below which refining both again takes no more than dividing
MAX_REDUCTION = 0.5  # ratio of successive differences that decrease regularly
# A slack line's motions differed by 6.7, 5.3 and 1.6 tolerances; the error of the last was 2.2.
MAX_EARLIER_REDUCTION = 0.7  # the same for the pair of differences before


@dataclass(frozen=True)
class Refinement:
    """Result of a refinement.

    Attributes
    ----------
    time : RunEstimates
        Of the steps.
    mesh : RunEstimates or None
        Of the automatic meshes.
    combined_errors : tuple of float, or None
        Error of the last run by mesh and steps together, for every quantity [its unit], if it is
        within the tolerance; `time` and `mesh` then have half of it each.
    is_bound : bool
        Whether these are bounds from four runs.
    """

    time: RunEstimates
    mesh: RunEstimates | None
    combined_errors: tuple[float, ...] | None = None
    is_bound: bool = False


class RunSeries:
    """Up to four successive runs, and the error of the last one by their differences."""

    def __init__(self, trials: TrialRuns, runs: Sequence[TrialRun], order: int) -> None:
        self.trials, self.runs = trials, tuple(runs)
        self.tolerances = absolute_tolerances(trials.goals, runs[-1])
        self.orders = mesh_orders(trials, order)
        # Waves have kinks at nodes inside beams.  With order 4, meshes of 5, 7 and 10 elements, two
        # of which agreed by chance, showed an error of .17 tolerances, and it was 1.7.
        self.has_kinks = max(self.orders) > LOW_ORDER and _has_inner_nodes(trials, runs[-1])
        if self.has_kinks:
            self.orders = [min(each, LOW_ORDER) for each in self.orders]
        pairs = list(pairwise(runs))
        self.over_time = [history_differences(trials.goals, *each) for each in pairs]
        requested = [goal_differences(trials.goals, *each) for each in pairs]
        self.is_regular = self._is_regular()
        columns = zip(zip(*requested, strict=True), self.orders, strict=True)
        self.errors = [self._error(i, *each) for i, each in enumerate(columns)]
        limits = [SAFETY_FRACTION * each for each in self.tolerances]
        self.excess = max(x / limit for x, limit in zip(self.errors, limits, strict=True))

    def _is_regular(self) -> bool:
        """Return True if differences decrease in the asymptotic range."""
        last = self.runs[-1]
        return (
            self.is_decreasing
            and all(map(self._decreases, pairwise(self.over_time), repeat(MAX_EARLIER_REDUCTION)))
            and is_close(self.trials, last, self.over_time[-1])
            and resolves_vibrations(last, self.tolerances)
        )

    @property
    def is_decreasing(self) -> bool:
        """True if the last difference is much smaller than the one before."""
        last = self.over_time[-2:]
        return len(last) < 2 or self._decreases(last, MAX_REDUCTION)

    @staticmethod
    def _decreases(pair: Sequence[Sequence[float]], ratio: float) -> bool:
        return all(new <= ratio * old for old, new in zip(*pair, strict=True))

    def _error(self, i: int, requested: Sequence[float], order: int) -> float:
        """Return the error of quantity i in the last run; infinite if it is unknown.

        From its differences at any time and at the requested ones.  Largest values, and those at
        the end, of two runs may agree by chance, so the former show the order, and the largest
        ratio of both the size.  Not so for bounds: the error exceeded two of 22 in place of three,
        but three of 156 plans that held were refused.
        """
        if not self.is_regular:
            ratio = self.step_ratio if self.step_ratio > 1.0 else self.mesh_ratio
            return bound(requested, ratio)[1] if len(self.runs) == N_BOUND else math.inf
        known = self._estimate(i, order)
        if not known.is_observed:
            is_uneven = _has_inner_nodes(self.trials, self.runs[-1])
            fraction = UNEVEN_FRACTION if is_uneven else UNOBSERVED_FRACTION
            return known.with_order(fraction * known.order).error
        pairs = zip(requested, (each[i] for each in self.over_time), strict=True)
        ratios = (one / whole for one, whole in pairs if whole > 0.0)
        return known.error * max(MIN_REQUESTED_RATIO, *ratios)

    def _estimate(self, i: int, order: int) -> Estimate:
        """Estimate the error of quantity i at any time by the steps of the runs, and by elements.

        The order of the mesh, `order`, is in the elements.  With equal ratios both agree, but
        coarse meshes with nodes at given positions grow unevenly: differences of 4, 7 and 10
        elements decreased as for order 2 in the steps, and the error was 3.9 times that estimate.
        Where elements show more, it counts for that part of the last difference which half the
        steps on the last mesh do not explain.
        """
        over_time = [each[i] for each in self.over_time]
        by_elements = by_steps = None
        if self.runs[-1].model.counts:
            by_elements = estimate([elements_of(run) for run in self.runs], over_time, order)
        if self.step_ratio > 1.0:
            steps = [run.steps for run in self.runs]
            by_steps = estimate(steps, over_time, self.trials.step_order)
        if by_elements is None or by_steps is None:
            known = by_elements or by_steps
            assert known is not None
            return known
        if by_elements.error <= by_steps.error or not by_elements.is_observed:
            return max(by_elements, by_steps, key=lambda each: each.error)
        more = (by_elements.error - by_steps.error) * (1.0 - self._step_fraction(i))
        return replace(by_steps, error=by_steps.error + more)

    def _step_fraction(self, i: int) -> float:
        """Return the part of the last difference of quantity i that the steps explain, up to 1."""
        last = self.runs[-1]
        other = self.trials.run(last.model, last.steps // STEP_GROWTH)
        if other is None:
            return 0.0
        difference = history_differences(self.trials.goals, other, last)[i]
        return min(1.0, difference / self.over_time[-1][i])

    @property
    def step_ratio(self) -> float:
        """Ratio of the numbers of steps of the last two runs."""
        before, last = self.runs[-2:]
        return last.steps / before.steps

    @property
    def mesh_ratio(self) -> float:
        """Ratio of the numbers of elements of the last two runs; infinite for given meshes."""
        before, last = map(elements_of, self.runs[-2:])
        return last / before if last else math.inf

    @property
    def is_known(self) -> bool:
        """True if the differences show the error of the last run."""
        differences = self.over_time[-1]
        return self.is_regular or may_be_compared(self.trials, self.runs[-1], differences)

    @property
    def margins(self) -> list[float]:
        """Errors of every quantity that may be added [its unit]."""
        pairs = zip(self.tolerances, self.errors, strict=True)
        return [SAFETY_FRACTION * tolerance - error for tolerance, error in pairs]

    @property
    def may_be_divided(self) -> bool:
        """True if the error decreases regularly, but is far larger than the tolerance.

        Not of positions with nodes inside beams, at which waves have kinks: meshes show order .6 in
        place of 4, and one of 18 elements was selected with an error of 2.3 tolerances.
        """
        is_far = len(self.runs) > 2 and self.excess > MAX_NEAR_EXCESS
        return self.is_regular and is_far and not self.has_kinks and not self._agrees_by_chance()

    def _agrees_by_chance(self) -> bool:
        """Return True if a last difference is far smaller than any order of the methods explains.

        Strains of 6, 9 and 14 elements differed by 11 and .7 tolerances; the error was 2.9.
        """
        known = (self._estimate(i, order).observed for i, order in enumerate(self.orders))
        limits = (max(order, self.trials.step_order) for order in self.orders)
        pairs = zip(known, limits, strict=True)
        return any(observed > ASYMPTOTIC_RANGE[1] * limit for observed, limit in pairs)

    @property
    def predicted_work(self) -> float:
        """Work of the next run, or of the one that meets the tolerances."""
        work = self.runs[-1].cost.work
        if not 1.0 < self.excess < math.inf:
            return RUN_GROWTH * work
        # Logarithms, because a tolerance may be beyond the reach of any number of runs.
        order = MIN_ORDER if self._is_slow() else TARGET_ORDER
        refinements = math.log(self.excess) / math.log(STEP_GROWTH**order)
        return work * math.exp(min(refinements * math.log(RUN_GROWTH), MAX_LOG))

    def _is_slow(self) -> bool:
        """Return True if an order below the smallest one is shown by runs that resolve vibrations.

        By four of them, for a quantity whose error exceeds its limit.
        """
        spent = sum(each.work for each in self.trials.run_costs)
        if len(self.runs) < N_BOUND or spent < MIN_SPENT_FRACTION * self.trials.budget:
            return False
        ratio = STEP_GROWTH ** (-2.0 * MIN_ORDER)
        columns = zip(self.over_time[0], self.over_time[-1], self.margins, strict=True)
        is_slow = any(margin < 0.0 and last > ratio * first for first, last, margin in columns)
        return is_slow and all(resolves_vibrations(run, self.tolerances) for run in self.runs)

    def combine(self) -> Refinement:
        """Return the refinement that selects the last run, with its undivided error."""
        one, other = self.runs[-2:]
        has_mesh = bool(other.model.counts)
        of_steps, of_mesh = [], []
        for error, order in zip(self.errors, self.orders, strict=True):
            part = 0.5 * error if has_mesh else error
            step_order = self.trials.step_order if self.is_regular else MAX_BOUND_ORDER
            mesh_order = order if self.is_regular else MAX_BOUND_ORDER
            of_steps.append(Estimate(other.steps, part, step_order, False, STEP_GROWTH, False))
            ratio = self.mesh_ratio
            of_mesh.append(Estimate(elements_of(other), part, mesh_order, False, ratio, False))
        time = RunEstimates(tuple(of_steps), self.runs[-3:] if self.is_regular else (one, other))
        mesh = RunEstimates(tuple(of_mesh), (one, other)) if has_mesh else None
        return Refinement(time, mesh, tuple(self.errors), not self.is_regular)

    def failure(self) -> PlanError:
        """Return the failure for the quantity with the largest error, with the time of that."""
        errors = self.errors if 1.0 < self.excess < math.inf else self.over_time[-1]
        i = max(range(len(errors)), key=lambda k: errors[k] / self.tolerances[k])
        quantity, last, t_end = self.trials.goals[i].quantity, self.runs[-1], self.trials.t_end
        assert t_end is not None
        differences = differences_over_time(
            self.trials.goals[i], *(run.histories[i] for run in self.runs[-2:])
        )
        t = t_end * float(differences.argmax()) / max(1, len(differences) - 1)
        cause = describe_vibration(last, i, t_end, self.tolerances[i], quantity.unit)
        return PlanError(
            quantity.name,
            self.tolerances[i],
            float(differences.max()),
            quantity.unit,
            len(self.runs),
            t,
            (cause,) if cause else (),
        )


def bound(differences: Sequence[float], growth: float = STEP_GROWTH) -> tuple[float, float]:
    """Return the order shown by three differences of four motions, and a bound of the error.

    A difference may be small by chance, so the previous one counts as well, reduced by the ratio
    expected since; if the differences do not decrease, the largest of all three counts.
    """
    first, second, third = differences
    observed = math.inf if third == 0.0 else 0.0
    if first > 0.0 and third > 0.0:
        observed = math.log(first / third) / (2.0 * math.log(growth))
    order = min(max(observed, MIN_ORDER), MAX_BOUND_ORDER)
    ratio = growth**order
    largest = max(third, second / ratio) if observed >= MIN_ORDER else max(differences)
    return order, largest / (ratio - 1.0)


def _has_inner_nodes(trials: TrialRuns, run: TrialRun) -> bool:
    """Return True if positions on beams add nodes to the meshes of a run, or move them."""
    scene, counts = run.run.system.scene, run.model.counts
    bodies = [scene.body(name) for name in counts]
    is_uneven = any(isinstance(body, Beam) and body.nodes is not None for body in bodies)
    return is_uneven or sum(b.n_elements for b in bodies) != sum(counts.values())
