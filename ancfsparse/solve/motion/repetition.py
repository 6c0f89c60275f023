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
    """State of a run after a step, with all that its next steps need.

    Attributes
    ----------
    step : int
        Number of steps before.
    state : tuple of float arrays
        Coordinates, velocities, accelerations and multipliers.
    memory : dict
        Memory of the time loop, with arrays of its own.
    contributions : (k,) float
        Internal variables of contributions.
    rate, measured : float
        Contraction of the corrections, and the length it holds for, see `NonlinearLoop`.
    """

    step: int
    state: tuple[Vector, Vector, Vector, Vector]
    memory: dict[str, Any]
    contributions: Vector
    rate: float
    measured: float


class Failure(NamedTuple):
    """Failure of the selected method, which remains if Newton's method fails too.

    Attributes
    ----------
    step : int
        Number of the failed step, from 1.
    report : FailedStep
        Its outcome, and a record of the loops after it.
    events : list of Event
        Recovered steps before.
    end : Checkpoint
        State after the last step that is kept.
    is_inside_step : bool
        Whether that is a state inside a step, not one of the run.
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
    """Two checkpoints of a run, the older of which its steps can be repeated from.

    Equations of a step can have several solutions, above all in contact.  A solution that is
    accepted can lead to a step that has none, or only solutions that gain energy, while another one
    can be continued.  In its first steps, a repetition is the run by Newton's method, bit for bit.

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

    def keep(self, step: int) -> None:
        """Take a checkpoint after a step if one is due."""
        if step < self._newer.step + self._interval:
            return
        self._older, self._newer = self._newer, self.save(step)
        if self._failed and step > self._failed:
            self._iteration.newton, self._failed = False, 0

    def begin(self, failed: int) -> int | None:
        """Return to the older checkpoint after a failed step, for steps by Newton's method.

        Return the number of steps before it; None if a repetition would be in vain.
        """
        back = self._older
        if self._iteration.newton or back.step >= failed - 1:
            return None
        self._failed, self._newer = failed, back
        self.restore(back)
        self._iteration.newton = True
        return back.step

    def save(self, step: int) -> Checkpoint:
        """Return a checkpoint of the present state, after a number of steps."""
        loop, iteration = self._time_loop, self._iteration
        memory = {name: value.copy() for name, value in loop.memory.items()}
        contributions = np.array(self._system.assembly.memory)
        return Checkpoint(
            step, loop.state, memory, contributions, iteration.rate, iteration.measured
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
