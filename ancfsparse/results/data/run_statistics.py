"""What a run cost, in counts first and in seconds second."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import NamedTuple


class Event(NamedTuple):
    """A step that its method could not solve, and what was tried next.

    Attributes
    ----------
    step : int
        Number of the step, from 1.  In a run to an accuracy, steps are numbered as ``stats.steps``
        counts them: those that were accepted, of all its runs one after another.
    time : float
        Time at its end [s]; each run to an accuracy starts at zero again.
    rung : str
        What was tried next: ``"new seed"``, ``"damped Newton"``, ``"Newton from rest"``, which
        starts without the acceleration of the last step, ``"descent"``, or ``"Newton"`` in place of
        a solution that gained energy; ``"8 steps of 0.001 s"`` where it was crossed in shorter
        ones, and ``"step of 0.001 s"`` or ``"shorter steps"`` where a run to an accuracy went on,
        or was begun again, with those.
    cause : str
        Why the attempt before had failed: ``"too many"`` iterations, ``"diverged"``,
        ``"not finite"``, or ``"indefinite"``: any of these on a factor with a wrong sign; or it
        was solved, and ``"gained energy"``.
    contraction : float
        Last ratio of two residuals in that attempt; not a number if there was none.
    """

    step: int
    time: float
    rung: str
    cause: str
    contraction: float


def _comparable(value: object) -> object:
    """Return a value with None for what is not a number, in sequences too."""
    if isinstance(value, float) and math.isnan(value):
        return None
    if isinstance(value, (list, tuple)):
        return [_comparable(each) for each in value]
    return value


@dataclass
class RunStats:
    """Counts and times of one run.

    Attributes
    ----------
    march_seconds : float
        Time of the compiled march alone, without set-up and output [s]; in statics of all load
        steps.
    steps : int
        Accepted time steps or load steps.
    iterations : int
        Corrections whose residual was looked at, or which ended a step by being small, summed over
        all steps.
    last_corrections : int
        Corrections by the residual that ended a step; they cost no residual and are not looked at.
    residual_evaluations : int
        Evaluations of the residual; accepted by residuals and without recoveries one more per step
        than iterations.
    factorizations : int
        Sparse factorizations.
    indefinite : int
        Those with a pivot of the wrong sign: compression beyond what the mass carries.
    negative_pivots : int
        Negative pivots of the stiffness at the equilibrium that statics found: directions in which
        it is unstable.
    material_seeds : int
        Indefinite ones that a factor with the material part of the stiffness alone replaced.
    rotating_seeds : int
        Seeds that were turned with the body.
    single_seeds : int
        Seeds that were kept in single precision, as those of large systems are.
    shifted_seeds : int
        Incomplete seeds that broke down and were made with a larger diagonal.
    sweeps, products : int
        Sweeps through an incomplete factor, and products with its matrix, in all solutions; 0 with
        complete seeds, whose solutions are a sweep each.
    solves : int
        Solutions with a factor or a dense inverse.
    pairs : int
        Secant pairs that were handed to an update.
    skipped_pairs : int
        Secant pairs an update refused.
    recoveries : int
        Steps that needed a rung of the ladder, from a new seed to another start.
    events : list of Event
        What was tried in them, at most the first thousand.
    short_steps : int
        Shorter steps that were accepted where one of a fixed length had failed and was halved; each
        of those counts once in `steps`.
    rejected_steps : int
        Steps that were solved and taken back because they were not accurate enough.
    runs : int
        Motions that were begun to reach an accuracy, those included that were given up because
        another method cost less; their counts are added up.
    error : float
        Estimated largest error of the position of a node at the saved times that the steps in time
        cause [m]; not a number where no accuracy was asked for.  In statics the last correction of
        a body, or how far the rounding of forces may move it if that is more.
    seconds : dict of str to float
        Time by part [s]: ``"set-up"`` always, and from a thousand unknowns on the march of an
        implicit run split into ``"force"``, ``"tangent"``, ``"factor"``, ``"solve"`` (pairs
        included) and ``"rest"``.
    solver : str
        The method and the reasons for its selection.
    threads : int
        Threads that shared the work at most; 1 for systems so small that more would not pay.
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

    def __post_init__(self) -> None:
        """Make events of what a file gave."""
        self.events = [Event(*event) for event in self.events]

    def __eq__(self, other: object) -> bool:
        """Compare field by field; a value that is not a number equals another one."""
        if not isinstance(other, RunStats):
            return NotImplemented
        return _comparable([*vars(self).values()]) == _comparable([*vars(other).values()])

    @property
    def method(self) -> str:
        """Name of the method, without the reasons for its selection, which `solver` states."""
        return re.split("[:;]", self.solver, maxsplit=1)[0]

    @property
    def iterations_per_step(self) -> float:
        """Mean number of iterations per step, whole or short; 0 if there was no step."""
        taken = self.steps + self.short_steps
        return self.iterations / taken if taken else 0.0
