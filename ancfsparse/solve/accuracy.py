"""Runs that meet an accuracy: whole motions are compared, and the error of the last one is told.

A local error estimate says where steps must be short; only a comparison of two motions says what
the local errors add up to.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from ancfsparse.checks import check_positive
from ancfsparse.errors import AccuracyFailure, EnergyGain, InputError
from ancfsparse.integrators import EnergyMomentum, Implicit, Newmark
from ancfsparse.nonlinear import Method, ModifiedNewton, Outcome, QuasiNewton
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.results import Event, RunStats
from ancfsparse.solve.setup import CAUSES
from ancfsparse.solve.steps import MOST_EVENTS, States, Stepper
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Error of a step in the first run, over the accuracy and the root of its share of the scene: steps
# that add up to an error A have A / N each, and their number N goes with the root of 1 / A.
FIRST = 0.5
# The second run's steps are half as long.  Those of later ones are shorter by what is wanted, but
# not by less than LEAST or more than MOST: closer, and the difference of two runs tells little;
# further, and nobody has seen whether the error obeys.
SECOND, LEAST, MOST = 2.0, 1.5, 5.0
SAFETY = 0.6  # share of the accuracy that the next run is meant for
MOST_RUNS = 12
STUCK = 0.7  # an error that falls by less than this, runs after runs, is not one of the steps
NOISE = 1e-13  # rounding of a position after many steps, over the size of the scene
# What the last run needs at least, over the smallest error of all, where rounding ended it.
CLEAR = 5.0


def check_accuracy(
    system: System,
    accuracy: float,
    tolerance: str | float,
    integrator: object,
    solver: Method | str,
    max_halvings: int = 0,
) -> Implicit:
    """Return the integrator, and refuse what cannot be meant together with an accuracy.

    Raises
    ------
    InputError
        For an accuracy larger than the scene, for a tolerance or halvings of its own, an
        inverse that outlives its factor, or an integrator whose
        steps cannot be changed: an explicit one, one that keeps energy, one of first order, or the
        trapezoidal rule with multipliers, in which it keeps for ever what a change of step leaves
        in them.
    """
    check_positive("accuracy", accuracy, "m")
    extent = _extent(system)
    if accuracy > extent:
        raise InputError(
            f"accuracy = {accuracy:.6g} m is more than the scene, which measures {extent:.6g} m: "
            f"ask for less, such as {1e-3 * extent:.1g} m"
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
    if isinstance(integrator, Newmark) and integrator.alpha > 0.0:
        raise InputError(
            f"{integrator!r} is of first order, whose error cannot be had from its steps: take "
            "HHT(alpha), GeneralizedAlpha(rho_inf) or Newmark(0)"
        )
    if isinstance(integrator, EnergyMomentum):
        raise InputError(
            f"accuracy={accuracy:g} changes steps by an error estimate, which {integrator!r} does "
            "not make: take GeneralizedAlpha(rho_inf), or give dt and no accuracy"
        )
    if not isinstance(integrator, Implicit):
        raise InputError(
            f"accuracy={accuracy:g} changes steps, which {integrator!r} does not: take an implicit "
            "integrator such as GeneralizedAlpha(0.9), or give dt and no accuracy"
        )
    if system.n_multipliers and integrator == Newmark(0.0):
        raise InputError(
            f"accuracy={accuracy:g} changes steps, and the trapezoidal rule keeps for ever what "
            f"that leaves in the forces of the {system.constraints.labels[0]}: take "
            "integrator=GeneralizedAlpha(0.9)"
        )
    if isinstance(solver, QuasiNewton) and solver.memory == "full":
        raise InputError(
            f"accuracy={accuracy:g} needs a factor that is renewed as the body moves, and "
            f"{solver!r} keeps its first: take solver='auto' or a number of pairs"
        )
    if isinstance(solver, ModifiedNewton | QuasiNewton) and solver.seed_frame == "rotating":
        raise InputError(
            f"accuracy={accuracy:g} estimates errors with a factor of the body as it lies, which "
            "a rotating one is not: leave out seed_frame='rotating'"
        )
    return integrator


def solve_accurately(
    system: System,
    t: Vector,
    accuracy: float,
    integrator: Implicit,
    solver: Method | str,
    max_energy_gain: float,
    progress: bool,
    threads: int = 1,
) -> tuple[States, RunStats]:
    """March with errors per step that shrink until the motion as a whole is accurate enough.

    The error of a scheme of second order goes with the square of its steps, and those with the
    cube root of the error allowed in each.  So two runs tell the error of the second, and how small
    the error of a step must be.

    Parameters
    ----------
    system : System
        What moves.
    t : (k,) float
        Times asked for, the first one 0 [s].
    accuracy : float
        Largest error of the position of a node at these times [m].
    integrator, solver, max_energy_gain, progress, threads
        As in `simulate`.

    Returns
    -------
    states : States
        Of the last run.
    stats : RunStats
        Counts of all runs together, and the error of the last one.

    Raises
    ------
    InputError
        If rounding alone is above the accuracy.
    AccuracyFailure
        If the error does not go down with the steps, or only their rounding is left of it.
    StepFailure, EnergyGain
        If no step is short enough.  They count the steps of the last run alone.
    """
    size = float(np.max(np.abs(system.q0)))
    if accuracy < NOISE * size:
        raise InputError(
            f"accuracy = {accuracy:.3g} m is below what double precision can hold in a scene of "
            f"{size:.3g} m, about {NOISE * size:.2g} m: ask for more than that"
        )
    chosen, why = "", "error estimates use its factor, which is one of the body as it lies"
    if solver == "auto":
        solver, chosen = ModifiedNewton(), f"modified Newton: {why}"
    if isinstance(solver, ModifiedNewton | QuasiNewton):
        solver = replace(solver, seed_frame="fixed")
    total = RunStats(runs=0, threads=threads)
    before: States | None = None
    local, shrink, error, stuck = FIRST * accuracy * math.sqrt(accuracy / size), SECOND, np.inf, 0
    least = np.inf
    begin = time.perf_counter()
    with tqdm(unit="run", disable=not progress, leave=False) as bar:
        while total.runs < MOST_RUNS and stuck < 3:
            stepper = Stepper(
                system,
                integrator,
                solver,
                local,
                _first_step(system, float(t[-1]), local),
                t,
                max_energy_gain,
                threads,
            )
            try:
                states = stepper.run()
            except EnergyGain as stop:
                if total.runs == MOST_RUNS - 1:
                    raise
                states, cause = None, CAUSES[Outcome.GAINED_ENERGY]
                stepper.note([Event(stop.step, stop.time, "shorter steps", cause, math.nan)])
            _add(total, stepper.stats)
            last, error = error, _error(system, states, before, shrink)
            stuck = stuck + 1 if STUCK * last < error < np.inf else 0
            bar.update()
            bar.set_postfix_str(f"error {error:.1e} m")
            if states is not None and error <= accuracy:
                total.error, total.solver = error, chosen or total.solver
                total.seconds["set-up"] = time.perf_counter() - begin - total.march_seconds
                return states, total
            least = min(least, error)
            # The rounding of a step is about that of the largest coordinate.  In n steps it adds up
            # to about root n times as much, and to n times at most.  Shorter steps only add to it,
            # and take ever longer.
            n, rounding = stepper.stats.steps, EPSILON * size
            hopeless = accuracy < rounding * math.sqrt(n) or (stuck and error < rounding * n)
            if error < np.inf and hopeless:
                raise AccuracyFailure(accuracy, error, total.runs, CLEAR * least)
            before = states
            wanted = math.sqrt(error / (SAFETY * accuracy))
            shrink = min(max(wanted, LEAST), MOST) if wanted < np.inf else SECOND
            local /= shrink**3
    raise AccuracyFailure(accuracy, error, total.runs)


def _extent(system: System) -> float:
    """Return the largest side of the box around all nodes in the reference shape [m]."""
    places = [body.positions for body in system.scene.beams]
    low = np.min([each.min(axis=0) for each in places], axis=0)
    high = np.max([each.max(axis=0) for each in places], axis=0)
    return float(np.max(high - low))


def _error(system: System, fine: States | None, coarse: States | None, shrink: float) -> float:
    """Estimate the error of the finer of two runs [m], whose steps were shorter by a factor."""
    if fine is None or coarse is None:
        return np.inf
    largest = 0.0
    for places in system.places:
        where = places[:, : system.dim]
        for a, b in zip(fine.q, coarse.q, strict=True):
            apart = a[where] - b[where]
            largest = max(largest, float(np.max(np.sum(apart**2, axis=1))))
    return math.sqrt(largest) / (shrink**2 - 1.0)


def _add(total: RunStats, stats: RunStats) -> None:
    """Add the counts of a run to those of all runs, whose steps are numbered one after another."""
    total.events += [e._replace(step=e.step + total.steps) for e in stats.events]
    del total.events[MOST_EVENTS:]
    for name in (
        *("march_seconds", "steps", "iterations", "last_corrections", "residual_evaluations"),
        *("factorizations", "indefinite", "material_seeds", "rotating_seeds", "single_seeds"),
        *("solves", "skipped_pairs", "recoveries", "rejected_steps", "runs"),
    ):
        setattr(total, name, getattr(total, name) + getattr(stats, name))
    for part, seconds in stats.seconds.items():
        total.seconds[part] = total.seconds.get(part, 0.0) + seconds
    total.solver = stats.solver


def _first_step(system: System, t_end: float, local_error: float) -> float:
    """Return a step that is surely short; good ones grow from it.

    It moves no faster point than the root of what a step of the error allowed and of unit rate of
    acceleration would, and is a thousandth of the run at most.
    """
    speed = float(np.max(np.abs(system.v0)))
    step = 1e-3 * t_end
    if speed > 0.0:
        step = min(step, np.cbrt(local_error / speed))
    return float(min(step, np.cbrt(local_error)))
