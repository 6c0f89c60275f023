"""How many equal steps implicit runs should take, where the vibrations of a motion are known."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.integrators.interface.time_grid import MOST_STEPS
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.error_models.modal_error_model import ModalSpectrum

Vector = NDArray[np.float64]

# Fewest steps of a run, relative resolution of numbers of steps, and first runs that are compared.
FEWEST, FINER, THOUGHT_OF = 40, 1.05, 20
# Steps that a run costs beside its own: the first ones and the factors.
BESIDE = 75.0
# How much more steps a run has than the last at least and at most, and the second of three.
CLOSER, FURTHEST, TWICE = 1.5, 3.5, 2.0
# Share of the accuracy that runs are planned for.
SAFETY = 0.55
# A load must not change by more of itself than this in a step.
CHANGE = 0.3
# Power of the step with which the rest without the second power falls, as far as that is believed;
# share of a difference that is always left.
BELIEVED, LEAST_LEFT = 1.25, 1.0 / 12.0
# Phase [rad] up to which errors of two runs are taken to cancel.
REGULAR = 1.0


@dataclass(frozen=True)
class StepPlan:
    """Errors of runs of the trapezoidal rule and its relatives, by the number of their steps.

    Attributes
    ----------
    waves : Waves
        What the motion is made of.
    length : float
        Its time [s].
    fewest : float
        Steps of a run at least: they follow the loads, and can be solved.
    """

    waves: ModalSpectrum
    length: float
    fewest: float

    @classmethod
    def of(
        cls, waves: ModalSpectrum | None, breaks: LoadDiscontinuities, length: float
    ) -> StepPlan | None:
        """Return a plan; None where vibrations are not known or loads ask for short steps."""
        if waves is None:
            return None
        steps = float(FEWEST)
        times, values = breaks.times, breaks.amplitudes
        size = np.max(np.abs(values), axis=0, initial=0.0)
        change = np.abs(np.diff(values, axis=0))
        for low, high in zip(breaks.before, breaks.after, strict=True):
            change[(times[:-1] <= high) & (times[1:] >= low)] = 0.0
        if size.size and size.max() > 0.0:
            most = change.max(axis=0)[size > 0.0] / size[size > 0.0]
            steps = max(steps, math.ceil(len(change) * float(most.max()) / CHANGE))
        return cls(waves, length, steps) if 2 * steps < len(times) else None

    def plain(self, steps: float) -> float:
        """Return the error of a run [m]."""
        return float(self.waves.amplitude @ np.minimum(1.0, self._phase(steps)))

    def apart(self, coarse: float, fine: float) -> float:
        """Return the distance of two runs [m]."""
        lost = [np.minimum(1.0, self._phase(steps)) for steps in (coarse, fine)]
        return float(self.waves.amplitude @ (lost[0] - lost[1]))

    def unseen(self, coarse: float, fine: float) -> float:
        """Return what two runs are both off, so that their distance does not show it [m]."""
        lost = [np.minimum(1.0, self._phase(steps)) for steps in (coarse, fine)]
        return float(self.waves.amplitude @ (lost[0] * lost[1]))

    def mixed(self, coarse: float, fine: float) -> float:
        """Return the error of two runs without their error of second order [m]."""
        weight = 1.0 / ((fine / coarse) ** 2 - 1.0)
        one, other = self._phase(coarse), self._phase(fine)
        left = np.abs(
            (1.0 + weight) * (np.exp(1j * other) - 1.0) - weight * (np.exp(1j * one) - 1.0)
        )
        most = (1.0 + weight) * np.minimum(other, 2.0) + weight * np.minimum(one, 2.0)
        return float(self.waves.amplitude @ np.where(one < REGULAR, left, most))

    def first(self, accuracy: float) -> tuple[int, float]:
        """Return the steps of the first run, and what all runs cost in steps, for an accuracy."""
        most = self._fewest_that(lambda n: self.plain(n) <= SAFETY * accuracy, self.fewest)
        plans = []
        for steps in np.geomspace(self.fewest, most, THOUGHT_OF).tolist():
            plans.append((steps + BESIDE + self.next([steps], accuracy)[1], steps))
        total, steps = min(plans)
        return math.ceil(steps), total

    def next(self, runs: list[float], accuracy: float, rough: float = 1.0) -> tuple[int, float]:
        """Return the steps of the next run, and what all that follow cost in steps.

        Parameters
        ----------
        runs : list of float
            Steps of the runs there are, ascending.
        accuracy : float
            Requested accuracy, over the ratio of errors to predicted ones [m].
        rough : float, optional
            By how much two runs together have more error than that [-].
        """
        aim, last = SAFETY * accuracy, runs[-1]
        ways = [self._following(last, lambda n: self.plain(n) <= aim)]
        before = runs[-2] if len(runs) > 1 else last
        near = last if len(runs) > 1 else TWICE * last
        known = self.mixed(before, near)

        def regular(n: float) -> bool:
            share = max(1.0 / ((n / runs[0]) ** BELIEVED - 1.0), LEAST_LEFT)
            return bool(rough * max(self.mixed(near, n), known * share) <= aim)

        then, total = self._following(near, regular)
        ways.append((then, total) if len(runs) > 1 else (near, near + BESIDE + total))
        then, total = min(ways, key=lambda way: way[1])
        return math.ceil(then), total

    def _following(self, last: float, does: Callable[[float], bool]) -> tuple[float, float]:
        """Return the next of runs that end with the first that does, and their cost in steps."""
        n = self._fewest_that(does, max(CLOSER * last, self.fewest))
        total = n + BESIDE
        while n > FURTHEST * max(last, self.fewest):
            n /= FURTHEST
            total += n + BESIDE
        return n, total

    def _fewest_that(self, does: Callable[[float], bool], least: float) -> float:
        """Return the fewest steps, not below the least, that do, to a few percent."""
        low = high = least
        while not does(high) and high < MOST_STEPS:
            low, high = high, 2.0 * high
        while high > FINER * low:
            middle = math.sqrt(low * high)
            low, high = (low, middle) if does(middle) else (middle, high)
        return high

    def _phase(self, steps: float) -> Vector:
        """Return the phase that each loses [rad]."""
        z = self.waves.omega * (self.length / steps)
        return np.asarray((1.0 - 2.0 * np.arctan(0.5 * z) / z) * self.waves.omega * self.waves.time)
