"""Error-controlled runs: select a candidate, integrate, and estimate the error of the result.

A local error estimate controls the steps; only the comparison of two motions shows the accumulated
error.
"""

from __future__ import annotations

import contextlib
import math
import time

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import AccuracyError, InputError, LoadError, StepError
from ancfsparse.integrators import EnergyMomentum, Explicit, GeneralizedAlpha, Implicit
from ancfsparse.integrators.names import EXPLICIT, integrator_of
from ancfsparse.nonlinear import Method
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.results import RunStats
from ancfsparse.solve.error_control.best_solution import BestSolution, add_counts
from ancfsparse.solve.error_control.explicit_candidate import ExplicitCandidate
from ancfsparse.solve.error_control.implicit_candidate import ImplicitCandidate
from ancfsparse.solve.error_control.motion_task import MotionTask
from ancfsparse.solve.preparation.progress_bar import progress_bar
from ancfsparse.solve.stepping.explicit_setup import check_explicit_scene
from ancfsparse.solve.stepping.sampled_states import largest_coordinate
from ancfsparse.system import System

MAX_RUNS = 20
# Second order, with damping of unresolved vibrations and of the effects of a step-size change.
DEFAULT_IMPLICIT = GeneralizedAlpha(0.9)
# In scenes with contact: it conserves the energy of impacts that its steps do not resolve.
CONTACT_IMPLICIT = EnergyMomentum()
MIN_CLEAR_ERROR = 5.0  # accuracy suggested after rounding over the smallest error

Candidate = ImplicitCandidate | ExplicitCandidate


def solve_accurately(
    system: System,
    t: Vector,
    accuracy: float,
    integrator: Implicit | Explicit | None,
    solver: Method | str,
    max_energy_gain: float,
    progress: bool,
    solution: BestSolution,
) -> None:
    """Integrate whole motions with decreasing errors until the estimate meets the accuracy.

    Parameters
    ----------
    system : System
        The moving system.
    t : (k,) float
        Output times from the start on [s].
    accuracy : float
        Largest error of the position of a node at these times [m].
    integrator : Implicit, Explicit or None
        None selects the cheapest.
    solver, max_energy_gain, progress
        As in `simulate`.
    solution : BestSolution
        Stores the motions, the statistics of all runs, and the error of the best.

    Raises
    ------
    AccuracyError
        If the error does not decrease with the steps, or is rounding.
    StepError, EnergyIncreaseError, InstabilityError
        If no step is short enough; with the number of steps of the last run.
    """
    begin, total, changes = time.perf_counter(), solution.stats, system.contact_changes
    task = MotionTask(system, t, accuracy, max_energy_gain, solution.watch)
    candidates = _candidates(task, integrator, solver, total.threads)
    size = largest_coordinate(system)
    best = candidates[0]
    with progress_bar("run", progress) as bar:
        while total.error > accuracy:
            costs = [candidate.predicted_cost() for candidate in candidates]
            first = int(np.argmin(costs))
            candidate = candidates[first]
            # If explicit waves do not converge, no other candidate does.
            is_hopeless = isinstance(candidates[0], ExplicitCandidate) and isinstance(
                candidates[0].failure, AccuracyError
            )
            if is_hopeless or costs[first] == math.inf or total.runs >= MAX_RUNS:
                for other in candidates:
                    other.warn()
                raise _candidate_error(candidates, accuracy, total)
            try:
                candidate.advance()
            finally:
                add_counts(total, candidate.last_stats)
                total.contact_changes = system.contact_changes - changes
                total.seconds["set-up"] = time.perf_counter() - begin - total.march_seconds
                solution.finish()
            for other in candidates:
                if other is not candidate:
                    other.receive(candidate.dominant, candidate.states)
            bar.update(candidate.last_stats.runs)
            bar.set_postfix_str(f"error {candidate.error:.1e} m")
            if candidate.states is not None and candidate.error <= total.error:
                total.error, total.solver = candidate.error, _reason(candidate, candidates, costs)
                solution.keep(candidate.states)
                best = candidate
            # The rounding of a step is relative to the largest coordinate and grows with the root
            # of the number of steps, so shorter steps only add to it.
            rounding = EPSILON * size * math.sqrt(max(candidate.steps, 1))
            if accuracy < min(rounding, total.error) and total.error < math.inf:
                raise AccuracyError(
                    accuracy, total.error, total.runs, MIN_CLEAR_ERROR * total.error
                )
    best.warn()


def _candidates(
    task: MotionTask, integrator: Implicit | Explicit | None, solver: Method | str, threads: int
) -> list[Candidate]:
    """Return the candidates that the scene and the arguments allow."""
    candidates: list[Candidate] = []
    if isinstance(integrator, Explicit):
        return [ExplicitCandidate(task, [integrator])]
    force_cost = 0.0
    if integrator is None and solver == "auto":
        methods = _explicit_integrators(task.system)
        if methods:
            explicit = ExplicitCandidate(task, methods)
            candidates, force_cost = [explicit], explicit.force_cost
    default = CONTACT_IMPLICIT if task.has_contact else DEFAULT_IMPLICIT
    implicit = ImplicitCandidate(task, integrator or default, solver, threads, force_cost)
    return [*candidates, implicit]


def _explicit_integrators(system: System) -> list[Explicit]:
    """Return the explicit integrators for a scene, by ascending order.

    Those that take velocities need more forces, and are the only ones of high order that satisfy
    constraints.
    """
    needs_velocities = bool(system.damped or system.n_multipliers)
    methods = [x for x in map(integrator_of, EXPLICIT) if isinstance(x, Explicit)]
    suitable = []
    for method in methods:
        if method.takes_velocities == needs_velocities:
            with contextlib.suppress(InputError):
                check_explicit_scene(system, method)
                suitable.append(method)
    return sorted(suitable, key=lambda method: method.order)


def _reason(candidate: Candidate, candidates: list[Candidate], costs: list[float]) -> str:
    """Explain the choice of a candidate by the costs predicted before the last run."""
    run = f"{candidate.name} in {candidate.steps} steps"
    other = next((x for x in candidates if x is not candidate), None)
    if other is None:
        return f"{run}: the only applicable method"
    cost, other_cost = (costs[candidates.index(x)] for x in (candidate, other))
    if other.failure is not None:
        return f"{run}: selected as {other.name} failed"
    if cost == 0.0:
        return f"{run}: its steps are so long that no other method was tried"
    return (
        f"{run}: expected to cost {cost / other_cost:.2g} times as much as {other.name} by counts"
    )


def _candidate_error(candidates: list[Candidate], accuracy: float, total: RunStats) -> Exception:
    """Return the error if no candidate meets the accuracy."""
    for candidate in candidates:
        if isinstance(candidate.failure, StepError | InputError | LoadError):
            return candidate.failure
    errors = [x.failure.error for x in candidates if isinstance(x.failure, AccuracyError)]
    return AccuracyError(accuracy, max([total.error, *errors]), total.runs)
