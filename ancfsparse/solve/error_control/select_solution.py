"""Error-controlled runs: select a candidate, integrate, and estimate the error of the result.

A local error estimate controls the steps; only the comparison of two motions shows the accumulated
error.
"""

from __future__ import annotations

import math
import time

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_positive
from ancfsparse.errors import AccuracyError, InputError, LoadError, Parameter, StepError
from ancfsparse.integrators import (
    CentralDifference,
    DormandPrince,
    Explicit,
    GeneralizedAlpha,
    Implicit,
    Newmark,
    RungeKuttaNystrom,
)
from ancfsparse.nonlinear import Method
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.results import RunStats
from ancfsparse.solve.error_control.best_solution import BestSolution, add_counts
from ancfsparse.solve.error_control.explicit_candidate import ExplicitCandidate
from ancfsparse.solve.error_control.implicit_candidate import ImplicitCandidate
from ancfsparse.solve.error_control.uniform_step_candidate import UniformStepCandidate
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.error_models.modal_error_model import ModalSpectrum
from ancfsparse.solve.error_models.step_count_selection import StepPlan
from ancfsparse.solve.preparation.progress_bar import progress_bar
from ancfsparse.solve.stepping.explicit_setup import (
    check_explicit_scene,
    check_no_equations_options,
)
from ancfsparse.solve.stepping.sampled_states import largest_coordinate
from ancfsparse.system import System

MAX_RUNS = 20
# Second order, with damping of unresolved vibrations and of the effects of a step-size change.
DEFAULT_IMPLICIT = GeneralizedAlpha(0.9)
MAX_USEFUL_ERROR = 100.0  # error over the accuracy, up to which other candidates can use a run
ROUNDING_RATIO = 1e-13  # rounding of a position after many steps, over the size of the scene
MIN_CLEAR_ERROR = 5.0  # accuracy suggested after rounding over the smallest error


