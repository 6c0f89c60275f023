"""Operation counts and computing times of a run."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field, replace
from typing import NamedTuple

MAX_EVENTS = 1000  # listed events of a run


class Event(NamedTuple):
    """A failed attempt at a step, and the next attempt.

    Attributes
    ----------
    step : int
        Number of the step, from 1.  In an error-controlled run this is the number of accepted steps
        of all its runs in sequence, as in ``stats.steps``.
    time : float
        Time at its end [s]; each run of an error-controlled simulation starts at zero.
    rung : str
        The next attempt: ``"new seed"``, ``"damped Newton"``, ``"Newton from rest"``, which starts
        without the acceleration of the last step, ``"descent"``, ``"damped Newton with more
        iterations"``, or ``"Newton"`` in place of a solution that gained energy; ``"8 steps of
        0.001 s"`` if the step was subdivided, and ``"step of 0.001 s"`` or ``"shorter steps"`` if
        an error-controlled run continued or restarted with these.
    cause : str
        Cause of the failure: ``"too many"`` iterations, ``"diverged"``, ``"not finite"``, or
        ``"indefinite"``: any of these with an indefinite factor; or ``"gained energy"`` of a
        converged step.
    contraction : float
        Last ratio of two residuals in that attempt; NaN if there was none.
    """

    step: int
    time: float
    rung: str
    cause: str
    contraction: float


def _comparable(value: object) -> object:
    """Return a value with NaN replaced by None, also in sequences."""
    if isinstance(value, float) and math.isnan(value):
        return None
    if isinstance(value, (list, tuple)):
        return [_comparable(each) for each in value]
    return value


ADDED = (
    *("march_seconds", "iterations", "last_corrections", "residual_evaluations", "factorizations"),
    *("indefinite", "material_seeds", "rotating_seeds", "single_seeds", "shifted_seeds"),
    *("pattern_changes", "contact_changes", "sweeps", "products", "solves", "pairs"),
    *("skipped_pairs", "recoveries", "events", "short_steps"),
)
"""Statistics that add up over the parts of a run with a fixed step."""


@dataclass
class RunStats:
    """Operation counts and times of one run.

    Attributes
    ----------
    march_seconds : float
        Time of the compiled time loop without set-up and output [s]; in statics time of all load
        steps.
    steps : int
        Accepted time steps or load steps.
    iterations : int
        Corrections of all steps whose residual was evaluated, or that ended a step by their size.
    last_corrections : int
        Final corrections by the residual that ended a step; their residual is not evaluated.
    residual_evaluations : int
        Evaluations of the residual; one more per step than iterations, if steps are accepted by
        their residual and without recovery.
    factorizations : int
        Sparse factorizations.
    indefinite : int
        Factorizations with a pivot of the wrong sign: compression beyond buckling of the effective
        stiffness.
    negative_pivots : int
        Negative pivots of the stiffness at a static equilibrium: number of unstable directions.
    material_seeds : int
        Indefinite factors replaced by those of the material part of the stiffness.
    rotating_seeds : int
        Seeds rotated with the body.
    single_seeds : int
        Seeds stored in single precision, as for large systems.
    shifted_seeds : int
        Incomplete factorizations that broke down and were repeated with a larger diagonal.
    pattern_changes : int
        Changes of the sparsity pattern, with a new elimination order, as other elements touch.
    contact_changes : int
        Accepted steps and substeps, also repeated ones, at whose end other points of a contact
        touch than at their start, between beams more or fewer points; the sum over all contacts.
    sweeps, products : int
        Sweeps through an incomplete factor, and products with its matrix, in all solutions; 0 for
        complete factors, which need one sweep per solution.
    solves : int
        Solutions with a factor or a dense inverse.
    pairs : int
        Secant pairs passed to an update.
    skipped_pairs : int
        Secant pairs rejected by an update.
    recoveries : int
        Steps that needed the recovery sequence, from a new seed to another initial guess.
    events : list of Event
        Attempts of the recovery sequence, at most the first thousand.
    short_steps : int
        Accepted substeps of failed fixed-length steps; each of the latter counts once in `steps`.
    rejected_steps : int
        Converged steps rejected by the error estimate.
    runs : int
        Runs of an error-controlled simulation, including those abandoned for a cheaper method; all
        counts are sums over them.
    error : float
        Estimated maximum time discretization error of the position of a node at the saved times
        [m]; NaN without a requested accuracy.  Of a planned run the larger of the predicted and the
        measured error of the first quantity [its unit].  In statics the last correction of a body,
        or the displacement by rounding errors of forces if that is larger.
    seconds : dict of str to float
        Time by part [s]: ``"set-up"`` always, and from a thousand unknowns on the time loop of an
        implicit run divided into ``"force"``, ``"tangent"``, ``"factor"``, ``"solve"`` (pairs
        included) and ``"rest"``.
    solver : str
        The method and the reasons for its selection.
    threads : int
        Largest number of threads; 1 for small systems, where more would cost time.
    checkpoints : list of int
        Numbers of steps before the checkpoints.
    """

    march_seconds: float = 0.0
    steps: int = 0
    iterations: int = 0
    last_corrections: int = 0
    residual_evaluations: int = 0
    factorizations: int = 0
    indefinite: int = 0
    negative_pivots: int = 0
    material_seeds: int = 0
    rotating_seeds: int = 0
    single_seeds: int = 0
    shifted_seeds: int = 0
    pattern_changes: int = 0
    contact_changes: int = 0
    sweeps: int = 0
    products: int = 0
    solves: int = 0
    pairs: int = 0
    skipped_pairs: int = 0
    recoveries: int = 0
    events: list[Event] = field(default_factory=list)
    short_steps: int = 0
    rejected_steps: int = 0
    runs: int = 1
    error: float = math.nan
    seconds: dict[str, float] = field(default_factory=dict)
    solver: str = ""
    threads: int = 1
    checkpoints: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Convert events read from a file, and keep the first thousand of two parts of a run."""
        self.events = [Event(*event) for event in self.events[:MAX_EVENTS]]

    def __eq__(self, other: object) -> bool:
        """Compare field by field; a value that is not a number equals another one."""
        if not isinstance(other, RunStats):
            return NotImplemented
        return _comparable([*vars(self).values()]) == _comparable([*vars(other).values()])

    def after(self, earlier: RunStats) -> RunStats:
        """Return the statistics of a run whose first part has others."""
        parts = {**earlier.seconds, **self.seconds}
        return replace(
            self,
            **{name: getattr(earlier, name) + getattr(self, name) for name in ADDED},
            seconds={
                part: earlier.seconds.get(part, 0.0) + self.seconds.get(part, 0.0) for part in parts
            },
        )

    @property
    def method(self) -> str:
        """Name of the method, without the reasons for its selection, which `solver` states."""
        return re.split("[:;]", self.solver, maxsplit=1)[0]

    @property
    def iterations_per_step(self) -> float:
        """Mean number of iterations per step or substep; 0 without steps."""
        steps = self.steps + self.short_steps
        return self.iterations / steps if steps else 0.0
