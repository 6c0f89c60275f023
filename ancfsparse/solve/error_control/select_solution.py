"""Runs that meet an accuracy: whole motions are compared, and the error of the last is estimated.

A local error estimate shows where steps must be short; only a comparison of two motions shows what
the local errors add up to.
"""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

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

Vector = NDArray[np.float64]

MOST_RUNS = 20
# Second order, damps what the steps cannot follow, and forgets what a change of step leaves.
USUAL = GeneralizedAlpha(0.9)
# Errors up to so many times the accuracy are of use to other ways.
USEFUL = 100.0
NOISE = 1e-13  # rounding of a position after many steps, over the size of the scene
# What the last run needs at least, over the smallest error of all, where rounding ended it.
CLEAR = 5.0


def check_accuracy(
    system: System,
    accuracy: float,
    tolerance: str | float,
    integrator: Implicit | Explicit | None,
    solver: Method | str,
    max_halvings: int = 0,
) -> None:
    """Refuse what does not go together with an accuracy.

    Raises
    ------
    InputError
        For an accuracy larger than the scene, for a tolerance or halvings of its own, an
        inverse that outlives its factor, or an integrator whose
        steps cannot be changed: one that keeps energy, one of first order, or the trapezoidal rule
        with multipliers, in which it keeps for ever what a change of step leaves in them; for an
        explicit one where there are multipliers or damping.
    """
    check_positive("accuracy", accuracy, "m")
    extent = _extent(system)
    if accuracy > extent:
        raise InputError(
            "{accuracy} is more than the scene, which measures {extent:.6g} m: ask for less, such "
            "as {less:.1g} m",
            accuracy=Parameter("accuracy", f"{accuracy:.6g} m"),
            extent=extent,
            less=1e-3 * extent,
        )
    if max_halvings:
        raise InputError(
            f"accuracy={accuracy:g} shortens steps by itself, as often as it takes: leave out "
            f"max_halvings={max_halvings}, or give dt and no accuracy"
        )
    if tolerance != "default":
        raise InputError(
            f"accuracy={accuracy:g} sets the tolerance of the iteration by itself: leave out "
            f"tolerance={tolerance!r}, or give dt and no accuracy"
        )
    if integrator is not None and integrator.order == 1:
        raise InputError(
            "{integrator!r} is of first order, whose error cannot be had from its steps: take "
            "HHT(alpha), {implicit} or Newmark(0)",
            integrator=integrator,
            implicit=Parameter("integrator", "GeneralizedAlpha(rho_inf)", separator=""),
        )
    if system.prescribed.differences:
        raise InputError(
            f"accuracy={accuracy:g} needs the rates of what moves as prescribed, and "
            f"{system.prescribed.differences} has none: give rate and second_rate, or a smooth "
            "Ramp or Sine"
        )
    if integrator is not None and integrator.keeps_energy:
        raise InputError(
            "{accuracy} changes steps by an error estimate, which {integrator!r} does not make: "
            "take {implicit}, or give {dt} and no {name}",
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
            "{accuracy} changes steps, and the trapezoidal rule keeps for ever what that leaves "
            "in the forces of the {first}: take {implicit}",
            accuracy=Parameter("accuracy", f"{accuracy:g}", "="),
            first=system.constraints.labels[0],
            implicit=Parameter("integrator", "GeneralizedAlpha(0.9)", "="),
        )
    if not isinstance(solver, str) and solver.is_dense:
        raise InputError(
            f"accuracy={accuracy:g} needs a factor that is renewed as the body moves, and "
            f"{solver!r} keeps its first: take solver='auto' or a number of pairs"
        )
    if not isinstance(solver, str) and solver.frame == "rotating":
        raise InputError(
            f"accuracy={accuracy:g} estimates errors with a factor of the body as it lies, which "
            "a rotating one is not: leave out seed_frame='rotating'"
        )


