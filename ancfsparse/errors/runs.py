"""Errors that end a run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from ancfsparse.errors.inputs import AncfError, InputError
from ancfsparse.errors.message import (
    MessageStyle,
    MessageTemplate,
    Parameter,
    format_quantity,
    python_style,
)


@dataclass(eq=False, repr=False)
class StepError(AncfError, RuntimeError):
    """A time step could not be accepted.

    Parameters
    ----------
    reason : str or MessageTemplate
        Description of the failure (sentence or clause): "no convergence in 25 iterations".
    time : float
        Time at the end of the failed step [s].
    step : int
        Number of the failed step, from 1.
    dt : float
        Length of the failed step [s].
    residual : float
        Largest entry of the residual: in N for a position, N m for a slope, m for a constraint.
    where : str
        Beam, node and coordinate of that entry.
    trajectory : Trajectory, optional
        The accepted states before the failed step.
    advice : str, optional
        Advice, a sentence.
    unit : str, optional
        Unit of the residual.
    """

    reason: str | MessageTemplate
    time: float
    step: int
    dt: float
    residual: float
    where: str
    trajectory: Any = None
    advice: str = "Try a smaller dt."
    unit: str = ""

    def __post_init__(self) -> None:
        """Keep the reason as a text; `message` writes it in other styles."""
        super().__post_init__()
        self.reason = str(self.reason)

    def replace_advice(self, advice: str) -> None:
        """Set other advice, for a run whose settings the user has not chosen."""
        self.args = tuple(advice if each is self.advice else each for each in self.args)
        self.advice = advice

    def message(self, style: MessageStyle = python_style) -> str:
        """Return the message in a style."""
        template = self.args[0]
        is_template = isinstance(template, MessageTemplate)
        reason = template.format(style) if is_template else str(template)
        return (
            f"step {self.step} (t = {self.time:.6g} s, dt = {self.dt:.3g} s) failed: "
            f"{reason.rstrip('.')}. "
            f"The largest residual is {format_quantity(self.residual, self.unit, 3)} at "
            f"{self.where}. {self.advice}" + _states_note(self.trajectory)
        )


class ConvergenceError(StepError):
    """The iteration of a time step did not converge; parameters as in `StepError`."""


class EnergyIncreaseError(StepError):
    """A run was stopped because its energy increased without external work.

    Parameters
    ----------
    gain, exchanged : float
        Spurious energy, and the largest energy exchanged so far between motion, strain, gravity and
        loads [J]; with `when` the largest kinetic energy of the run.
    limit : float
        Largest ratio of the two that was allowed.
    time, step, dt, trajectory, advice
        As in `StepError`.  A step with many corrections is checked before it is accepted; otherwise
        the states may extend some steps beyond the beginning of the increase.
    when : int, optional
        Step after which the energy had increased, if this was detected at the end of the run: the
        increase of the first steps cannot be assessed before the motion has developed.
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
        """Return the message in a style."""
        ratio = self.gain / self.exchanged if self.exchanged > 0.0 else math.inf
        gained, compared = "the motion would gain", "energy exchanged so far"
        if self.when is not None:
            gained = f"after step {self.when} the motion had gained"
            compared = "kinetic energy of the run"
        return (
            f"stopped at step {self.step} (t = {self.time:.6g} s, dt = {self.dt:.3g} s): "
            f"{gained} {self.gain:.3g} J that no load accounts for, {100 * ratio:.3g} % of "
            f"the largest {compared} (allowed: {100 * self.limit:.3g} %). "
            f"{self.advice}" + _states_note(self.trajectory)
        )


@dataclass(eq=False, repr=False)
class InstabilityError(StepError):
    """An explicit run was stopped because its step exceeds the stability limit.

    Parameters as in `StepError`; `residual` is the spurious energy [J].
    """

    advice: str = (
        "Try a smaller dt, an implicit integrator such as GeneralizedAlpha(0.9), or "
        "max_energy_gain=inf to go on all the same."
    )
    unit: str = "J"

    def message(self, style: MessageStyle = python_style) -> str:
        """Return the message in a style."""
        return (
            f"stopped after step {self.step} (t = {self.time:.6g} s, dt = {self.dt:.3g} s): "
            f"{str(self.reason).rstrip('.')}. {self.advice}" + _states_note(self.trajectory)
        )


