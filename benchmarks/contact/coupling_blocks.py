"""Blocks of the matrix that couple touching cables: iterations and time with and without them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from itertools import product
from typing import Any
from unittest.mock import patch

from matplotlib.figure import Figure

from ancfsparse.errors import StepError
from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.problems import pile
from ancfsparse.solve import simulate
from ancfsparse.system.contributions.force_elements.beam_contact.beam_contacts import (
    BeamContactContribution,
)
from benchmarks.common import methods
from benchmarks.common.charts import draw_lines, new_figure, panels, set_axes, set_legend
from benchmarks.common.progress import bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table

END = 0.1  # [s]
STIFFNESSES = (1e5, 1e6, 1e7, 1e8)  # of contact [N/m2]
STEPS = (5e-4, 2e-3)  # [s]
PAIRS = f"{methods.PAIRS} pairs"
SOLVERS = methods.chosen(
    methods.SOLVERS, "Newton", "modified Newton", f"bfgs, {PAIRS}", f"broyden, {PAIRS}", "auto"
)


@dataclass(frozen=True)
class HeapRun:
    """A run of a heap of cables that comes to rest."""

    stiffness: float  # of contact [N/m2]
    dt: float  # [s]
    solver: str
    has_blocks: bool
    iterations: float  # mean per step [-], infinite if the run failed
    recoveries: int
    seconds: float  # processor time [s]


def coupling_blocks(progress: bool = False) -> list[HeapRun]:
    """Compare solvers with and without the blocks that couple touching cables."""
    cases = list(product(STIFFNESSES, STEPS, SOLVERS, (True, False)))
    return [_run(*case) for case in bar(cases, "run", progress)]


def _run(stiffness: float, dt: float, solver: str, has_blocks: bool) -> HeapRun:
    scene = pile(mu=0.0, stiffness=stiffness).scene
    omitted: Any = patch.object(BeamContactContribution, "coupled_pairs", lambda contact: [])
    with nullcontext() if has_blocks else omitted:
        start = time.process_time()
        try:
            method = SOLVERS[solver]
            run = simulate(scene, END, dt, integrator=GeneralizedAlpha(0.5), solver=method)
            stats, finished = run.stats, True
        except StepError as failure:
            stats, finished = failure.trajectory.stats, False
        seconds = time.process_time() - start
    iterations = stats.iterations / stats.steps if finished else math.inf
    return HeapRun(stiffness, dt, solver, has_blocks, iterations, stats.recoveries, seconds)


def run_table(result: list[HeapRun]) -> Table:
    """Set iterations per step and times, a line for each stiffness, step and matrix."""
    lines = list(dict.fromkeys((run.stiffness, run.dt, run.has_blocks) for run in result))
    cells = {(run.stiffness, run.dt, run.has_blocks, run.solver): run for run in result}

    def cell(solver: str) -> Callable[[tuple[float, float, bool]], str]:
        return lambda line: _text(cells[(*line, solver)])

    columns: dict[str, Callable[[tuple[float, float, bool]], str]] = {
        "k [N/m^2]": lambda line: _power(line[0]),
        "step [ms]": lambda line: f"{1e3 * line[1]:g}",
        "blocks": lambda line: "yes" if line[2] else "no",
        **{solver: cell(solver) for solver in dict.fromkeys(run.solver for run in result)},
    }
    title = f"A heap of 20 cables, {END:g} s: iterations per step, processor time"
    return Table.of(lines, columns, left=(), title=title)


def _power(stiffness: float) -> str:
    return f"{stiffness:.0e}".replace("+0", "")


def _text(run: HeapRun) -> str:
    if math.isinf(run.iterations):
        return "fails"
    return f"{run.iterations:.3g}, {run.seconds:.2g} s"


def findings(result: list[HeapRun]) -> list[str]:
    """State the fastest solvers, and the attempts to recover."""
    out = []
    for stiffness, dt in dict.fromkeys((run.stiffness, run.dt) for run in result):
        of_case = [
            run
            for run in result
            if (run.stiffness, run.dt) == (stiffness, dt) and math.isfinite(run.iterations)
        ]
        best = {
            has: min((run for run in of_case if run.has_blocks == has), key=lambda run: run.seconds,
                     default=None)
            for has in (True, False)
        }  # fmt: skip
        fastest, rest = best[True], best[False]
        if fastest is None:
            continue
        other = "no run comes to its end"
        if rest is not None:
            other = f"{rest.solver}, {rest.seconds / fastest.seconds:.2g} times as long"
        out.append(
            f"{_power(stiffness)} N/m2, {1e3 * dt:g} ms: {fastest.solver} is the fastest with "
            f"{fastest.seconds:.2g} s; without blocks {other}."
        )
    for has_blocks, name in ((True, "With"), (False, "Without")):
        count = sum(run.recoveries for run in result if run.has_blocks == has_blocks)
        out.append(f"{name} blocks {count} attempts to recover steps in all runs.")
    return out


def blocks_chart(result: list[HeapRun]) -> Figure:
    """Draw times over the stiffness; dashed without blocks."""
    figure = new_figure(4.0, "A heap of cables with and without blocks that couple them")
    steps = list(dict.fromkeys(run.dt for run in result))
    solvers = list(dict.fromkeys(run.solver for run in result))
    keys: dict[str, Any] = {}
    for ax, dt in zip(panels(figure, len(steps), 2, sharey=True), steps, strict=True):
        keys |= draw_lines(
            ax,
            [run for run in result if run.dt == dt and math.isfinite(run.iterations)],
            lambda run: (run.solver, run.has_blocks),
            lambda run: run.stiffness,
            lambda run: run.seconds,
            lambda key: {
                "color": f"C{solvers.index(key[0])}",
                "linestyle": "-" if key[1] else "--",
                "label": f"{key[0]}{'' if key[1] else ', without'}",
            },
        )
        set_axes(
            ax,
            "stiffness of contact [N/m$^2$]",
            "processor time [s]",
            title=f"dt = {1e3 * dt:g} ms",
        )
    set_legend(figure, keys, 5)
    return figure


STUDY = Study(
    "contact-blocks",
    run=coupling_blocks,
    tables=lambda result: [run_table(result)],
    rows=lambda result: result,
    findings=findings,
    charts={"contact-blocks": blocks_chart},
    regions={"contact-blocks": run_table},
)
