"""Repeat the last steps of a motion by Newton's method where a later one fails."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.integrators.implicit.time_integration import Start
from ancfsparse.results import Event
from ancfsparse.solve.stepping.outcome_reporting import FailedStep
from ancfsparse.solve.stepping.state_recorder import StateRecorder
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import ImplicitLoop
    from ancfsparse.nonlinear.loop_protocols import NonlinearLoop


class Checkpoint(NamedTuple):
    """State of a run after a step, with all data on which its next steps depend.

    Attributes
    ----------
    step : int
        Number of steps taken before this state.
    state : tuple of float arrays
        Coordinates, velocities, accelerations and multipliers.
    memory : dict
        Memory of the time loop, copied.
    contributions : (k,) float
        Internal variables of contributions.
    rate, measured : float
        Contraction of the corrections, and the length of the first correction for which it was
        measured, see `NonlinearLoop`.
    next_projection, projection_interval : int
        Step after which velocities are projected next, and the steps between (`ImplicitRun`).
    """

    step: int
    state: tuple[Vector, Vector, Vector, Vector]
    memory: dict[str, Any]
    contributions: Vector
    rate: float
    measured: float
    next_projection: int
    projection_interval: int


class Failure(NamedTuple):
    """Failure of the selected method, which is reported if Newton's method fails too.

    Attributes
    ----------
    step : int
        Number of the failed step, from 1.
    report : FailedStep
        Its outcome, and a record of the loops after it.
    events : list of Event
        Events before the repetition.
    end : Checkpoint
        Last state that is kept.
    is_inside_step : bool
        Whether that state lies inside a step, which was divided, and is not one of the run.
    recorder : StateRecorder
        Recorder of the run, with its states.
    back : int
        Number of steps before the first repeated one.
    """

    step: int
    report: FailedStep
    events: list[Event]
    end: Checkpoint
    is_inside_step: bool
    recorder: StateRecorder
    back: int


class Repetition:
    """Two checkpoints of a run; its steps can be repeated from the older one.

    The equations of a step can have several solutions, above all in contact.  An accepted solution
    can lead to a later step that has no solution, or only solutions that gain energy, although
    another one could have been continued.  A repetition from the start is identical to the run by
    Newton's method.

    Parameters
    ----------
    system, time_loop, iteration
        The moving system and its compiled loops.
    interval : int
        Number of steps between checkpoints.
    """

    def __init__(
        self, system: System, time_loop: ImplicitLoop, iteration: NonlinearLoop, interval: int
    ) -> None:
        self._system, self._time_loop, self._iteration = system, time_loop, iteration
        self._interval, self._failed = interval, 0
        self._newer = self._older = self.save(0)

    def is_due(self, step: int) -> bool:
        """Return whether the next checkpoint is due after a step."""
        return step >= self._newer.step + self._interval

    def keep(self, checkpoint: Checkpoint) -> None:
        """Keep a checkpoint, and return to the selected method after the failed step."""
        self._older, self._newer = self._newer, checkpoint
        if self._failed and checkpoint.step > self._failed:
            self._iteration.newton, self._failed = False, 0

    def begin(self, failed: int) -> Checkpoint | None:
        """Return to the older checkpoint after a failed step, and select Newton's method.

        Returns None if that is in vain, because Newton's method failed, or only the failed step
        would be repeated.
        """
        back = self._older
        if self._iteration.newton or back.step >= failed - 1:
            return None
        self._failed, self._newer = failed, back
        self.restore(back)
        self._iteration.newton = True
        return back

    def save(self, step: int, next_projection: int = 0, projection_interval: int = 0) -> Checkpoint:
        """Return a checkpoint of the present state, after a number of steps."""
        loop, iteration = self._time_loop, self._iteration
        memory = {name: value.copy() for name, value in loop.memory.items()}
        contributions = np.array(self._system.assembly.memory)
        return Checkpoint(
            step,
            loop.state,
            memory,
            contributions,
            iteration.rate,
            iteration.measured,
            next_projection,
            projection_interval,
        )

    def restore(self, back: Checkpoint) -> None:
        """Set the loops and the internal variables of contributions to a checkpoint."""
        q, v, a, lam = back.state
        memory = back.memory
        b = memory.get("b0", a)
        start = Start(q, v, a, b, lam, memory["amplitudes0"])
        self._time_loop.move(start, memory.get("before", q), np.zeros(0), np.zeros(0))
        self._time_loop.recall(memory)
        self._system.assembly.begin(q)
        if len(back.contributions):
            self._system.assembly.memory = back.contributions
        self._iteration.rate, self._iteration.measured = back.rate, back.measured
        self._iteration.step = back.step
        self._iteration.mark_stale()
