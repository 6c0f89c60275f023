"""Estimate the errors of explicit runs from their differences, and predict them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ancfsparse.integrators.explicit.explicit_methods import Explicit
from ancfsparse.integrators.explicit.nystrom_tableaus import Tableau
from ancfsparse.solve.error_control.explicit_integration import ExplicitIntegration
from ancfsparse.solve.error_models.modal_error_model import ModalSpectrum
from ancfsparse.solve.error_models.phase_error import (
    DominantFrequency,
    difference_frequency,
    difference_ratio,
    observed_order,
    phase_error,
)
from ancfsparse.solve.stepping.sampled_states import SampledStates, distance
from ancfsparse.system import System

# Assumed order of convergence over the theoretical one, by the latter: for a phase error of the
# difference of two runs below RESOLVED_PHASE, below 1, and above.  The second table is for runs
# that dissipate common vibrations of more than MAX_COMMON_RATIO.  Measured on 2300 pairs of runs
# of 80 random scenes, in which no error was more than 1.4 times the estimate.
RESOLVED_PHASE = 0.1  # [rad]
MAX_COMMON_RATIO = 0.1  # common error of two runs over their difference
ASSUMED_ORDERS = {2: (0.9, 0.75, 0.7), 4: (0.85, 0.5, 0.4), 8: (0.75, 0.45, 0.55)}
DISSIPATED_ORDERS = {2: (0.9, 0.75, 0.7), 4: (0.65, 0.5, 0.33), 8: (0.45, 0.3, 0.25)}
MIN_DIFFERENCE_RATIO = 0.1  # difference of two runs over the error of the second
MIN_ORDER_RATIO = {2: 0.6, 4: 0.6, 8: 0.8}  # of the order, for planning
MAX_ORDER_RATIO = 1.5  # of the order, beyond which a decrease is by chance
# Of the order, beyond which it is not that of shorter steps: of 950 random runs two were estimated
# at .42 and .14 of the accuracy and had errors of 2.0 and 5.1; with it the largest is 1.74.
MAX_CONFIRMED_RATIO = 1.25
ROUNDED = 1.0 + 1e-9  # ratio of equal ratios, with rounding errors
FIRST_SCALE = 1.5  # error over the predicted one before the first estimate
MIN_SCALE = 0.2  # error over the predicted one afterwards
MAX_SCALE = 1e3  # the same
# The same after a first run with known vibrations, by order.
ANALYSED_SCALES = {2: 0.7, 4: 1.3, 8: 1.4}
UNKNOWN_SCALES = {2: 1.5, 4: 2.0, 8: 6.0}  # the same with unknown vibrations
MIN_PREDICTED_RATIO = 0.3  # predicted difference of two runs over the predicted error of the first
MAX_AMPLITUDE_RATIO = 3.0  # amplitude of vibrations over the predicted one
MIN_ERROR_RATIO = 0.5  # error of a run over its difference from one of lower order
MAX_SCALE_WITHOUT_ORDER = 30.0  # difference over the predicted one, up to which order is assumed


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
    system : System
        The moving system.
    length : float
        Duration of the motion [s].
    integration : ExplicitIntegration
        Provides the steps.
    spectrum : ModalSpectrum or None
        Vibrations of the motion, if they are known.

    Attributes
    ----------
    dominant : DominantFrequency
        Vibration that causes the difference of two runs, perhaps of another candidate; None while
        it is not known.
    """

    def __init__(
        self,
        system: System,
        length: float,
        integration: ExplicitIntegration,
        spectrum: ModalSpectrum | None,
    ) -> None:
        self._system, self._length, self._start = system, length, spectrum
        self._integration = integration
        self._spectrum = [] if spectrum is None else [spectrum]
        self._runs: list[_Run] = []  # the last three, by descending error
        self._last_difference = math.inf  # of the last two of one integrator
        self._scale = dict.fromkeys(ASSUMED_ORDERS, FIRST_SCALE)  # by the order
        # Estimate for the last run, and its assumed order of convergence, 0 while unknown.
        self._error, self._power = math.inf, 0.0
        self.dominant: DominantFrequency | None = None

    @property
    def may_predict(self) -> bool:
        """Return True if errors of further runs can be predicted."""
        return bool(self._spectrum) or self.dominant is not None

    def shorten(self, by: float) -> None:
        """Scale the step ratios for a stable step that is shorter by a factor."""
        self._runs = [replace(run, ratio=by * run.ratio) for run in self._runs]

    def closest(self, integrator: Explicit, default_ratio: float, min_ratio: float) -> float:
        """Return the smallest step ratio to the last run.

        It may be small if the new run can be compared with the run before as well.
        """
        ratios = [run.ratio for run in self._runs if run.integrator == integrator]
        return (
            max(min_ratio, default_ratio * ratios[-2] / ratios[-1])
            if len(ratios) > 1
            else default_ratio
        )

    def predicted(self, integrator: Explicit, ratio: float) -> float:
        """Return the predicted error of a run [m]."""
        if self._spectrum:
            step = self._integration.step(integrator, ratio)
            tableau = integrator.tableau
            error = self._scale[tableau.order] * max(x.error(tableau, step) for x in self._spectrum)
        else:
            assert self.dominant is not None
            error = self.dominant.error(self._phase_error(integrator, ratio, self.dominant.omega))
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
            self._analyse(integrator, states)
            return math.inf
        last = self._runs[-1]
        difference = self._distance(run, last)
        omega = min(
            difference_frequency(self._system, states, last.states, resolved=True),
            self._integration.omega,
        )
        errors = sorted(self._phase_error(x.integrator, x.ratio, omega) for x in (last, run))[::-1]
        self.dominant = DominantFrequency.of(difference, omega, self._length, *errors)
        if integrator.tableau.order < last.integrator.tableau.order:
            self._runs.insert(0, run)
            return self._error_of_two_orders(difference)
        if last.integrator == integrator:
            error, difference, confirmed = self._error_of_one_order(run, difference)
        else:
            error, confirmed = self._error_of_two_orders(difference), False
            self._power = 0.0
        if self._spectrum:
            error = self._with_predicted_error(last, run, difference, error, confirmed)
        if self._integration.rank_deficiency.time is not None:
            # Errors depend on the distance of a step from the singular configuration, and not on
            # the order: two of the last three runs must be as near.
            near = sorted(self._distance(run, other) for other in self._runs)
            error = max(error, near[min(1, len(near) - 1)])
        self._error, self._last_difference = error, difference
        self._runs = [*self._runs[-2:], run]
        return error

    def _analyse(self, integrator: Explicit, states: SampledStates) -> None:
        """Analyse the vibrations of the first run, for predictions."""
        spectrum = None
        if not (self._system.damped or self._system.n_multipliers):
            spectrum = ModalSpectrum.during(self._system, states)
        if spectrum is not None:
            self._spectrum.append(spectrum)
        self._scale = UNKNOWN_SCALES if spectrum is None else ANALYSED_SCALES

    def _error_of_two_orders(self, difference: float) -> float:
        """Return the error of the higher order of two.

        Their difference is at least the difference of the errors of both orders.
        """
        assert self.dominant is not None
        return MIN_ERROR_RATIO * difference if self.dominant.phase_error < 1.0 else difference

    def _error_of_one_order(self, run: _Run, difference: float) -> tuple[float, float, bool]:
        """Return the error of a run, and its difference from the last without chance.

        The last value tells whether three runs confirm the order.
        """
        assert self.dominant is not None
        last, ratio, order = self._runs[-1], run.ratio, run.integrator.tableau.order
        phase = sum(self.dominant.phase_error >= limit for limit in (RESOLVED_PHASE, 1.0))
        common = 0.0
        if self._start is not None:
            common = self._start.common_error(*self._pair(last, run))
        is_small = self._start is None or common < MAX_COMMON_RATIO * difference
        power = order * (ASSUMED_ORDERS if is_small else DISSIPATED_ORDERS)[order][phase]
        before = self._runs[-2] if len(self._runs) > 1 else last
        confirmed = False
        if before is not last and before.integrator == run.integrator:
            steps = (before.ratio, last.ratio, ratio)
            observed = observed_order(steps[0], self._last_difference, *steps[1:], difference)
            # The order that similar steps show may not be that of much shorter ones: a run of 67
            # steps had 6 times the error that its difference from those of 24 and 30 suggested.
            is_near = ratio / last.ratio <= ROUNDED * last.ratio / before.ratio
            confirmed = is_near and power <= observed <= MAX_CONFIRMED_RATIO * order
            if observed > MAX_CONFIRMED_RATIO * order:
                power = order * ASSUMED_ORDERS[order][1]
            power = min(power, observed)
            # Differences that decrease faster than the order are small by chance.
            limit = self._last_difference * difference_ratio(*steps, MAX_ORDER_RATIO * order)
            difference = max(difference, limit)
            further = self._distance(run, before) * _error_ratio(ratio / before.ratio, power)
            error = min(difference * _error_ratio(ratio / last.ratio, power), further)
        else:
            error = difference * _error_ratio(ratio / last.ratio, power)
        self._power = max(power, MIN_ORDER_RATIO[order] * order)
        # Unresolved waves do not converge with the order: the full difference counts.
        is_resolved = is_small or phase < 2
        return (error if is_resolved else max(error, difference)), difference, confirmed

    def _with_predicted_error(
        self, last: _Run, run: _Run, difference: float, error: float, confirmed: bool
    ) -> float:
        """Return the error in view of the predicted one, and update their ratio."""
        tableaus, steps = self._pair(last, run)
        spectrum = max(self._spectrum, key=lambda x: x.error(tableaus[0], steps[0]))
        first, second = (spectrum.error(*x) for x in zip(tableaus, steps, strict=True))
        predicted = max(
            spectrum.difference(tableaus, steps), MIN_PREDICTED_RATIO * first, np.finfo(float).tiny
        )
        scale = difference / predicted
        if scale > MAX_SCALE_WITHOUT_ORDER and not confirmed:
            error = max(error, difference)
        if self._start is not None:
            # Vibrations that both have dissipated do not appear in their difference.
            factor = min(max(scale, 1.0), MAX_AMPLITUDE_RATIO)
            error = max(error, factor * self._start.common_error(tableaus, steps))
        if last.integrator == run.integrator:
            scale = error / max(second, np.finfo(float).tiny)
        self._scale = dict.fromkeys(ASSUMED_ORDERS, min(max(scale, MIN_SCALE), MAX_SCALE))
        return error

    def _pair(self, *runs: _Run) -> tuple[tuple[Tableau, Tableau], tuple[float, float]]:
        """Return tableaus and steps of two runs."""
        one, other = (
            (x.integrator.tableau, self._integration.step(x.integrator, x.ratio)) for x in runs
        )
        return (one[0], other[0]), (one[1], other[1])

    def _distance(self, one: _Run, other: _Run) -> float:
        return max(distance(self._system, one.states, other.states), np.finfo(float).tiny)

    def _phase_error(self, integrator: Explicit, ratio: float, omega: float) -> float:
        """Return the relative phase error of a vibration in a run."""
        return phase_error(integrator.tableau, omega * self._integration.step(integrator, ratio))


def _error_ratio(ratio: float, power: float) -> float:
    """Return the error of a run over its difference from one with longer steps by a ratio."""
    return float(1.0 / max(ratio**power - 1.0, MIN_DIFFERENCE_RATIO))