@dataclass(eq=False, repr=False)
class OutputError(AncfError, RuntimeError):
    """The file of a run cannot be extended, for example because the disk is full.

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

    reason: str
    path: str
    time: float
    trajectory: Any = None

    def message(self, style: MessageStyle = python_style) -> str:
        """Return the message in a style."""
        return (
            f"{self.path} cannot take the states after t = {self.time:.6g} s: {self.reason}. "
            "Free some space or write elsewhere, or save less with save_every or save_nodes."
            + _states_note(self.trajectory)
        )


@dataclass(eq=False, repr=False)
class AccuracyError(AncfError, RuntimeError):
    """The requested accuracy of a motion was not reached.

    Parameters
    ----------
    accuracy, error : float
        The requested accuracy, and the error estimate of the last run [m].
    runs : int
        Number of runs, each with shorter steps.
    within_reach : float, optional
        An attainable accuracy, if rounding errors limit the error [m].
    trajectory : Trajectory, optional
        The motion with the smallest error so far.
    """

    accuracy: float
    error: float
    runs: int
    within_reach: float | None = None
    trajectory: Any = None

    def message(self, style: MessageStyle = python_style) -> str:
        """Return the message in a style."""
        accuracy = style(Parameter("accuracy", f"{self.accuracy:.3g} m"))
        why = (
            " and no longer follows the steps. Request a larger accuracy, a shorter time (chaotic "
            "motions cannot be predicted for long), or smooth loads that jump."
        )
        if self.within_reach is not None:
            why = (
                ", which is the rounding error of this many steps, and shorter ones add to it. "
                f"Request {self.within_reach:.1g} m or more, or a shorter time."
            )
        return (
            f"{accuracy} was not reached: after {self.runs} runs, each with shorter steps, the "
            f"error is about {self.error:.3g} m" + why + _states_note(self.trajectory)
        )


@dataclass(eq=False, repr=False)
class PlanError(AncfError, RuntimeError):
    """The error of a quantity cannot be predicted.

    Parameters
    ----------
    quantity : str
        Description of the quantity.
    tolerance, difference : float
        The requested error, and the difference of the last two trial runs.
    unit : str
        Unit of both.
    runs : int
        Number of trial runs.
    t : float, optional
        Time of the largest difference, if meshes were refined too [s]; with `dt`, the time of the
        failed step of the last trial run.
    dt : float, optional
        Shortest steps of trial runs, if no step was short enough for a complete one [s].
    causes : tuple of str
        Observations in the trial runs, sentences without full stops.
    steps : int, optional
        Steps of the longest trial run, if further runs would take too long.
    """

    quantity: str
    tolerance: float
    difference: float
    unit: str
    runs: int
    t: float | None = None
    causes: tuple[str, ...] = ()
    dt: float | None = None
    steps: int | None = None

    def with_causes(self, causes: Sequence[str]) -> PlanError:
        """Return this error with further causes."""
        return replace(self, causes=(*self.causes, *causes))

    def message(self, style: MessageStyle = python_style) -> str:
        """Return the message in a style."""
        if self.t == 0.0:
            return (
                f"no plan: the {self.quantity} has no limit at t = 0, where it grows by "
                f"{self.difference:.3g} {self.unit} from a fine mesh to a finer one: the "
                "stress-free shape does not satisfy its supports. Begin with start='equilibrium', "
                "or request it at='end'."
            )
        causes = "".join(f"{each[0].upper()}{each[1:]}. " for each in self.causes)
        if self.dt is not None:
            return (
                f"no plan: trial runs for the {self.quantity} fail with any step; with steps of "
                f"{self.dt:.3g} s the last one failed at t = {self.t:.6g} s. {causes}Check loads "
                "and joints at that time, request a shorter time, or give the material "
                "axial_damping and bending_damping, or plan with integrator=EnergyMomentum()."
            )
        if self.steps is not None:
            return (
                f"no plan: {self.runs} trial runs of up to {self.steps} steps do not show the "
                f"error of the {self.quantity}, and more would take too long. {causes}Request a "
                "larger error or a shorter time, or run it with accuracy= or dt=."
            )
        refined = "steps are halved" if self.t is None else "meshes and steps are refined"
        where = "" if self.t is None else f", most at t = {self.t:.3g} s"
        return (
            f"no plan: the {self.quantity} does not converge as {refined}; after "
            f"{self.runs} trial runs the last two differ by "
            f"{format_quantity(self.difference, self.unit, 3)}{where}, and the requested error is "
            f"{format_quantity(self.tolerance, self.unit, 3)}. "
            + causes
            + "Request a larger error or a shorter time (chaotic motions cannot be predicted for "
            "long), or smooth loads that jump."
        )


@dataclass(eq=False, repr=False)
class LoadError(AncfError, RuntimeError):
    """A load function failed, or returned something other than a load.

    Parameters
    ----------
    reason : str
        The load, the time and the failure, a sentence.  An exception of the function is the cause
        of this error.
    time : float
        Time of the call [s].
    trajectory : Trajectory, optional
        The states up to this time.
    """

    reason: str
    time: float
    trajectory: Any = None

    def message(self, style: MessageStyle = python_style) -> str:
        """Return the message in a style."""
        if self.trajectory is None:
            return self.reason
        return f"{self.reason.rstrip('.')}." + _states_note(self.trajectory)


def _states_note(trajectory: Any) -> str:
    """Return a sentence on the states that an error contains, if it does."""
    if trajectory is None:
        return ""
    return " The states up to here are in the attribute `trajectory` of this error."


@contextmanager
def trial_call() -> Iterator[None]:
    """Raise a load failure in a trial call as an error of the argument."""
    try:
        yield
    except LoadError as failure:
        raise InputError(str(failure)) from failure.__cause__