def check_accuracy(
    system: System,
    accuracy: float,
    tolerance: str | float,
    integrator: Implicit | Explicit | None,
    solver: Method | str,
    max_halvings: int = 0,
) -> None:
    """Check that options of a run are compatible with an accuracy.

    Raises
    ------
    InputError
        For an accuracy larger than the scene; a tolerance or halvings; an inverse that is never
        renewed; an integrator of first order or one that conserves energy; the trapezoidal rule
        with multipliers, in which the effect of a step-size change never decays; an explicit one
        that cannot handle multipliers or damping of the scene.
    """
    check_positive("accuracy", accuracy, "m")
    extent = _extent(system)
    if accuracy > extent:
        raise InputError(
            "{accuracy} exceeds the size of the scene ({extent:.6g} m): use a smaller value, such "
            "as {less:.1g} m",
            accuracy=Parameter("accuracy", f"{accuracy:.6g} m"),
            extent=extent,
            less=1e-3 * extent,
        )
    if max_halvings:
        raise InputError(
            f"accuracy={accuracy:g} shortens steps as needed: leave out "
            f"max_halvings={max_halvings}, or give dt and no accuracy"
        )
    if tolerance != "default":
        raise InputError(
            f"accuracy={accuracy:g} sets the tolerance of the iteration: leave out "
            f"tolerance={tolerance!r}, or give dt and no accuracy"
        )
    if integrator is not None and integrator.order == 1:
        raise InputError(
            "{integrator!r} is of first order and has no error estimate: use "
            "HHT(alpha), {implicit} or Newmark(0)",
            integrator=integrator,
            implicit=Parameter("integrator", "GeneralizedAlpha(rho_inf)", separator=""),
        )
    if system.prescribed.differences:
        raise InputError(
            f"accuracy={accuracy:g} needs the rates of prescribed motions, and "
            f"{system.prescribed.differences} has none: give rate and second_rate, or a smooth "
            "Ramp or Sine"
        )
    if integrator is not None and integrator.keeps_energy:
        raise InputError(
            "{accuracy} changes steps by an error estimate, which {integrator!r} does not have: "
            "use {implicit}, or give {dt} and no {name}",
            accuracy=Parameter("accuracy", f"{accuracy:g}", "="),
            integrator=integrator,
            implicit=Parameter("integrator", "GeneralizedAlpha(rho_inf)", separator=""),
            dt=Parameter("dt"),
            name=Parameter("accuracy"),
        )
    if isinstance(integrator, Explicit):
        check_no_equations_options(integrator, solver, "default")
        check_explicit_scene(system, integrator)
    if system.n_multipliers and integrator == Newmark(0.0):
        raise InputError(
            "{accuracy} changes steps, and with the trapezoidal rule the effect on the forces of "
            "the {first} never decays: use {implicit}",
            accuracy=Parameter("accuracy", f"{accuracy:g}", "="),
            first=system.constraints.labels[0],
            implicit=Parameter("integrator", "GeneralizedAlpha(0.9)", "="),
        )
    if not isinstance(solver, str) and solver.is_dense:
        raise InputError(
            f"accuracy={accuracy:g} needs a factor that is renewed during the motion, and "
            f"{solver!r} keeps its first: use solver='auto' or a number of pairs"
        )
    if not isinstance(solver, str) and solver.frame == "rotating":
        raise InputError(
            f"accuracy={accuracy:g} estimates errors with a factor in fixed directions: leave out "
            "seed_frame='rotating'"
        )


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
    InputError
        If rounding alone is above the accuracy.
    AccuracyError
        If the error does not decrease with the steps, or is rounding.
    StepError, EnergyIncreaseError, InstabilityError
        If no step is short enough; with the number of steps of the last run.
    """
    size = largest_coordinate(system)
    if accuracy < ROUNDING_RATIO * size:
        raise InputError(
            "{accuracy} is below the rounding of double precision in a scene of {size:.3g} m, "
            "about {least:.2g} m: use a larger value",
            accuracy=Parameter("accuracy", f"{accuracy:.3g} m"),
            size=size,
            least=ROUNDING_RATIO * size,
        )
    begin, total = time.perf_counter(), solution.stats
    candidates = _candidates(system, t, accuracy, integrator, solver, max_energy_gain, solution)
    best = candidates[0]
    with progress_bar("run", progress) as bar:
        while total.error > accuracy:
            costs = [candidate.predicted_cost() for candidate in candidates]
            first = int(np.argmin(costs))
            candidate = candidates[first]
            others = min(costs[:first] + costs[first + 1 :], default=math.inf)
            # If explicit waves do not converge, no other candidate does.
            is_hopeless = isinstance(candidates[0], ExplicitCandidate) and isinstance(
                candidates[0].failure, AccuracyError
            )
            if is_hopeless or costs[first] == math.inf or total.runs >= MAX_RUNS:
                for other in candidates:
                    other.warn()
                raise _candidate_error(candidates, accuracy, total)
            try:
                candidate.advance(others)
            finally:
                add_counts(total, candidate.last_stats)
                total.seconds["set-up"] = time.perf_counter() - begin - total.march_seconds
                solution.finish()
            if candidate.error < MAX_USEFUL_ERROR * accuracy:
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
    system: System,
    t: Vector,
    accuracy: float,
    integrator: Implicit | Explicit | None,
    solver: Method | str,
    max_energy_gain: float,
    solution: BestSolution,
) -> list[ImplicitCandidate | ExplicitCandidate]:
    """Return the candidates that the scene and the arguments allow."""
    discontinuities = LoadDiscontinuities(system, float(t[0]), float(t[-1]))
    candidates: list[ImplicitCandidate | ExplicitCandidate] = []
    spectrum = ModalSpectrum.of(system, discontinuities, float(t[-1]))
    force_cost = 0.0
    methods = [integrator] if isinstance(integrator, Explicit) else _explicit_integrators(system)
    if isinstance(integrator, Explicit) or (integrator is None and solver == "auto" and methods):
        explicit = ExplicitCandidate(
            system, t, accuracy, methods, max_energy_gain, discontinuities, solution.watch, spectrum
        )
        candidates, force_cost = [explicit], explicit.force_cost
    if not isinstance(integrator, Explicit):
        arguments = (
            system,
            t,
            accuracy,
            integrator or DEFAULT_IMPLICIT,
            solver,
            max_energy_gain,
            solution.stats.threads,
            discontinuities,
            solution.watch,
            force_cost,
        )
        plan = StepPlan.of(spectrum, discontinuities, float(t[-1] - t[0]))
        if plan is None:
            candidates.append(ImplicitCandidate(*arguments))
        else:
            candidates.append(UniformStepCandidate(plan, *arguments))
    return candidates


def _explicit_integrators(system: System) -> list[Explicit]:
    """Return the explicit integrators for a scene, by ascending order."""
    is_sliding = any(term.is_sliding for _, _, term in system.constraints.measures)
    if is_sliding or system.depends_on_reactions or system.assembly.n_history:
        return []
    if not system.n_multipliers and not system.damped:
        return [CentralDifference(), RungeKuttaNystrom(4), RungeKuttaNystrom(8)]
    return [DormandPrince()]


def _reason(
    candidate: ImplicitCandidate | ExplicitCandidate,
    candidates: list[ImplicitCandidate | ExplicitCandidate],
    costs: list[float],
) -> str:
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


def _candidate_error(
    candidates: list[ImplicitCandidate | ExplicitCandidate], accuracy: float, total: RunStats
) -> Exception:
    """Return the error if no candidate meets the accuracy."""
    for candidate in candidates:
        if isinstance(candidate.failure, StepError | InputError | LoadError):
            return candidate.failure
    return AccuracyError(accuracy, total.error, total.runs)


def _extent(system: System) -> float:
    """Return the largest side of the box around all nodes in the reference shape [m]."""
    corners = [body.corners for body in system.scene.bodies]
    low = np.min([points.min(axis=0) for points in corners], axis=0)
    high = np.max([points.max(axis=0) for points in corners], axis=0)
    return float(np.max(high - low))
