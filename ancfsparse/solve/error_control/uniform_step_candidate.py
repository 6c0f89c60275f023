"""Implicit candidate of an error-controlled run with equal steps and a predicted error."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ancfsparse.errors import EnergyIncreaseError, InputError, Parameter, StepError
from ancfsparse.integrators.interface.time_grid import MAX_STEPS
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.error_control.implicit_candidate import MAX_ATTEMPTS, ImplicitCandidate
from ancfsparse.solve.error_control.step_size_controller import Pattern, divide_steps
from ancfsparse.solve.error_models.cost_model import CostModel
from ancfsparse.solve.error_models.step_count_selection import EXTRA_STEPS, StepPlan

RESIDUALS_PER_STEP = 2.0  # residuals with their solutions in a step, before the first run
MIN_SCALE = 0.3  # error of a run over the predicted one
MIN_PREDICTED_RATIO = 0.3  # predicted difference of two runs over the error of the first
# Nonlinearly excited waves are not predicted, and shorten steps of order 2 more than of order 8.
FIRST_COST_FACTOR = 1.3  # cost over the planned one, before the first run
RESTART_RATIO = 2.0  # steps of a restart over the steps of the failed run


class UniformStepCandidate(ImplicitCandidate):
    """Implicit candidate with equal steps, as `ImplicitCandidate` without step-size control.

    Parameters
    ----------
    plan : StepPlan
        Errors by the number of steps.
    arguments
        As of `ImplicitCandidate`.
    """

    def __init__(self, plan: StepPlan, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._plan, self._scale = plan, 1.0
        # Error after extrapolation, over the predicted one and that scale.
        self._excess = 1.0
        self._begin: tuple[int, float] | None = None  # plan before the first run
        # Runs are numbered by their steps.
        self._base, self._first_steps = 1, 0
        pattern = self._system.pattern
        seed = SparseSeed(pattern.indptr, pattern.indices, self._system.n_free, self._threads)
        cost_model = CostModel.of(self._system, self._integrator, seed)
        self._cost = RESIDUALS_PER_STEP * (cost_model.residual + cost_model.solve)

    def predicted_cost(self) -> float:
        """Return the predicted cost until the accuracy is met, by `CostModel`."""
        if self.failure is not None:
            return math.inf
        return (1.0 if self._runs else FIRST_COST_FACTOR) * self._planned()[1] * self._cost

    def advance(self, budget: float) -> None:
        """Make the next run."""
        pattern = self._next()
        n = sum(steps for rows in pattern for _, steps in rows)
        controller = self._controller(pattern=pattern, iteration_error=math.inf)
        try:
            states = controller.run()
        except (EnergyIncreaseError, StepError) as stop:
            self._count_attempt(stop, controller)
            self.failure = stop if self._attempts == MAX_ATTEMPTS else None
            self._plan, self._begin = replace(self._plan, min_steps=RESTART_RATIO * n), None
            return
        finally:
            self.steps = controller.stats.steps
        self._cost = controller.cost_model.of_run(controller.stats) / (n + EXTRA_STEPS)
        if self._runs:
            self._add_run(n, states)
        else:
            self._first_steps, self._pattern = n, pattern
            self._runs, self.states = [(n, states)], states

    def _planned(self) -> tuple[int, float]:
        """Return the steps of the next run, and the cost of all that follow in steps."""
        accuracy = self._accuracy / self._scale
        if self._runs:
            return self._plan.next([steps for steps, _ in self._runs], accuracy, self._excess)
        if self._begin is None:
            self._begin = self._plan.first(accuracy)
        return self._begin

    def _next(self) -> Pattern:
        """Return the steps of the next run.

        With load discontinuities, later runs divide the steps of the first, so that all steps have
        the same ratio.
        """
        n, t_end = self._planned()[0], float(self._t[-1])
        t_start = float(self._t[0])
        if n > MAX_STEPS:
            raise InputError(
                "a run to {end} would take more than {most:.0e} steps: use a shorter time",
                end=Parameter("t_end", f"{t_end:g} s"),
                most=MAX_STEPS,
            )
        if self._runs and len(self._pattern) > 1:
            last = round(self._runs[-1][0] / self._first_steps)
            return divide_steps(self._pattern, max(math.ceil(n / self._first_steps), last + 1))
        begins = [begin for begin, _ in self._discontinuities.spans]
        lengths = np.diff([t_start, *begins[1:], t_end]).tolist()
        counts = [math.ceil(n * length / (t_end - t_start)) for length in lengths]
        return [[(length / k, k)] for length, k in zip(lengths, counts, strict=True)]

    def _common_error(self, difference: float, coarse: float, fine: float) -> float:
        """Return the common error of two runs, and update the scale by their difference [m]."""
        predicted = max(
            self._plan.difference(coarse, fine), MIN_PREDICTED_RATIO * self._plan.error(coarse)
        )
        self._scale = max(difference / max(predicted, np.finfo(float).tiny), MIN_SCALE)
        if self._extrapolated_error < math.inf:
            extrapolated = self._scale * self._plan.extrapolated_error(coarse, fine)
            self._excess = max(
                1.0, self._extrapolated_error / max(extrapolated, np.finfo(float).tiny)
            )
        return self._plan.common_error(coarse, fine)
