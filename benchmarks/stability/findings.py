"""Findings and tables of any map of outcomes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from statistics import median

from benchmarks.common.tables import Table
from benchmarks.common.target import verdict
from benchmarks.stability.cells import FAILED, GAINED, RECOVERED, MapPoint, Run, in_words
from benchmarks.stability.map_spec import MIN_COMPLETION_RATIO, PERTURBATION, PERTURBATIONS
from benchmarks.stability.stability_map import MAX_GAIN, Stability

MAX_LISTED = 20  # runs that only Newton finishes in a list on a page


def completed(runs: Sequence[Run]) -> float:
    """Return the share of runs that came to their end [%]."""
    return 100.0 * sum(run.is_complete for run in runs) / max(len(runs), 1)


def safe_step(runs: Sequence[Run]) -> float:
    """Return the longest step up to which every run came to its end [s]; 0 if there is none."""
    steps = sorted({run.map_point.dt for run in runs})
    dead = min((run.map_point.dt for run in runs if not run.is_complete), default=float("inf"))
    return max((dt for dt in steps if dt < dead), default=0.0)


def comparison(result: Stability) -> list[str]:
    """State how many runs end otherwise than Newton's, and each that fails alone."""
    pairs = list(result.with_newton())
    lost, gained = result.worse_than_newton(FAILED), result.worse_than_newton(GAINED)
    worse, more = [*lost, *gained], len(lost) + len(gained) - MAX_LISTED
    return [
        f"Other solvers than Newton at the same {len(pairs)} points: {len(lost)} failed and "
        f"{len(gained)} were stopped for energy where Newton finished, "
        f"{len(result.better_than_newton())} finished where "
        f"Newton did not. {len(result.by_chance())} more did not finish by chance: of "
        f"{2 * PERTURBATIONS} motions whose {result.spec.varied} differs by multiples of "
        f"{PERTURBATION:g}, they finish at least {MIN_COMPLETION_RATIO:g} times as many as Newton, "
        "and Newton not all.",
        *(
            f"Only Newton finishes: {describe(result, run.map_point)}: {in_words(run)}."
            for run in worse[:MAX_LISTED]
        ),
        *[f"Newton alone finishes {more} more, which the table of all runs has."] * (more > 0),
    ]


def gains(result: Stability, of_what: str, details: Callable[[Run], str]) -> list[str]:
    """State how many runs that came to their end have gained too much energy, and each of them."""
    hidden = result.hidden_gains()
    return [
        f"Runs that came to their end with more than {100 * MAX_GAIN:g} % {of_what}: "
        f"{len(hidden)} of {sum(run.is_complete for run in result.runs)} (target: none, "
        f"{verdict(not hidden)}).",
        *(
            f"Gained between two checks of the energy: {describe(result, run.map_point)}: "
            f"{100 * run.gain:.2g} %{details(run)}."
            for run in hidden
        ),
    ]


def describe(result: Stability, point: MapPoint) -> str:
    """Name a point, without its solver if that is empty."""
    unit = f" {result.spec.unit}" * bool(result.spec.unit)
    stiffness = f"{point.stiffness:.0e}{unit}" if unit else f"stiffness {point.stiffness:g}"
    parts = point.scene, stiffness, f"dt = {point.dt:g} s", point.integrator, point.solver
    return ", ".join(part for part in parts if part)


def integrator_table(result: Stability) -> Table:
    """Set safe step and share of the runs that complete by scene and integrator."""
    integrators = result.integrators
    rows = []
    for scene in result.scenes:
        cells = []
        for name in integrators:
            here = result.of([scene], name, "auto")
            step = safe_step(here)
            text = f"{f'{step:g} s' if step else 'none'}, {completed(here):.0f} %"
            cells.append(text if here else "-")
        rows.append([scene, *cells])
    return Table(['with `"auto"`', *integrators], rows)


def solver_table(result: Stability) -> Table:
    """Set the outcomes by solver and integrator, and the runs that end otherwise than Newton's."""
    head = [
        "", "integrator", "finished", "with help", "gained energy", "failed", "only Newton ends",
        "Newton does not end", "corrections per step",
    ]  # fmt: skip
    worse = [*result.worse_than_newton(FAILED), *result.worse_than_newton(GAINED)]
    better = result.better_than_newton()
    rows = []
    for solver in result.spec.solvers:
        for integrator in result.spec.for_all_solvers:
            runs = result.of(result.scenes, integrator, solver)
            counts = [
                sum(run.is_complete for run in runs),
                *(sum(run.outcome == kind for run in runs) for kind in (RECOVERED, GAINED, FAILED)),
                *(sum(run in runs for run in others) for others in (worse, better)),
            ]
            work = [run.iterations for run in runs if run.is_complete]
            line = [solver, integrator, *map(str, counts), f"{median(work):.2f}" if work else "-"]
            rows += [line] * bool(runs)
    return Table(head, rows, left=(0, 1))
