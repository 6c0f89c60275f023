"""Errors that end a run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ancfsparse.errors.inputs import AncfError, InputError
from ancfsparse.errors.message import (
    MessageStyle,
    MessageTemplate,
    Parameter,
    format_quantity,
    python_style,
)

KEPT = " The states up to here are in the attribute `trajectory` of this error."


class StepError(AncfError, RuntimeError):
    """A time step could not be accepted.

    Parameters
    ----------
    reason : str or Sentence
        What happened, as a sentence or the rest of one: "no convergence in 25 iterations".
    time : float
        Time at the end of the failed step [s].
    step : int
        Number of the failed step, counted from 1.
    dt : float
        Length of the failed step [s].
    residual : float
        Size of the largest entry of the residual left over: N for a position, N m for a slope, m
        for a constraint.
    where : str
        Beam, node and coordinate of that entry.
    trajectory : Trajectory, optional
        The accepted states before the failed step.
    advice : str, optional
        What to try, a sentence.
    unit : str, optional
        Of the residual.
    """

    def __init__(
        self,
        reason: str | MessageTemplate,
        time: float,
        step: int,
        dt: float,
        residual: float,
        where: str,
        trajectory: Any = None,
        advice: str = "Try a smaller dt.",
        unit: str = "",
    ) -> None:
        # All arguments go into `args`, so that the exception survives pickling between processes.
        super().__init__(reason, time, step, dt, residual, where, trajectory, advice, unit)
        self.reason = str(reason)
        self.time = time
        self.step = step
        self.dt = dt
        self.residual = residual
        self.where = where
        self.trajectory = trajectory
        self.advice = advice
        self.unit = unit

    def message(self, style: MessageStyle = python_style) -> str:
        """Compose the message a reader meets."""
        given = self.args[0]
        reason = given.format(style) if isinstance(given, MessageTemplate) else self.reason
        return (
            f"step {self.step} (t = {self.time:.6g} s, dt = {self.dt:.3g} s) failed: "
            f"{reason.rstrip('.')}. "
            f"The largest residual is {format_quantity(self.residual, self.unit, 3)} at "
            f"{self.where}. {self.advice}" + KEPT * (self.trajectory is not None)
        )


class ConvergenceError(StepError):
    """The equations of a time step were not solved; the parameters are those of `StepError`."""


class EnergyIncreaseError(StepError):
    """A run was stopped because it gained energy that nothing had given it.

    Parameters
    ----------
    gain, exchanged : float
        Energy above what was given, and the largest energy that had been exchanged between motion,
        strain, gravity and loads [J]; with `when` the largest kinetic energy of the run.
    limit : float
        Share of it that was allowed.
    time, step, dt, trajectory, advice
        As in `StepError`.  The step was not accepted if it took many corrections, since then its
        energy is looked at first; else the states may be some steps past where the gain began.
    when : int, optional
        The step after which the motion had that much, if it was found at the end of the run: what
        the first steps gain cannot be assessed before the motion has developed.
    """

    def __init__(
        self,
        gain: float,
        exchanged: float,
        limit: float,
        time: float,
        step: int,
        dt: float,
        trajectory: Any = None,
        advice: str = "Try a smaller dt.",
        when: int | None = None,
    ) -> None:
        where = "the whole scene"
        super().__init__("it gained energy", time, step, dt, gain, where, trajectory, advice)
        self.args = (gain, exchanged, limit, time, step, dt, trajectory, advice, when)
        self.gain = gain
        self.exchanged = exchanged
        self.limit = limit
        self.when = when

    def message(self, style: MessageStyle = python_style) -> str:
        """Compose the message a reader meets."""
        share = self.gain / self.exchanged if self.exchanged > 0.0 else math.inf
        gained, compared = "the motion would gain", "energy exchanged so far"
        if self.when is not None:
            gained = f"after step {self.when} the motion had gained"
            compared = "kinetic energy of the run"
        return (
            f"stopped at step {self.step} (t = {self.time:.6g} s, dt = {self.dt:.3g} s): "
            f"{gained} {self.gain:.3g} J that no load accounts for, {100 * share:.3g} % of "
            f"the largest {compared} (allowed: {100 * self.limit:.3g} %). "
            f"{self.advice}" + KEPT * (self.trajectory is not None)
        )


class InstabilityError(StepError):
    """An explicit run was stopped: its step has become too long for the motion.

    The parameters are those of `StepError`; `residual` is the energy gained [J].
    """

    def __init__(
        self,
        reason: str,
        time: float,
        step: int,
        dt: float,
        residual: float,
        where: str,
        trajectory: Any = None,
        advice: str = (
            "Try a smaller dt, an implicit integrator such as GeneralizedAlpha(0.9), or "
            "max_energy_gain=inf to go on all the same."
        ),
        unit: str = "J",
    ) -> None:
        super().__init__(reason, time, step, dt, residual, where, trajectory, advice, unit)

    def message(self, style: MessageStyle = python_style) -> str:
        """Compose the message a reader meets."""
        return (
            f"stopped after step {self.step} (t = {self.time:.6g} s, dt = {self.dt:.3g} s): "
            f"{self.reason.rstrip('.')}. {self.advice}" + KEPT * (self.trajectory is not None)
        )


class OutputError(AncfError, RuntimeError):
    """The file of a run can no longer be written, as when the disk is full.

    Parameters
    ----------
    reason : str
        Message of the operating system.
    path : str
        The file.
    time : float
        Time of the last state in it [s].
    trajectory : Trajectory, optional
        The states in it.
    """

    def __init__(self, reason: str, path: str, time: float, trajectory: Any = None) -> None:
        super().__init__(reason, path, time, trajectory)
        self.reason = reason
        self.path = path
        self.time = time
        self.trajectory = trajectory

    def message(self, style: MessageStyle = python_style) -> str:
        """Compose the message a reader meets."""
        return (
            f"{self.path} cannot take the states after t = {self.time:.6g} s: {self.reason}. "
            "Free some space or write elsewhere, or save less with save_every or save_nodes."
            + KEPT
            * (self.trajectory is not None)
        )


class AccuracyError(AncfError, RuntimeError):
    """The requested accuracy of a motion was not reached.

    Parameters
    ----------
    accuracy, error : float
        What was asked for, and the estimate for the last run [m].
    runs : int
        Number of runs, each with shorter steps.
    within_reach : float, optional
        Where the rounding of the steps is what is left of the error: an accuracy that is above it
        [m].
    trajectory : Trajectory, optional
        The motion with the smallest error so far.
    """

    def __init__(
        self,
        accuracy: float,
        error: float,
        runs: int,
        within_reach: float | None = None,
        trajectory: Any = None,
    ) -> None:
        super().__init__(accuracy, error, runs, within_reach, trajectory)
        self.accuracy = accuracy
        self.error = error
        self.runs = runs
        self.within_reach = within_reach
        self.trajectory = trajectory

    def message(self, style: MessageStyle = python_style) -> str:
        """Compose the message a reader meets."""
        accuracy = style(Parameter("accuracy", f"{self.accuracy:.3g} m"))
        if self.within_reach is not None:
            return (
                f"{accuracy} was not reached: after {self.runs} runs, each "
                f"with shorter steps, the error is about {self.error:.3g} m, which is the rounding "
                "of so many steps, and shorter ones add to it. Ask for "
                f"{self.within_reach:.1g} m or more, or for a shorter time."
                + KEPT
                * (self.trajectory is not None)
            )
        return (
            f"{accuracy} was not reached: after {self.runs} runs, each with "
            f"shorter steps, the error is about {self.error:.3g} m and no longer follows the "
            "steps. Ask for less, for a shorter time (a chaotic motion forgets its start), or "
            "smooth loads that jump." + KEPT * (self.trajectory is not None)
        )


class PlanError(AncfError, RuntimeError):
    """The error of a quantity cannot be predicted.

    Parameters
    ----------
    quantity : str
        What was asked for.
    asked, apart : float
        The error that was asked for, and by how much motions with half the step still differ.
    unit : str
        Of both.
    runs : int
        Number of motions that were compared.
    t : float, optional
        Where meshes were refined too: the time at which the last two differ most [s].
    causes : tuple of str
        What the motions, and what else was tried, have shown, in sentences without full stops.
    """

    def __init__(
        self,
        quantity: str,
        asked: float,
        apart: float,
        unit: str,
        runs: int,
        t: float | None = None,
        causes: tuple[str, ...] = (),
    ) -> None:
        super().__init__(quantity, asked, apart, unit, runs, t, causes)
        self.quantity, self.asked, self.apart = quantity, asked, apart
        self.unit, self.runs, self.t, self.causes = unit, runs, t, causes

    def because(self, causes: Sequence[str]) -> PlanError:
        """Return the same with further causes."""
        every = (*self.causes, *causes)
        return PlanError(self.quantity, self.asked, self.apart, self.unit, self.runs, self.t, every)

    def message(self, style: MessageStyle = python_style) -> str:
        """Compose the message a reader meets."""
        if self.t == 0.0:
            return (
                f"no plan: the {self.quantity} has no limit at t = 0, where it grows by "
                f"{self.apart:.3g} {self.unit} from a fine mesh to a finer one: the shape without "
                "stress does not suit what holds it. Begin with start='equilibrium', or ask for it "
                "at='end'."
            )
        refined = "steps are halved" if self.t is None else "meshes and steps are refined"
        where = "" if self.t is None else f", most at t = {self.t:.3g} s"
        return (
            f"no plan: the {self.quantity} does not converge as {refined}; after "
            f"{self.runs} motions the last two differ by {self.apart:.3g} {self.unit}".rstrip()
            + f"{where}, and {self.asked:.3g} {self.unit}".rstrip()
            + " was asked for. "
            + "".join(f"{each[0].upper()}{each[1:]}. " for each in self.causes)
            + "Ask for a larger error, for a shorter time (a chaotic "
            "motion forgets its start), or smooth loads that jump."
        )


class PlanChangedWarning(UserWarning):
    """A run has left the range that its plan assumed, and was planned again."""


class LoadError(AncfError, RuntimeError):
    """A load function failed, or returned something other than a load.

    Parameters
    ----------
    reason : str
        Which load, when, and what it did; a sentence.  What a function raised is the cause of this
        error.
    time : float
        The time it was called with [s].
    trajectory : Trajectory, optional
        The states up to there.
    """

    def __init__(self, reason: str, time: float, trajectory: Any = None) -> None:
        super().__init__(reason)
        self.args = (reason, time, trajectory)  # for pickling
        self.reason = reason
        self.time = time
        self.trajectory = trajectory

    def message(self, style: MessageStyle = python_style) -> str:
        """Compose the message a reader meets."""
        if self.trajectory is None:
            return self.reason
        return f"{self.reason.rstrip('.')}." + KEPT


@contextmanager
def trial_call() -> Iterator[None]:
    """Raise the failure of a function that is tried out as an error of the argument it was."""
    try:
        yield
    except LoadError as failure:
        raise InputError(str(failure)) from failure.__cause__
