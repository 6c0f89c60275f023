"""A motion that is advanced step by step, from outside."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from threading import RLock
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count, check_finite, check_moderate, check_positive
from ancfsparse.errors import AncfError, InputError
from ancfsparse.messages import format_value
from ancfsparse.nonlinear import Method, Outcome
from ancfsparse.results import Equilibrium
from ancfsparse.scene import Input, Scene
from ancfsparse.scene.records.inputs import TRANSITIONS, Transition, make_transition
from ancfsparse.solve.error_models.signal_resolution import warn_of_unresolved_signals
from ancfsparse.solve.motion.arguments import (
    ENDLESS,
    check_request,
    select_halvings,
    select_integrator,
)
from ancfsparse.solve.motion.fixed_step_run import FixedStepRun
from ancfsparse.solve.motion.present_state import PresentState, Punctuality, StepCall
from ancfsparse.solve.motion.simulate import (
    build_run,
    build_system_at_start,
    warn_of_penetrations,
)
from ancfsparse.solve.preparation.memory_estimate import check_memory
from ancfsparse.solve.recovery.checkpoints import Checkpoint
from ancfsparse.solve.stepping.state_recorder import NoRecorder
from ancfsparse.system.contributions.force_elements.penetrations import LimitedPenetration
from ancfsparse.system.coordinates.state import State
from ancfsparse.system.used_inputs import inputs_of

if TYPE_CHECKING:
    from ancfsparse.integrators import Explicit, Implicit

ROUNDING = 1e-9  # of a time, over the step


class Snapshot:
    """State of a simulation that `Simulation.restore` returns to.

    Attributes
    ----------
    t : float
        Time [s].
    """

    def __init__(
        self,
        owner: Simulation,
        checkpoint: Checkpoint,
        memory: dict[str, Any],
        t: float,
        transitions: dict[str, Transition],
    ) -> None:
        self._owner, self._checkpoint, self._memory = owner, checkpoint, memory
        self.t, self._transitions = t, transitions

    def __repr__(self) -> str:
        """Name the time."""
        return f"Snapshot: t = {self.t:.6g} s"


class Simulation(PresentState):
    """A motion with a fixed step that is advanced on demand.

    Results have the names of those in a `Trajectory`, but no time axis:
    ``simulation.position(rod.end)`` is an array (dim,) at the present time.  All steps are those of
    `simulate`, bit for bit.

    Parameters
    ----------
    scene : Scene
        The scene.
    dt : float
        Time step [s].
    integrator, solver, factorization, tolerance, max_energy_gain, max_halvings, threads, start
        As in `simulate`.

    Attributes
    ----------
    steps : int
        Number of steps taken.

    Raises
    ------
    InputError
        If an argument is invalid.

    Notes
    -----
    Functions of time of prescribed motions are checked over the first 1000 steps only.  Unlike in
    `simulate`, mechanisms of rigid bodies are not carried across singular configurations.
    """

    def __init__(
        self,
        scene: Scene,
        dt: float,
        *,
        integrator: Implicit | Explicit | str = "auto",
        solver: Method | str = "auto",
        factorization: str = "auto",
        tolerance: str | float = "default",
        max_energy_gain: float = 0.01,
        max_halvings: int | None = None,
        threads: int = 1,
        start: State | Equilibrium | str | None = None,
    ) -> None:
        request = check_request(
            scene,
            None,
            dt,
            integrator=integrator,
            solver=solver,
            factorization=factorization,
            tolerance=tolerance,
            max_energy_gain=max_energy_gain,
            max_halvings=max_halvings,
            threads=threads,
            start=start,
        )
        request = replace(request, save_every=request.n_steps)
        needed = request.memory()
        check_memory(needed)
        self.system = build_system_at_start(request)
        warn_of_penetrations(request, self.system, stacklevel=3)
        warn_of_unresolved_signals(self.system, request.clock, request.n_steps, stacklevel=3)
        request = replace(request, n_steps=ENDLESS, save_every=ENDLESS)
        request = select_halvings(select_integrator(request, self.system), self.system)
        self._clock, self._settings = request.clock, request.settings | {"t_end": None}
        self._inputs = inputs_of(self.system)
        self._transitions: dict[str, Transition] = {}
        self._run = cast(FixedStepRun, build_run(request, self.system, needed))
        self._run.begin(NoRecorder())
        self._error: AncfError | None = None
        self._contacts = [
            each for each in self.system.contributions if isinstance(each, LimitedPenetration)
        ]
        self._calls, self._next_call, self._busy = [], 0, RLock()

    def __repr__(self) -> str:
        """Summarise time and steps in one line."""
        end = "" if self._error is None else ", ended by an error"
        return f"Simulation: t = {self.t:.6g} s after {self.steps} steps of {self.dt:g} s{end}"

    @property
    def dt(self) -> float:
        """Time step [s]."""
        return float(self._clock.dt)

    @property
    def state(self) -> State:
        """The present state; ``simulate(..., start=simulation.state)`` continues."""
        return self._run.last_state()

    def step(self, n: int = 1) -> None:
        """Take steps.

        Parameters
        ----------
        n : int, optional
            Number of steps.

        Raises
        ------
        StepError
            If a step fails; the simulation then stays at the last step before it.
        LoadError
            If a function of time fails.
        """
        if n != 1:
            n = check_count("n", n)
        end = self._run.steps + n
        if end < self._next_call or not self._calls:
            self._advance(end)
            return
        while self._run.steps < end:
            steps = self._run.steps
            due = min((x.every - steps % x.every for x in self._calls), default=n)
            self._next_call = steps + due
            self._advance(min(end, self._next_call))
            for each in tuple(self._calls):
                if self._run.steps % each.every == 0:
                    each.follow(self)

    def _advance(self, end: int) -> None:
        if self._error is not None:
            raise InputError(
                f"the simulation ended at t = {self.t:.6g} s with an error "
                f"({type(self._error).__name__}): restore a snapshot, or begin another simulation"
            ) from self._error
        with self._busy:
            before = TRANSITIONS.set(self._transitions)  # as `_signals`, which takes longer
            try:
                outcome = None
                self.system.assembly.forget()  # errors of functions in an earlier step
                try:
                    outcome = self._run.advance_to(end)
                finally:
                    if outcome != Outcome.CONVERGED:
                        self._run.keep_last_step()
                if outcome != Outcome.CONVERGED:
                    self._error = self._run.failure(outcome, self._trajectory())
                    raise self._error
            finally:
                TRANSITIONS.reset(before)
        for contact in tuple(self._contacts):
            for warning in contact.motion_warnings(lambda: f"before t = {self.t:.4g} s,"):
                self._contacts.remove(contact)  # one warning is enough
                warnings.warn(warning, stacklevel=3)

    @contextmanager
    def _signals(self) -> Iterator[None]:
        """Give the inputs of the scene the values of this simulation."""
        before = TRANSITIONS.set(self._transitions)
        try:
            yield
        finally:
            TRANSITIONS.reset(before)

    def set(
        self,
        which: Input,
        value: ArrayLike | None = None,
        *,
        rate: ArrayLike | None = None,
        over: float | None = None,
    ) -> None:
        """Set an input; it changes smoothly from its present value and rate.

        Parameters
        ----------
        which : Input
            An input that the scene uses.
        value : float or array_like, shape (size,), optional
            New value [unit of its use].  By default the present value, plus the rate times the
            duration.
        rate : float or array_like, shape (size,), optional
            Rate with which it arrives there and continues, by default zero [unit/s].
        over : float, optional
            Duration of the change [s], by default one step.  A load then reaches the new value at
            the end of the next step.

        Raises
        ------
        InputError
            If the scene has no such input, or a value is invalid.
        """
        which = self._own(which)
        duration = self.dt if over is None else check_moderate("over", over, "s")
        if value is None and rate is None:
            raise InputError("set needs a value, a rate, or both")
        velocity = np.zeros(which.size) if rate is None else which.check_value("the rate", rate)
        last = self._transitions.get(which.name, which.initial)
        t = self.t
        start = last.derivatives(t)
        if value is None:
            end = start[0] + duration * velocity
        else:
            end = which.check_value("the value", value)
        change = make_transition(t, duration, start, end, velocity)
        self._transitions = self._transitions | {which.name: change}
        self._run.forbid_repetition()

    def value(self, which: Input) -> float | Vector:
        """Return the present value of an input, a number or (size,) [unit of its use]."""
        which = self._own(which)
        value = self._transitions.get(which.name, which.initial).derivatives(self.t)[0]
        return value if which.size > 1 else float(value[0])

    def _own(self, which: Input) -> Input:
        """Return the input of the scene that has the name of one."""
        if not isinstance(which, Input) or which.name not in self._inputs:
            names = ", ".join(self._inputs) or "none"
            raise InputError(
                f"{format_value(which)} is not an input of this scene; its inputs are: {names}"
            )
        return self._inputs[which.name]

    def run_real_time(self, t: float, factor: float = 1.0) -> Punctuality:
        """Take steps to a time in real time: none ends before its time by the clock.

        Parameters
        ----------
        t : float
            Time of the end of a step [s].
        factor : float, optional
            Simulated time over time by the clock [-].

        Returns
        -------
        Punctuality
            Number of steps, number of late ones, and the largest delay [s].
        """
        check_positive("factor", factor)
        begin, clock, missed, latest = self.t, time.perf_counter(), 0, 0.0
        steps = self._steps_to(t)
        for _ in range(steps):
            self.step()
            ahead = (self.t - begin) / factor - (time.perf_counter() - clock)
            if ahead > 0.0:
                time.sleep(ahead)
            else:
                missed, latest = missed + 1, max(latest, -ahead)
        return Punctuality(steps, missed, latest)

    def run_until(self, condition: float | Callable[[Simulation], bool]) -> None:
        """Take steps to a time, or until a condition holds.

        Parameters
        ----------
        condition : float or callable
            Time of the end of a step, after the present one [s]; or a function of the simulation
            that is called after each step and returns True at the end.

        Raises
        ------
        InputError
            If the time is not the end of a later step.
        """
        if callable(condition):
            self.step()
            while not condition(self):
                self.step()
            return
        self.step(self._steps_to(condition))

    def _steps_to(self, t: float) -> int:
        """Return the number of steps from the present time to another one."""
        end = check_finite("the time to run to", t, "s")
        steps = (end - self.t) / self.dt
        n = round(steps)
        if n < 1 or abs(steps - n) > ROUNDING * max(1.0, abs(end) / self.dt):
            raise InputError(
                f"the time to run to must be a number of steps of {self.dt:g} s after the present "
                f"t = {self.t:.10g} s, got {end:.10g} s: try {self.t + max(1, n) * self.dt:.10g} s"
            )
        return n

    def on_step(self, call: Callable[[Simulation], object], every: int = 1) -> None:
        """Call a function with the simulation after every step, or every few steps.

        Parameters
        ----------
        call : callable
            The function.
        every : int, optional
            Number of steps between two calls.
        """
        if not callable(call):
            raise InputError(f"on_step needs a function, got {format_value(call)}")
        self._add_call(StepCall(call, check_count("every", every)))

    def snapshot(self) -> Snapshot:
        """Return the present state with all data that the next steps depend on.

        The matrix is factored again in the next step, so that these steps and those after a
        `restore` are equal bit for bit.  One exception: a run whose factorization has become
        complete since (``stats.solver`` says so) keeps it, and its steps are equal to rounding.
        """
        saved = self._run.save_checkpoint()
        return Snapshot(self, saved, self._run.describe_memory(), self.t, self._transitions)

    def restore(self, snapshot: Snapshot) -> None:
        """Return to a snapshot of this simulation.

        Raises
        ------
        InputError
            If the snapshot is of another simulation.
        """
        if not isinstance(snapshot, Snapshot) or snapshot._owner is not self:
            raise InputError(
                f"restore needs a snapshot of this simulation, got {format_value(snapshot)}: to "
                "continue from a state of another one, begin a simulation with start="
            )
        self._run.take_memory(snapshot._memory)
        self._run.return_to(snapshot._checkpoint)
        self._transitions, self._error, self._next_call = snapshot._transitions, None, 0
