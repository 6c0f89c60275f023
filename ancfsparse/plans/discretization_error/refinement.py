"""Refine mesh and steps together until the error of the last trial run is known.

Each run has half the step of the previous one and, where meshes are automatic, more elements.  The
difference of two runs is about three quarters of the error of the first.  With two runs the orders
of the methods are assumed in part, with three they are observed, and where differences decrease
irregularly, as after load jumps, four runs bound the error.  If the last run is accurate enough it
is selected.  If its error is far larger than the tolerance but decreases regularly, steps alone are
refined on the coarser of the last two meshes, which divides the error into parts of mesh and steps
that are extrapolated.

The first run has no numerical damping, so that the vibrations removed by long damped steps are part
of the first difference.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from ancfsparse.errors import PlanError
from ancfsparse.plans.discretization_error.error_model import SAFETY_FRACTION
from ancfsparse.plans.discretization_error.mesh_error import GROWTH
from ancfsparse.plans.discretization_error.richardson import (
    ASYMPTOTIC_RANGE,
    MIN_ORDER,
    Estimate,
)
from ancfsparse.plans.discretization_error.run_estimates import (
    RunEstimates,
    elements_of,
    is_close,
    may_be_compared,
    mesh_estimates,
    mesh_orders,
    step_estimates,
)
from ancfsparse.plans.discretization_error.vibrations import (
    describe_vibration,
    resolves_vibrations,
)
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.trial_runs.run_differences import (
    absolute_tolerances,
    differences_over_time,
    goal_differences,
    history_differences,
)
from ancfsparse.plans.trial_runs.trial_runs import TrialRun, TrialRuns
from ancfsparse.scene import Beam

STEP_GROWTH = 2  # ratio of the numbers of steps; of elements too, if they are of low order
LOW_ORDER = 2
# Fraction of the order with which errors are assumed to decrease.
UNOBSERVED_FRACTION = 0.75  # for two runs
# With a mass at .34 of a taut line, meshes of 5 and 7 elements agreed to .3 of the tolerance; the
# error was 1.8 tolerances.
UNEVEN_FRACTION = 0.2  # for two runs with nodes at given positions, whose error is irregular
MIN_OBSERVED_FRACTION = 0.4  # for three runs
TARGET_ORDER = 2  # by which the work of reaching the tolerance is predicted
RUN_GROWTH = GROWTH * STEP_GROWTH  # of the work of successive runs
MAX_LOG = 600.0  # of a ratio of work, below overflow
MAX_BOUND_ORDER = 1.0  # in the steps, that a bound relies on
N_BOUND = 4  # runs of which a bound is made
MAX_NEAR_EXCESS = 2.0  # over that, below which refining both again takes no more than dividing
MAX_UNOBSERVED_RATIO = 1.5  # steps extrapolated without an observed order, over those run
MAX_STEP_RATIO = 16.0  # steps extrapolated with the order of the method, over those run
MAX_REFINEMENTS = 12
MAX_HALVINGS = 5  # of the steps alone
MAX_REDUCTION = 0.5  # ratio of successive differences that decrease regularly
# The undamped integrator conserves vibrations that long damped steps remove.  In 60 random plans
# that were met, damping changed the quantity by .03 of the tolerance or less (.1 in one); in three
# that were exceeded 1.7 to 4 times, by .2 to .5.
MAX_DAMPING_FRACTION = 0.05  # of the tolerance


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


def refine_together(trials: TrialRuns, model: Model, order: int) -> Refinement:
    """Refine mesh and steps together until the errors of both are known or small enough.

    The order is that of positions in the length of the elements.

    Raises
    ------
    StepError
        If no step is short enough for a complete run.
    PlanError
        If the errors do not decrease to the tolerances within the budget: the motion is chaotic, or
        the quantity is not smooth.
    """
    runs: list[TrialRun] = []
    series: _Series | None = None
    growth = GROWTH if order > LOW_ORDER else float(STEP_GROWTH)
    for integrator_trials, mesh, steps in _resolutions(trials, model, growth, runs):
        trials.check_budget()
        run = integrator_trials.run(mesh, steps)
        if run is None:
            runs.clear()
            continue
        runs.append(run)
        if len(runs) < 2:
            continue
        series = _Series(trials, runs[-N_BOUND:], order)
        if series.is_known and series.excess <= 1.0:
            if agrees_with_undamped(trials, runs):
                return series.combine()
        elif series.may_be_divided:
            divided = _divide(trials, runs, order)
            if divided is not None:
                return divided
        if not series.is_regular and series.predicted_work > trials.budget:
            break
    if series is None:
        assert trials.failure is not None
        raise trials.failure
    raise series.failure()


def _resolutions(
    trials: TrialRuns, model: Model, growth: float, runs: Sequence[TrialRun]
) -> Iterator[tuple[TrialRuns, Model, int]]:
    """Yield the integrator, mesh and number of steps of the next run.

    After a failed run only the step is halved.
    """
    n_longest, steps = trials.first
    while steps <= trials.failed:
        steps *= STEP_GROWTH
    mesh = trials.with_mesh(model, n_longest)
    yield trials.without_damping(), mesh, steps
    for _ in range(MAX_REFINEMENTS):
        count, steps = _count_elements(trials, mesh), STEP_GROWTH * steps
        # Nodes at given positions may turn several numbers of elements into one mesh.
        while runs and count and _count_elements(trials, mesh) <= count:
            n_longest *= growth
            mesh = trials.with_mesh(model, n_longest)
        yield trials, mesh, steps


def _count_elements(trials: TrialRuns, model: Model) -> int:
    """Return the number of elements of the automatic meshes of a model."""
    scene = trials.build(model)
    return sum(scene.body(name).n_elements for name in model.counts)


class _Series:
    """Up to four successive runs, and the error of the last one by their differences."""

    def __init__(self, trials: TrialRuns, runs: Sequence[TrialRun], order: int) -> None:
        self.trials, self.runs = trials, tuple(runs)
        self.tolerances = absolute_tolerances(trials.goals, runs[-1])
        self.orders = mesh_orders(trials, order)
        pairs = list(pairwise(runs))
        self.whole = [history_differences(trials.goals, *each) for each in pairs]
        # Largest values, and those at the end, of two runs may agree by chance.
        requested = [goal_differences(trials.goals, *each) for each in pairs]
        differences = self.whole if len(runs) == 2 else requested
        self.is_regular = self._is_regular()
        columns = zip(zip(*differences, strict=True), self.orders, strict=True)
        self.errors = [self._error(*each) for each in columns]
        limits = [SAFETY_FRACTION * each for each in self.tolerances]
        self.excess = max(x / limit for x, limit in zip(self.errors, limits, strict=True))

    def _is_regular(self) -> bool:
        """Return True if differences decrease in the asymptotic range."""
        last = self.runs[-1]
        pairs = zip(*self.whole[-2:], strict=True) if len(self.whole) > 1 else ()
        return (
            all(new <= MAX_REDUCTION * old for old, new in pairs)
            and is_close(self.trials, last, self.whole[-1])
            and resolves_vibrations(last, self.tolerances)
        )

    def _error(self, differences: Sequence[float], order: int) -> float:
        """Return the error of a quantity in the last run; infinite if it is unknown."""
        if self.is_regular:
            by_steps = float(STEP_GROWTH**self.trials.step_order)
            ratio = min(self.mesh_ratio**order, by_steps)
            is_uneven = len(differences) == 1 and _has_inner_nodes(self.trials, self.runs[-1])
            fraction = UNEVEN_FRACTION if is_uneven else UNOBSERVED_FRACTION
            return error_of_last(differences, ratio, fraction)
        return bound(differences)[1] if len(self.runs) == N_BOUND else math.inf

    @property
    def mesh_ratio(self) -> float:
        """Ratio of the numbers of elements of the last two runs; infinite for given meshes."""
        before, last = map(elements_of, self.runs[-2:])
        return last / before if last else math.inf

    @property
    def is_known(self) -> bool:
        """True if the differences show the error of the last run."""
        whole = self.whole[-1]
        return self.is_regular or may_be_compared(self.trials, self.runs[-1], whole)

    @property
    def may_be_divided(self) -> bool:
        """True if the error decreases regularly, but is far larger than the tolerance."""
        return self.is_regular and len(self.runs) > 2 and self.excess > MAX_NEAR_EXCESS

    @property
    def predicted_work(self) -> float:
        """Work of the next run, or of the one that meets the tolerances."""
        work = self.runs[-1].cost.work
        if not 1.0 < self.excess < math.inf:
            return RUN_GROWTH * work
        # Logarithms, because a tolerance may be beyond the reach of any number of runs.
        refinements = math.log(self.excess) / math.log(STEP_GROWTH**TARGET_ORDER)
        return work * math.exp(min(refinements * math.log(RUN_GROWTH), MAX_LOG))

    def combine(self) -> Refinement:
        """Return the last run, which is accurate enough, with undivided errors."""
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
        time = RunEstimates(tuple(of_steps), (one, other))
        mesh = RunEstimates(tuple(of_mesh), (one, other)) if has_mesh else None
        return Refinement(time, mesh, tuple(self.errors), not self.is_regular)

    def failure(self) -> PlanError:
        """Return the failure for the quantity with the largest error, with the time of that."""
        errors = self.errors if 1.0 < self.excess < math.inf else self.whole[-1]
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


def error_of_last(
    differences: Sequence[float], ratio: float, power: float = UNOBSERVED_FRACTION
) -> float:
    """Return the error of the last run from the differences of successive runs.

    Errors decrease by `ratio` to a power, of two runs the given one, of three the observed one.  A
    much smaller difference is one by chance, see `richardson`.
    """
    difference = differences[-1]
    before = differences[-2] if len(differences) > 1 else 0.0
    if before > difference * ratio ** ASYMPTOTIC_RANGE[1]:
        difference = before / ratio
    if before > 0.0 and difference > 0.0:
        observed = math.log(before / difference) / math.log(ratio)
        power = min(1.0, max(MIN_OBSERVED_FRACTION, observed))
    return difference / float(ratio**power - 1.0)


def bound(differences: Sequence[float]) -> tuple[float, float]:
    """Return the order shown by three differences of four motions, and a bound of the error.

    A difference may be small by chance, so the previous one counts as well, reduced by the ratio
    expected since; if the differences do not decrease, the largest of all three counts.
    """
    first, second, third = differences
    observed = math.inf if third == 0.0 else 0.0
    if first > 0.0 and third > 0.0:
        observed = math.log(first / third) / (2.0 * math.log(STEP_GROWTH))
    order = min(max(observed, MIN_ORDER), MAX_BOUND_ORDER)
    ratio = STEP_GROWTH**order
    largest = max(third, second / ratio) if observed >= MIN_ORDER else max(differences)
    return order, largest / (ratio - 1.0)


def agrees_with_undamped(trials: TrialRuns, runs: Sequence[TrialRun]) -> bool:
    """Return True if the damping of long steps has removed no relevant vibration.

    The first run shows it if it has no damping; otherwise the last one is repeated without.
    """
    undamped, last = trials.without_damping(), runs[-1]
    if undamped is trials or runs[0].integrator == undamped.integrator:
        return True
    run = undamped.run(last.model, last.steps)
    if run is None:  # its steps are too long; the quantity is still unknown
        return True
    differences = goal_differences(trials.goals, last, run)
    pairs = zip(differences, absolute_tolerances(trials.goals, last), strict=True)
    return all(difference <= MAX_DAMPING_FRACTION * tolerance for difference, tolerance in pairs)


def _divide(trials: TrialRuns, runs: Sequence[TrialRun], order: int) -> Refinement | None:
    """Return the errors of mesh and steps, by runs on the coarser of the last two meshes.

    None if a run fails, or the motions there do not converge.
    """
    one, other = runs[-2:]
    if not other.model.counts:
        time = refine_steps(trials, runs)
        return None if time is None else Refinement(time, None)
    time = refine_steps(trials, [one])
    if time is None:
        return None
    pair = time.runs[1], other
    return Refinement(time, RunEstimates(mesh_estimates(trials, pair, order), pair))


def refine_steps(trials: TrialRuns, first: Sequence[TrialRun]) -> RunEstimates | None:
    """Halve the step on one mesh until the error of the steps can be extrapolated.

    None if a run fails, or the motions do not converge.
    """
    runs = list(first)
    while True:
        trials.check_budget()
        if len(runs) > 1:
            estimates = step_estimates(trials, runs, trials.step_order)
            if any(each.is_observed and each.order <= MIN_ORDER for each in estimates):
                return None
            result = RunEstimates(estimates, tuple(runs))
            if _may_extrapolate(trials, result) or len(runs) > MAX_HALVINGS + 1:
                return result
        run = trials.run(runs[-1].model, STEP_GROWTH * runs[-1].steps)
        if run is None:
            return None
        runs.append(run)


def _may_extrapolate(trials: TrialRuns, time: RunEstimates) -> bool:
    """Return True if the steps for half of the tolerances follow from known errors."""
    last = time.runs[-1]
    pairs = zip(time.estimates, absolute_tolerances(trials.goals, last), strict=True)
    return all(
        each.resolution_for(0.5 * tolerance) <= _max_ratio(each) * last.steps
        for each, tolerance in pairs
    )


def _max_ratio(known: Estimate) -> float:
    """Return the ratio of steps up to which an error may be extrapolated."""
    if not known.is_observed:
        return MAX_UNOBSERVED_RATIO
    return MAX_STEP_RATIO if known.is_asymptotic else 1.0


def refine_other_elements(
    trials: TrialRuns, model: Model, order: int, time: RunEstimates, reference_run: TrialRun
) -> Refinement | None:
    """Estimate the mesh error of other elements, with the time error of known ones.

    The reference run has the known elements on the finest mesh.  None if a run fails, or the two
    meshes are the same.
    """
    n_longest, steps = float(max(reference_run.model.counts.values())), reference_run.steps
    growth = GROWTH if order > LOW_ORDER else float(STEP_GROWTH)
    # To take less work than the known elements.
    if model.gradings:
        n_longest /= growth**2
    elif any(element.name == "string" for element in model.elements.values()):
        n_longest /= growth
    runs = [trials.run(trials.with_mesh(model, n), steps) for n in (n_longest, growth * n_longest)]
    one, other = runs
    if one is None or other is None or elements_of(one) == elements_of(other):
        return None
    whole = history_differences(trials.goals, one, other)
    tolerances = absolute_tolerances(trials.goals, other)
    if not (is_close(trials, other, whole) and resolves_vibrations(other, tolerances)):
        return None
    of_mesh = mesh_estimates(trials, (one, other), order)
    errors = [m.conservative + t.at(steps) for m, t in zip(of_mesh, time.estimates, strict=True)]
    pairs = zip(errors, tolerances, strict=True)
    is_enough = all(error <= SAFETY_FRACTION * tolerance for error, tolerance in pairs)
    mesh = RunEstimates(of_mesh, (one, other))
    return Refinement(time, mesh, tuple(errors) if is_enough else None)


def _has_inner_nodes(trials: TrialRuns, run: TrialRun) -> bool:
    """Return True if positions on beams add nodes to the meshes of a run, or move them."""
    scene, counts = run.run.system.scene, run.model.counts
    bodies = [scene.body(name) for name in counts]
    is_uneven = any(isinstance(body, Beam) and body.nodes is not None for body in bodies)
    return is_uneven or sum(b.n_elements for b in bodies) != sum(counts.values())
