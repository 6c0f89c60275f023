"""Estimate the errors of explicit runs from their differences, and predict them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ancfsparse.integrators.explicit.explicit_methods import Explicit
from ancfsparse.solve.error_control.explicit_integration import ExplicitIntegration
from ancfsparse.solve.error_control.motion_task import MotionTask
from ancfsparse.solve.error_models.modal_spectrum import MIN_SCALE, ModalSpectrum, Scheme
from ancfsparse.solve.error_models.run_differences import (
    assumed_order,
    difference_frequency,
    difference_ratio,
    observed_order,
    remaining_error,
)
from ancfsparse.solve.stepping.sampled_states import SampledStates, distance

# Observed order over the theoretical one, above which a decrease is not that of shorter steps: of
# 950 random runs two were estimated at .42 and .14 of the accuracy and had errors of 2.0 and 5.1.
MAX_ORDER_RATIO = 1.25
FIRST_SCALE = 1.5  # error over the predicted one before the first run
# The same before an estimate, over the order: after a run whose vibrations are known, in the median
# it was 0.7 for order 2, 1.3 for 4 and 1.4 for 8.
ANALYSED_SCALE = 0.35
UNKNOWN_SCALE = 0.75  # the same if they are not known
# Difference of the first two runs over the predicted one, up to which they are assumed to converge:
# two runs of a cable that whips differ by 0.06 m, and would seem accurate to 0.01 m.
MAX_SECOND_SCALE = 30.0
# Runs of 105 and 230 steps of order 4 differed by a vibration with phases of 1.8 and .8 rad in a
# step, and converged with order 2.3: an estimate of .98 of the accuracy had an error of 2.6.  With
# 3.2 and 1.4 rad, the finer run being late by 1 rad at the end, one of .73 had an error of 2.2.
MAX_STEP_PHASE = 1.5  # rad of a resolved vibration in a step
MIN_ERROR_RATIO = 0.5  # error of a run over its difference from one of lower order


@dataclass(frozen=True)
class _Run:
    """A run with an integrator, and the ratio of the stable step to its step."""

    integrator: Explicit
    ratio: float
    states: SampledStates


class ExplicitErrors:
    """Error estimates from the differences of explicit runs.

    Parameters
    ----------
    task : MotionTask
        The motion.
    integration : ExplicitIntegration
        Provides the steps.

    Attributes
    ----------
    dominant : ModalSpectrum or None
        Vibration that causes the difference of two runs, perhaps of another candidate; None while
        it is not known.
    """

    def __init__(self, task: MotionTask, integration: ExplicitIntegration) -> None:
        self._task, self._integration = task, integration
        self._spectra = [] if task.spectrum is None else [task.spectrum]
        self._runs: list[_Run] = []  # the last three, by descending error
        self._last_difference = math.inf  # of the last two of one integrator
        # Error over the predicted one, and the part of it in proportion to the order.
        self._scale, self._scale_of_order = FIRST_SCALE, 0.0
        # Estimate for the last run, and its assumed order of convergence, 0 while unknown.
        self._error, self._power = math.inf, 0.0
        self.dominant: ModalSpectrum | None = None

    @property
    def may_predict(self) -> bool:
        """Return True if errors of further runs can be predicted."""
        return bool(self._spectra) or self.dominant is not None

    def shorten(self, by: float) -> None:
        """Scale the step ratios for a stable step that is shorter by a factor."""
        self._runs = [replace(run, ratio=by * run.ratio) for run in self._runs]

    def predicted(self, integrator: Explicit, ratio: float) -> float:
        """Return the predicted error of a run [m]."""
        scheme = integrator, self._integration.step(integrator, ratio)
        if self._spectra:
            scale = self._scale + self._scale_of_order * integrator.order
            error = scale * max(spectrum.error(scheme) for spectrum in self._spectra)
        else:
            assert self.dominant is not None
            error = self.dominant.error(scheme)
        if self._power > 0.0 and self._runs[-1].integrator == integrator:
            decrease = self._runs[-1].ratio / ratio
            error = max(error, self._error * decrease**self._power)
        return error

    def add(self, integrator: Explicit, ratio: float, states: SampledStates) -> float:
        """Return the estimated error of a run [m], infinite for the first one.

        A run of lower order than the last gives the error of the last.
        """
        run = _Run(integrator, ratio, states)
        if not self._runs:
            self._runs = [run]
            self._analyse(states)
            return math.inf
        last = self._runs[-1]
        difference = self._distance(run, last)
        omega = min(
            difference_frequency(self._task.system, states, last.states, resolved=True),
            self._integration.omega,
        )
        fine, coarse = sorted(
            (self._scheme(run), self._scheme(last)),
            key=lambda scheme: float(scheme[0].phase_error(np.array(omega * scheme[1]))),
        )
        self.dominant = ModalSpectrum.of_difference(
            difference, omega, self._task.length, coarse, fine
        )
        phase = float(self.dominant.phase_errors(fine)[0])
        # The difference is at least the difference of the errors of both orders.
        error = MIN_ERROR_RATIO * difference if phase < 1.0 else difference
        is_other = integrator != last.integrator
        if self._task.has_contact and is_other and error <= self._task.accuracy:
            # Errors depend on the times of impacts in the steps, and not on the order: two runs of
            # orders 4 and 8 agreed to 0.4 of the accuracy, and both had errors of 15.
            error = max(error, self._distance_of_two(run))
        if integrator.order < last.integrator.order:
            self._runs.insert(0, run)
            return error
        if last.integrator == integrator:
            is_resolved = omega * coarse[1] <= MAX_STEP_PHASE
            error, difference = self._error_of_one_order(
                run, difference, phase if is_resolved else math.inf
            )
            # Velocities have less of fast vibrations whose displacements are small.
            slower = difference_frequency(self._task.system, states, last.states)
            if min(omega, slower) * coarse[1] > MAX_STEP_PHASE:  # both may have lost the phase
                error = max(error, min(1.0, phase) * difference)
        else:
            self._power = 0.0
        if self._spectra:
            error = self._with_predicted_error(last, run, difference, error)
        if self._integration.rank_deficiency.time is not None:
            # Errors depend on the distance of a step from the singular configuration, and not on
            # the order.
            error = max(error, self._distance_of_two(run))
        self._error, self._last_difference = error, difference
        self._runs = [*self._runs[-2:], run]
        return error

    def _distance_of_two(self, run: _Run) -> float:
        """Return the distance within which two of the last three runs are, or the only one [m]."""
        near = sorted(self._distance(run, other) for other in self._runs)
        return near[min(1, len(near) - 1)]

    def _analyse(self, states: SampledStates) -> None:
        """Analyse the vibrations of the first run, for predictions."""
        system, spectrum = self._task.system, None
        if not (system.damped or system.n_multipliers):
            spectrum = ModalSpectrum.during(system, states)
        self._scale, self._scale_of_order = 0.0, UNKNOWN_SCALE
        if spectrum is not None:
            self._scale_of_order = ANALYSED_SCALE
            self._spectra.append(spectrum)

    def _error_of_one_order(
        self, run: _Run, difference: float, phase: float
    ) -> tuple[float, float]:
        """Return the error of a run, and its difference from the last without chance."""
        last, ratio, order = self._runs[-1], run.ratio, run.integrator.order
        power, unresolved = (
            assumed_order(order, x, self._task.has_contact) for x in (phase, math.inf)
        )
        bounds = []
        if len(self._runs) > 1 and self._runs[-2].integrator == run.integrator:
            before = self._runs[-2]
            steps = (before.ratio, last.ratio, ratio)
            observed = observed_order(steps[0], self._last_difference, *steps[1:], difference)
            if observed > MAX_ORDER_RATIO * order:
                power = min(power, unresolved)
            power = min(power, observed)
            # Differences that decrease faster than the order are small by chance.
            limit = self._last_difference * difference_ratio(*steps, MAX_ORDER_RATIO * order)
            difference = max(difference, limit)
            remaining = remaining_error(ratio / before.ratio, power)
            bounds = [self._distance(run, before) * remaining]
        error = difference * remaining_error(ratio / last.ratio, power)
        error = min(error, *bounds) if bounds else error
        self._power = max(power, unresolved)
        return error, difference

    def _with_predicted_error(
        self, last: _Run, run: _Run, difference: float, error: float
    ) -> float:
        """Return the error in view of the predicted one, and update their ratio."""
        coarse, fine = self._scheme(last), self._scheme(run)
        spectrum = max(self._spectra, key=lambda x: x.error(coarse))
        scale = spectrum.scale(difference, coarse, fine)
        is_second = all(x.integrator != run.integrator for x in self._runs[:-1])
        if scale > MAX_SECOND_SCALE and is_second:
            error = max(error, difference)
        if self._task.spectrum is not None:
            # Vibrations that both have dissipated do not appear in their difference.
            common = self._task.spectrum.common_error(coarse, fine)
            error = max(error, max(scale, 1.0) * common)
        if last.integrator == run.integrator:
            scale = error / max(spectrum.error(fine), np.finfo(float).tiny)
        self._scale, self._scale_of_order = max(scale, MIN_SCALE), 0.0
        return error

    def _scheme(self, run: _Run) -> Scheme:
        return run.integrator, self._integration.step(run.integrator, run.ratio)

    def _distance(self, one: _Run, other: _Run) -> float:
        return max(distance(self._task.system, one.states, other.states), np.finfo(float).tiny)
