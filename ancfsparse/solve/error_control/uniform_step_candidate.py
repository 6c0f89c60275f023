"""Whole motions by an implicit integrator in equal steps, where the error of each is predicted."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ancfsparse.errors import EnergyIncreaseError, InputError, Parameter, StepError
from ancfsparse.integrators.interface.time_grid import MOST_STEPS
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.error_control.implicit_candidate import MOST_ATTEMPTS, ImplicitCandidate
from ancfsparse.solve.error_control.step_size_controller import Pattern, divided
from ancfsparse.solve.error_models.cost_model import CostModel
from ancfsparse.solve.error_models.step_count_selection import EXTRA_STEPS, StepPlan

# Residuals with their solutions that a step costs, about, before any is made.
EACH_STEP = 2.0
# Error of a run over the predicted one, at least; and the predicted distance of two runs over the
# error of the first, at least.
LEAST_SCALE, UNLIKE = 0.3, 0.3
# What runs are expected to cost over what is planned, before the first: waves set off by others are
# missing from the prediction, and shorten steps of order 2 much more than those of order 8.
DOUBT = 1.3
# How many times as many steps a run takes that gains energy or cannot be solved.
MORE = 2.0


class UniformStepCandidate(ImplicitCandidate):
    """One way to an accuracy, as `ImplicitCandidate` without the search for steps.

    Parameters
    ----------
    plan : StepPlan
        Errors by the number of steps.
    arguments
        As `ImplicitCandidate` takes them.
    """

    def __init__(self, plan: StepPlan, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._plan, self._scale = plan, 1.0
        # The error of two runs together, over the predicted one and that scale.
        self._rough = 1.0
        self._begin: tuple[int, float] | None = None  # what is planned before the first run
        # Runs are numbered by their steps.
        self._base, self._first_steps = 1, 0
        pattern = self._system.pattern
        seed = SparseSeed(pattern.indptr, pattern.indices, self._system.n_free, self._threads)
        cost_model = CostModel.of(self._system, self._integrator, seed)
        self._cost = EACH_STEP * (cost_model.residual + cost_model.solve)

    def forecast(self) -> float:
        """Return what is yet to be spent until the accuracy is met, as `CostModel` models it."""
        if self.failure is not None:
            return math.inf
        return (1.0 if self._runs else DOUBT) * self._planned()[1] * self._cost

    def advance(self, budget: float) -> None:
        """Make the next run."""
        pattern = self._next()
        n = sum(steps for rows in pattern for _, steps in rows)
        stepper = self._stepper(pattern=pattern, left=self._left(n))
        try:
            states = stepper.run()
        except (EnergyIncreaseError, StepError) as stop:
            self._count_attempt(stop, stepper)
            self.failure = stop if self._attempts == MOST_ATTEMPTS else None
            self._plan, self._begin = replace(self._plan, min_steps=MORE * n), None
            return
        finally:
            self.steps = stepper.stats.steps
        self._cost = stepper.cost_model.of_run(stepper.stats) / (n + EXTRA_STEPS)
        if self._runs:
            self._take(n, states)
        else:
            self._first_steps, self._pattern = n, pattern
            self._runs, self.states = [(n, states)], states

    def _planned(self) -> tuple[int, float]:
        """Return the steps of the next run, and what all that follow cost in steps."""
        accuracy = self._accuracy / self._scale
        if self._runs:
            return self._plan.next([steps for steps, _ in self._runs], accuracy, self._rough)
        if self._begin is None:
            self._begin = self._plan.first(accuracy)
        return self._begin

    def _next(self) -> Pattern:
        """Return the steps of the next run.

        Where loads jump, later runs divide the steps of the first, so that all their steps are in
        the same proportion.
        """
        n, t_end = self._planned()[0], float(self._t[-1])
        t_start = float(self._t[0])
        if n > MOST_STEPS:
            raise InputError(
                "a run to {end} would take more than {most:.0e} steps: ask for a shorter time",
                end=Parameter("t_end", f"{t_end:g} s"),
                most=MOST_STEPS,
            )
        if self._runs and len(self._pattern) > 1:
            last = round(self._runs[-1][0] / self._first_steps)
            return divided(self._pattern, max(math.ceil(n / self._first_steps), last + 1))
        begins = [begin for begin, _ in self._discontinuities.spans]
        lengths = np.diff([t_start, *begins[1:], t_end]).tolist()
        counts = [math.ceil(n * length / (t_end - t_start)) for length in lengths]
        return [[(length / k, k)] for length, k in zip(lengths, counts, strict=True)]

    def _unseen(self, apart: float, coarse: float, fine: float) -> float:
        """Return what two runs are both off, and learn from their distance [m]."""
        predicted = max(self._plan.difference(coarse, fine), UNLIKE * self._plan.error(coarse))
        self._scale = max(apart / max(predicted, np.finfo(float).tiny), LEAST_SCALE)
        if self._mixed_error < math.inf:
            mixed = max(
                self._scale * self._plan.extrapolated_error(coarse, fine), np.finfo(float).tiny
            )
            self._rough = max(1.0, self._mixed_error / mixed)
        return self._plan.common_error(coarse, fine)
