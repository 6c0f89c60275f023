"""Findings and tables of the stability map."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median

from benchmarks.common.tables import Table
from benchmarks.common.target import verdict
from benchmarks.stability.cells import (
    FAILED,
    GAINED,
    INTEGRATORS,
    MIN_COMPLETION_RATIO,
    PERTURBATION,
    PERTURBATIONS,
    RECOVERED,
    SOLVERS,
    Run,
    in_words,
)
from benchmarks.stability.stability_map import (
    CALM_STRETCH,
    CALM_TURN,
    FOR_ALL_SOLVERS,
    MAX_GAIN,
    MAX_NEWTON_FRACTION,
    Stability,
)


def completed(runs: Sequence[Run]) -> float:
    """Return the share of runs that came to their end [%]."""
    return 100.0 * sum(run.is_complete for run in runs) / max(len(runs), 1)


def with_integrator(result: Stability, integrator: str, solver: str = "auto") -> list[Run]:
    """Return the runs of all scenes with an integrator and a solver."""
    return [
        run for run in result.runs
        if (run.map_point.integrator, run.map_point.solver) == (integrator, solver)
    ]  # fmt: skip


def safe_step(runs: Sequence[Run]) -> float:
    """Return the longest step up to which every run came to its end [s]; 0 if there is none."""
    steps = sorted({run.map_point.dt for run in runs})
    dead = min((run.map_point.dt for run in runs if not run.is_complete), default=float("inf"))
    return max((dt for dt in steps if dt < dead), default=0.0)


def findings(result: Stability) -> list[str]:
    """State the failures relative to Newton, recoveries of calm runs, and hidden gains."""
    pairs = list(result.with_newton())
    lost = result.worse_than_newton(FAILED)
    gained = result.worse_than_newton(GAINED)
    chance = result.by_chance()
    better = sum(run.is_complete and not newton.is_complete for run, newton in pairs)
    calm, often, hidden = result.calm(), result.often_recovered(), result.hidden_gains()
    others = result.calm_of_others()
    largest = max((run.newton for run in others), default=0.0)
    own = max((run.newton for run in calm if run.map_point.solver == "Newton"), default=0.0)
    return [
        f"Other solvers than Newton at the same {len(pairs)} points: {len(lost)} failed and "
        f"{len(gained)} were stopped for energy where Newton finished, {better} finished where "
        f"Newton did not. {len(chance)} more did not finish by chance: of {2 * PERTURBATIONS} "
        f"motions whose Young's modulus differs by multiples of {PERTURBATION:g}, they finish "
        f"at least {MIN_COMPLETION_RATIO:g} times as many as Newton, and Newton not all.",
        *(f"Only Newton finishes: {_where(run)}: {in_words(run)}." for run in [*lost, *gained]),
        f"Where no element turns by {CALM_TURN:g} rad or stretches by {CALM_STRETCH:g} within a "
        f"step, in {len(others)} runs of other solvers, damped Newton saved at most "
        f"{100 * largest:.2g} % of the steps of a run (target: {100 * MAX_NEWTON_FRACTION:g} %, "
        f"{verdict(not often)}); of Newton's own calm runs, at most {100 * own:.2g} %.",
        f"Runs that came to their end with more than {100 * MAX_GAIN:g} % of the largest kinetic "
        f"energy above the supplied work: {len(hidden)} of "
        f"{sum(run.is_complete for run in result.runs)} (target: none, {verdict(not hidden)}).",
        *(
            f"Gained between two checks of the energy: {_where(run)}: {100 * run.gain:.2g} %, "
            f"with stretches of {100 * run.stretch:.2g} % and turns of {run.turn:.2g} rad in a "
            "step."
            for run in hidden
        ),
    ]


def _where(run: Run) -> str:
    p = run.map_point
    return f"{p.scene}, {p.youngs_modulus:.0e} Pa, dt = {p.dt:g} s, {p.integrator}, {p.solver}"


def integrator_table(result: Stability) -> Table:
    """Set safe step and share of the runs that complete by integrator and scene."""
    rows = []
    for name in INTEGRATORS:
        runs = with_integrator(result, name)
        cells = []
        for scene in result.scenes:
            here = [run for run in runs if run.map_point.scene == scene]
            step = safe_step(here)
            cells.append(f"{f'{step:g} s' if step else 'none'}, {completed(here):.0f} %")
        rows.append([name, *cells])
    return Table(['with `"auto"`', *result.scenes], rows)


def solver_table(result: Stability) -> Table:
    """Set the outcomes by solver and integrator."""
    head = [
        "", "integrator", "finished", "with help", "gained energy", "failed",
        "corrections per step",
    ]  # fmt: skip
    rows = []
    for solver in SOLVERS:
        for integrator in FOR_ALL_SOLVERS:
            runs = with_integrator(result, integrator, solver)
            counts = [
                sum(run.is_complete for run in runs),
                *(sum(run.outcome == kind for run in runs) for kind in (RECOVERED, GAINED, FAILED)),
            ]
            work = median(run.iterations for run in runs if run.is_complete)
            rows.append([solver, integrator, *map(str, counts), f"{work:.2f}"])
    return Table(head, rows, left=(0, 1))
