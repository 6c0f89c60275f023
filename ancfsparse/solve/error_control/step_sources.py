"""Steps of implicit runs whose errors are comparable: in all of them the ratio of steps is one."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.errors import InputError, Parameter
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.interface.time_grid import MAX_STEPS
from ancfsparse.nonlinear.iteration import Costs
from ancfsparse.solve.error_control.motion_task import MotionTask
from ancfsparse.solve.error_models.modal_spectrum import ModalSpectrum
from ancfsparse.solve.error_models.step_count_selection import StepPlan

if TYPE_CHECKING:
    from ancfsparse.solve.error_control.step_size_controller import Pattern

# Residuals with their solutions in a step before the first run.  Vibrations excited nonlinearly are
# not predicted, and shorten steps of order 2 more than of order 8: so it is more than two.
RESIDUALS_PER_STEP = 3.8
RESTART_RATIO = 2.0  # steps of a restart over the steps of the failed run
# Local error over the one of a restart, for steps a third as long: with 8, a cantilever at rest
# under a force of 20 us failed six times in a row.
RESTART_ERROR_RATIO = 27.0
# A coarse first run is cheap, and shows the cost of finer ones with its divided steps.
FIRST_ERROR_RATIO = 1.3e-3  # intended error of the first run over the size of the scene
MIN_FORCES = 900.0  # evaluations of forces that the first steps of any run cost


class EqualSteps:
    """Equal steps in each interval of smooth loads, for a motion whose vibrations are known.

    With load discontinuities, later runs divide the steps of the first.

    Parameters
    ----------
    task : MotionTask
        The motion.
    plan : StepPlan
        Plan by the known vibrations.
    costs : Costs
        Costs of residuals, solutions and factors.

    Attributes
    ----------
    local_error, first_error : float
        Allowed error of a step, and intended error of a first run, whose steps are not given [m].
    """

    local_error, first_error = math.inf, math.inf

    def __init__(self, task: MotionTask, plan: StepPlan, costs: Costs) -> None:
        self._task, self._plan = task, plan
        self._step_cost = RESIDUALS_PER_STEP * costs.iteration
        self._first: tuple[int, float] | None = None
        self._pattern: Pattern = []

    @property
    def first_cost(self) -> float:
        """Predicted cost until the accuracy is met, before the first run."""
        return self._first_plan()[1] * self._step_cost

    def plan(self, dominant: ModalSpectrum | None) -> StepPlan | None:
        """Return the plan of further runs."""
        return self._plan

    def pattern(self, steps: int, last: int) -> Pattern | None:
        """Return the steps of the next run, after one with the number `last`; 0 for the first.

        None for steps that are controlled by their error.
        """
        if last and len(self._pattern) > 1:
            return divide_steps(self._pattern, steps, last)
        n = steps if last else self._first_plan()[0]
        if n > MAX_STEPS:
            raise InputError(
                "a run to {end} would take more than {most:.0e} steps: use a shorter time",
                end=Parameter("t_end", f"{self._task.t[-1]:g} s"),
                most=MAX_STEPS,
            )
        begins = [begin for begin, _ in self._task.discontinuities.spans]
        lengths = np.diff([self._task.t[0], *begins[1:], self._task.t[-1]]).tolist()
        counts = [math.ceil(n * length / self._task.length) for length in lengths]
        return [[(length / k, k)] for length, k in zip(lengths, counts, strict=True)]

    def begin(self, pattern: Pattern) -> None:
        """Take the steps of the first run."""
        self._pattern = pattern

    def shorten(self, steps: int) -> bool:
        """Plan shorter steps than in a failed run; return whether earlier runs still count."""
        self._plan, self._first = replace(self._plan, min_steps=RESTART_RATIO * steps), None
        return True

    def _first_plan(self) -> tuple[int, float]:
        if self._first is None:
            self._first = self._plan.first(self._task.accuracy)
        return self._first


class DividedSteps:
    """Steps of a first run that are controlled by their error, divided in later runs.

    Parameters and attributes are as of `EqualSteps`, and:

    Parameters
    ----------
    integrator : Implicit
        The integrator.
    force_cost : float
        Modelled cost of an evaluation of the forces; 0 if there is no other candidate.
    """

    def __init__(self, task: MotionTask, integrator: Implicit, force_cost: float) -> None:
        self._task, self._integrator = task, integrator
        size = float(np.max(np.abs(task.system.q0)))
        self.first_error = max(task.accuracy, FIRST_ERROR_RATIO * size)
        # Steps with an error A in total have A / N each, and N grows with the root of 1 / A.
        self.local_error = self.first_error * math.sqrt(self.first_error / size)
        self.first_cost = MIN_FORCES * force_cost
        self._pattern: Pattern = []

    def plan(self, dominant: ModalSpectrum | None) -> StepPlan | None:
        """Return the plan of further runs by the vibration in which two differ."""
        if dominant is None:
            return None
        return StepPlan(dominant, self._integrator, self._task.length)

    def pattern(self, steps: int, last: int) -> Pattern | None:
        """Return the steps of the next run; None for the first."""
        return divide_steps(self._pattern, steps, last) if last else None

    def begin(self, pattern: Pattern) -> None:
        """Take the steps of the first run."""
        self._pattern = pattern

    def shorten(self, steps: int) -> bool:
        """Plan another first run with shorter steps."""
        self.local_error /= RESTART_ERROR_RATIO
        return False


def divide_steps(pattern: Pattern, steps: int, last: int) -> Pattern:
    """Return a pattern of about a number of steps, more than the last, by division of each."""
    base = sum(n for rows in pattern for _, n in rows)
    # With at least twice the last, runs of short pulses agreed by chance: in steps divided by 1, 2
    # and 4 they seemed accurate to 5e-8 m, at an error of 1.3e-6 m.
    by = max(math.ceil(steps / base), last // base + 1)
    return [[(dt / by, n * by) for dt, n in rows] for rows in pattern]
