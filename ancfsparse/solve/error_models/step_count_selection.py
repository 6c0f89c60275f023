"""Select the number of steps of implicit runs from the vibrations of a motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ancfsparse.integrators.interface.integrator import Integrator
from ancfsparse.integrators.interface.time_grid import MAX_STEPS
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.error_models.modal_spectrum import ModalSpectrum, Scheme
from ancfsparse.solve.error_models.run_differences import remaining_error

MIN_STEPS = 40.0  # steps of a run
RESOLUTION = 1.05  # relative resolution of numbers of steps
N_FIRST_RUNS = 20  # first runs that are compared
EXTRA_STEPS = 75.0  # cost of a run in addition to its steps: the first ones and the factors
MIN_STEP_RATIO = 1.5  # steps of a run over those of the last
MAX_STEP_RATIO = 3.5  # the same
SAFETY_FACTOR = 0.55  # of the accuracy, for which runs are planned
# Without it, runs under a pulse of 2 ms in 1 s take three times as many steps to 1e-5 m.
MAX_LOAD_CHANGE = 0.3  # of a load in a step, relative
ASSUMED_ORDER = 1.25  # of the error without its part of second order


@dataclass(frozen=True)
class StepPlan:
    """Choice of the runs of an implicit integrator of second order with equal or divided steps.

    Attributes
    ----------
    spectrum : ModalSpectrum
        The vibrations.
    integrator : Integrator
        The integrator.
    length : float
        Duration of the motion [s].
    min_steps : float, optional
        Steps of a run that resolve the loads and can be solved.
    """

    spectrum: ModalSpectrum
    integrator: Integrator
    length: float
    min_steps: float = MIN_STEPS

    def run(self, steps: float) -> Scheme:
        """Return the integrator with its mean step in a number of steps."""
        return self.integrator, self.length / steps

    def first(self, accuracy: float) -> tuple[int, float]:
        """Return the steps of the first run for an accuracy, and the cost of all runs in steps."""
        limit = find_smallest(lambda n: self._suffices(n, accuracy), self.min_steps)
        plans = []
        for steps in np.geomspace(self.min_steps, limit, N_FIRST_RUNS).tolist():
            plans.append((steps + EXTRA_STEPS + self.next([steps], accuracy)[1], steps))
        total, steps = min(plans)
        return math.ceil(steps), total

    def next(
        self, runs: Sequence[float], accuracy: float, excess: float = 1.0
    ) -> tuple[int, float]:
        """Return the steps of the next run, and the cost of all that follow in steps.

        Parameters
        ----------
        runs : list of float
            Steps of the last two runs, ascending, or of the only one.
        accuracy : float
            Requested accuracy, over the ratio of errors to predicted ones [m].
        excess : float, optional
            Additional error of two runs together over that ratio [-].
        """
        before, last = runs[0], runs[-1]
        plain = self._following(last, lambda n: self._suffices(n, accuracy))
        near = last if len(runs) > 1 else max(MIN_STEP_RATIO * last, self.min_steps)
        known = self.spectrum.extrapolated_error(self.run(before), self.run(near))

        def suffices_extrapolated(n: float) -> bool:
            remaining = known * remaining_error(n / before, ASSUMED_ORDER)
            error = self.spectrum.extrapolated_error(self.run(near), self.run(n))
            return excess * max(error, remaining) <= SAFETY_FACTOR * accuracy

        steps, total = self._following(near, suffices_extrapolated)
        if len(runs) == 1:
            steps, total = near, near + EXTRA_STEPS + total
        steps, total = min(plain, (steps, total), key=lambda plan: plan[1])
        return math.ceil(steps), total

    def _suffices(self, steps: float, accuracy: float) -> bool:
        return self.spectrum.error(self.run(steps)) <= SAFETY_FACTOR * accuracy

    def _following(self, last: float, is_enough: Callable[[float], bool]) -> tuple[float, float]:
        """Return the next of the runs up to the first that is enough, and their cost in steps."""
        n = find_smallest(is_enough, max(MIN_STEP_RATIO * last, self.min_steps))
        total = n + EXTRA_STEPS
        while n > MIN_STEP_RATIO * MAX_STEP_RATIO * max(last, self.min_steps):
            n /= MAX_STEP_RATIO
            total += n + EXTRA_STEPS
        return n, total


def find_smallest(
    is_enough: Callable[[float], bool], minimum: float, maximum: float = MAX_STEPS
) -> float:
    """Return the smallest number that is enough, to a few percent."""
    low = high = minimum
    while not is_enough(high) and high < maximum:
        low, high = high, 2.0 * high
    while high > RESOLUTION * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if is_enough(middle) else (middle, high)
    return high


def min_steps(discontinuities: LoadDiscontinuities, length: float) -> float:
    """Return the fewest equal steps that resolve the loads, at most those of their sampling."""
    steps = max(MIN_STEPS, length / discontinuities.longest_step)
    times, values = discontinuities.times, discontinuities.amplitudes
    size = np.max(np.abs(values), axis=0, initial=0.0)
    change = np.abs(np.diff(values, axis=0))
    for low, high in zip(discontinuities.before, discontinuities.after, strict=True):
        change[(times[:-1] <= high) & (times[1:] >= low)] = 0.0
    rates = change.max(axis=0, initial=0.0)[size > 0.0] / size[size > 0.0]
    largest = float(np.max(rates, initial=0.0))
    steps = max(steps, math.ceil(len(change) * largest / MAX_LOAD_CHANGE))
    return max(min(steps, len(times)), length / discontinuities.longest_step)
