"""Select the number of equal steps of implicit runs from the vibrations of a motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.integrators.interface.time_grid import MAX_STEPS
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.error_models.modal_error_model import ModalSpectrum

MIN_STEPS = 40  # steps of a run
STEP_RESOLUTION = 1.05  # relative resolution of numbers of steps
N_FIRST_RUNS = 20  # first runs that are compared
EXTRA_STEPS = 75.0  # cost of a run in addition to its steps: the first ones and the factors
MIN_STEP_RATIO = 1.5  # steps of a run over those of the last
MAX_STEP_RATIO = 3.5  # the same
SECOND_STEP_RATIO = 2.0  # the same, for the second of three runs
SAFETY_FACTOR = 0.55  # of the accuracy, for which runs are planned
MAX_LOAD_CHANGE = 0.3  # of a load in a step, relative
ASSUMED_ORDER = 1.25  # of the error without its part of second order
MIN_REMAINING = 1.0 / 12.0  # remaining error over the difference of two runs
MAX_REGULAR_PHASE = 1.0  # [rad]: up to it errors of two runs are assumed to cancel


@dataclass(frozen=True)
class StepPlan:
    """Errors of runs of the trapezoidal rule and similar methods, by their number of steps.

    Attributes
    ----------
    spectrum : ModalSpectrum
        The vibrations.
    length : float
        Duration of the motion [s].
    min_steps : float
        Steps of a run that resolve the loads and can be solved.
    """

    spectrum: ModalSpectrum
    length: float
    min_steps: float

    @classmethod
    def of(
        cls, spectrum: ModalSpectrum | None, discontinuities: LoadDiscontinuities, length: float
    ) -> StepPlan | None:
        """Return a plan; None without known vibrations, or if the loads require short steps."""
        if spectrum is None:
            return None
        steps = max(float(MIN_STEPS), length / discontinuities.longest_step)
        times, values = discontinuities.times, discontinuities.amplitudes
        size = np.max(np.abs(values), axis=0, initial=0.0)
        change = np.abs(np.diff(values, axis=0))
        for low, high in zip(discontinuities.before, discontinuities.after, strict=True):
            change[(times[:-1] <= high) & (times[1:] >= low)] = 0.0
        if size.size and size.max() > 0.0:
            rate = change.max(axis=0)[size > 0.0] / size[size > 0.0]
            steps = max(steps, math.ceil(len(change) * float(rate.max()) / MAX_LOAD_CHANGE))
        return cls(spectrum, length, steps) if 2 * steps < len(times) else None

    def error(self, steps: float) -> float:
        """Return the error of a run [m]."""
        return float(self.spectrum.amplitude @ np.minimum(1.0, self._phase(steps)))

    def difference(self, coarse: float, fine: float) -> float:
        """Return the difference of two runs [m]."""
        errors = [np.minimum(1.0, self._phase(steps)) for steps in (coarse, fine)]
        return float(self.spectrum.amplitude @ (errors[0] - errors[1]))

    def common_error(self, coarse: float, fine: float) -> float:
        """Return the error that two runs have in common [m]."""
        errors = [np.minimum(1.0, self._phase(steps)) for steps in (coarse, fine)]
        return float(self.spectrum.amplitude @ (errors[0] * errors[1]))

    def extrapolated_error(self, coarse: float, fine: float) -> float:
        """Return the error of two runs after Richardson extrapolation of second order [m]."""
        weight = 1.0 / ((fine / coarse) ** 2 - 1.0)
        one, other = self._phase(coarse), self._phase(fine)
        error = np.abs(
            (1.0 + weight) * (np.exp(1j * other) - 1.0) - weight * (np.exp(1j * one) - 1.0)
        )
        bound = (1.0 + weight) * np.minimum(other, 2.0) + weight * np.minimum(one, 2.0)
        return float(self.spectrum.amplitude @ np.where(one < MAX_REGULAR_PHASE, error, bound))

    def first(self, accuracy: float) -> tuple[int, float]:
        """Return the steps of the first run for an accuracy, and the cost of all runs in steps."""
        limit = self._min_steps(lambda n: self.error(n) <= SAFETY_FACTOR * accuracy, self.min_steps)
        plans = []
        for steps in np.geomspace(self.min_steps, limit, N_FIRST_RUNS).tolist():
            plans.append((steps + EXTRA_STEPS + self.next([steps], accuracy)[1], steps))
        total, steps = min(plans)
        return math.ceil(steps), total

    def next(self, runs: list[float], accuracy: float, excess: float = 1.0) -> tuple[int, float]:
        """Return the steps of the next run, and the cost of all that follow in steps.

        Parameters
        ----------
        runs : list of float
            Steps of the previous runs, ascending.
        accuracy : float
            Requested accuracy, over the ratio of errors to predicted ones [m].
        excess : float, optional
            Additional error of two runs together over that ratio [-].
        """
        aim, last = SAFETY_FACTOR * accuracy, runs[-1]
        options = [self._following(last, lambda n: self.error(n) <= aim)]
        before = runs[-2] if len(runs) > 1 else last
        near = last if len(runs) > 1 else SECOND_STEP_RATIO * last
        known = self.extrapolated_error(before, near)

        def regular(n: float) -> bool:
            ratio = max(1.0 / ((n / runs[0]) ** ASSUMED_ORDER - 1.0), MIN_REMAINING)
            return bool(excess * max(self.extrapolated_error(near, n), known * ratio) <= aim)

        steps, total = self._following(near, regular)
        options.append((steps, total) if len(runs) > 1 else (near, near + EXTRA_STEPS + total))
        steps, total = min(options, key=lambda option: option[1])
        return math.ceil(steps), total

    def _following(self, last: float, is_enough: Callable[[float], bool]) -> tuple[float, float]:
        """Return the next of the runs up to the first that is enough, and their cost in steps."""
        n = self._min_steps(is_enough, max(MIN_STEP_RATIO * last, self.min_steps))
        total = n + EXTRA_STEPS
        while n > MAX_STEP_RATIO * max(last, self.min_steps):
            n /= MAX_STEP_RATIO
            total += n + EXTRA_STEPS
        return n, total

    def _min_steps(self, is_enough: Callable[[float], bool], minimum: float) -> float:
        """Return the smallest number of steps that is enough, to a few percent."""
        low = high = minimum
        while not is_enough(high) and high < MAX_STEPS:
            low, high = high, 2.0 * high
        while high > STEP_RESOLUTION * low:
            middle = math.sqrt(low * high)
            low, high = (low, middle) if is_enough(middle) else (middle, high)
        return high

    def _phase(self, steps: float) -> Vector:
        """Return the phase error of each vibration [rad]."""
        z = self.spectrum.omega * (self.length / steps)
        return np.asarray(
            (1.0 - 2.0 * np.arctan(0.5 * z) / z) * self.spectrum.omega * self.spectrum.time
        )
