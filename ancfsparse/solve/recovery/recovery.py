"""The interface of a recovery: an attempt at a step that the compiled loop has not solved."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.interface.time_grid import TimeGrid
from ancfsparse.nonlinear import Outcome
from ancfsparse.results import Event, RunStats
from ancfsparse.solve.stepping.outcome_reporting import CAUSE_NAMES, RECOVERABLE_OUTCOMES
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.seeds import Seed
    from ancfsparse.solve.stepping.implicit_setup import ImplicitSetup


class RecoverableRun(Protocol):
    """Data of a run that its recoveries use."""

    system: System
    setup: ImplicitSetup  # loops, first seed and criterion, while recoveries are constructed
    integrator: Implicit
    clock: TimeGrid
    stats: RunStats
    seeds: list[Seed]  # the last one is in use
    recovered: list[Event]
    max_halvings: int  # of a step
    longest_chunk: int  # of steps taken together

    def take_step(self, recovery: StepRecovery, outcome: Outcome) -> Outcome:
        """Take a failed step by a recovery; count and record it."""


class Recovery(ABC):
    """An attempt at a failed step; `name` denotes it in the documentation."""

    name: ClassVar[str]

    def __init__(self, run: RecoverableRun) -> None:
        self._run, self._system, self._clock = run, run.system, run.clock
        self._time_loop, self._iteration = run.setup.time_loop, run.setup.iteration

    def applies(self, outcome: Outcome) -> bool:
        """Return whether a step with an outcome can be recovered in this way."""
        return outcome in RECOVERABLE_OUTCOMES

    @abstractmethod
    def attempt(self, step: int, outcome: Outcome) -> Outcome:
        """Try to recover a step, and return its new outcome.

        Parameters
        ----------
        step : int
            Number of the failed step, from 1.
        outcome : Outcome
            Outcome of the failed step.
        """

    def _record(self, step: int, name: str, cause: Outcome, rate: float) -> None:
        event = Event(step, self._clock.at(step), name, CAUSE_NAMES[cause], rate)
        self._run.recovered.append(event)


class StepRecovery(Recovery):
    """A recovery that takes the failed step in another way.

    Attributes
    ----------
    is_inside_step : bool
        Whether the time loop is inside a step, in a state that is not one of the run.
    steps_to_projection : int
        Steps until velocities are projected next; 0 for none.
    """

    is_inside_step = False
    steps_to_projection = 0

    def __init__(self, run: RecoverableRun) -> None:
        super().__init__(run)
        self._integrator = run.integrator

    def attempt(self, step: int, outcome: Outcome) -> Outcome:
        """Try to recover a step, and return its new outcome."""
        return self._run.take_step(self, outcome)

    def _advance(self, step: int, loads: Vector) -> Outcome:
        """Advance the time loop to the end of a step, or of a part of it."""
        n, m = self._system.n_all, self._system.n_multipliers
        unused = [np.empty((1, width)) for width in (n, n, n, m)]
        self._iteration.step = step - 1
        _, code = self._time_loop.advance(self._iteration, 1, loads, 2, 0, *unused)
        return Outcome(code)

    @abstractmethod
    def solve(self, step: int, outcome: Outcome) -> Outcome:
        """Advance the time loop by a step; parameters as of `attempt`."""


RECOVERIES: dict[str, Callable[[RecoverableRun], bool]] = {
    "CompleteSeed": lambda run: run.setup.back is not None,
    "CompliantConstraints": lambda run: (
        run.system.n_multipliers > 0
        and any(body.masses is not None for body in run.system.scene.bodies)
    ),
    "StepHalving": lambda run: run.max_halvings > 0,
    "RepeatedSteps": lambda run: True,
}
"""Classes of this folder in the order in which they are attempted, and the runs that have them."""
