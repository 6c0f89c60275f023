"""What a run cost, in counts first and in seconds second."""

from __future__ import annotations

from dataclasses import dataclass, field


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
        Evaluations of the residual; judged by residuals and without recoveries one more per step
        than iterations.
    factorizations : int
        Sparse factorizations.
    indefinite : int
        Those with a pivot of the wrong sign: compression beyond what the mass carries.
    solves : int
        Solutions with a factor or a dense inverse.
    skipped_pairs : int
        Secant pairs an update refused.
    recoveries : int
        Steps that needed a new seed or damped Newton to converge.
    seconds : dict of str to float
        Time by part [s]: ``"set-up"`` always, and from a thousand unknowns on the march of an
        implicit run split into ``"force"``, ``"tangent"``, ``"factor"``, ``"solve"`` (pairs
        included) and ``"rest"``.
    solver : str
        What was chosen and why.
    """

    march_seconds: float = 0.0
    steps: int = 0
    iterations: int = 0
    last_corrections: int = 0
    residual_evaluations: int = 0
    factorizations: int = 0
    indefinite: int = 0
    solves: int = 0
    skipped_pairs: int = 0
    recoveries: int = 0
    seconds: dict[str, float] = field(default_factory=dict)
    solver: str = ""

    @property
    def iterations_per_step(self) -> float:
        """Mean number of iterations per step; 0 if there was no step."""
        return self.iterations / self.steps if self.steps else 0.0
