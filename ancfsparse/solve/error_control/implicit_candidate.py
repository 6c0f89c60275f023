"""Implicit candidate of an error-controlled run: runs with steps in one ratio.

Their errors are in a fixed ratio as well: the error follows from their difference and can be
subtracted (Richardson).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ancfsparse.errors import EnergyIncreaseError, InputError, Parameter, StepError
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.interface.time_grid import MAX_STEPS
from ancfsparse.nonlinear import Method, ModifiedNewton, Outcome
from ancfsparse.nonlinear.iteration import describe
from ancfsparse.results import Event, RunStats
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.error_control.implicit_integration import ImplicitIntegration
from ancfsparse.solve.error_control.motion_task import MotionTask
from ancfsparse.solve.error_models.disturbance_growth import growth_exponent
from ancfsparse.solve.error_models.modal_spectrum import MIN_SCALE, ModalSpectrum, Scheme
from ancfsparse.solve.error_models.run_differences import (
    assumed_order,
    difference_frequency,
    difference_growth,
    observed_order,
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
# 0.27 in 596 of 598 random scenes.  With one d for steps of all lengths it was up to 5.2.
ITERATIONS_RATIO = 0.03  # error of positions by all iterations over the accuracy
ELASTIC_ITERATIONS_RATIO = 0.5  # the same where all bodies are elastic, if all signs were equal
# Where differences of two runs grow, iteration errors do.  A cable that left its plane was off by
# 8.6 times the accuracy, its estimate was 0.3, and other accuracies were not met at all.
MAX_AMPLIFIED_RATIO = 16.0  # ITERATIONS_RATIO times the growth; 8 costs 17 % of all residuals
# Value of that product in later runs once it has exceeded the maximum.  With 0.05 such a cable was
# off by 2.1 times the accuracy.
AMPLIFIED_RATIO = 0.01
# Exponent of the growth of disturbances in the first run that also marks a motion as one that
# amplifies errors: without it 6 of 221 such runs are off by up to 9.0 times the accuracy, with it
# 2 are, by up to 1.6.
MAX_GROWTH_EXPONENT = 7.0
# Residuals with their solutions in a step before the first run.  Vibrations excited nonlinearly are
# not predicted, and shorten steps of order 2 more than of order 8: so it is more than two.
RESIDUALS_PER_STEP = 3.8
MIN_FORCES = 900.0  # evaluations of forces that the first steps of any run cost
# Steps over the steps of the last run if errors stagnate: with half as many, runs of an arm with a
# beam in axial vibration ended without the accuracy.
STAGNANT_STEP_RATIO = 3.0
# The same with contact, and after the second such run where errors are amplified: there motions
# whose errors stagnate are mostly chaotic.  With 3, a cable that whips onto a floor takes 113 s and
# 21 million steps before the `AccuracyError`, and a chaotic beam six times as many residuals.
STAGNANT_IMPACT_RATIO = 1.5
FIRST_STEPS = 48.0  # steps of a first run whose error is not predicted
FIRST_ERROR_RATIO = 1e-3  # assumed error of such a run over the size of the scene, for costs
RESTART_RATIO = 2.0  # steps of a restart over the steps of the failed run
# Steps between discontinuities: with one, two motions under a pulse of 60 us agreed to 5e-8 m, and
# were off by 2.3e-6 m.
MIN_INTERVAL_STEPS = 4
MAX_ATTEMPTS = 6  # runs that gain energy or cannot be solved
# Error of a run over its difference from a coarser one, in scenes with contact.  With half of it, a
# cable that whips onto a floor seems accurate to 1e-3 m, and is off by 3.8e-3 m.
MIN_IMPACT_REMAINING = 1.0
MAX_IRREGULARITY = 1.5  # differences over those of second order, up to which extrapolation is valid


class ImplicitCandidate:
    """Implicit candidate of an error-controlled run, with equal steps where loads are smooth.

    With load discontinuities, later runs divide the steps of the first.

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
        self._solver = ModifiedNewton() if isinstance(solver, str) else solver
        self._min_steps = max(
            min_steps(task.discontinuities, task.length),
            self._resolving_steps(integrator.keeps_energy),
        )
        self._step_cost, self._counts = 0.0, list[int]()
        self._runs: list[tuple[int, SampledStates]] = []  # the last two, by their steps
        self._extrapolated: tuple[SampledStates, float] | None = None
        scene = task.system.scene
        is_elastic = len(scene.beams) == len(scene.bodies)
        self._iterations_ratio = ELASTIC_ITERATIONS_RATIO if is_elastic else ITERATIONS_RATIO
        self._is_unstable = False  # whether the motion amplifies errors
        self._attempts, self._convergence = 0, StagnationCheck(task.accuracy)
        # Error over the predicted one, and after extrapolation in addition.
        self._scale, self._excess = 1.0, 1.0
        self.states: SampledStates | None = None
        self.error = math.inf
        self.failure: Exception | None = None
        self.dominant: ModalSpectrum | None = None
        self.steps, self.last_stats = 0, RunStats()
        self.name = f"{integrator!r} with {describe(self._solver)}"
        self._first_cost = MIN_FORCES * force_cost
        if task.spectrum is not None:
            self._first_cost = self._plan()[1] * self._predicted_step_cost()

    def predicted_cost(self) -> float:
        """Return the predicted cost until the accuracy is met, in the unit of `Costs`."""
        if self.failure is not None:
            return math.inf
        cost = self._plan()[1] * self._step_cost
        return cost if self._runs else max(cost, self._first_cost)

    def receive(self, dominant: ModalSpectrum | None, states: SampledStates | None) -> None:
        """Ignore the results of another candidate."""

    def warn(self) -> None:
        """Do nothing: errors at singular configurations are in the differences of runs."""

    def advance(self) -> None:
        """Make the next run."""
        counts = self._next_counts(self._plan()[0])
        n = sum(counts)
        run = self._integration(counts)
        self.last_stats = run.stats
        try:
            states = run.run()
        except (EnergyIncreaseError, StepError) as stop:
            gained = isinstance(stop, EnergyIncreaseError)
            cause = CAUSE_NAMES[Outcome.GAINED_ENERGY] if gained else "failed"
            run.note([Event(stop.step, stop.time, "shorter steps", cause, math.nan)])
            self._attempts += 1
            self.failure = stop if self._attempts == MAX_ATTEMPTS else None
            self._min_steps = RESTART_RATIO * n
            return
        finally:
            self.steps = run.stats.steps
            self._step_cost = run.cost() / (self.steps + EXTRA_STEPS)
        if self._runs:
            self._add_run(n, states)
        else:
            self._counts, self._runs, self.states = counts, [(n, states)], states
            task = self._task
            if not task.has_contact:  # errors there are differences of runs in any case
                exponent = growth_exponent(task.system, task.discontinuities, states)
                self._is_unstable = exponent > MAX_GROWTH_EXPONENT
            if self._is_unstable:
                self._iterations_ratio = min(self._iterations_ratio, AMPLIFIED_RATIO)

    def _resolving_steps(self, keeps_energy: bool = False) -> int:
        """Return the fewest steps that resolve impacts."""
        return math.ceil(self._task.length / self._task.resolving_step(keeps_energy))

    def _plan_of(self, spectrum: ModalSpectrum) -> StepPlan:
        return StepPlan(spectrum, self._integrator, self._task.length, self._min_steps)

    def _plan(self) -> tuple[int, float]:
        """Return the steps of the next run, and the cost of all that follow in steps."""
        accuracy, runs = self._task.accuracy, [steps for steps, _ in self._runs]
        spectrum = self._task.spectrum or self.dominant
        if spectrum is None:
            steps = math.ceil(max([FIRST_STEPS, self._min_steps, *(2.0 * n for n in runs)]))
            # At least as if the error decreased with the fourth power of the step from now on.
            error = FIRST_ERROR_RATIO * float(np.max(np.abs(self._task.system.q0)))
            return steps, steps * max(1.0, math.sqrt(math.sqrt(error / accuracy)))
        if not runs:
            return self._plan_of(spectrum).first(accuracy)
        steps, total = self._plan_of(spectrum).next(runs, accuracy / self._scale, self._excess)
        if self._convergence.stagnant_runs and self._task.has_contact:
            steps = max(round(STAGNANT_IMPACT_RATIO * runs[-1]), self._resolving_steps())
        elif self._convergence.stagnant_runs > 1 and self._is_unstable:
            steps = round(STAGNANT_IMPACT_RATIO * runs[-1])
        elif self._convergence.stagnant_runs:
            steps = max(steps, round(STAGNANT_STEP_RATIO * runs[-1]))
        return steps, max(total, steps)

    def _next_counts(self, steps: int) -> list[int]:
        """Return the steps of the next run in each interval of smooth loads."""
        if steps > MAX_STEPS:
            raise InputError(
                "a run to {end} would take more than {most:.0e} steps: use a shorter time",
                end=Parameter("t_end", f"{self._task.t[-1]:g} s"),
                most=MAX_STEPS,
            )
        if self._runs and len(self._counts) > 1:
            # With at least twice the last, runs of short pulses agreed by chance: in steps divided
            # by 1, 2 and 4 they seemed accurate to 5e-8 m, at an error of 1.3e-6 m.
            base, last = sum(self._counts), self._runs[-1][0]
            by = max(math.ceil(steps / base), last // base + 1)
            return [by * n for n in self._counts]
        begins = [begin for begin, _ in self._task.spans]
        lengths = np.diff([self._task.t[0], *begins[1:], self._task.t[-1]]).tolist()
        steps_per_second = steps / self._task.length
        return [max(math.ceil(steps_per_second * x), MIN_INTERVAL_STEPS) for x in lengths]

    def _predicted_step_cost(self) -> float:
        """Return the cost of a step before the first run."""
        system = self._task.system
        pattern = system.pattern
        seed = SparseSeed(pattern.indptr, pattern.indices, system.n_free, self._threads)
        costs = iteration_costs(system, self._integrator, seed, None)
        return RESIDUALS_PER_STEP * costs.iteration

    def _integration(self, counts: Sequence[int]) -> ImplicitIntegration:
        """Return a run with a number of steps in each interval."""
        return ImplicitIntegration(
            self._task,
            self._integrator,
            self._solver,
            counts,
            self._iterations_ratio * self._task.accuracy,
            self._threads,
        )

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
        has_contact = self._task.has_contact
        order = assumed_order(self._integrator.order, phase, has_contact)
        minimum = MIN_IMPACT_REMAINING if has_contact else 0.0
        error, is_stagnant = difference * remaining_error(n / before, order, minimum), False
        extrapolated_error, later_difference = math.inf, 0.0
        lost = min(1.0, phase) * difference
        pairs = [(states, coarse)]
        if self._extrapolated is not None:
            earlier, last_difference = self._extrapolated
            first = self._runs[0][0]
            later_difference = self._distance(extrapolated, earlier)
            # Extrapolation reduces the difference, or it has not removed the error.
            expected = (first**-2 - before**-2) / (before**-2 - n**-2)
            ratio = last_difference / difference / expected
            is_regular = (
                1.0 / MAX_IRREGULARITY < ratio < MAX_IRREGULARITY and later_difference < difference
            )
            content = self._dominant(later_difference, extrapolated, earlier, before, n)
            phase = float(content.phase_errors(self._scheme(n))[0])
            remaining = remaining_error(n / first, ASSUMED_ORDER)
            # Of waves at a frequency w the remaining part is the phase error, up to 1, which grows
            # with w^3.  By their velocity v they differ by v / w, so none remains by more than at
            # the frequency of phase error 1.
            remaining = max(remaining, min(1.0, math.cbrt(phase)))
            if is_regular or not has_contact:
                extrapolated_error = (
                    later_difference * remaining if is_regular else later_difference
                )
                error = plain + later_difference * remaining
                pairs.append((extrapolated, earlier))
            else:  # of first order: an extrapolation of second order does not remove it
                observed = observed_order(first, last_difference, before, n, difference)
                error = difference * remaining_error(n / before, min(order, observed), minimum)
            is_stagnant = MIN_DECREASE * last_difference < difference
        error = max(error, lost)
        runs, self._extrapolated = [(before, coarse), (n, states)], (extrapolated, difference)
        if self._reduce_iteration_errors(pairs):
            extrapolated_error, runs, self._extrapolated = math.inf, runs[1:], None
        if self._is_unstable:
            # Amplified errors decrease late, from a size that only the motion limits: 957 steps are
            # off by 2.3 times the accuracy, 1436 by 2.1, and they differ by 0.7.  Extrapolations of
            # 545 and 818 steps are off by 2.1 times and by 1.5.
            remaining = remaining_error(n / before, ASSUMED_ORDER)
            error = max(error, difference * max(1.0, remaining))
            extrapolated_error = max(extrapolated_error, later_difference * min(1.0, second_order))
        if extrapolated_error < error:
            error, best = extrapolated_error, extrapolated
        pair = self._scheme(before), self._scheme(n)
        if self._task.spectrum is not None:
            error = max(error, self._task.spectrum.common_error(*pair))
        spectrum = self._task.spectrum or self.dominant
        self._scale = max(spectrum.scale(difference, *pair), MIN_SCALE)
        if extrapolated_error < math.inf:
            predicted = self._scale * spectrum.extrapolated_error(*pair)
            self._excess = max(1.0, extrapolated_error / max(predicted, np.finfo(float).tiny))
        self.failure = self._convergence.add(error, is_stagnant)
        self.error, self.states, self._runs = error, best, runs

    def _reduce_iteration_errors(self, pairs: list[tuple[SampledStates, SampledStates]]) -> bool:
        """Reduce iteration errors of later runs of an unstable motion.

        Return True if the last runs can have iteration errors too large for an extrapolation.

        Parameters
        ----------
        pairs : list of (SampledStates, SampledStates)
            The last two runs and, if there are, the last two extrapolations: they show growth that
            errors of the steps hide in the runs.  With runs alone, a chain was off by 3.6 times the
            accuracy at an estimate of 0.44.
        """
        ratio = self._iterations_ratio
        minimum = 0.25 * ratio * self._task.accuracy  # in half of the time, if all signs are equal
        growth = max(difference_growth(self._task.system, *pair, minimum) for pair in pairs)
        is_too_large = ratio * growth > MAX_AMPLIFIED_RATIO
        self._is_unstable |= is_too_large
        if self._is_unstable and growth < math.inf:
            self._iterations_ratio = min(ratio, AMPLIFIED_RATIO / growth)
        return is_too_large

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
