"""Checkpoints of a run, and the repetition of steps from them by Newton's method."""

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
    from ancfsparse.integrators.interface.time_loops import ImplicitLoop, Loop
    from ancfsparse.nonlinear.loop_protocols import NonlinearLoop


class Checkpoint(NamedTuple):
    """State of a run after a step, with all data that its next steps depend on.

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
    solver : (14,) float
        Memory of the nonlinear loop; empty without one.
    next_projection, projection_interval : int
        Step after which velocities are projected next, and the steps between (`ImplicitRun`).
    """

    step: int
    state: tuple[Vector, Vector, Vector, Vector]
    memory: dict[str, Any]
    contributions: Vector
    solver: Vector
    next_projection: int = 0
    projection_interval: int = 0


def save(
    system: System,
    time_loop: Loop,
    iteration: NonlinearLoop | None,
    step: int,
    next_projection: int = 0,
    projection_interval: int = 0,
) -> Checkpoint:
    """Return a checkpoint of the present state, after a number of steps."""
    memory = {
        name: np.copy(value) if isinstance(value, np.ndarray) else value
        for name, value in time_loop.memory.items()
    }
    return Checkpoint(
        step,
        time_loop.state,
        memory,
        np.array(system.assembly.memory),
        np.empty(0) if iteration is None else iteration.memory,
        next_projection,
        projection_interval,
    )


def restore(
    system: System, time_loop: ImplicitLoop, iteration: NonlinearLoop, back: Checkpoint
) -> None:
    """Set implicit loops and the internal variables of contributions to a checkpoint.

    The seed is renewed in the next step.  Steps accepted on trial before are final.
    """
    time_loop.withdraw()
    q, v, a, lam = back.state
    memory = back.memory
    start = Start(q, v, a, memory.get("b0", a), lam, memory["amplitudes0"])
    time_loop.move(start, memory.get("before", q), np.zeros(0), np.zeros(0))
    time_loop.recall(memory)
    restore_contributions(system, back)
    iteration.memory = back.solver
    iteration.step = back.step
    iteration.mark_stale()


def restore_contributions(system: System, back: Checkpoint) -> None:
    """Set the internal variables of contributions to a checkpoint."""
    system.assembly.begin(back.state[0])
    if len(back.contributions):
        system.assembly.memory = back.contributions


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
    iteration : NonlinearLoop
        The compiled loop of corrections.
    interval : int
        Number of steps between checkpoints.
    first : Checkpoint
        The first checkpoint.

    Attributes
    ----------
    first_step : int
        Number of steps before the first one that can be repeated.
    """

    def __init__(self, iteration: NonlinearLoop, interval: int, first: Checkpoint) -> None:
        self._iteration, self._interval, self._failed = iteration, interval, 0
        self._newer = self._older = first
        self.first_step = first.step

    @property
    def is_begun(self) -> bool:
        """True while Newton's method takes the steps of a repetition."""
        return self._failed > 0

    def is_due(self, step: int) -> bool:
        """Return whether the next checkpoint is due after a step."""
        return step >= self._newer.step + self._interval

    def keep(self, newest: Checkpoint) -> None:
        """Keep a checkpoint, and return to the selected method after the failed step."""
        self._older, self._newer = self._newer, newest
        if self._failed and newest.step > self._failed:
            self._iteration.newton, self._failed = False, 0

    def begin(self, failed: int) -> Checkpoint | None:
        """Return the checkpoint from which the steps before a failed one are repeated.

        Returns None if that is in vain, because Newton's method failed, or only the failed step
        would be repeated, or if a step cannot be repeated.
        """
        back = self._older
        if self._iteration.newton or not self.first_step <= back.step < failed - 1:
            return None
        self._failed, self._newer = failed, back
        return back