def solve_accurately(
    system: System,
    t: Vector,
    accuracy: float,
    integrator: Implicit | Explicit | None,
    solver: Method | str,
    max_energy_gain: float,
    progress: bool,
    attempts: BestSolution,
) -> None:
    """March whole motions with ever smaller errors until two of them agree well enough.

    Parameters
    ----------
    system : System
        What moves.
    t : (k,) float
        Times asked for, the first one that of the start [s].
    accuracy : float
        Largest error of the position of a node at these times [m].
    integrator : Implicit, Explicit or None
        None takes whichever is cheapest.
    solver, max_energy_gain, progress
        As in `simulate`.
    attempts : Attempts
        Takes the motions, the counts of all runs together, and the error of the best.

    Raises
    ------
    InputError
        If rounding alone is above the accuracy.
    AccuracyError
        If the error does not go down with the steps, or only their rounding is left of it.
    StepError, EnergyIncreaseError, InstabilityError
        If no step is short enough.  They count the steps of the last run alone.
    """
    size = largest_coordinate(system)
    if accuracy < NOISE * size:
        raise InputError(
            "{accuracy} is below what double precision can hold in a scene of {size:.3g} m, about "
            "{least:.2g} m: ask for more than that",
            accuracy=Parameter("accuracy", f"{accuracy:.3g} m"),
            size=size,
            least=NOISE * size,
        )
    begin, total = time.perf_counter(), attempts.stats
    ways = _ways(system, t, accuracy, integrator, solver, max_energy_gain, attempts)
    best = ways[0]
    with progress_bar("run", progress) as bar:
        while total.error > accuracy:
            costs = [way.forecast() for way in ways]
            first = int(np.argmin(costs))
            way, others = ways[first], min(costs[:first] + costs[first + 1 :], default=math.inf)
            # No other way leads where exact waves do not converge.
            hopeless = isinstance(ways[0], ExplicitCandidate) and isinstance(
                ways[0].failure, AccuracyError
            )
            if hopeless or costs[first] == math.inf or total.runs >= MOST_RUNS:
                for each in ways:
                    each.warn()
                raise _failure(ways, accuracy, total)
            try:
                way.advance(others)
            finally:
                add_counts(total, way.running)
                total.seconds["set-up"] = time.perf_counter() - begin - total.march_seconds
                attempts.finish()
            if way.error < USEFUL * accuracy:
                for other in ways:
                    if other is not way:
                        other.receive(way.content, way.states)
            bar.update(way.running.runs)
            bar.set_postfix_str(f"error {way.error:.1e} m")
            if way.states is not None and way.error <= total.error:
                total.error, total.solver = way.error, _reason(way, ways, costs)
                attempts.keep(way.states)
                best = way
            # The rounding of a step is about that of the largest coordinate.  In n steps it adds up
            # to about root n times as much.  Shorter steps only add to it, and take ever longer.
            rounding = EPSILON * size * math.sqrt(max(way.steps, 1))
            if accuracy < min(rounding, total.error) and total.error < math.inf:
                raise AccuracyError(accuracy, total.error, total.runs, CLEAR * total.error)
    best.warn()


def _ways(
    system: System,
    t: Vector,
    accuracy: float,
    integrator: Implicit | Explicit | None,
    solver: Method | str,
    max_energy_gain: float,
    attempts: BestSolution,
) -> list[ImplicitCandidate | ExplicitCandidate]:
    """Return the ways that a scene and what was asked for leave open."""
    discontinuities = LoadDiscontinuities(system.loads, float(t[0]), float(t[-1]))
    ways: list[ImplicitCandidate | ExplicitCandidate] = []
    spectrum = ModalSpectrum.of(system, discontinuities, float(t[-1]))
    force_cost = 0.0
    these = [integrator] if isinstance(integrator, Explicit) else _explicit(system)
    if isinstance(integrator, Explicit) or (integrator is None and solver == "auto" and these):
        explicit = ExplicitCandidate(
            system, t, accuracy, these, max_energy_gain, discontinuities, attempts.watch, spectrum
        )
        ways, force_cost = [explicit], explicit.force_cost
    if not isinstance(integrator, Explicit):
        given = (
            system,
            t,
            accuracy,
            integrator or USUAL,
            solver,
            max_energy_gain,
            attempts.stats.threads,
            discontinuities,
            attempts.watch,
            force_cost,
        )
        plan = StepPlan.of(spectrum, discontinuities, float(t[-1] - t[0]))
        implicit = ImplicitCandidate(*given) if plan is None else UniformStepCandidate(plan, *given)
        ways.append(implicit)
    return ways


def _explicit(system: System) -> list[Explicit]:
    """Return the explicit integrators that take a scene, by ascending order."""
    if system.depends_on_reactions or any(
        each.is_sliding for _, _, each in system.constraints.measures
    ):
        return []
    if not system.n_multipliers and not system.damped:
        return [CentralDifference(), RungeKuttaNystrom(4), RungeKuttaNystrom(8)]
    return [DormandPrince()]


def _reason(
    way: ImplicitCandidate | ExplicitCandidate,
    ways: list[ImplicitCandidate | ExplicitCandidate],
    costs: list[float],
) -> str:
    """Explain what was chosen, and why, by what was expected of each way before the last run."""
    taken = f"{way.name} in {way.steps} steps"
    other = next((each for each in ways if each is not way), None)
    if other is None:
        return f"{taken}: the only applicable method"
    mine, its = (costs[ways.index(each)] for each in (way, other))
    if other.failure is not None:
        return f"{taken}: selected as {other.name} failed"
    if mine == 0.0:
        return f"{taken}: its steps are so long that no other method was tried"
    return f"{taken}: expected to cost {mine / its:.2g} times as much as {other.name} by counts"


def _failure(
    ways: list[ImplicitCandidate | ExplicitCandidate], accuracy: float, total: RunStats
) -> Exception:
    """Return why no way led to the accuracy."""
    for way in ways:
        if isinstance(way.failure, StepError | InputError | LoadError):
            return way.failure
    return AccuracyError(accuracy, total.error, total.runs)


def _extent(system: System) -> float:
    """Return the largest side of the box around all nodes in the reference shape [m]."""
    places = [body.corners for body in system.scene.bodies]
    low = np.min([each.min(axis=0) for each in places], axis=0)
    high = np.max([each.max(axis=0) for each in places], axis=0)
    return float(np.max(high - low))
